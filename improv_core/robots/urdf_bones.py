"""The skeleton of a robot, from its URDF."""

from __future__ import annotations

import math

from improv_core.robots.urdf import TURNING, Urdf, UrdfError, UrdfJoint, Vector
from improv_core.score.skeleton import BASE, MOST_BONES, Bone, JointKind


def bones(urdf: Urdf) -> tuple[Bone, ...]:
    """Convert all joints of a URDF to bones. Raises UrdfError if there are too many to draw."""
    if len(urdf.joints) > MOST_BONES:
        raise UrdfError(0, f"it has {len(urdf.joints):,} joints: at most {MOST_BONES:,} can be drawn")
    number = {urdf.root: BASE} | {joint.child: place for place, joint in enumerate(urdf.joints)}
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


def unit(vector: Vector) -> Vector:
    """Return the vector of length 1 in the same direction; a vector of length 0 stays as it is."""
    length = math.hypot(*vector)
    return (vector[0] / length, vector[1] / length, vector[2] / length) if length else vector
