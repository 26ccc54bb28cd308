"""Finds the robots that meet in open programs. The server asks for it in a separate process: that may take a second.

The latest version of each program is known, so after an edit only pairs with a robot that changed are checked again.
"""

from __future__ import annotations

from typing import NamedTuple

from improv_core.diagnostics import Diagnostic
from improv_core.program import room
from improv_core.program.analysis import Analysis, analyze
from improv_core.program.joint_check import check_joints
from improv_core.robots.config import Robots
from improv_core.score.encounters import RoomResults
from improv_core.stage.dry_run import predict
from improv_core.text import difference

MOST_KEPT = 20
"""Programs that are known at a time."""


class OpenProgram(NamedTuple):
    """A version of a program."""

    uri: str
    text: str
    robots: Robots


class _Version(NamedTuple):
    analysis: Analysis
    known: RoomResults | None


class Rooms:
    """The latest versions of some programs, and the meetings found in them."""

    def __init__(self) -> None:
        self._versions: dict[str, _Version] = {}

    def check(self, program: OpenProgram) -> tuple[Diagnostic, ...]:
        """Return the robots that meet or hit something in a program, and the motions that joints can't make."""
        before = self._versions.pop(program.uri, None)
        if before and before.analysis.config == program.robots:
            analysis = before.analysis.edited(*difference(before.analysis.text, program.text))
        else:
            analysis = analyze(program.text, program.robots)
        report = room.check(analysis, before.known if before else None, predict)
        self._versions[program.uri] = _Version(analysis, report.known if report else before and before.known)
        for oldest in list(self._versions)[:-MOST_KEPT]:
            del self._versions[oldest]
        return (*(report.diagnostics if report else ()), *check_joints(analysis))


_rooms = Rooms()


def check(program: OpenProgram) -> tuple[Diagnostic, ...]:
    """Check a program, as `Rooms` does, with those that this process has checked before."""
    return _rooms.check(program)
