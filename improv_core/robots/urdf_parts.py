"""Finds the body parts of a robot in its URDF, and the direction in which each joint moves its part."""

from __future__ import annotations

import math
import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import groupby
from typing import NamedTuple

from improv_core.robots.urdf import TURNING, Urdf, UrdfError, UrdfJoint, Vector, unit
from improv_core.syntax.vocabulary import WORDS
from improv_core.text import free_name

MAX_JOINTS = 4
"""Joints of a part, because a part has as many directions."""
_MIN_ROOM = 0.001
"""Radians or meters: a joint whose limits leave less than that can't dance."""
_ALONG = 0.9
"""The least cosine at which two directions count as the same, about 26 degrees apart."""
_ON_AXIS = 0.005
"""Meters from the axis within which a tip counts as on it."""
_LIMBS = {"arm": ("shoulder", "elbow", "wrist"), "leg": ("hip", "knee", "ankle")}
_SIZES = {  # the last three axes of an industrial arm meet
    "arm": {5: (2, 1, 2), 6: (2, 1, 3), 7: (3, 1, 3)},
    "leg": {5: (2, 1, 2), 6: (3, 1, 2), 7: (3, 1, 3)},
}
"""Numbers of joints at the three places of a limb, by the number of all its joints."""
_LOOKING = ("head", "neck")
"""Parts that look up, wherever their ends go."""
_WORDS = {
    "shoulder": "shoulder|clavicle|upper_?arm",
    "elbow": "elbow|fore_?arm|lower_?arm",
    "wrist": "wrist",
    "hip": "hip|thigh|haa|hfe",
    "knee": "knee|calf|shin|kfe",
    "ankle": "ankle|foot",
    **{word: word for word in ("head", "neck", "waist", "torso")},
    "hand": "hand|gripper|finger|thumb|index|(?<![a-z])ring|little|pinky",
}
"""Words for the joints of a body, and the names of joints and links that mean them."""
_BASE = re.compile("wheel|cast[eo]r|steer|rotor|propell", re.IGNORECASE)
"""Names of joints that drive a base: velocities move these, and no body part."""
_SIDES = {"left": "right", "l": "r"}
_SIDE = re.compile(r"(?<![a-z])(left|right|l|r)(?![a-z0-9])|^(left|right|l|r)(?=(?-i:[A-Z]))", re.IGNORECASE)
_CORNER = re.compile(r"(?<![a-z])([fhr][lr]|[lr][fh])(?![a-z])", re.IGNORECASE)
"""A leg of four: front, hind, or rear; left or right."""
_PAIRS = _SIDES | {other: side for side, other in _SIDES.items()}


class UrdfDirection(NamedTuple):
    """The direction in which a positive joint velocity moves its part, or the opposite of that one. It `is_clear` if
    the joint moves its part that way and no other."""

    name: str
    sign: int
    is_clear: bool = True


@dataclass(frozen=True, slots=True)
class UrdfPart:
    """The joints of a body part, from the root on, and the link by whose motion people see them move."""

    name: str
    tip: str
    joints: tuple[UrdfJoint, ...]


