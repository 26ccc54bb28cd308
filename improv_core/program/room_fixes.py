"""Fixes that keep two robots apart: one of them rests first, or their formation is larger. Each is tried out."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from fractions import Fraction
from functools import partial

from improv_core.diagnostics import Edit, Fix
from improv_core.program.analysis import Analysis
from improv_core.program.compiler import score_of
from improv_core.program.numbers import product
from improv_core.score.meetings import Meeting, would_meet
from improv_core.score.movement import near
from improv_core.score.score import Score
from improv_core.syntax.nodes import InFormation
from improv_core.text import Span

MOST_RESTS = 16
"""The most beats of `rest` that are tried."""
MOST_SIZES = 15
LARGER = 1.25
"""The number of larger formations that are tried, and the factor from each to the next."""


def fixes(analysis: Analysis, score: Score, meeting: Meeting) -> tuple[Fix, ...]:
    """Return the fixes that keep two robots apart that meet. `score` is that of the program for pictures."""
    return (*_rests(analysis, score, meeting), *_distances(analysis, meeting.robots))


def _rests(analysis: Analysis, score: Score, meeting: Meeting) -> Iterator[Fix]:
    """Have one of the two rest first: the one that needs fewer beats, or if both need the same, the one named later."""
    scene, _ = score.scene_at(near(meeting.beat))
    for beats in range(1, MOST_RESTS + 1):
        for robot in reversed(meeting.robots):
            fix = _rest(analysis, robot, scene, beats)
            if fix and _clears(analysis, fix.edits[0], meeting.robots):
                yield fix
                return


def _rest(analysis: Analysis, robot: str, scene: int, beats: int) -> Fix | None:
    """Return the fix that has a robot rest before its movements in a scene; None if it plays nothing there."""
    lines = (index for index, line in analysis.played.items() if line.scene == scene and robot in dict(line.parts))
    first = next(lines, None)
    body = None if first is None else analysis.statements[first].body
    if first is None or body is None:
        return None
    statement, start = analysis.statements[first], analysis.offsets[first]
    rest = "rest" if beats == 1 else f"repeat {beats} rest"
    if len(statement.heads) == 1 and not statement.has_voices:
        edit = Edit(Span(start + body.span.start, start + body.span.start), f"{rest} ")
    else:
        edit = Edit(Span(start, start), f"{robot} $ {rest}\n")
    return Fix(f"Start {robot} {beats} beat{'' if beats == 1 else 's'} later", (edit,))


def _distances(analysis: Analysis, pair: tuple[str, str]) -> Iterator[Fix]:
    """Enlarge the formation in which both stand a little."""
    for index in analysis.openings:
        said, node = analysis.meanings[index].said, analysis.statements[index].opening
        if said and isinstance(node, InFormation) and said.poses and set(pair) <= set(said.robots):
            span = node.size.span.shifted(analysis.offsets[index])
            size = product(node.size.tokens, {})
            assert isinstance(size, Fraction)
            tenths = _least(math.ceil(size * 10), partial(_clears_sized, analysis, span, pair))
            if tenths:
                edit = _sized(span, tenths)
                yield Fix(f"Change to {node.shape.text} {edit.text}", (edit,))


def _clears_sized(analysis: Analysis, span: Span, pair: tuple[str, str], tenths: int) -> bool:
    return _clears(analysis, _sized(span, tenths), pair)


def _sized(span: Span, tenths: int) -> Edit:
    return Edit(span, f"{tenths / 10:g}")


def _least(too_small: int, is_enough: Callable[[int], bool]) -> int | None:
    """Return a number that is enough although a little less is not, if one is found among the larger ones."""
    for _ in range(MOST_SIZES):
        larger = math.ceil(too_small * LARGER)
        if is_enough(larger):
            while larger - too_small > 1:
                middle = (larger + too_small) // 2
                larger, too_small = (middle, too_small) if is_enough(middle) else (larger, middle)
            return larger
        too_small = larger
    return None


def _clears(analysis: Analysis, edit: Edit, pair: tuple[str, str]) -> bool:
    """Return whether two robots don't meet any more after an edit, which must leave all robots at their places."""
    edited = analysis.edited(*edit.span, edit.text)
    if not edited.ok:
        return False
    before, after = score_of(analysis).parts, score_of(edited)
    moved = [name for name, part in after.parts.items() if part.start != before[name].start]
    return (not moved or edit.span.start < edit.span.end) and not would_meet(after, *pair)
