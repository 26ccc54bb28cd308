"""Reads a robot's joints from a URDF (wiki.ros.org/urdf/XML), which may be hostile."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from io import BytesIO
from xml.sax import SAXParseException
from xml.sax.handler import ContentHandler
from xml.sax.xmlreader import AttributesImpl, Locator

from improv_core.slices import checkpoint

Vector = tuple[float, float, float]

TURNING = ("revolute", "continuous")
MOVING = (*TURNING, "prismatic")
"""The types of joints that one number moves."""
_STILL = ("fixed", "floating", "planar")
LARGEST_URDF = 5_000_000
"""Bytes of a URDF; the largest public ones have about one million."""
MAX_ELEMENTS = 200_000
"""Elements and attributes of a URDF; the largest public ones have about a fifth."""
DEEPEST = 100
"""Elements within one another; in a URDF, four are."""
LONGEST_TAG = 200_000
"""Bytes of a tag or of a text: everything between two `<`."""


class UrdfError(Exception):
    """A URDF can't be used. The message is one line; `line` counts from 1, and is 0 if the error belongs to no line."""

    def __init__(self, line: int, message: str) -> None:
        super().__init__(message)
        self.line = line


@dataclass(frozen=True, slots=True)
class UrdfJoint:
    """A connection of two links: meters, radians, their rates per second.

    `place` and `turn` (roll, pitch, yaw) are the joint's pose in its parent's frame. `lower`, `upper`, and `velocity`
    are None if the file sets no limit; some files have placeholders, such as -1. A joint that `follows` another has no
    motor: its position is `ratio` times that of the other, plus `shift`.
    """

    name: str
    kind: str
    parent: str
    child: str
    line: int
    axis: Vector = (1.0, 0.0, 0.0)
    place: Vector = (0.0, 0.0, 0.0)
    turn: Vector = (0.0, 0.0, 0.0)
    lower: float | None = None
    upper: float | None = None
    velocity: float | None = None
    follows: str | None = None
    ratio: float = 1.0
    shift: float = 0.0

    @property
    def driven(self) -> bool:
        """True if a motor moves it."""
        return self.kind in MOVING and self.follows is None


@dataclass(frozen=True, slots=True)
class Urdf:
    """A robot's joints, each after the one that carries it. `root` is the link that no joint moves."""

    name: str
    root: str
    joints: tuple[UrdfJoint, ...]


def read_urdf(source: bytes) -> Urdf:
    """Read the joints in a URDF. Raises UrdfError."""
    # Imported when used: only one command reads a URDF.
    from defusedxml.common import DefusedXmlException
    from defusedxml.sax import make_parser

    if len(source) > LARGEST_URDF:
        raise UrdfError(0, f"it is larger than {LARGEST_URDF // 1_000_000} MB")
    if _has_long_tag(source):  # parsing it could not be interrupted
        raise UrdfError(0, f"it has a tag or a text of more than {LONGEST_TAG:,} bytes")
    reader = _Reader()
    parser = make_parser()
    parser.forbid_dtd = True
    parser.setContentHandler(reader)
    try:
        parser.parse(BytesIO(source))
    except DefusedXmlException:
        line = parser.getLineNumber() or 0
        raise UrdfError(line, "a URDF must not declare a document type or entities: remove them") from None
    except SAXParseException as error:
        raise UrdfError(error.getLineNumber() or 0, f"this is not XML: {error.getMessage()}") from None
    except (ValueError, LookupError):
        raise UrdfError(0, "this is not XML in an encoding that Improv knows: save it as UTF-8") from None
    return reader.robot()


def unit(vector: Vector) -> Vector:
    """Return the vector of length 1 in the same direction; a vector of length 0 stays as it is."""
    length = math.hypot(*vector)
    return (vector[0] / length, vector[1] / length, vector[2] / length) if length else vector


def _has_long_tag(source: bytes) -> bool:
    begin = 0
    while len(source) - begin > LONGEST_TAG:
        begin = source.rfind(b"<", begin, begin + LONGEST_TAG + 1) + 1
        if not begin:
            return True
    return False


class _Reader(ContentHandler):
    """Keeps the joints that stand directly in `<robot>`: `<transmission>` and `<ros2_control>` name them, too."""

    def __init__(self) -> None:
        super().__init__()
        self._path: list[str] = []
        self._work = 0
        self._name = ""
        self._links: dict[str, int] = {}
        self._joints: dict[str, UrdfJoint] = {}
        self._open: tuple[int, dict[str, Mapping[str, str]]] | None = None  # a joint's line, and what is in it so far
        self._locator: Locator | None = None

    def setDocumentLocator(self, locator: Locator) -> None:  # noqa: N802
        self._locator = locator

    def startElement(self, name: str, attrs: AttributesImpl) -> None:  # noqa: N802
        checkpoint()
        line = (self._locator and self._locator.getLineNumber()) or 0
        given: dict[str, str] = dict(attrs.items())
        self._work += 1 + len(given)
        if self._work > MAX_ELEMENTS:
            raise UrdfError(line, f"it has more than {MAX_ELEMENTS:,} elements and attributes: no robot needs so many")
        if not self._path and name != "robot":
            raise UrdfError(line, f"a URDF begins with <robot>, not with <{name}>")
        if name.startswith("xacro:"):
            raise UrdfError(line, "this is a xacro file: run `xacro FILE > robot.urdf`, and read that")
        self._path.append(name)
        depth = len(self._path)
        if depth > DEEPEST:
            raise UrdfError(line, f"more than {DEEPEST} elements are in one another: no URDF needs that")
        if depth == 1:
            self._name = given.get("name", "")
        elif depth == 2 and name == "link":
            link = _needed(given, "name", "a link", line)
            if link in self._links:
                raise UrdfError(line, f"there are two links {link!r}")
            self._links[link] = line
        elif depth == 2 and name == "joint":
            self._open = line, {"joint": given}
        elif depth == 3 and self._open:
            self._open[1][name] = given

    def characters(self, content: str) -> None:
        checkpoint()

    def endElement(self, name: str) -> None:  # noqa: N802
        if len(self._path) == 2 and self._open:
            joint = _joint(*self._open)
            if joint.name in self._joints:
                raise UrdfError(joint.line, f"there are two joints {joint.name!r}")
            self._joints[joint.name] = joint
            self._open = None
        self._path.pop()

    def robot(self) -> Urdf:
        root, ordered = _tree(self._links, self._joints.values())
        return Urdf(self._name, root, ordered)


