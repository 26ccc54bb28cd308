"""A score: which robot plays which movement, and how fast. The stage plays it. Standard library only."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass, field, replace
from fractions import Fraction
from functools import lru_cache
from typing import Any, Literal, TypedDict

from improv_core.score import dice as chances
from improv_core.score import movement as algebra
from improv_core.score import ramps
from improv_core.score import world as worlds
from improv_core.score.fits import checked, fits
from improv_core.score.motion import Pose, Twist
from improv_core.score.movement import Bounds, Movement, Velocity
from improv_core.score.profiles import Profile
from improv_core.score.scenes import performance, scene_begins
from improv_core.score.world import World
from improv_core.text import Span

FASTEST_RATE = 1_000
"""Commands per second that a robot may be sent."""


@dataclass(frozen=True, slots=True)
class Part:
    """One robot's part: its scenes, its profile, its start pose, and its topic.

    `scenes` has a movement for each scene, which is empty if the robot has nothing to do in it. `movement` is all that
    it performs, and in between it stands until each scene begins, at `scene_begins`. These beats depend on all robots,
    so the `Score` sets them; by itself, a part performs as if it were alone.

    `reset` is the service that moves it to its start pose, if there is one. With `use_sim_time`, its messages are
    stamped with the time on /clock.
    """

    robot: str
    scenes: tuple[Movement, ...]
    profile: Profile
    start: Pose
    topic: str
    reset: str | None = None
    use_sim_time: bool = False
    scene_begins: tuple[int, ...] = ()
    movement: Movement = field(init=False)

    def __post_init__(self) -> None:
        begins = self.scene_begins or scene_begins((self.scenes,))
        object.__setattr__(self, "movement", performance(self.scenes, begins))


Rejoin = Literal["continue", "next", "pause"]
"""What a robot does that listens again: continue with the others, or stand until the next play; or all wait for it."""


@dataclass(frozen=True, slots=True)
class Deadman:
    """A button to hold while real robots move, counted from 0, on a topic of sensor_msgs/Joy."""

    topic: str
    button: int

    def __str__(self) -> str:
        return f"button {self.button} on {self.topic}"


@dataclass(frozen=True, slots=True)
class Safety:
    """What stops real robots besides the score; `stop` is a topic of std_msgs/Bool that is true in an emergency."""

    stop: str | None = None
    deadman: Deadman | None = None
    rejoin: Rejoin = "continue"


@dataclass(frozen=True, slots=True)
class Score:
    """All parts, which play together from beat 0 at `tempo` beats per minute.

    `begins` are the beats at which the scenes begin, for all robots. `world` is the surroundings of simulated robots.
    For the page, `text` is the program, and `offsets` are the offsets of its statements by ID.
    """

    tempo: Fraction
    parts: Mapping[str, Part]
    text: str = ""
    offsets: Mapping[int, int] = field(default_factory=dict)
    world: World = worlds.EMPTY
    safety: Safety = Safety()
    begins: tuple[int, ...] = field(init=False)

    def __post_init__(self) -> None:
        begins = scene_begins(part.scenes for part in self.parts.values())
        object.__setattr__(self, "begins", begins)
        if len(begins) > 1:
            parts = {name: replace(part, scene_begins=begins) for name, part in self.parts.items()}
            object.__setattr__(self, "parts", parts)

    @property
    def beats(self) -> algebra.Duration:
        """The length of the longest part, in beats."""
        return max((part.movement.duration for part in self.parts.values()), default=0)

    def seconds(self, beats: algebra.Duration) -> float:
        """How long these beats take, in seconds."""
        return float(beats * 60 / self.tempo)


def twist(velocity: Velocity, profile: Profile, tempo: Fraction) -> Twist:
    """A velocity in SI units: steps per beat times meters per step times beats per second."""
    per_second = tempo / 60
    x, y, z, yaw = (float(value * per_second) if value else 0.0 for value in velocity)
    return Twist(x * profile.step, y * profile.step, z * profile.step, yaw * profile.quarter_turn)


def to_json(score: Score) -> dict[str, Any]:
    """The score as JSON values. Each distinct movement is listed once, after the movements inside it."""
    rows: list[list[Any]] = []
    indices: dict[int, int] = {}
    parts = {
        name: {
            "scenes": [_add(scene, rows, indices) for scene in part.scenes],
            "profile": asdict(part.profile),
            "start": asdict(part.start),
            "topic": part.topic,
            "reset": part.reset,
            "use_sim_time": part.use_sim_time,
        }
        for name, part in score.parts.items()
    }
    program = {"text": score.text, "offsets": list(score.offsets.items())}
    world = worlds.to_json(score.world)
    safety = asdict(score.safety)
    return {"tempo": str(score.tempo), "movements": rows, "parts": parts, "world": world, "safety": safety, **program}


class _PartJson(TypedDict):
    scenes: Sequence[int]
    profile: Mapping[str, Any]
    start: Mapping[str, Any]
    topic: str
    reset: str | None
    use_sim_time: bool


class _DeadmanJson(TypedDict):
    topic: str
    button: int


class _SafetyJson(TypedDict):
    stop: str | None
    deadman: _DeadmanJson | None
    rejoin: Rejoin


class _ScoreJson(TypedDict):
    tempo: str
    movements: Sequence[Any]
    parts: Mapping[str, _PartJson]
    world: Mapping[str, Any] | None
    text: str
    offsets: Sequence[Sequence[int]]
    safety: _SafetyJson


def from_json(data: Mapping[str, Any]) -> Score:
    """The score that `to_json` wrote. Raises an exception on anything else, and on what is too much to play."""
    if not fits(data, _ScoreJson):
        raise ValueError("it is not a score")
    made: list[Movement] = []
    for kind, *rest in data["movements"]:
        made.append(_playable(_read(kind, rest, made)))
    parts = {
        name: Part(
            name,
            tuple(_at(scene, made) for scene in part["scenes"]),
            checked(Profile, part["profile"]),
            checked(Pose, part["start"]),
            part["topic"],
            part["reset"],
            part["use_sim_time"],
        )
        for name, part in data["parts"].items()
    }
    if any(not 0 < part.profile.command_rate <= FASTEST_RATE for part in parts.values()):
        raise ValueError("a robot's command rate is out of range")
    world = worlds.from_json(data["world"])
    tempo = Fraction(_above_zero(data["tempo"]))
    if not 1 <= tempo * algebra.LARGEST <= algebra.LARGEST**2:
        raise ValueError("the tempo is out of range")
    safety = data["safety"]
    deadman = Deadman(**safety["deadman"]) if safety["deadman"] else None
    rules = Safety(safety["stop"], deadman, safety["rejoin"])
    return Score(tempo, parts, data["text"], dict(data["offsets"]), world, rules)


def _playable(movement: Movement) -> Movement:
    """A movement that the language would take too, which bounds what it costs to walk it."""
    duration = movement.duration
    is_long = not isinstance(duration, float) and (duration > _LONGEST or algebra.bits(duration) > _MOST_DURATION_BITS)
    if is_long or not _are_playable(movement.bounds):
        raise ValueError("its numbers are too large or its voices too many")
    return movement


@lru_cache(maxsize=10_000)
def _are_playable(bounds: Bounds) -> bool:
    return (
        bounds.width <= algebra.MOST_VOICES
        and bounds.depth <= algebra.MOST_DEPTH
        and bounds.bits <= algebra.MOST_BITS
        and bounds.throws <= algebra.MOST_THROWS
        and not algebra.is_too_fast(bounds.peak)
    )


_LONGEST = algebra.LARGEST**2
_MOST_DURATION_BITS = 4 * algebra.MOST_BITS
"""The durations of one robot's statements share a denominator of up to `MOST_BITS`."""


