"""Tests that hold while the stage half of Improv is rebuilt: names and imports in them may change, the rest stays.

A person's safety depends on them. So they may get more scenes, and none of theirs may go until one session plays on all
stages; then this file goes, too.
"""

from __future__ import annotations

import ast
from pathlib import Path
from typing import NamedTuple

import pytest

TESTS = Path(__file__).parent


class Content(NamedTuple):
    tests: int
    assertions: int
    literals: int
    """Numbers and strings: the rows of tables, and the messages and expectations of scenes."""


FROZEN = {
    "player/test_decide.py": Content(61, 138, 1122),
    "stage/test_in_time.py": Content(18, 18, 381),
    "player/test_any_order.py": Content(1, 9, 78),
    "stage/test_loop.py": Content(28, 55, 541),
    "safety/test_pending_zeros.py": Content(3, 8, 124),
    "session/test_on_request.py": Content(15, 25, 298),
    "session/test_on_report.py": Content(18, 36, 848),
    "session/test_group.py": Content(44, 125, 750),
    "session/test_synced_start.py": Content(17, 49, 290),
    "safety/test_stops.py": Content(4, 18, 56),
    "safety/test_stop_socket.py": Content(10, 21, 115),
    "safety/test_stage_watchdog.py": Content(8, 24, 61),
    "ros/test_standby.py": Content(6, 11, 81),
    "ros/test_ros_sink.py": Content(11, 15, 250),
    "ros/test_requests.py": Content(4, 23, 104),
    "ros/test_preflight.py": Content(1, 5, 45),
    "ros/test_hosts.py": Content(4, 13, 105),
    "page/test_stops.py": Content(3, 2, 42),
    "page/test_stop_confirmations.py": Content(5, 14, 44),
    "page/test_server.py": Content(34, 96, 698),
    "page/test_flood.py": Content(1, 5, 73),
    "score/brute_force.py": Content(0, 1, 237),
    "score/test_movement.py": Content(15, 31, 238),
    "score/test_meetings.py": Content(14, 15, 261),
    "score/test_path.py": Content(6, 9, 53),
    "score/test_performer.py": Content(6, 13, 106),
    "score/test_projection.py": Content(8, 15, 55),
    "score/test_replay.py": Content(11, 28, 233),
    "score/test_scenes.py": Content(11, 16, 193),
    "score/test_smoothing.py": Content(5, 16, 117),
    "score/test_dice.py": Content(19, 35, 359),
    "mutants/faults.py": Content(0, 0, 242),
}


def content_of(path: Path) -> Content:
    nodes = [*ast.walk(ast.parse(path.read_text(encoding="utf-8")))]
    functions = [node for node in nodes if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef)]
    return Content(
        sum(function.name.startswith("test_") for function in functions),
        sum(isinstance(node, ast.Assert) for node in nodes),
        sum(isinstance(node, ast.Constant) for node in nodes),
    )


@pytest.mark.parametrize("name", FROZEN)
def test_a_frozen_file_loses_nothing(name: str) -> None:
    now = content_of(TESTS / name)
    assert all(count >= before for count, before in zip(now, FROZEN[name], strict=True)), now