@dataclass(frozen=True)
class UrdfBody:
    """The body parts of a URDF, and groups of them by name."""

    urdf: Urdf

    def named(self, tips: Mapping[str, str]) -> list[UrdfPart]:
        """Return parts that end in these links, by name: the joints that carry its tip, except those that carry the tip
        of another part. Raises UrdfError."""
        carrier = {joint.child: joint for joint in self.urdf.joints}
        for name, tip in tips.items():
            if problem := _unusable(name):
                raise UrdfError(0, problem)
            if tip not in carrier and tip != self.urdf.root:
                raise UrdfError(0, f"the file has no link {tip!r}: name another tip for the part {name!r}")
        paths = {name: _path(tip, carrier) for name, tip in tips.items()}
        parts, taken = {}, set[str]()
        # A joint that carries two tips belongs to the one nearest to the root: a torso, not an arm.
        for name in sorted(paths, key=lambda name: len(paths[name])):
            joints = tuple(joint for joint in paths[name] if joint.driven and joint.name not in taken)
            if not joints:
                raise UrdfError(0, f"no joint with a motor is left for the part {name!r}, with the tip {tips[name]!r}")
            taken |= {joint.name for joint in joints}
            parts[name] = UrdfPart(name, tips[name], joints)
        return [parts[name] for name in tips]

    def found(self) -> tuple[list[UrdfPart], dict[str, list[str]]]:
        """Return the parts that people would name, and groups of those that make up one limb or one hand."""
        parts, groups, taken = list[UrdfPart](), dict[str, list[str]](), set[str]()
        palms = {joint.child: joint for joint in self.urdf.joints}
        hands: dict[UrdfJoint, list[str]] = {}  # the parts of the fingers on each palm

        def free(name: str) -> str:
            taken.add(name := free_name(name, taken))
            return name

        for chain in self._chains():
            whole, tip = free(_named_after(chain)), self._end(chain[-1].child)
            cuts = [*_cuts(chain)] if len(chain) > MAX_JOINTS else [(whole, tuple(chain))]
            own = [UrdfPart(free(name) if cuts[1:] else whole, tip, joints) for name, joints in cuts]
            parts += own
            if own[1:]:
                groups[whole] = [part.name for part in own]
            palm = palms.get(chain[0].parent)
            if palm and {*map(_word_in, chain)} == {"hand"} and not (dances(palm) and _word_in(palm) == "hand"):
                hands.setdefault(palm, []).extend(part.name for part in own)
        made = [(palm, names) for palm, names in hands.items() if names[1:] and names not in groups.values()]
        return parts, groups | {free(f"{_side(palm)}hand"): names for palm, names in made}

    def directions(self, part: UrdfPart) -> dict[str, UrdfDirection]:
        """Return the directions of the joints of a part, by the names of these; none beyond the fourth. A joint that
        has a clear direction gets it, unless one nearer to the root has it."""
        wanted = {joint.name: self._wanted(joint, part.tip) for joint in part.joints}
        found = dict[str, UrdfDirection]()
        for name, (first, *_) in wanted.items():
            if first.is_clear and all(each.name != first.name for each in found.values()):
                found[name] = first
        for name, each in wanted.items():
            free = [way for way in each if all(way.name != other.name for other in found.values())]
            if name not in found and free:
                found[name] = free[0]._replace(is_clear=False)
        return found

    def _chains(self) -> Iterator[list[UrdfJoint]]:
        """Yield the joints that dance, from each fork to the next one or to the end of a limb."""
        above: dict[str, UrdfJoint | None] = {self.urdf.root: None}  # the joint that carries a link
        below: dict[str, int] = {}
        chains: dict[str, list[UrdfJoint]] = {}
        for joint in self.urdf.joints:
            before = above[joint.parent]
            above[joint.child] = joint if dances(joint) else before
            if dances(joint) and before:
                below[before.name] = below.get(before.name, 0) + 1
        for joint in filter(dances, self.urdf.joints):
            before = above[joint.parent]
            chain = chains[before.name] if before and below[before.name] == 1 else []
            chain.append(joint)
            chains[joint.name] = chain
        for name, chain in chains.items():
            rolls = not above[chain[0].parent] and all(joint.kind == "continuous" for joint in chain)
            if name == chain[0].name and not (rolls and abs(self._frames[chain[-1].child].axis[2]) < _ALONG):
                yield chain

    def _end(self, link: str) -> str:
        held, start = [link], self._frames[link].place
        for each in held:
            held += self._fixed.get(each, ())
        return max(held, key=lambda each: math.dist(start, self._frames[each].place))

    @cached_property
    def _fixed(self) -> Mapping[str, Sequence[str]]:
        found: dict[str, list[str]] = {}
        for joint in self.urdf.joints:
            if joint.kind == "fixed":
                found.setdefault(joint.parent, []).append(joint.child)
        return found

    def _wanted(self, joint: UrdfJoint, tip: str) -> list[UrdfDirection]:
        """Return all directions, from the one in which a joint moves a link while all joints are at 0.

        A joint about the vertical turns `left`. Any other joint moves the link along axis × (link - joint) (Lynch &
        Park, Modern Robotics, 5.1), and a slider along its axis. A joint that has the link on its axis looks `up`, or
        leans.
        """
        (ax, ay, az), place = self._frames[joint.child].axis, self._frames[joint.child].place
        ways = {"left": 0.0, "forward": 0.0, "strafeleft": 0.0, "up": 0.0}
        x, y, z = (end - own for end, own in zip(self._frames[tip].place, place, strict=True))
        way = (ay * z - az * y, az * x - ax * z, ax * y - ay * x)
        if _word_in(joint) in _LOOKING:
            way = (0.0, 0.0, 0.0)
        if joint.kind not in TURNING:
            ways |= {"forward": ax, "strafeleft": ay, "up": az}
        elif abs(az) > _ALONG:
            ways["left"] = az
        elif math.hypot(*way) > _ON_AXIS:
            ways |= dict(zip(("forward", "strafeleft", "up"), unit(way), strict=True))
        else:
            ways |= {"up": -ay, "strafeleft": -ax * _ALONG, "left": az}
        room = 1 if joint.lower is None or joint.upper is None or joint.upper >= -joint.lower else -1
        nods = abs(ay) >= max(abs(ax), abs(az))
        order = ("up", "forward", "left", "strafeleft") if nods else ("left", "strafeleft", "up", "forward")
        found = [
            UrdfDirection(
                name, (1 if ways[name] > 0 else -1) if abs(ways[name]) > 0.1 else room, abs(ways[name]) > _ALONG
            )
            for name in order
        ]
        return sorted(found, key=lambda each: -round(abs(ways[each.name]), 1))

    @cached_property
    def _frames(self) -> Mapping[str, _Frame]:
        """A frame for each link, with the axis of the joint that carries it."""
        placed: dict[str, tuple[Vector, _Matrix]] = {self.urdf.root: ((0.0, 0.0, 0.0), _LEVEL)}
        frames = {self.urdf.root: _Frame((0.0, 0.0, 0.0), (0.0, 0.0, 0.0))}
        for joint in self.urdf.joints:
            place, turn = placed[joint.parent]
            x, y, z = _turned(turn, joint.place)
            place = (place[0] + x, place[1] + y, place[2] + z)
            rows = tuple(
                zip(*(_turned(turn, column) for column in zip(*_rotation(joint.turn), strict=True)), strict=True)
            )
            turn = (rows[0], rows[1], rows[2])
            placed[joint.child] = (place, turn)
            frames[joint.child] = _Frame(place, unit(_turned(turn, joint.axis)))
        return frames


