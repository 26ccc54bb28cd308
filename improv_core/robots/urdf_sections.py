"""Proposes the sections of `improv.toml` for a body from its URDF. Comments list what the URDF doesn't say."""

from __future__ import annotations

import json
import math
import re
from collections.abc import Collection, Iterator, Mapping

from improv_core.robots.schema import known
from improv_core.robots.urdf import TURNING, Urdf, UrdfError, UrdfJoint
from improv_core.robots.urdf_parts import UrdfBody, UrdfDirection, UrdfPart, drives_base, has_room, mirrors, word_of
from improv_core.score.profiles import BUILT_IN
from improv_core.text import free_name

BEAT_DEGREES, BEAT_METERS = 30, 0.05
"""Movement of a joint per beat unless people write another value: a third of a right angle, two inches."""
STEP = 0.2
"""Meters: a URDF doesn't say how far the base drives, and the built-in profiles of bases have this value."""


def sections(
    urdf: Urdf, source: str, profile: str | None = None, tips: Mapping[str, str] | None = None, file: str | None = None
) -> str:
    """Return sections for a profile with this body: parts, their directions, and the limits of their joints.

    Without `tips`, the parts are what people would name, such as `left_elbow`. With it, a part is the joints that carry
    its tip, a link, except those that carry the tip of another part. `source`, in printable text, is the origin of the
    URDF, and `file` its path, if it is in a file that can be read again. Raises UrdfError.
    """
    table = f"profiles.{_key(free_name(profile or word_of(urdf.name) or 'robot', BUILT_IN))}"
    body = UrdfBody(urdf)
    parts, groups = (body.named(tips), {}) if tips else body.found()
    if not parts:
        raise UrdfError(0, "nothing in it can dance: its joints are wheels, or have no motor or no room to move")
    lines = [
        f"# From {source}. Check to which side each direction moves its joint, and how far in a beat.",
        "# A guess: the joint moves its part in no clear direction, or another joint has that one.",
        f"[{table}]",
        f"step = {STEP} # meters that its base drives in a beat: write yours",
        'joint_states = "joint_states"',
    ]
    if file:
        lines += [
            f"urdf = {_text(file)} # the page draws the robot from it; the path is from the folder of improv.toml"
        ]
    mirrored, joints = mirrors(parts), list[str]()
    for part in parts:
        lines += ["", f"[{table}.body.{_key(part.name)}] # what moves {part.tip}"]
        lines += [f"mirror = {_text(mirrored[part.name])}"] if part.name in mirrored else []
        ways = body.directions(part)
        lines += _rows(part, ways)
        for joint in part.joints:
            section = [f"[{table}.joints.{_key(joint.name)}]", *_limits(joint)]
            joints += ["", *(section if joint.name in ways else [f"# {line.removeprefix('# ')}" for line in section])]
    for group, names in groups.items():
        lines += ["", f"[{table}.body.{_key(group)}]", f"parts = [{', '.join(map(_text, names))}]"]
    taken = {joint.name for part in parts for joint in part.joints}
    rest = [f"# {joint.name}: {why}" for joint in urdf.joints if (why := _left_out(joint, taken))]
    return "\n".join([*lines, *joints, *(["", "# In no part:", *rest] if rest else []), ""])


def _rows(part: UrdfPart, directions: Mapping[str, UrdfDirection]) -> Iterator[str]:
    for joint in part.joints:
        if way := directions.get(joint.name):
            unit = "degrees" if joint.kind in TURNING else "meters"
            guess = "" if way.is_clear else " # a guess"
            yield f"{way.name} = {{ joint = {_text(joint.name)}, {unit} = {way.sign * _per_beat(joint):g} }}{guess}"
        else:
            yield f"# {joint.name}: choose a direction"


def _per_beat(joint: UrdfJoint) -> float:
    """Return the movement of a joint in a beat, halved until it has the room and the time for that."""
    far, low, high = float(BEAT_DEGREES if joint.kind in TURNING else BEAT_METERS), *_ends(joint)
    most = [] if low is None or high is None else [max(high - _start(joint), _start(joint) - low)]
    if (speed := _accepted("max_velocity", joint.velocity, joint)) is not None:
        most.append(speed)
    while far > _in_file(min(most, default=math.inf), joint):
        far /= 2
    return round(far, 4)


def _ends(joint: UrdfJoint) -> tuple[float | None, float | None]:
    return _accepted("min", joint.lower, joint), _accepted("max", joint.upper, joint)


def _start(joint: UrdfJoint) -> float:
    """Return 0, or else the middle of the limits of a joint."""
    low, high = _ends(joint)
    if (low is None or low <= 0) and (high is None or high >= 0):
        return 0.0
    inside = [each for each in (low, high) if each is not None]
    return sum(inside) / len(inside)


def _limits(joint: UrdfJoint) -> Iterator[str]:
    for key, own, limit in zip(("min", "max"), (joint.lower, joint.upper), _ends(joint), strict=True):
        if limit is not None:
            yield f"{key} = {_number(limit, joint)}"
        elif joint.kind != "continuous":
            yield f"# {_missing(key, own, joint)}."
    speed = _accepted("max_velocity", joint.velocity, joint)
    if speed is not None:
        yield f"max_velocity = {_number(speed, joint)}"
    else:
        yield f"# {_missing('speed limit', joint.velocity or None, joint)}: write a max_velocity."
    if start := _start(joint):
        yield f"start = {_number(start, joint)} # within its limits, which don't include 0"


def _missing(what: str, value: float | None, joint: UrdfJoint) -> str:
    if value is None:
        return f"The file sets no {what}"
    return f"The file's {what}, {_number(value, joint)}, is none that a robot has"


def _accepted(key: str, value: float | None, joint: UrdfJoint) -> float | None:
    """Return a limit of a joint in the file's units if `improv.toml` accepts it: placeholders, such as 1000 rad/s, are
    beyond that."""
    allowed = known(("profiles", "", "joints", "", key))
    return value if value is not None and allowed.least <= _in_file(value, joint) <= allowed.most else None


def _in_file(value: float, joint: UrdfJoint) -> float:
    """Convert radians to degrees; meters stay."""
    return math.degrees(value) if joint.kind in TURNING else value


def _number(value: float, joint: UrdfJoint) -> str:
    """Format degrees or meters, rounded so that one turn and its fractions read as people write them."""
    return f"{round(_in_file(value, joint), 4) + 0.0:.10g}"  # never -0


def _left_out(joint: UrdfJoint, taken: Collection[str]) -> str | None:
    if joint.name in taken or joint.kind == "fixed":
        return None
    if joint.follows:
        return f"it follows {joint.follows}"
    if not joint.driven:
        return f"no single number moves a {joint.kind} joint"
    if not has_room(joint):
        return "its limits leave it no room"
    what = "it seems to drive the base" if drives_base(joint) else f"it carries {joint.child}"
    return f"{what}; --part NAME={joint.child} makes it a part"


def _key(name: str) -> str:
    return name if re.fullmatch(r"[A-Za-z0-9_-]+", name) else _text(name)


def _text(name: str) -> str:
    return json.dumps(name, ensure_ascii=False)
