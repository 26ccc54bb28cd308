"""Scores as JSON values: the message to a stage, without anything that it already has. Standard library only."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from fractions import Fraction
from functools import lru_cache
from typing import Any, NamedTuple

from improv_core.score.algebra import FromStatement, Gain, Hold, Pace, Parallel, Repeat, Reverse, Series
from improv_core.score.body import is_whole
from improv_core.score.bounds import is_too_fast
from improv_core.score.by_part import ByPart, ToPose
from improv_core.score.dice import Chance, Choose, Seed, Shuffle, Throwing
from improv_core.score.fields import above_zero
from improv_core.score.json_types import as_json, hints_of, read
from improv_core.score.movement import (
    LARGEST,
    MAX_BITS,
    MAX_DEPTH,
    MAX_THROWS,
    MAX_VOICES,
    Bounds,
    Movement,
    Several,
    Single,
    bits,
)
from improv_core.score.ramps import Ease, Ramp
from improv_core.score.reactions import If, Pause, Until
from improv_core.score.score import Part, Score
from improv_core.score.senses import require_valid
from improv_core.score.traversal import inner_first

MAX_KNOWN = 10_000
"""Movements that a reader of scores may keep although none of its scores needs them any more."""
FASTEST_RATE = 1_000
"""Commands per second that a robot may be sent."""
_KINDS: Mapping[str, type[Movement]] = {
    kind.NAME: kind
    for kind in (
        *(Hold, Series, Parallel, Repeat, Pace, Gain, Reverse, FromStatement, Ramp, Ease),
        *(Choose, Shuffle, Chance, Seed, Throwing, Until, Pause, If, ByPart, ToPose),
    )
}


_OF_A_PART = (
    *("profile", "start", "topic", "reset", "use_sim_time", "frame", "odom", "follow", "odom_frame"),
    *("battery", "namespace", "host", "device", "senses", "editions"),
)
"""The fields of a part that are sent besides its scenes."""
_OF_A_SCORE = ("world", "safety", "publish", "bar", "count_in", "clock", "scene_names", "music", "text")
"""The fields of a score that are sent as they are."""


@dataclass(slots=True)
class RowsWritten:
    """The rows that were written for a reader of scores, numbered in order, and the parts of the latest score."""

    rows: dict[tuple[Any, ...], int] = field(default_factory=dict)
    numbers: dict[int, int] = field(default_factory=dict)
    """The numbers of movements by their id(). Movements are kept, so that no other object gets their id()."""
    movements: list[Movement] = field(default_factory=list)
    parts: dict[str, _Written] = field(default_factory=dict)
    whole: int = 0
    """The number of rows of the first score, which was written whole."""

    def renewed(self) -> RowsWritten:
        """Return this, or a new one once most of its rows may belong to scores that no longer play."""
        return RowsWritten() if len(self.rows) > 2 * self.whole + MAX_KNOWN else self


class _Written(NamedTuple):
    scenes: tuple[int, ...]
    part: Part

    def is_like(self, other: _Written) -> bool:
        return self.scenes == other.scenes and all(
            getattr(self.part, name) == getattr(other.part, name) for name in _OF_A_PART
        )


@dataclass(slots=True)
class RowsRead:
    """The movements that a reader of scores has, numbered in order, and the parts of the latest score."""

    movements: list[Movement] = field(default_factory=list)
    parts: Mapping[str, Part] = field(default_factory=dict)


class LackingError(Exception):
    """Raised if a score builds on movements or parts that its reader does not have."""


def to_json(score: Score, written: RowsWritten | None = None) -> dict[str, Any]:
    """Return the score as JSON values, except what the reader has: `written` is what was written for it before.

    Each distinct movement is listed once, after the movements inside it. A part that is the same as in the score before
    is null.
    """
    written = RowsWritten() if written is None else written
    known = len(written.rows)
    rows: list[list[Any]] = []
    now = {
        name: _Written(tuple(_add(scene, rows, written) for scene in part.scenes), part)
        for name, part in score.parts.items()
    }
    before = written.parts
    parts = {
        name: None if name in before and each.is_like(before[name]) else _part_json(each) for name, each in now.items()
    }
    written.parts = now
    written.whole = written.whole or len(rows)
    return {
        "tempo": str(score.tempo),
        "known": known,
        "movements": rows,
        "parts": parts,
        **{name: as_json(getattr(score, name)) for name in _OF_A_SCORE},
        "offsets": list(score.offsets.items()),
    }


def _part_json(written: _Written) -> dict[str, Any]:
    return {"scenes": written.scenes, **{name: as_json(getattr(written.part, name)) for name in _OF_A_PART}}


def from_json(data: Mapping[str, Any], known: RowsRead | None = None) -> Score:
    """Return the score that `to_json` wrote. `known` is what was read before it, on which its writer builds. It is
    emptied if this score can't be read.

    Raises `LackingError` if the writer builds on something else, and an exception on anything that is no score or is
    too much to play.
    """
    known = RowsRead() if known is None else known
    if read(data["known"], int) == 0:
        known.movements, known.parts = [], {}
    made, before = known.movements, known.parts
    if data["known"] != len(made):
        raise LackingError
    try:
        for kind, *rest in data["movements"]:
            made.append(_playable(_read(kind, rest, made)))
        parts = {
            name: _known_part(name, before) if part is None else _part(name, part, made)
            for name, part in data["parts"].items()
        }
        score = _score(data, parts)
    except Exception:
        known.movements, known.parts = [], {}
        raise
    known.parts = parts
    return score


def _part(name: str, data: Mapping[str, Any], made: Sequence[Movement]) -> Part:
    scenes = tuple([_at(scene, made) for scene in read(data["scenes"], Sequence[int])])
    part = Part(robot=name, scenes=scenes, **_fields(Part, _OF_A_PART, data))
    if not 0 < part.profile.command_rate <= FASTEST_RATE:
        raise ValueError("a robot's command rate is out of range")
    if part.profile.body and not is_whole(part.profile.body):
        raise ValueError("a body lacks a part or a joint, or a direction moves nothing")
    for source in part.senses.values():
        require_valid(source)
    return part


def _known_part(name: str, before: Mapping[str, Part]) -> Part:
    if name not in before:
        raise LackingError
    return before[name]


def _score(data: Mapping[str, Any], parts: Mapping[str, Part]) -> Score:
    tempo = Fraction(above_zero(data["tempo"]))
    if not 1 <= tempo * LARGEST <= LARGEST**2:
        raise ValueError("the tempo is out of range")
    offsets = dict(read(data["offsets"], Sequence[tuple[int, int]]))
    score = Score(tempo, parts, offsets=offsets, **_fields(Score, _OF_A_SCORE, data))
    if score.bar is not None and score.bar < 1:
        raise ValueError("a bar must have at least one beat")
    return score


def _fields(kind: type, names: Sequence[str], data: Mapping[str, Any]) -> dict[str, Any]:
    return {name: read(data[name], hints_of(kind)[name]) for name in names}


def _playable(movement: Movement) -> Movement:
    """Return a movement that the language would accept too, so walking it costs no more. Raises ValueError."""
    duration = movement.duration
    is_long = not isinstance(duration, float) and (duration > _LONGEST or bits(duration) > _MAX_DURATION_BITS)
    if is_long or not _are_playable(movement.bounds):
        raise ValueError("its numbers are too large or its voices too many")
    return movement


@lru_cache(maxsize=10_000)
def _are_playable(bounds: Bounds) -> bool:
    return (
        bounds.width <= MAX_VOICES
        and bounds.depth <= MAX_DEPTH + _AROUND_STATEMENTS
        and bounds.bits <= MAX_BITS
        and bounds.throws <= MAX_THROWS
        and not (is_too_fast(bounds.peak) or is_too_fast(bounds.body.peak))
    )


_LONGEST = LARGEST**2
_AROUND_STATEMENTS = 2  # the series of a scene, and that of all scenes
_MAX_DURATION_BITS = 4 * MAX_BITS
"""The durations of one robot's statements share a denominator of up to `MAX_BITS`."""