def dances(joint: UrdfJoint) -> bool:
    """Return whether a joint can belong to a body part: it has a motor and room to move, and doesn't drive the base."""
    return joint.driven and has_room(joint) and not drives_base(joint)


def has_room(joint: UrdfJoint) -> bool:
    return joint.lower is None or joint.upper is None or joint.upper - joint.lower >= _MIN_ROOM


def drives_base(joint: UrdfJoint) -> bool:
    """Return whether a joint seems to be that of a wheel or a propeller."""
    return bool(_BASE.search(joint.name) or _BASE.search(joint.child))


def mirrors(parts: Sequence[UrdfPart]) -> dict[str, str]:
    """Return the names of the right parts that mirror left ones, by the names of these: their joints have the same
    names, except for the side."""
    named = {tuple(joint.name for joint in part.joints): part.name for part in parts}
    found: dict[str, str] = {}
    for names, part in named.items():
        left = any(match[0].lower() in _SIDES for match in map(_SIDE.search, names) if match)
        other = named.get(tuple(_SIDE.sub(_exchanged, name) for name in names))
        if left and other and other not in found.values():
            found[part] = other
    return found


def word_of(text: str) -> str:
    """Return a text as a name for programs; empty if nothing in it can be part of a name."""
    word = re.sub(r"\W+", "_", text).strip("_")
    return word if word and not _unusable(word) else f"part_{word}" if word else ""


