"""Words for body parts: movements that a part performs instead of the base, and poses. Standard library only.

For everything else, these are movements of the base: it stands while body parts move. `projection` gives the movement
of each part.
"""

from __future__ import annotations

from dataclasses import replace

from improv_core.score import fields
from improv_core.score.algebra import Hold
from improv_core.score.bounds import held, under_part
from improv_core.score.movement import STILL, Around, Asked, BodyWords, Factors, Movement, Single, Through, makes
from improv_core.text import Span
from improv_core.values import value

_SILENT = Factors(0, 0, 0, 0)


@value(frozen=True, slots=True, eq=False)
class ByPart(Single, Through):
    """A movement that a body part performs, or each part of a group, by the word for it."""

    part: str

    NAME = "by_part"
    FIELDS = (("part", fields.TEXT),)

    def within(self, around: Around) -> Around:
        return around._replace(gain=_SILENT)


@value(frozen=True, slots=True, eq=False)
class ToPose(Hold):
    """One beat in which the body part around it reaches a pose."""

    pose: str

    NAME = "to_pose"
    FIELDS = (("pose", fields.TEXT), ("span", fields.SPAN))


@makes(ByPart)
def by_part(body: Movement, part: str) -> Movement:
    """Return the movement, performed by a body part. The base stands meanwhile."""
    if not (body.duration or body.open):
        return body
    return ByPart(body.duration, None if body.open else STILL, under_part(body.bounds, part), body, part)


@makes(ToPose)
def to_pose(pose: str, span: Span | None = None) -> Movement:
    """Return one beat in which the body part around it reaches a pose."""
    bounds = held(0.0, 0.0, 0.0, 0.0, 1.0)
    words = BodyWords(frozenset({Asked("", pose=pose)}), bounds.body.peak)
    return ToPose(1, STILL, replace(bounds, body=words), STILL, span, pose)
