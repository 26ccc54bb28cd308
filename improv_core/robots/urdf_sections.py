"""Proposes the sections of `improv.toml` for a body from its URDF. Comments list what the URDF doesn't say."""

from __future__ import annotations

import json
import math
import re
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from typing import NamedTuple

from improv_core.robots.urdf import TURNING, Urdf, UrdfError, UrdfJoint, Vector, unit
from improv_core.syntax.vocabulary import WORDS
from improv_core.text import free_name

BEAT_DEGREES, BEAT_METERS = 30, 0.05
"""Movement of a joint per beat unless people write another value: a third of a right angle, two inches."""
STEP = 0.2
"""Meters: a URDF doesn't say how far the base drives, and the built-in profiles of bases have this value."""
_ALONG = 0.9
"""The least cosine at which two directions count as the same, about 26 degrees apart."""


def sections(
    urdf: Urdf,
    source: str,
    profile: str | None = None,
    tips: Mapping[str, str] | None = None,
    file: str | None = None,
) -> str:
    """Return sections for a profile with this body: parts, their directions, and the limits of their joints.

    Without `tips`, each chain of joints that ends in a leaf of the tree is a part. With it, a part is the joints that
    carry its tip, a link, except those that carry the tip of another part. `source`, in printable text, is the origin
    of the URDF, and `file` its path, if it is in a file that can be read again. Raises UrdfError.
    """
    name = profile or _word(urdf.name) or "robot"
    parts = _named(urdf, tips) if tips else _leaves(urdf)
    if not parts:
        raise UrdfError(0, "no joint in it has a motor, so there is nothing to move")
    frames = _frames(urdf)
    parts = [part for part in parts if tips or any(_direction(joint, part, frames) for joint in part.joints)]
    taken = {joint.name for part in parts for joint in part.joints}
    table = f"profiles.{_key(name)}"
    lines = [
        f"# From {source}. Check to which side each direction moves its joint, and how far in a beat.",
        "# Joints behind # have no direction yet: give them forward, strafeleft, up, or left, or a part of their own",
        "# (improv body --part NAME=LINK).",
        f"[{table}]",
        f"step = {STEP} # meters that its base drives in a beat: write yours",
        'joint_states = "joint_states"',
        *(
            [f"urdf = {_text(file)} # the page draws the robot from it; the path is from the folder of improv.toml"]
            if file
            else []
        ),
    ]
    proposed: set[str] = set()
    for part in parts:
        lines += ["", f"[{table}.body.{_key(part.name)}] # what moves {part.tip}"]
        lines += [f"mirror = {_text(other.name)}" for other in parts if _mirrors(part, other)]
        directions = _directions(part, frames)
        proposed |= {joint.name for joint in directions.values()}
        lines += _rows(part, directions)
    for joint in (joint for part in parts for joint in part.joints):
        section = [f"[{table}.joints.{_key(joint.name)}]", *_limits(joint)]
        lines += ["", *(section if joint.name in proposed else [f"# {line.removeprefix('# ')}" for line in section])]
    rest = [f"# {joint.name}: {why}" for joint in urdf.joints if (why := _left_out(joint, taken))]
    if rest:
        lines += ["", "# In no part:", *rest]
    return "\n".join([*lines, ""])


@dataclass(frozen=True, slots=True)
class _Part:
    name: str
    tip: str
    joints: tuple[UrdfJoint, ...]


def _named(urdf: Urdf, tips: Mapping[str, str]) -> list[_Part]:
    carrier = {joint.child: joint for joint in urdf.joints}
    for name, tip in tips.items():
        if problem := _unusable(name):
            raise UrdfError(0, problem)
        if tip not in carrier and tip != urdf.root:
            raise UrdfError(0, f"the file has no link {tip!r}: name another tip for the part {name!r}")
    paths = {name: _path(tip, carrier) for name, tip in tips.items()}
    parts, taken = [], set[str]()
    # A joint that carries two tips belongs to the one nearest to the root: a torso, not an arm.
    for name in sorted(paths, key=lambda name: len(paths[name])):
        joints = tuple(joint for joint in paths[name] if joint.driven and joint.name not in taken)
        if not joints:
            raise UrdfError(0, f"no joint with a motor is left for the part {name!r}, with the tip {tips[name]!r}")
        taken |= {joint.name for joint in joints}
        parts.append(_Part(name, tips[name], joints))
    return [part for name in tips for part in parts if part.name == name]


