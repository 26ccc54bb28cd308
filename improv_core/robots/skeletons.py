"""The skeletons of robots, from their URDFs: how their joints carry one another, so that the page can draw them."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from functools import lru_cache
from pathlib import Path

from improv_core.diagnostics import Diagnostic
from improv_core.robots.config import Robots
from improv_core.robots.toml_reading import listed
from improv_core.robots.toml_text import read_toml
from improv_core.robots.urdf import LARGEST_URDF, TURNING, Urdf, UrdfError, UrdfJoint, read_urdf, unit
from improv_core.score.body import MAX_BONES, ROOT, Body, Bone, JointKind
from improv_core.score.profiles import Profile

Skeleton = tuple[Bone, ...]


def with_skeletons(
    robots: Robots, read: Callable[[Path, int], bytes | str], skeleton_in: Callable[[bytes], Skeleton | str]
) -> Robots:
    """Return the robots with the skeletons in the URDFs that their profiles name, relative to the folder of the
    `improv.toml`.

    `read` returns the content of a file of at most this many bytes, or an error, and `skeleton_in` the skeleton in that
    content, or an error. A URDF that can't be used, or that contradicts the joints of its profile, is an error at the
    line that names it.
    """
    named = {name: each.body for name, each in robots.profiles.items() if each.body and each.body.urdf}
    if not robots.path:
        return robots
    skeletons: dict[str, Skeleton] = {}
    wrong: dict[tuple[str, str], str] = {}  # by URDF and problem, the first profile that names it
    for name, body in named.items():
        assert body.urdf
        source = read(robots.path.parent / body.urdf, LARGEST_URDF)
        found = f": {source}" if isinstance(source, str) else skeleton_in(source)
        if isinstance(found, str):
            wrong.setdefault((body.urdf, found), name)
        else:
            skeletons[body.urdf] = found
            for problem in _contradictions(body, found):
                wrong.setdefault((body.urdf, f" {problem}"), name)
    positions = read_toml(robots.text).positions
    said = (
        Diagnostic("robots", positions.nearest(("profiles", name, "urdf")).value, f"`{urdf}`{problem}")
        for (urdf, problem), name in wrong.items()
    )

    def drawn(profile: Profile) -> Profile:
        skeleton = skeletons.get(profile.body.urdf, ()) if profile.body and profile.body.urdf else ()
        return replace(profile, body=replace(profile.body, skeleton=skeleton)) if profile.body and skeleton else profile

    return replace(
        robots,
        profiles={name: drawn(profile) for name, profile in robots.profiles.items()},
        robots={name: replace(robot, profile=drawn(robot.profile)) for name, robot in robots.robots.items()},
        diagnostics=tuple(sorted([*robots.diagnostics, *said], key=lambda each: each.span)),
    )


@lru_cache(maxsize=4)  # each key in an improv.toml asks for it
def skeleton_in(source: bytes) -> Skeleton | str:
    """Read the skeleton in a URDF, or return what is wrong with it."""
    try:
        return bones(read_urdf(source))
    except UrdfError as error:
        return f"{f', line {error.line}' if error.line else ''}: {error}"


def bones(urdf: Urdf) -> tuple[Bone, ...]:
    """Convert all joints of a URDF to bones. Raises UrdfError if there are too many to draw."""
    if len(urdf.joints) > MAX_BONES:
        raise UrdfError(0, f"it has {len(urdf.joints):,} joints: at most {MAX_BONES:,} can be drawn")
    number = {urdf.root: ROOT} | {joint.child: place for place, joint in enumerate(urdf.joints)}
    return tuple(_bone(joint, number[joint.parent]) for joint in urdf.joints)


def _bone(joint: UrdfJoint, carrier: int) -> Bone:
    way: JointKind = "turns" if joint.kind in TURNING else "slides" if joint.kind == "prismatic" else "stays"
    least, most = (
        (-math.inf if joint.lower is None else joint.lower),
        (math.inf if joint.upper is None else joint.upper),
    )
    return Bone(
        joint.name,
        carrier,
        joint.place,
        joint.turn,
        unit(joint.axis),
        way,
        max(least, min(0.0, most)),
        joint.follows,
        joint.ratio,
        joint.shift,
    )


def _contradictions(body: Body, skeleton: Sequence[Bone]) -> Iterator[str]:
    bones = {bone.joint: bone for bone in skeleton}
    for joint in body.joints:
        bone = bones.get(joint.name)
        if not bone:
            movable = [each.joint for each in skeleton if each.way != "stays"]
            yield f"has no joint `{joint.name}`, but {listed(movable[:_MAX_LISTED])}" if movable else "moves nothing"
        elif bone.way == "stays":
            yield f"has `{joint.name}` as a joint that doesn't move: remove it from the body"
        elif bone.follows:
            yield f"has `{joint.name}` follow `{bone.follows}`: move that instead"
        elif joint.slides != (bone.way == "slides"):
            what, unit = ("slide", "meters") if bone.way == "slides" else ("turn", "degrees")
            yield f"has `{joint.name}` {what}: say in {unit} how far it moves"


_MAX_LISTED = 12