def _add(whole: Movement, rows: list[list[Any]], indices: dict[int, int]) -> int:
    """Append the rows of a movement, inner ones first, and return its index. Uses an explicit stack for long chains."""
    waiting = [whole]
    while waiting:
        part = waiting[-1]
        inner = [child for child in algebra.parts(part) if id(child) not in indices]
        if inner:
            waiting += inner
            continue
        waiting.pop()
        if id(part) not in indices:
            indices[id(part)] = len(rows)
            rows.append(_row(part, [indices[id(child)] for child in algebra.parts(part)]))
    return indices[id(whole)]


def _row(part: Movement, inner: list[int]) -> list[Any]:
    if isinstance(part, algebra.Hold):
        return ["hold", [_number(value) for value in part.velocity], _number(Fraction(part.duration)), part.span]
    if isinstance(part, algebra.Series):
        return ["series", inner]
    if isinstance(part, algebra.Parallel):
        return ["parallel", inner]
    if isinstance(part, algebra.Repeat):
        return ["repeat", inner[0], part.times]
    if isinstance(part, algebra.Pace):
        return ["pace", inner[0], str(part.rate)]
    if isinstance(part, algebra.Gain):
        return ["gain", inner[0], [_number(value) for value in part.gain]]
    if isinstance(part, algebra.Use):
        return ["use", inner[0], part.span, part.statement]
    if isinstance(part, algebra.Reverse):
        return ["reverse", inner[0]]
    if isinstance(part, ramps.Ramp):
        return ["ramp", inner[0], *map(_number, part.rates)] if part.rates else ["ease", inner[0]]
    if isinstance(part, chances.Choose):
        return ["choose", inner]
    if isinstance(part, chances.Shuffle):
        return ["shuffle", inner]
    if isinstance(part, chances.Chance):
        return ["chance", inner[0], str(part.probability), part.span]
    if isinstance(part, chances.Seed):
        return ["seed", inner[0], str(part.number)]
    assert isinstance(part, chances.Throwing)
    return ["throwing", inner[0], part.throw]


