"""A score: which robot plays which movement, how fast. What the stage is given to play. Standard library only."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, field
from fractions import Fraction
from functools import lru_cache
from typing import Any, Literal

from improv_core.score import movement as algebra
from improv_core.score import world as worlds
from improv_core.score.motion import Pose, Twist
from improv_core.score.movement import Movement, Velocity
from improv_core.score.profiles import Profile
from improv_core.score.world import World
from improv_core.text import Span


@dataclass(frozen=True, slots=True)
class Part:
    """One robot's part: what it plays, what kind of robot it is, where it starts and where it listens.

    `reset` names the service that puts it at its start, if there is one. With `use_sim_time` what it is sent is stamped
    with the time on /clock.
    """

    robot: str
    movement: Movement
    profile: Profile
    start: Pose
    topic: str
    reset: str | None = None
    use_sim_time: bool = False


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
    """All parts, played together from beat 0 at `tempo` beats per minute.

    `world` is what stands around simulated robots. For the page, `text` is the program, and `offsets` are the places in
    it where statements begin, by their number.
    """

    tempo: Fraction
    parts: Mapping[str, Part]
    text: str = ""
    offsets: Mapping[int, int] = field(default_factory=dict)
    world: World = worlds.EMPTY
    safety: Safety = Safety()

    @property
    def beats(self) -> algebra.Duration:
        """How long the longest part lasts."""
        return max((part.movement.duration for part in self.parts.values()), default=0)

    def seconds(self, beats: algebra.Duration) -> float:
        """The time these beats take."""
        return float(beats * 60 / self.tempo)


def twist(velocity: Velocity, profile: Profile, tempo: Fraction) -> Twist:
    """A velocity in SI units: steps per beat times metres per step times beats per second."""
    per_second = tempo / 60
    x, y, z, yaw = (float(value * per_second) if value else 0.0 for value in velocity)
    return Twist(x * profile.step, y * profile.step, z * profile.step, yaw * profile.quarter_turn)


def to_json(score: Score) -> dict[str, Any]:
    """The score as JSON values: each distinct part of a movement once, before what is made of it."""
    rows: list[list[Any]] = []
    places: dict[int, int] = {}
    parts = {
        name: {
            "movement": _add(part.movement, rows, places),
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


def from_json(data: Mapping[str, Any]) -> Score:
    """The score that `to_json` wrote. Raises KeyError, ValueError or TypeError on anything else."""
    made: list[Movement] = []
    for kind, *rest in data["movements"]:
        made.append(_read(kind, rest, made))
    parts = {
        name: Part(
            name,
            made[part["movement"]],
            Profile(**part["profile"]),
            Pose(**part["start"]),
            part["topic"],
            part["reset"],
            part["use_sim_time"],
        )
        for name, part in data["parts"].items()
    }
    world = worlds.from_json(data["world"])
    safety = data["safety"]
    deadman = Deadman(**safety["deadman"]) if safety["deadman"] else None
    safety = Safety(safety["stop"], deadman, safety["rejoin"])
    return Score(Fraction(data["tempo"]), parts, data["text"], dict(data["offsets"]), world, safety)


def _add(whole: Movement, rows: list[list[Any]], places: dict[int, int]) -> int:
    """Append the rows of a movement, parts first, and return its own place; an explicit stack, for long chains."""
    waiting = [whole]
    while waiting:
        part = waiting[-1]
        inner = [child for child in algebra.parts(part) if id(child) not in places]
        if inner:
            waiting += inner
            continue
        waiting.pop()
        if id(part) not in places:
            places[id(part)] = len(rows)
            rows.append(_row(part, [places[id(child)] for child in algebra.parts(part)]))
    return places[id(whole)]


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
    return ["reverse", inner[0]]


def _number(value: algebra.Exact) -> int | str:
    """An exact number: most are whole, and come as they are."""
    return value.numerator if value.denominator == 1 else str(value)


@lru_cache(maxsize=1_000)
def _exact(number: int | str) -> algebra.Exact:
    return number if isinstance(number, int) else algebra.exact(Fraction(number))


def _velocity(numbers: Sequence[int | str]) -> Velocity:
    return Velocity(*(_exact(number) for number in numbers))


def _read(kind: str, rest: list[Any], made: list[Movement]) -> Movement:
    if kind == "hold":
        velocity, duration, span = rest
        return algebra.hold(_velocity(velocity), _exact(duration), Span(*span) if span else None)
    if kind == "series":
        return algebra.series([made[place] for place in rest[0]])
    if kind == "parallel":
        return algebra.parallel([made[place] for place in rest[0]])
    body = made[rest[0]]
    if kind == "repeat":
        return algebra.repeat(body, rest[1])
    if kind == "pace":
        return algebra.pace(body, Fraction(rest[1]))
    if kind == "gain":
        return algebra.gain(body, _velocity(rest[1]))
    if kind == "use":
        return algebra.use(body, Span(*rest[1]) if rest[1] else None, rest[2])
    if kind == "reverse":
        return algebra.reverse(body)
    raise ValueError(f"no movement is called {kind!r}")
