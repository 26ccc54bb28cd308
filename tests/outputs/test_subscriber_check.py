"""Listeners that are known to receive: the ones to ask for a confirmation, and the times from which they count."""

from __future__ import annotations

import pytest

from improv_core.outputs.ros.subscriber_check import (
    ANSWER_LIMIT,
    SETTLE,
    ZEROS,
    Hearing,
    answered,
    counted,
    is_overdue,
    may_answer,
    replaced,
    zeros_to_send,
)

NOBODY = Hearing()
FOUND = Hearing(1, since=10.0)
ASKED = Hearing(1, since=10.0, asked=10.15)
HEARD = Hearing(1, 1, since=10.0, asked=10.15)


@pytest.mark.parametrize(
    ("before", "listeners", "after"),
    [
        (NOBODY, 0, NOBODY),
        (NOBODY, 1, Hearing(1, since=11.0)),
        (ASKED, 1, ASKED),
        (HEARD, 1, HEARD),
        (HEARD, 0, NOBODY),
        (HEARD, 2, Hearing(2, 1, since=11.0)),
        (Hearing(2, 2, since=10.0), 1, Hearing(1, 1, since=10.0)),
        (Hearing(trusts=True), 1, Hearing(1, 1)),
        (Hearing(trusts=True), 0, NOBODY),
        (replaced(10.9), 1, Hearing(1, since=11.0, earliest=10.9 + SETTLE)),
    ],
)
def test_a_look_at_how_many_listen(before: Hearing, listeners: int, after: Hearing) -> None:
    assert counted(before, listeners, 11.0) == after


@pytest.mark.parametrize(
    ("hearing", "zeros"),
    [
        (NOBODY, 0),
        (FOUND, ZEROS),
        (ASKED, 0),
        (Hearing(1, since=10.0, asked=10.1), ZEROS),
        (HEARD, 0),
        (Hearing(2, 1, since=10.0), ZEROS),
        (Hearing(1, since=10.0, earliest=10.3), 0),
    ],
)
def test_listeners_get_zeros_until_they_confirm_one(hearing: Hearing, zeros: int) -> None:
    assert zeros_to_send(hearing, 10.2) == zeros


@pytest.mark.parametrize(
    ("hearing", "moves", "may"),
    [
        (NOBODY, False, False),
        (FOUND, False, False),  # all is confirmed as long as nothing has been sent
        (ASKED, False, True),
        (HEARD, False, False),
        (Hearing(1, since=10.2), True, False),
        (FOUND, True, True),
        (Hearing(2, 1, since=10.0), True, False),
        (Hearing(2, 1, since=10.0, asked=10.15), False, True),
        (Hearing(1, since=10.0, earliest=10.3, asked=10.15), False, False),
    ],
)
def test_an_answer_counts_only_after_something_was_sent(hearing: Hearing, moves: bool, may: bool) -> None:
    assert may_answer(hearing, moves, 10.2) == may


@pytest.mark.parametrize(
    ("confirms", "now", "heard"), [(True, 10.01, True), (False, 10.01, False), (False, 10.0 + SETTLE, True)]
)
def test_a_listener_that_confirms_nothing_counts_after_a_while(confirms: bool, now: float, heard: bool) -> None:
    assert answered(ASKED, confirms, now).is_heard(moves=False) == heard


@pytest.mark.parametrize(
    ("hearing", "moves", "heard"),
    [(NOBODY, True, False), (ASKED, True, False), (Hearing(2, 1), False, False), (Hearing(2, 1), True, True)],
)
def test_a_robot_that_moves_needs_no_new_answer_when_somebody_else_listens_too(
    hearing: Hearing, moves: bool, heard: bool
) -> None:
    assert hearing.is_heard(moves) == heard


@pytest.mark.parametrize(
    ("hearing", "waited", "overdue"),
    [(ASKED, ANSWER_LIMIT, True), (ASKED, ANSWER_LIMIT - 0.1, False), (FOUND, ANSWER_LIMIT, False)],
)
def test_a_listener_that_never_confirms_is_overdue(hearing: Hearing, waited: float, overdue: bool) -> None:
    assert is_overdue(hearing, 10.0 + waited) == overdue