def _number(value: algebra.Exact) -> int | str:
    """An exact number for JSON: an int if it is whole, otherwise text."""
    return value.numerator if value.denominator == 1 else str(value)


@lru_cache(maxsize=1_000)
def _exact(number: int | str) -> algebra.Exact:
    if isinstance(number, int):
        return number
    if not _FRACTION.fullmatch(number):  # an exponent would make a number of any length
        raise ValueError("a number is wrong")
    return algebra.exact(Fraction(number))


_FRACTION = re.compile(r"-?[0-9]{1,2000}(?:/[0-9]{1,2000})?")


def _above_zero(number: int | str) -> algebra.Exact:
    value = _exact(number)
    if value <= 0:
        raise ValueError("a number is not above zero")
    return value


def _velocity(numbers: Sequence[int | str]) -> Velocity:
    return Velocity(*(_exact(number) for number in numbers))


def _count(number: object) -> int:
    if type(number) is not int or not 0 <= number <= algebra.MOST_THROWS:
        raise ValueError("a count is wrong")
    return number


def _span(span: list[int] | None) -> Span | None:
    if span is None:
        return None
    start, end = span
    if type(start) is not int or type(end) is not int:
        raise ValueError("a span is wrong")
    return Span(start, end)


def _at(place: int, made: Sequence[Movement]) -> Movement:
    if place < 0:
        raise ValueError("a movement is missing")
    return made[place]


def _read(kind: str, rest: list[Any], made: list[Movement]) -> Movement:
    if kind == "hold":
        velocity, duration, span = rest
        return algebra.hold(_velocity(velocity), _above_zero(duration), _span(span))
    if make := _OF_SEVERAL.get(kind):
        return make([_at(place, made) for place in rest[0]])
    body = _at(rest[0], made)
    if kind == "repeat":
        return algebra.repeat(body, None if rest[1] is None else _count(rest[1]))
    if kind == "pace":
        return algebra.pace(body, Fraction(_above_zero(rest[1])))
    if kind == "gain":
        return algebra.gain(body, _velocity(rest[1]))
    if kind == "use":
        if type(rest[2]) is not int:
            raise ValueError("the number of a statement is wrong")
        return algebra.use(body, _span(rest[1]), rest[2])
    if kind == "reverse":
        return algebra.reverse(body)
    if kind == "ramp":
        return ramps.ramp(body, _exact(rest[1]), _exact(rest[2]))
    if kind == "ease":
        return ramps.ease(body)
    if kind == "chance":
        return chances.chance(body, Fraction(_exact(rest[1])), _span(rest[2]))
    if kind == "seed":
        return chances.seed(body, Fraction(_exact(rest[1])))
    if kind == "throwing":
        return chances.throwing(body, _count(rest[1]))
    raise ValueError(f"no movement is called {kind!r}")


_OF_SEVERAL: Mapping[str, Callable[[Sequence[Movement]], Movement]] = {
    "series": algebra.series,
    "parallel": algebra.parallel,
    "choose": chances.choose,
    "shuffle": chances.shuffle,
}
