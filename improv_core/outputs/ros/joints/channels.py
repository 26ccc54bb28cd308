"""The controllers of ros2_control that move a robot's joints. Standard library only."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from fractions import Fraction

from improv_core.score.body import Body, Controller, Interface, Joint
from improv_core.score.joints import limbs_of, moved_parts
from improv_core.score.movement import Velocity
from improv_core.score.profiles import PUPPET
from improv_core.score.score import Part, in_namespace

WINDOW = 0.1
"""Seconds over which the positions in a trajectory are smoothed, at least. If no command follows, it comes to rest in
this time after it has cruised."""
LONGEST_WINDOW = 2.0
"""Seconds over which they are smoothed, at most."""
HOMING = 5
"""Joints move to their starts at their highest speed divided by this."""
TOPICS: Mapping[Interface, str] = {"trajectory": "joint_trajectory", "position": "commands", "velocity": "commands"}
"""The topic names of ros2_control's joint_trajectory_controller and forward_command_controller."""
MESSAGES: Mapping[Interface, str] = {
    "trajectory": "JointTrajectory",
    "position": "Float64MultiArray",
    "velocity": "Float64MultiArray",
}
"""The message types on these topics."""
FOR_ALL = "joint_trajectory"
"""The controller's name if the profile lists no controllers."""


@dataclass(frozen=True, slots=True)
class Channel:
    """A controller of a robot: its joints in their order, its interface, and the full name of its topic.

    No direction moves the joints that are `held`: they stay where they stand. The controller doesn't have those that
    are `lacking`, although the settings list them. Positions in trajectories are smoothed over a `window` of seconds,
    with which joints keep their highest accelerations.
    """

    joints: tuple[Joint, ...]
    interface: Interface
    topic: str
    held: frozenset[str] = frozenset()
    lacking: tuple[str, ...] = ()
    window: float = field(default=WINDOW, compare=False)

    @property
    def message(self) -> str:
        return MESSAGES[self.interface]

    @property
    def needs_positions(self) -> bool:
        """True if its joints' positions must be known before it can get a command."""
        return self.interface != "velocity"


Listed = Callable[[str], Sequence[str]]
"""Returns the joints that the controller on a topic itself lists; none if they are unknown."""


def channels_of(part: Part, listed: Listed = lambda topic: ()) -> list[Channel]:
    """The controllers that move the body parts of a robot's part. Other controllers get no commands.

    A controller has the joints that it lists itself, because it refuses commands for others, or for fewer.

    For a part without scenes, whose robot only has to stop, these are the ones that don't stop by themselves.
    """
    body = part.profile.body
    if not body or part.profile == PUPPET:  # only the simulator has such a robot
        return []
    if not part.scenes:
        endless = [each for each in controllers_of(body) if each.interface == "velocity"]
        return [_channel(each, body, part.namespace, listed) for each in endless]
    moved = {drive.joint for name in moved_parts(part) for drive in body.part[name].drives}
    used = [each for each in controllers_of(body) if not moved.isdisjoint(each.joints)]
    return [_channel(each, body, part.namespace, listed) for each in used]


def controllers_of(body: Body) -> Sequence[Controller]:
    """The controllers of a body. If it names none, one controller moves all its joints."""
    return body.controllers or [Controller(FOR_ALL, tuple(body.joint))]


def window_of(part: Part, channel: Channel, tempo: Fraction) -> float:
    """The seconds over which a controller's joints are smoothed, so that each reverses from its highest speed in a part
    within its highest acceleration."""
    joints, found = {joint.name: joint for joint in channel.joints}, [WINDOW]
    for limb in limbs_of(part, tempo):
        drives = [drive for drive in limb.part.drives if drive.joint in joints and joints[drive.joint].max_acceleration]
        for peak in [limb.performs(scene).bounds.peak for scene in part.scenes] if drives else ():
            speeds = limb.velocities(Velocity(peak.x, peak.y, peak.z, peak.yaw))  # type: ignore[arg-type]
            found += [_reversing(joints[drive.joint], abs(speeds[drive.joint]), part, tempo) for drive in drives]
    return min(max(found), LONGEST_WINDOW)


def _reversing(joint: Joint, speed: float, part: Part, tempo: Fraction) -> float:
    if part.movement.body_words.has_poses:  # its way there isn't known before
        way = joint.max - joint.min if joint.max is not None and joint.min is not None else math.tau
        speed = max(speed, way * float(tempo) / 60)
    speed = min(speed, joint.max_velocity or math.inf)
    homing = (joint.max_velocity or 0.0) / HOMING
    return 2 * max(speed, homing) / (joint.max_acceleration or math.inf)


def joint_states_of(part: Part) -> str | None:
    """The full name of the topic with a robot's joint positions, if there is one."""
    body = part.profile.body
    return in_namespace(body.joint_states, part.namespace) if body and body.joint_states else None


def needs_base(part: Part) -> bool:
    """Return whether a robot needs a base. A robot that moves only its body parts doesn't."""
    if part.profile == PUPPET:
        return False
    return not channels_of(part) or any(any(scene.bounds.peak[:4]) for scene in part.scenes)


def topic_of(controller: Controller, namespace: str) -> str:
    """The full name of a controller's topic in a robot's namespace."""
    return in_namespace(controller.topic or f"{controller.name}_controller/{TOPICS[controller.interface]}", namespace)


def _channel(controller: Controller, body: Body, namespace: str, listed: Listed) -> Channel:
    topic = topic_of(controller, namespace)
    names = listed(topic)
    if set(names).isdisjoint(controller.joints):  # they are unknown, or those of something else
        names = controller.joints
    return Channel(
        tuple(body.joint.get(name) or Joint(name) for name in names),
        controller.interface,
        topic,
        frozenset(names).difference(body.joint),
        tuple(name for name in controller.joints if name not in names),
    )
