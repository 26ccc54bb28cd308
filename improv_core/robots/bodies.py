"""Reads the bodies of profiles: body parts, groups, poses, joints, and controllers."""

from __future__ import annotations

import math
import re
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, cast

from improv_core.robots.ros_names import ros_name
from improv_core.robots.schema_robots import DRIVE
from improv_core.robots.toml_positions import Keys
from improv_core.robots.toml_reading import TomlReading, listed
from improv_core.score.body import START, Body, BodyGroup, BodyPart, BodyPose, Controller, Drive, Interface, Joint
from improv_core.syntax.vocabulary import WORDS

DIRECTIONS: Mapping[str, str] = {"forward": "x", "strafeleft": "y", "up": "z", "left": "yaw"}
"""Directions that a body part may have, with the component of the velocity of each. Their opposites are derived."""
SIDEWAYS = ("y", "yaw")
"""The components that a mirror negates."""
_NAME = re.compile(r"[^\W\d]\w*")
_CONTROLLER_NAME = re.compile(r"[A-Za-z_][A-Za-z0-9_]*")
_SLACK = 1e-9


def read_body(
    reading: TomlReading, keys: Keys, table: Mapping[str, Any], values: Mapping[str, Any], base: Body | None
) -> Body | None:
    """Read the body of a profile: the file's `values` and sections replace those of `base`. Reports errors."""
    if not table.keys() & {"body", "joints", "controllers", "joint_states", "home", "urdf"}:
        return base
    base = base or Body()
    made = _Bodies(reading, keys)
    parts, groups = made.parts(reading.table((*keys, "body"), table.get("body", {})), base)
    slides = {drive.joint: made.slides.get(drive.joint, False) for part in parts.values() for drive in part.drives}
    slides |= {name: joint.slides for name, joint in base.joint.items() if name in slides and name not in made.slides}
    joints = made.joints(reading.table((*keys, "joints"), table.get("joints", {})), slides, base)
    parts = {name: made.posed(part, joints) for name, part in parts.items()}
    controllers = made.controllers(reading.table((*keys, "controllers"), table.get("controllers", {})), joints, base)
    states, home = values["joint_states"], values["home"] or base.home
    states = states if ros_name(reading, (*keys, "joint_states"), states, "") else base.joint_states
    if home == "move":
        made.can_move_home((*keys, "home") if "home" in table else keys, states, controllers, joints)
    return Body(
        tuple(made.mirrored(part, parts, joints) for part in parts.values()),
        tuple(groups.values()),
        tuple(joints.values()),
        tuple(controllers),
        states,
        home,
        values["urdf"] or base.urdf,
    )


def with_offsets(reading: TomlReading, keys: Keys, value: Any, body: Body | None) -> Body | None:
    """Read the offsets of one robot's joints into the body of its profile. Errors are reported."""
    changed = {}
    for name, own in reading.table(keys, value).items():
        if joint := body and body.joint.get(name):
            found = reading.values((*keys, name), reading.table((*keys, name), own))
            offset = found.get("offset", 0.0)
            changed[name] = replace(joint, offset=offset if joint.slides else math.radians(offset))
        else:
            advice = f"write one of {listed(list(body.joint))}" if body and body.joint else "remove this"
            reading.at_key((*keys, name), f"its profile has no joint `{name}`: {advice}", whole=True)
    if not (body and changed):
        return body
    return replace(body, joints=tuple(changed.get(each.name, each) for each in body.joints))