def _path(tip: str, carrier: Mapping[str, UrdfJoint]) -> list[UrdfJoint]:
    joints = []
    while joint := carrier.get(tip):
        joints.append(joint)
        tip = joint.parent
    return joints[::-1]


def _leaves(urdf: Urdf) -> list[_Part]:
    """Return the chains of driven joints after the last fork."""
    above: dict[str, UrdfJoint | None] = {urdf.root: None}  # the driven joint that carries a link
    below: dict[str, list[UrdfJoint]] = {}
    for joint in urdf.joints:
        before = above[joint.parent]
        above[joint.child] = joint if joint.driven else before
        if joint.driven and before:
            below.setdefault(before.name, []).append(joint)
    parts: list[_Part] = []
    for last in (joint for joint in urdf.joints if joint.driven and joint.name not in below):
        chain = [last]
        while (before := above[chain[-1].parent]) and len(below[before.name]) == 1:
            chain.append(before)
        name = free_name(_word(last.child.removesuffix("_link")) or "part", {part.name for part in parts})
        parts.append(_Part(name, last.child, tuple(chain[::-1])))
    return parts


@dataclass(frozen=True, slots=True)
class _Frame:
    """Pose of a joint while all joints are at 0, in the frame of the root."""

    place: Vector
    axis: Vector


_Matrix = tuple[Vector, Vector, Vector]
"""A rotation, as rows."""
_LEVEL: _Matrix = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))


def _frames(urdf: Urdf) -> dict[str, _Frame]:
    """Return a frame for each link, with the axis of the joint that carries it."""
    placed: dict[str, tuple[Vector, _Matrix]] = {urdf.root: ((0.0, 0.0, 0.0), _LEVEL)}
    frames: dict[str, _Frame] = {}
    for joint in urdf.joints:
        place, turn = placed[joint.parent]
        x, y, z = _turned(turn, joint.place)
        place = (place[0] + x, place[1] + y, place[2] + z)
        rows = tuple(zip(*(_turned(turn, column) for column in zip(*_rotation(joint.turn), strict=True)), strict=True))
        turn = (rows[0], rows[1], rows[2])
        placed[joint.child] = (place, turn)
        frames[joint.child] = _Frame(place, unit(_turned(turn, joint.axis)))
    return frames


def _rotation(turn: Vector) -> _Matrix:
    """Rotate by roll, pitch, and yaw about fixed axes, as URDF has them: Rz(yaw) Ry(pitch) Rx(roll)."""
    (sr, sp, sy), (cr, cp, cy) = map(math.sin, turn), map(math.cos, turn)
    return (
        (cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr),
        (sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr),
        (-sp, cp * sr, cp * cr),
    )


def _turned(turn: _Matrix, vector: Vector) -> Vector:
    x, y, z = (sum(a * b for a, b in zip(row, vector, strict=True)) for row in turn)
    return x, y, z


def _directions(part: _Part, frames: Mapping[str, _Frame]) -> dict[_Direction, UrdfJoint]:
    """Return the direction of each joint of a part that has a clear one, unless a joint nearer to the root has it."""
    found: dict[_Direction, UrdfJoint] = {}
    for joint in part.joints:
        direction = _direction(joint, part, frames)
        if direction and all(each.name != direction.name for each in found):
            found[direction] = joint
    return found


def _rows(part: _Part, directions: Mapping[_Direction, UrdfJoint]) -> Iterator[str]:
    for direction, joint in directions.items():
        unit, far = ("degrees", BEAT_DEGREES) if joint.kind in TURNING else ("meters", BEAT_METERS)
        yield f"{direction.name} = {{ joint = {_text(joint.name)}, {unit} = {direction.sign * far:g} }}"
    yield from (f"# {joint.name}: choose a direction" for joint in part.joints if joint not in directions.values())


class _Direction(NamedTuple):
    name: str
    sign: int


