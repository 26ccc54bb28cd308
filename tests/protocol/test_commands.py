"""The rows of commands: each is complete, and the page agrees with them."""

from __future__ import annotations

import pytest

from improv_core.protocol.commands import COMMANDS, PageRequest, about
from improv_core.protocol.decoding import by_type
from improv_core.protocol.page_messages import FromPage
from tests import page_requests


def test_everything_a_page_may_request_has_a_row() -> None:
    assert COMMANDS.keys() == by_type(PageRequest).keys()


def test_a_page_may_send_the_commands_of_its_rows() -> None:
    asks = {
        "press",
        "window",
        "analyze",
        "complete",
        "explain",
        "handle",
        "preview",
        "write",
        "change",
    }  # answered, or sent on
    sent = {row.name for row in COMMANDS.values() if "page" in row.by} - {"editing"}
    assert by_type(FromPage).keys() - asks == sent


def test_commands_void_others_that_exist() -> None:
    assert all(row.voids <= COMMANDS.keys() for row in COMMANDS.values())


LEFT = {
    *("stop", "speed", "silence"),  # they hold for later scores
    *("held", "released", "key", "force", "osc_sense"),  # of senses: after a stop, none moves a robot
    "editing",  # the parent does them; a save counts the stops itself
}
"""The commands that a stop leaves alone, because none of them moves robots that stand."""


def test_a_stop_voids_each_command_that_could_move_robots() -> None:
    assert COMMANDS["stop"].voids == COMMANDS.keys() - LEFT


def test_the_page_has_the_same_messages_and_limits() -> None:
    written = [file.read_text(encoding="utf-8") for file in (page_requests.TYPES, page_requests.LIMITS)]
    assert written == [page_requests.types(), page_requests.limits()], "run `python -m tests.page_requests`"


@pytest.mark.parametrize(
    ("first", "second", "same"),
    [
        ({"type": "seek", "beat": 1}, {"type": "seek", "beat": 2}, True),
        ({"type": "seek", "beat": 1}, {"type": "speed", "factor": 2}, False),
        ({"type": "stop", "direct": "ada 1"}, {"type": "stop", "direct": "ada 2"}, True),
        ({"type": "stop", "direct": "ada 1"}, {"type": "stop", "direct": "bo 1"}, False),
        ({"type": "stop"}, {"type": "stop", "by": "osc"}, False),
        ({"type": "stop", "by": "ros"}, {"type": "stop", "by": "osc"}, False),
        ({"type": "key", "key": "a", "held": True}, {"type": "key", "key": "a", "held": False}, True),
        ({"type": "key", "key": "a", "held": True}, {"type": "key", "key": "b", "held": True}, False),
    ],
)
def test_only_the_latest_command_about_something_counts(first: PageRequest, second: PageRequest, same: bool) -> None:
    assert (about(first) == about(second)) == same
