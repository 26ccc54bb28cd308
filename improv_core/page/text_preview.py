"""The paths of a program as it stands, for the page on which somebody writes it."""

from __future__ import annotations

from collections.abc import Iterator
from fractions import Fraction
from typing import NamedTuple

from improv_core.diagnostics import Severity
from improv_core.preview.window import look_of
from improv_core.program.analysis import Analysis
from improv_core.program.compiler import score_of
from improv_core.program.room import prediction_of
from improv_core.protocol.editing import Preview, PreviewedPath
from improv_core.score.equality import same
from improv_core.score.movement import ENDLESS, Movement
from improv_core.score.prediction import Predict
from improv_core.score.score import Part, Score
from improv_core.score.strokes import MAX_MOMENTS, path_of, pictured

MAX_STROKES = 4_000
"""The most lines and arcs of all paths together."""
MAX_BEATS = 24
"""The beats that are drawn of a path without an end: as many as the page shows of one that plays."""


class _DrawnPart(NamedTuple):
    """The path that was drawn for a part at a tempo."""

    part: Part
    tempo: Fraction
    shown: PreviewedPath

    def is_of(self, part: Part, tempo: Fraction) -> bool:
        mine = self.part
        alike = (self.tempo, mine.start, mine.profile) == (tempo, part.start, part.profile)
        return alike and same(mine.movement, part.movement)


class TextPreview:
    """Draws one text after another; a robot that plays the same as before isn't drawn again."""

    def __init__(self) -> None:
        self._known: dict[str, _DrawnPart] = {}

    def answers(self, number: int, analysis: Analysis, predict: Predict) -> Iterator[Preview]:
        """Yield the answer for the text with a number, or two, if robots sense something: `predict` takes time.

        With an error, robots in whose own lines nothing is missing are shown, except for those that sense something:
        nobody knows what the others do.
        """
        score, problem = score_of(analysis), _problem(analysis)
        lacking = {robot for index in analysis.lacks for robot in analysis.meanings[index].robots}
        parts = {name: part for name, part in score.parts.items() if name not in lacking and part.movement.duration}
        sensing = {name for name, part in parts.items() if part.movement.open}
        known = {name: self._path(score, part) for name, part in parts.items() if name not in sensing}
        self._known = known
        robots = {name: each.shown for name, each in known.items()}
        waits_for = [] if problem else sorted(sensing)
        yield {"type": "preview", "number": number, "robots": robots, "problem": problem, "waits_for": waits_for}
        if not waits_for:
            return
        prediction = prediction_of(analysis, score, predict)
        drawn = prediction.score if prediction else pictured(score)
        goes_on = prediction is not None and prediction.cut is not None
        robots = {**robots}
        for name in waits_for:
            is_certain = prediction and name not in prediction.assuming
            assumed = (drawn if is_certain else score).parts[name].movement
            robots[name] = _shown(drawn, drawn.parts[name], assumed, goes_on)
        yield {"type": "preview", "number": number, "robots": robots, "problem": problem, "waits_for": []}

    def _path(self, score: Score, part: Part) -> _DrawnPart:
        known = self._known.get(part.robot)
        if known and known.is_of(part, score.tempo):
            return known
        return _DrawnPart(part, score.tempo, _shown(score, part, part.movement))


def _problem(analysis: Analysis) -> str:
    """Return the first error of a program, in a few words; empty if there is none."""
    if analysis.ok:
        return ""
    if why := next((analysis.lacks[index] for index in sorted(analysis.lacks) if analysis.meanings[index].robots), ""):
        return why
    wrong = next((each for each in analysis.diagnostics if each.severity is Severity.ERROR), None)
    return f"line {analysis.lines.number(wrong.span.start)} has an error" if wrong else "improv.toml has errors"


def _shown(score: Score, part: Part, assumed: Movement, goes_on: bool = False) -> PreviewedPath:
    """Return a path, rounded to millimeters and thousandths of a radian: the first beats if the part `goes_on` after
    it."""
    beats = MAX_BEATS if goes_on or part.movement.duration == ENDLESS else None
    path = path_of(score, part, assumed, MAX_MOMENTS, MAX_STROKES // len(score.parts), beats)
    return {
        "start": [round(value, 3) for value in (path.start.x, path.start.y, path.start.heading)],
        "strokes": [
            [round(value, 3) for pose in (each.start, each.end) for value in (pose.x, pose.y, pose.heading)]
            for each in path.strokes
        ],
        "certain": path.certain,
        "look": look_of(part, score),
    }
