"""Finds the robots that meet in open programs, in a separate process: that may take a second.

It knows the latest version of each program, so after an edit only pairs with a robot that changed are checked again.
"""

from __future__ import annotations

import sys
from collections.abc import Callable
from typing import NamedTuple

from improv_core.diagnostics import Diagnostic
from improv_core.program import room
from improv_core.program.analysis import Analysis, analyze
from improv_core.program.joint_check import check_joints
from improv_core.protocol.json_lines import own_output
from improv_core.robots.config import Robots
from improv_core.score.encounters import Known
from improv_core.text import difference
from improv_ls.asking import Answerer, packed, unpacked

MOST_KEPT = 20
"""Programs that are known at a time."""


class RoomChecker:
    """Asks the process, which starts when there is something to check, and ends with `close`."""

    def __init__(self) -> None:
        self._answerer = Answerer("improv_ls.room_checker")

    def check(self, uri: str, text: str, robots: Robots) -> tuple[Diagnostic, ...]:
        """Return the robots that meet or hit something in a program, and the motions that joints can't make. Blocks;
        raises EOFError or OSError if the process has ended, or has hung and was killed."""
        found: tuple[Diagnostic, ...] = self._answerer.ask((uri, text, robots))
        return found

    def close(self) -> None:
        self._answerer.close()


class _Version(NamedTuple):
    analysis: Analysis
    known: Known | None


class Rooms:
    """The latest versions of some programs, and the meetings found in them."""

    def __init__(self) -> None:
        self._versions: dict[str, _Version] = {}

    def check(self, uri: str, text: str, robots: Robots) -> tuple[Diagnostic, ...]:
        """Return the robots that meet or hit something in a program, and the motions that joints can't make."""
        before = self._versions.pop(uri, None)
        if before and before.analysis.config == robots:
            analysis = before.analysis.edited(*difference(before.analysis.text, text))
        else:
            analysis = analyze(text, robots)
        report = room.check(analysis, before.known if before else None)
        self._versions[uri] = _Version(analysis, report.known if report else before and before.known)
        for oldest in list(self._versions)[:-MOST_KEPT]:
            del self._versions[oldest]
        return (*(report.diagnostics if report else ()), *check_joints(analysis))


def _serve() -> None:
    """Answer the questions from standard input, until it is closed."""
    say: Callable[[str], None] = own_output()
    rooms = Rooms()
    for line in sys.stdin.buffer:
        say(packed(rooms.check(*unpacked(line))))


if __name__ == "__main__":
    _serve()
