"""Finds the robots that meet in open programs, and their paths. The server asks for it in a separate process: that may
take a second.

The latest version of each program is known, so after an edit only pairs with a robot that changed are checked again.
"""

from __future__ import annotations

from collections.abc import Iterator
from functools import cache
from typing import TYPE_CHECKING, NamedTuple

from improv_core.diagnostics import Diagnostic
from improv_core.program import room
from improv_core.program.analysis import Analysis, analyze
from improv_core.program.joint_check import check_joints
from improv_core.protocol.editing import Preview
from improv_core.robots.config import Robots
from improv_core.score.encounters import RoomResults
from improv_core.text import difference

if TYPE_CHECKING:
    from improv_core.page.text_preview import TextPreview

MAX_KEPT = 20
"""Programs that are known at a time."""


class OpenProgram(NamedTuple):
    """A version of a program. With `draws`, nothing is wanted but its paths, at once."""

    uri: str
    text: str
    robots: Robots
    draws: bool = False


class Sight(NamedTuple):
    """The diagnostics of a program, and its paths, if they weren't all known before."""

    diagnostics: tuple[Diagnostic, ...] = ()
    paths: Preview | None = None


class _Version(NamedTuple):
    analysis: Analysis
    known: RoomResults | None
    preview: TextPreview
    answers: Iterator[Preview]
    """Those of the preview that are left."""


class Rooms:
    """The latest versions of some programs, and the findings about them."""

    def __init__(self) -> None:
        self._versions: dict[str, _Version] = {}
        # The server, which only asks, needs no player and no simulator.
        from improv_core.page.text_preview import TextPreview
        from improv_core.stage.dry_run import Predictions

        self._begun = TextPreview
        self._predict = Predictions()

    def look(self, program: OpenProgram) -> Sight:
        """Return the robots that meet or hit something in a program, and the motions that joints can't make. If its
        paths were drawn before, and depend on what robots sense, also return them again."""
        version = self._versions.pop(program.uri, None) or _Version(analyze(""), None, self._begun(), iter(()))
        analysis = version.analysis if version.analysis.config == program.robots else analyze("", program.robots)
        if analysis.text != program.text:
            analysis = analysis.edited(*difference(analysis.text, program.text))
        if analysis is not version.analysis:
            version = version._replace(answers=iter(()))
        report = None
        if program.draws:
            version = version._replace(answers=version.preview.answers(0, analysis, self._predict))
        else:
            report = room.check(analysis, version.known, self._predict)
        known = report.known if report else version.known
        self._versions[program.uri] = version._replace(analysis=analysis, known=known)
        for oldest in list(self._versions)[:-MAX_KEPT]:
            del self._versions[oldest]
        paths = next(version.answers, None)
        return Sight(() if program.draws else (*(report.diagnostics if report else ()), *check_joints(analysis)), paths)


_rooms = cache(Rooms)


def look(program: OpenProgram) -> Sight:
    """Look at a program, as `Rooms` does, with those that this process has seen before."""
    return _rooms().look(program)