def _joint(line: int, elements: Mapping[str, Mapping[str, str]]) -> UrdfJoint:
    given = elements["joint"]
    name = _needed(given, "name", "a joint", line)
    what = f"the joint {name!r}"
    kind = _needed(given, "type", what, line)
    if kind not in (*MOVING, *_STILL):
        raise UrdfError(line, f"{what} has the unknown type {kind!r}: write {', '.join((*MOVING, *_STILL))}")
    ends = {
        end: _needed(elements.get(end, {}), "link", f"{what} has no <{end} link>, or it", line)
        for end in ("parent", "child")
    }
    origin, limit = elements.get("origin", {}), elements.get("limit", {})
    axis = _vector(elements.get("axis", {}), "xyz", (1.0, 0.0, 0.0), what, line)
    if kind in MOVING and not any(axis):
        raise UrdfError(line, f"{what} has an axis of length 0")
    bounded = kind in ("revolute", "prismatic")
    lower, upper = (_number(limit, end, what, line) or 0.0 if bounded and limit else None for end in ("lower", "upper"))
    if lower is not None and upper is not None and lower > upper:
        raise UrdfError(line, f"{what} has its lower limit {lower:g} above its upper limit {upper:g}")
    mimic = elements.get("mimic", {})
    ratio = _number(mimic, "multiplier", what, line)
    return UrdfJoint(
        name,
        kind,
        ends["parent"],
        ends["child"],
        line,
        axis,
        _vector(origin, "xyz", (0.0, 0.0, 0.0), what, line),
        _vector(origin, "rpy", (0.0, 0.0, 0.0), what, line),
        lower,
        upper,
        _number(limit, "velocity", what, line),
        _needed(mimic, "joint", f"{what} mimics a joint, which", line) if "mimic" in elements else None,
        1.0 if ratio is None else ratio,
        _number(mimic, "offset", what, line) or 0.0,
    )


def _needed(given: Mapping[str, str], key: str, what: str, line: int) -> str:
    if not (text := given.get(key, "").strip()):
        raise UrdfError(line, f"{what} has no {key}")
    if not text.isprintable():
        raise UrdfError(line, f"{what} has a {key} with invisible characters")
    return text


def _number(given: Mapping[str, str], key: str, what: str, line: int) -> float | None:
    return _numbers(given[key], 1, key, what, line)[0] if key in given else None


def _vector(given: Mapping[str, str], key: str, default: Vector, what: str, line: int) -> Vector:
    if key not in given:
        return default
    x, y, z = _numbers(given[key], 3, key, what, line)
    return x, y, z


def _numbers(text: str, count: int, key: str, what: str, line: int) -> list[float]:
    try:
        numbers = [float(each) for each in text.split()]
    except ValueError:
        numbers = []
    if len(numbers) != count or not all(map(math.isfinite, numbers)):
        wanted = "one finite number" if count == 1 else f"{count} finite numbers"
        raise UrdfError(line, f"{what} has {key}={text!r}: write {wanted}")
    return numbers


def _tree(links: Mapping[str, int], joints: Iterable[UrdfJoint]) -> tuple[str, tuple[UrdfJoint, ...]]:
    """Return the root of the tree, and its joints from there on. Raises UrdfError if it isn't one tree."""
    carried: dict[str, UrdfJoint] = {}
    carries: dict[str, list[UrdfJoint]] = {}
    for joint in joints:
        for end in (joint.parent, joint.child):
            if end not in links:
                raise UrdfError(joint.line, f"the joint {joint.name!r} names the link {end!r}, which is not there")
        if other := carried.get(joint.child):
            what = f"the joints {other.name!r} and {joint.name!r} both carry the link {joint.child!r}"
            raise UrdfError(joint.line, f"{what}: only one can")
        carried[joint.child] = joint
        carries.setdefault(joint.parent, []).append(joint)
    roots = [link for link in links if link not in carried]
    if not links:
        raise UrdfError(0, "the URDF has no links")
    if len(roots) > 1:
        what = f"no joint connects the links {roots[0]!r} and {roots[1]!r}"
        raise UrdfError(links[roots[1]], f"{what}: all links must form one tree")
    ordered = {joint.name: joint for root in roots for joint in _downward(root, carries)}
    if len(ordered) < len(carried):
        looped = next(joint for joint in carried.values() if joint.name not in ordered)
        raise UrdfError(looped.line, f"the joint {looped.name!r} is in a loop: all links must form one tree")
    return roots[0], tuple(ordered.values())


def _downward(root: str, carries: Mapping[str, list[UrdfJoint]]) -> Iterator[UrdfJoint]:
    waiting = list(reversed(carries.get(root, [])))
    while waiting:
        joint = waiting.pop()
        yield joint
        waiting.extend(reversed(carries.get(joint.child, [])))