def _add(whole: Movement, rows: list[list[Any]], written: RowsWritten) -> int:
    """Append the rows of a movement that are new, inner ones first, and return its number.

    A movement that was made again for this score, but has the same row as an earlier one, is not new.
    """
    known, made = written.numbers, dict[int, int]()
    if id(whole) in known:
        return known[id(whole)]
    for part in inner_first(whole, lambda part: [each for each in part.parts if id(each) not in known]):
        row = _row(part, [made[key] if (key := id(each)) in made else known[key] for each in part.parts])
        key_of_row = _frozen(row)
        if key_of_row in written.rows:
            made[id(part)] = written.rows[key_of_row]
            continue
        known[id(part)] = written.rows[key_of_row] = len(written.rows)
        written.movements.append(part)
        rows.append(row)
    return made[id(whole)] if id(whole) in made else known[id(whole)]


def _frozen(row: Sequence[Any]) -> tuple[Any, ...]:
    return tuple(_frozen(each) if isinstance(each, (list, tuple)) else each for each in row)


def _row(part: Movement, inner: list[int]) -> list[Any]:
    own = [form.write(getattr(part, name)) for name, form in part.FIELDS]
    return [part.NAME, inner, *own] if isinstance(part, Several) else [part.NAME, *inner, *own]


def _read(name: str, rest: list[Any], made: Sequence[Movement]) -> Movement:
    kind = _KINDS[name]
    if issubclass(kind, Several):
        inner, *own = rest
    else:
        count = 1 if issubclass(kind, Single) else 0
        inner, own = rest[:count], rest[count:]
    values = [form.read(value) for (_, form), value in zip(kind.FIELDS, own, strict=True)]
    return kind.make([_at(place, made) for place in inner], *values)


def _at(place: int, made: Sequence[Movement]) -> Movement:
    if place < 0:
        raise ValueError("a movement is missing")
    return made[place]