def _path(tip: str, carrier: Mapping[str, UrdfJoint]) -> list[UrdfJoint]:
    joints = []
    while joint := carrier.get(tip):
        joints.append(joint)
        tip = joint.parent
    return joints[::-1]


def _cuts(chain: Sequence[UrdfJoint]) -> Iterator[tuple[str, tuple[UrdfJoint, ...]]]:
    """Yield the joints of a chain in parts of at most four, with their names: by what its joints are called, or else
    as limbs with this number of joints usually are."""
    words = [_word_in(joint) for joint in chain]
    for place in range(1, len(words)):
        words[place] = words[place] or words[place - 1]
    for word, run in groupby(zip(words, chain, strict=True), lambda pair: pair[0]):
        joints = tuple(joint for _, joint in run)
        sizes = _SIZES[limb].get(len(joints)) if (limb := _limb(joints)) else None
        begin, names = 0, _LIMBS[limb] if limb and sizes else ()
        for place, size in enumerate(sizes or [MAX_JOINTS] * math.ceil(len(joints) / MAX_JOINTS)):
            part = joints[begin : (begin := begin + size)]
            name = names[place] if names else word if len(joints) <= MAX_JOINTS else None
            yield (f"{_side(part[0])}{name}" if name else _leaf(part)), part


def _named_after(joints: Sequence[UrdfJoint]) -> str:
    """Return the word for all of these joints, or the name of the link at their end."""
    words = {_word_in(joint) for joint in joints} - {None, "hand"}
    word = _limb(joints) if joints[1:] else None
    if not word and len(words) == 1:
        word = words.pop()
    return f"{_side(joints[0])}{word}" if word else _leaf(joints)


def _leaf(joints: Sequence[UrdfJoint]) -> str:
    return word_of(joints[-1].child.removesuffix("_link")) or "part"


def _word_in(joint: UrdfJoint) -> str | None:
    """Return what people call a joint, by its name or that of its link."""
    names = joint.name.lower(), joint.child.lower()
    return next((word for name in names for word, means in _WORDS.items() if re.search(means, name)), None)


def _limb(joints: Sequence[UrdfJoint]) -> str | None:
    """Return the limb that these joints make up, perhaps with a hand: as their names say, or an arm if these say
    nothing but there are as many as usual."""
    others = [joint for joint in joints if _word_in(joint) != "hand"]
    words = {word for word in map(_word_in, others) if word}
    for limb, own in _LIMBS.items():
        if words and words <= {*own}:
            return limb
        if others and not words and all(limb in f"{joint.name} {joint.child}".lower() for joint in others):
            return limb
    return "arm" if len(others) in _SIZES["arm"] and not words else None


def _side(joint: UrdfJoint) -> str:
    """Return the beginning of the names of parts on one side, such as `left_`."""
    for name in (joint.name, joint.child):
        if corner := _CORNER.search(name):
            return f"{corner[0].lower()}_"
        if side := _SIDE.search(name):
            return "left_" if side[0].lower() in _SIDES else "right_"
    return ""


def _exchanged(match: re.Match[str]) -> str:
    side = match[0]
    other = _PAIRS[side.lower()]
    return other.upper() if side.isupper() else other.capitalize() if side[0].isupper() else other


def _unusable(name: str) -> str | None:
    if not name.isidentifier():
        return f"{name!r} can't be the name of a part: write letters, digits, and _"
    return f"{name!r} is a word of the language: call the part something else" if name in (*WORDS, "to") else None


class _Frame(NamedTuple):
    """Pose of a joint while all joints are at 0, in the frame of the root."""

    place: Vector
    axis: Vector


_Matrix = tuple[Vector, Vector, Vector]
"""A rotation, as rows."""
_LEVEL: _Matrix = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))


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