def _direction(joint: UrdfJoint, part: _Part, frames: Mapping[str, _Frame]) -> _Direction | None:
    """Return the direction in which a joint moves its part's tip while all joints are at 0. None if that is none of
    ours.

    A joint about the vertical turns `left`. Any other joint moves the tip along axis × (tip - joint) (Lynch & Park,
    Modern Robotics, 5.1), and a slider along its axis. A joint that has the tip on its axis, turns about the y axis,
    and, unlike a wheel, has limits looks `up`.
    """
    (ax, ay, az), place = frames[joint.child].axis, frames[joint.child].place
    if joint.kind not in TURNING:
        return _along(frames[joint.child].axis)
    if abs(az) > _ALONG:
        return _Direction("left", _sign(az))
    x, y, z = (tip - own for tip, own in zip(frames[part.tip].place, place, strict=True))
    way = (ay * z - az * y, az * x - ax * z, ax * y - ay * x)
    if math.hypot(*way) > _ON_AXIS:
        return _along(unit(way))
    return _Direction("up", -_sign(ay)) if abs(ay) > _ALONG and joint.kind == "revolute" else None


_ON_AXIS = 0.005
"""Meters from the axis within which a tip counts as on it."""


def _along(way: Vector) -> _Direction | None:
    names = zip(("forward", "strafeleft", "up"), way, strict=True)
    return next((_Direction(name, _sign(share)) for name, share in names if abs(share) > _ALONG), None)


def _sign(number: float) -> int:
    return 1 if number > 0 else -1


def _limits(joint: UrdfJoint) -> Iterator[str]:
    turning = joint.kind in TURNING
    for key, limit in (("min", joint.lower), ("max", joint.upper)):
        if limit is not None:
            yield f"{key} = {_number(limit, turning)}"
        elif joint.kind != "continuous":
            yield f"# The file sets no {key}."
    if joint.velocity:
        yield f"max_velocity = {_number(joint.velocity, turning)}"
    else:
        yield "# The file sets no speed limit: write a max_velocity."
    if joint.lower is not None and joint.upper is not None and not joint.lower <= 0 <= joint.upper:
        middle = _number((joint.lower + joint.upper) / 2, turning)
        yield f"start = {middle} # the middle of its limits, which don't include 0"


def _number(value: float, turning: bool) -> str:
    """Format degrees or meters, rounded so that one turn and its fractions read as people write them."""
    return f"{round(math.degrees(value) if turning else value, 4) + 0.0:.10g}"  # never -0


def _left_out(joint: UrdfJoint, taken: Iterable[str]) -> str | None:
    if joint.name in taken or joint.kind == "fixed":
        return None
    if joint.follows:
        return f"it follows {joint.follows}"
    if not joint.driven:
        return f"no single number moves a {joint.kind} joint"
    return f"it carries {joint.child}; --part NAME={joint.child} makes it a part"


_SIDES = {"left": "right", "l": "r"}
_SIDE = re.compile(r"(?<![a-z])(left|right|l|r)(?![a-z])|^([lr])(?=[A-Z])|^(left|right)(?=[A-Z])", re.IGNORECASE)
_PAIRS = _SIDES | {other: side for side, other in _SIDES.items()}


def _mirrors(part: _Part, other: _Part) -> bool:
    """True if `part` is the left one of two that mirror each other, by the names of their joints."""
    ours, theirs = [joint.name for joint in part.joints], [joint.name for joint in other.joints]
    left = any(match[0].lower() in _SIDES for match in map(_SIDE.search, ours) if match)
    return left and part is not other and [_SIDE.sub(_exchanged, name) for name in ours] == theirs


def _exchanged(match: re.Match[str]) -> str:
    side = match[0]
    other = _PAIRS[side.lower()]
    return other.upper() if side.isupper() else other.capitalize() if side[0].isupper() else other


def _unusable(name: str) -> str | None:
    if not name.isidentifier():
        return f"{name!r} can't be the name of a part: write letters, digits, and _"
    return f"{name!r} is a word of the language: call the part something else" if name in (*WORDS, "to") else None


def _word(text: str) -> str:
    word = re.sub(r"\W+", "_", text).strip("_")
    return word if word and not _unusable(word) else f"part_{word}" if word else ""


def _key(name: str) -> str:
    return name if re.fullmatch(r"[A-Za-z0-9_-]+", name) else _text(name)


def _text(name: str) -> str:
    return json.dumps(name, ensure_ascii=False)