@dataclass(slots=True)
class _Bodies:
    """Reads one body. `owners` has the direction that moves each joint; if it `slides`, its values are in meters."""

    reading: TomlReading
    keys: Keys
    owners: dict[str, str] = field(default_factory=dict)
    slides: dict[str, bool] = field(default_factory=dict)
    own: dict[str, Mapping[str, Any]] = field(default_factory=dict)

    def parts(self, tables: Mapping[str, Any], base: Body) -> tuple[dict[str, BodyPart], dict[str, BodyGroup]]:
        reading, keys = self.reading, (*self.keys, "body")
        own = {name: reading.table((*keys, name), value) for name, value in tables.items()}
        named = [name for name in own if self._is_free((*keys, name), name, "body part")]
        groups = {each.name: each for each in base.groups if each.name not in own}
        parts = {each.name: each for each in base.parts if each.name not in own}
        self.owners = {drive.joint: f"{part.name}" for part in parts.values() for drive in part.drives}
        self.own = {name: own[name] for name in named if "parts" not in own[name]}
        for name, table in self.own.items():
            drives = tuple(
                filter(None, (self._drive((*keys, name, each), table[each]) for each in table if each in DIRECTIONS))
            )
            if isinstance(tables[name], dict) and tables[name].keys() <= {"mirror", "poses"}:
                message = f"`{name}` moves nothing: add a direction, such as `left = {DRIVE}`"
                reading.at_key((*keys, name), message, whole=True)
            parts[name] = BodyPart(name, drives)
        for name, table in self.own.items():
            if mirror := reading.text((*keys, name, "mirror"), table.get("mirror")):
                self._mirror((*keys, name, "mirror"), name, mirror, parts)
        for name in named:
            if "parts" in own[name]:
                groups[name] = BodyGroup(name, self._group((*keys, name), own[name], parts))
        return parts, {name: group for name, group in groups.items() if group.parts}

    def _is_free(self, keys: Keys, name: str, what: str) -> bool:
        if not _NAME.fullmatch(name):
            self.reading.at_key(keys, f"`{name}` can't be the name of a {what}: use letters, digits, and `_`")
        elif name in WORDS or name == "to" or (what == "pose" and name == START):
            self.reading.at_key(keys, f"`{name}` is a word of the language: choose another name for this {what}")
        else:
            return True
        return False

    def _drive(self, keys: Keys, value: Any) -> Drive | None:
        reading, direction = self.reading, str(keys[-1])
        if not isinstance(value, dict) or "joint" not in value or len(value.keys() & {"degrees", "meters"}) != 1:
            reading.at_value(keys, f"write `{direction}` as a joint and degrees, or meters: `{DRIVE}`", whole=True)
            return None
        values, unit = reading.values(keys, reading.table(keys, value)), "meters" if "meters" in value else "degrees"
        joint, amount = values.get("joint"), values.get(unit)
        if joint is None or amount is None:
            return None
        if not amount:
            reading.at_value((*keys, unit), f"write `{unit}` as a number other than 0")
            return None
        here = f"`{direction}` of `{keys[-2]}`"
        if self.owners.setdefault(joint, here) != here:
            other = self.owners[joint]
            reading.at_value((*keys, "joint"), f"{other} already moves `{joint}`: give each direction its own joint")
            return None
        self.slides[joint] = unit == "meters"
        return Drive(DIRECTIONS[direction], joint, amount if unit == "meters" else math.radians(amount))

    def _mirror(self, keys: Keys, name: str, mirror: str, parts: dict[str, BodyPart]) -> None:
        if mirror not in parts or mirror == name:
            others = [each for each in parts if each != name]
            advice = f"write one of {listed(others)}" if others else "remove this line"
            self.reading.at_value(keys, f"`{mirror}` is not another body part of this profile: {advice}", whole=True)
        elif any(parts[each].mirror not in (None, other) for each, other in ((name, mirror), (mirror, name))):
            self.reading.at_value(keys, f"`{mirror}` or `{name}` has another mirror already: remove one of them")
        else:
            parts[name] = replace(parts[name], mirror=mirror)
            parts[mirror] = replace(parts[mirror], mirror=name)

    def _group(self, keys: Keys, table: Mapping[str, Any], parts: Collection[str]) -> tuple[str, ...]:
        for key in table:
            if key != "parts":
                self.reading.at_key(
                    (*keys, key), f"`{keys[-1]}` is a group of body parts, so it has no `{key}`: remove it"
                )
        value = table["parts"] if self.reading.value((*keys, "parts"), table["parts"]) else ()
        for place, each in enumerate(value):
            if isinstance(each, str) and each not in parts:
                message = f"a group stands for body parts, not for groups: write one of {listed(list(parts))}"
                self.reading.at_value((*keys, "parts", place), message, whole=True)
        return tuple(dict.fromkeys(each for each in value if isinstance(each, str) and each in parts))

    def joints(self, tables: Mapping[str, Any], slides: Mapping[str, bool], base: Body) -> dict[str, Joint]:
        keys = (*self.keys, "joints")
        for name in tables:
            if name not in slides:
                self.reading.at_key(
                    (*keys, name), f"no direction moves `{name}`: name it in one or remove this", whole=True
                )
        return {
            name: self._joint((*keys, name), tables.get(name), base.joint.get(name) or Joint(name), is_sliding)
            for name, is_sliding in slides.items()
        }

    def _joint(self, keys: Keys, value: Any, base: Joint, slides: bool) -> Joint:
        joint = replace(base, slides=slides)
        if value is None:
            return joint
        table = self.reading.table(keys, value)
        found = self.reading.values(keys, table)
        changes: dict[str, Any] = {
            name: each if slides or isinstance(each, bool) else math.radians(each) for name, each in found.items()
        }
        joint = replace(joint, **changes)
        if joint.min is not None and joint.max is not None and joint.min > joint.max:
            key = "min" if "min" in table else "max"
            self.reading.at_value((*keys, key), "`min` is greater than `max`: swap them")
            return replace(joint, min=None, max=None)
        if abs(joint.within(joint.start) - joint.start) > _SLACK:
            key = next((each for each in ("start", "min", "max") if each in table), "start")
            self.reading.at_value((*keys, key), "`start` is beyond `min` or `max`: write one between them")
            return replace(joint, start=joint.within(joint.start))
        return joint

    def posed(self, part: BodyPart, joints: Mapping[str, Joint]) -> BodyPart:
        """Add the poses in a part's own table to it."""
        if part.name not in self.own:
            return part
        keys = (*self.keys, "body", part.name, "poses")
        tables = self.reading.table(keys, self.own[part.name].get("poses", {}))
        poses = [self._pose((*keys, name), value, part, joints) for name, value in tables.items()]
        return replace(part, poses=tuple(each for each in poses if each))

    def _pose(self, keys: Keys, value: Any, part: BodyPart, joints: Mapping[str, Joint]) -> BodyPose | None:
        if not self._is_free(keys, str(keys[-1]), "pose"):
            return None
        steps = {}
        for name, amount in self.reading.values(keys, self.reading.table(keys, value)).items():
            drive = part.drive(DIRECTIONS[name])
            if not drive:
                self.reading.at_key(
                    (*keys, name), f"`{part.name}` has no direction `{name}`: remove this or declare it"
                )
                continue
            joint = joints[drive.joint]
            own = amount if joint.slides else math.radians(amount)
            steps[drive.direction] = own / abs(drive.per_step)
            if not self._reaches(joint, steps[drive.direction] * drive.per_step):
                self.reading.at_value((*keys, name), f"this is beyond the limits of `{joint.name}`: {_limits(joint)}")
        return BodyPose(str(keys[-1]), steps)

    def mirrored(self, part: BodyPart, parts: Mapping[str, BodyPart], joints: Mapping[str, Joint]) -> BodyPart:
        """Add the mirror images of the poses that only its mirror has."""
        other = parts[part.mirror] if part.mirror else None
        images = []
        for pose in other.poses if other else ():
            if part.has_pose(pose.name):
                continue
            steps = {
                direction: -value if direction in SIDEWAYS else value
                for direction, value in pose.steps.items()
                if part.drive(direction)
            }
            for drive in part.drives:
                joint = joints[drive.joint]
                if drive.direction in steps and not self._reaches(joint, steps[drive.direction] * drive.per_step):
                    keys = (*self.keys, "body", str(part.mirror), "poses", pose.name)
                    message = f"its mirror image is beyond the limits of `{joint.name}`: {_limits(joint)}"
                    self.reading.at_key(keys, message, whole=True)
            images.append(BodyPose(pose.name, steps))
        return replace(part, poses=(*part.poses, *images))

    def _reaches(self, joint: Joint, position: float) -> bool:
        return abs(joint.within(position) - position) <= _SLACK

    def controllers(self, tables: Mapping[str, Any], joints: Collection[str], base: Body) -> list[Controller]:
        keys, reading = (*self.keys, "controllers"), self.reading
        made = []
        taken: dict[str, str] = {}
        before = len(reading.diagnostics)
        for name, value in tables.items():
            table = reading.table((*keys, name), value)
            found = table.get("joints")
            if not isinstance(found, list) or not found:
                reading.at_key((*keys, name), f'add the joints of `{name}`: `joints = ["head_yaw"]`', whole=True)
                continue
            for place, joint in enumerate(found):
                if not (isinstance(joint, str) and joint and joint.isprintable()):
                    reading.at_value((*keys, name, "joints", place), 'write the name of a joint: `"head_yaw"`')
                elif joint in found[:place]:
                    reading.at_value((*keys, name, "joints", place), f"`{joint}` is here twice: remove one")
                elif taken.setdefault(joint, name) != name:
                    reading.at_value(
                        (*keys, name, "joints", place), f"`{taken[joint]}` already moves `{joint}`: remove one"
                    )
            interface = reading.text((*keys, name, "interface"), table.get("interface")) or "trajectory"
            topic = reading.text((*keys, name, "topic"), table.get("topic"))
            ros_name(reading, (*keys, name, "topic"), topic, "")
            if "topic" not in table and not _CONTROLLER_NAME.fullmatch(name):
                reading.at_key((*keys, name), f"`{name}` can't be part of a topic: use a to z, digits, and `_`")
            used = tuple(dict.fromkeys(each for each in found if isinstance(each, str)))
            made.append(Controller(name, used, cast(Interface, interface), topic))
        if made and len(reading.diagnostics) == before and (left := [joint for joint in joints if joint not in taken]):
            reading.at_key(keys, f"no controller moves `{left[0]}`: add it to the `joints` of one", whole=True)
        return made or [each for each in base.controllers if not set(joints).isdisjoint(each.joints)]

    def can_move_home(
        self, keys: Keys, states: str | None, controllers: Sequence[Controller], joints: Mapping[str, Joint]
    ) -> None:
        """Report the reason if joints can't move to their starts."""
        slow = next((name for name, joint in joints.items() if joint.max_velocity is None), None)
        if not states:
            message = "to move joints to their starts, Improv must know where they are: add `joint_states`"
        elif slow is not None:
            message = f"joints move to their starts at a fifth of their highest speed: add `max_velocity` of `{slow}`"
        elif any(each.interface == "velocity" for each in controllers):
            message = (
                'a velocity controller can\'t move joints to their starts: change its `interface`, or write `"wait"`'
            )
        else:
            return
        self.reading.at_key(keys, message, whole=True)


def _limits(joint: Joint) -> str:
    """Format limits: `from -60 to 180 degrees`"""
    least, most = (_shown(each, joint) for each in (joint.min, joint.max))
    return f"from {least} to {most} {'meters' if joint.slides else 'degrees'}"


def _shown(position: float | None, joint: Joint) -> str:
    return "anywhere" if position is None else f"{position if joint.slides else math.degrees(position):.6g}"
