"""Scores as JSON values: the message to a stage, without anything that it already has. Standard library only."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, field
from fractions import Fraction
from functools import lru_cache
from typing import Any, NamedTuple, TypedDict

from improv_core.score import body, senses
from improv_core.score import world as worlds
from improv_core.score.algebra import Gain, Hold, Pace, Parallel, Repeat, Reverse, Series, Use
from improv_core.score.bounds import is_too_fast
from improv_core.score.by_part import ByPart, ToPose
from improv_core.score.dice import Chance, Choose, Seed, Shuffle, Throwing
from improv_core.score.faults import Fault, FaultRules, Response
from improv_core.score.fields import above_zero
from improv_core.score.fits import checked, fits
from improv_core.score.inner_first import inner_first
from improv_core.score.motion import Pose
from improv_core.score.movement import (
    LARGEST,
    MOST_BITS,
    MOST_DEPTH,
    MOST_THROWS,
    MOST_VOICES,
    Bounds,
    Movement,
    Several,
    Single,
    bits,
)
from improv_core.score.music import Music
from improv_core.score.profiles import Profile
from improv_core.score.ramps import Ease, Ramp
from improv_core.score.reactions import If, Pause, Until
from improv_core.score.score import (
    Deadman,
    Follow,
    Host,
    OdomFrame,
    OutsideClock,
    Part,
    Preflight,
    Rejoin,
    Safety,
    Score,
)

MOST_KNOWN = 10_000
"""Movements that a reader of scores may keep although none of its scores needs them any more."""
FASTEST_RATE = 1_000
"""Commands per second that a robot may be sent."""
_KINDS: Mapping[str, type[Movement]] = {
    kind.NAME: kind
    for kind in (
        *(Hold, Series, Parallel, Repeat, Pace, Gain, Reverse, Use, Ramp, Ease),
        *(Choose, Shuffle, Chance, Seed, Throwing, Until, Pause, If, ByPart, ToPose),
    )
}


@dataclass(slots=True)
class RowsWritten:
    """The rows that were written for a reader of scores, numbered in order, and the parts of the latest score."""

    rows: dict[tuple[Any, ...], int] = field(default_factory=dict)
    numbers: dict[int, int] = field(default_factory=dict)
    """The numbers of movements by their id(). Movements are kept, so that their id() stays their own."""
    movements: list[Movement] = field(default_factory=list)
    parts: dict[str, _Written] = field(default_factory=dict)
    whole: int = 0
    """The number of rows of the first score, which was written whole."""

    def renewed(self) -> RowsWritten:
        """Return this, or a new one once most of its rows may belong to scores that no longer play."""
        return RowsWritten() if len(self.rows) > 2 * self.whole + MOST_KNOWN else self


class _Written(NamedTuple):
    scenes: tuple[int, ...]
    part: Part

    def is_like(self, other: _Written) -> bool:
        one, two = self.part, other.part
        return (
            self.scenes == other.scenes
            and (one.editions, one.topic, one.reset, one.use_sim_time, one.frame, one.odom, one.follow, one.odom_frame)
            == (two.editions, two.topic, two.reset, two.use_sim_time, two.frame, two.odom, two.follow, two.odom_frame)
            and (one.battery, one.namespace, one.host) == (two.battery, two.namespace, two.host)
            and one.profile == two.profile
            and one.start == two.start
            and one.senses == two.senses
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
    program = {"text": score.text, "offsets": list(score.offsets.items())}
    return {
        "tempo": str(score.tempo),
        "known": known,
        "movements": rows,
        "parts": parts,
        "world": worlds.to_json(score.world),
        "safety": asdict(score.safety),
        "publish": score.publish,
        "bar": score.bar,
        "count_in": score.count_in,
        "clock": score.clock and asdict(score.clock),
        "scene_names": list(score.scene_names),
        "music": asdict(score.music) if score.music else None,
        **program,
    }


def _part_json(written: _Written) -> dict[str, Any]:
    part = written.part
    return {
        "scenes": written.scenes,
        "profile": asdict(part.profile),
        "start": asdict(part.start),
        "topic": part.topic,
        "reset": part.reset,
        "use_sim_time": part.use_sim_time,
        "frame": part.frame,
        "odom": part.odom,
        "follow": part.follow,
        "odom_frame": part.odom_frame,
        "battery": part.battery,
        "namespace": part.namespace,
        "host": asdict(part.host) if part.host else None,
        "senses": senses.to_json(part.senses),
        "editions": part.editions,
    }


class _PartJson(TypedDict):
    scenes: Sequence[int]
    profile: Mapping[str, Any]
    start: Mapping[str, Any]
    topic: str
    reset: str | None
    use_sim_time: bool
    frame: str
    odom: str | None
    follow: bool
    odom_frame: OdomFrame
    battery: str | None
    namespace: str
    host: Mapping[str, Any] | None
    senses: Mapping[str, Mapping[str, Any]]
    editions: Sequence[int]


class _DeadmanJson(TypedDict):
    topic: str
    button: int


class _FaultRulesJson(TypedDict):
    responses: Mapping[Fault, Response]
    distance: float
    angle: float


class _PreflightJson(TypedDict):
    distance: float
    turn: float


class _ClockJson(TypedDict):
    follow: Follow
    port: str


class _SafetyJson(TypedDict):
    stop: str | None
    deadman: _DeadmanJson | None
    rejoin: Rejoin
    faults: _FaultRulesJson
    start_without: bool
    preflight: _PreflightJson
    sight: bool


class _ScoreJson(TypedDict):
    tempo: str
    known: int
    movements: Sequence[Any]
    parts: Mapping[str, _PartJson | None]
    world: Mapping[str, Any] | None
    text: str
    offsets: Sequence[Sequence[int]]
    safety: _SafetyJson
    publish: bool
    bar: int | None
    count_in: bool
    clock: _ClockJson | None
    scene_names: Sequence[str]
    music: Mapping[str, Any] | None


def from_json(data: Mapping[str, Any], read: RowsRead | None = None) -> Score:
    """Return the score that `to_json` wrote. `read` is what was read before it, on which its writer builds. It is
    emptied if this score can't be read.

    Raises `LackingError` if the writer builds on something else, and an exception on anything that is no score or is
    too much to play.
    """
    if not fits(data, _ScoreJson):
        raise ValueError("it is not a score")
    read = RowsRead() if read is None else read
    if data["known"] == 0:
        read.movements, read.parts = [], {}
    made, before = read.movements, read.parts
    if data["known"] != len(made):
        raise LackingError
    try:
        for kind, *rest in data["movements"]:
            made.append(_playable(_read(kind, rest, made)))
        parts = {
            name: _part(name, part, made) if part else _known_part(name, before) for name, part in data["parts"].items()
        }
        score = _score(data, parts)
    except Exception:
        read.movements, read.parts = [], {}
        raise
    read.parts = parts
    return score


def _part(name: str, data: _PartJson, made: Sequence[Movement]) -> Part:
    return Part(
        name,
        tuple(_at(scene, made) for scene in data["scenes"]),
        checked(Profile, {**data["profile"], "body": body.from_json(data["profile"].get("body"))}),
        checked(Pose, data["start"]),
        data["topic"],
        data["reset"],
        data["use_sim_time"],
        data["odom"],
        senses.from_json(data["senses"]),
        tuple(data["editions"]),
        frame=data["frame"],
        follow=data["follow"],
        odom_frame=data["odom_frame"],
        battery=data["battery"],
        namespace=data["namespace"],
        host=checked(Host, data["host"]) if data["host"] else None,
    )


def _known_part(name: str, before: Mapping[str, Part]) -> Part:
    if name not in before:
        raise LackingError
    return before[name]


def _score(data: Mapping[str, Any], parts: Mapping[str, Part]) -> Score:
    if any(not 0 < part.profile.command_rate <= FASTEST_RATE for part in parts.values()):
        raise ValueError("a robot's command rate is out of range")
    world = worlds.from_json(data["world"])
    tempo = Fraction(above_zero(data["tempo"]))
    if not 1 <= tempo * LARGEST <= LARGEST**2:
        raise ValueError("the tempo is out of range")
    safety = data["safety"]
    deadman = Deadman(**safety["deadman"]) if safety["deadman"] else None
    faults, preflight = FaultRules(**safety["faults"]), Preflight(**safety["preflight"])
    rules = Safety(
        safety["stop"], deadman, safety["rejoin"], faults, safety["start_without"], preflight, safety["sight"]
    )
    bar, names = data["bar"], tuple(data["scene_names"])
    if bar is not None and bar < 1:
        raise ValueError("a bar must have at least one beat")
    music = checked(Music, data["music"]) if data["music"] else None
    text, offsets = data["text"], dict(data["offsets"])
    clock = data["clock"] and OutsideClock(**data["clock"])
    rest = {name: data[name] for name in ("publish", "count_in")}
    rest |= {"bar": bar, "scene_names": names, "clock": clock, "music": music}
    return Score(tempo, parts, text, offsets, world, rules, **rest)


def _playable(movement: Movement) -> Movement:
    """Return a movement that the language would accept too, so walking it costs no more. Raises ValueError."""
    duration = movement.duration
    is_long = not isinstance(duration, float) and (duration > _LONGEST or bits(duration) > _MOST_DURATION_BITS)
    if is_long or not _are_playable(movement.bounds):
        raise ValueError("its numbers are too large or its voices too many")
    return movement


@lru_cache(maxsize=10_000)
def _are_playable(bounds: Bounds) -> bool:
    return (
        bounds.width <= MOST_VOICES
        and bounds.depth <= MOST_DEPTH + _AROUND_STATEMENTS
        and bounds.bits <= MOST_BITS
        and bounds.throws <= MOST_THROWS
        and not (is_too_fast(bounds.peak) or is_too_fast(bounds.body.peak))
    )


_LONGEST = LARGEST**2
_AROUND_STATEMENTS = 2  # the series of a scene, and that of all scenes
_MOST_DURATION_BITS = 4 * MOST_BITS
"""The durations of one robot's statements share a denominator of up to `MOST_BITS`."""


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
