"""Commands for the controllers of a robot's joints. It never reads a clock. Standard library only.

Positions are in radians or meters, and times in seconds. A commanded position never jumps: it follows from the joint's
last position at rest and the commanded velocities since then.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from fractions import Fraction
from typing import NamedTuple

from improv_core.outputs.cdr import numbers_message, trajectory_message
from improv_core.outputs.ros.joints.smoothing import Stretch, TrajectoryPoint, points
from improv_core.safety.joint_preflight import FAR_SLIDE, FAR_TURN, adrift
from improv_core.score.body import Body, Controller, Interface, Joint
from improv_core.score.joints import JointMotion, limbs_of, moved_parts
from improv_core.score.movement import Velocity
from improv_core.score.profiles import is_simulated
from improv_core.score.score import Part, in_namespace

CRUISE = 0.2
"""Seconds for which a trajectory keeps its velocity: a few commands may be late or get lost."""
WINDOW = 0.1
"""Seconds over which the positions in a trajectory are smoothed, at least. If no command follows, it comes to rest in
this time after it has cruised."""
LONGEST_WINDOW = 2.0
"""Seconds over which they are smoothed, at most."""
LAG, LAST_LAG = 0.5, 0.2
"""Seconds by which joints may lag behind their commands: while they move, and when they are stopped. They still cover
that distance."""
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
        """The type of its messages."""
        return MESSAGES[self.interface]

    @property
    def needs_positions(self) -> bool:
        """True if its joints' positions must be known before it can get a command."""
        return self.interface != "velocity"


class _Leg(NamedTuple):
    """The positions of joints at a performance time, and their velocities from then until the next leg."""

    since: float
    motions: tuple[JointMotion, ...]


@dataclass(frozen=True, slots=True)
class Course:
    """The movement of a controller's joints, in their order, from a performance time on. `legs` are its latest ones,
    with which it is smoothed, up to the present one."""

    motions: tuple[JointMotion, ...]
    since: float = 0.0
    legs: tuple[_Leg, ...] = field(default=(), compare=False)

    @property
    def velocities(self) -> list[float]:
        return [velocity for _, velocity in self.motions]

    @property
    def moves(self) -> bool:
        return any(self.velocities)


Listed = Callable[[str], Sequence[str]]
"""Returns the joints that the controller on a topic itself lists; none if they are unknown."""


def channels_of(part: Part, listed: Listed = lambda topic: ()) -> list[Channel]:
    """The controllers that move the body parts of a robot's part. Other controllers get no commands.

    A controller has the joints that it lists itself, because it refuses commands for others, or for fewer.

    For a part without scenes, whose robot only has to stop, these are the ones that don't stop by themselves.
    """
    body = part.profile.body
    if not body or is_simulated(part.profile):
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
    """The seconds in which a joint reverses from a speed in a part."""
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
    if is_simulated(part.profile):
        return False
    return not channels_of(part) or any(any(scene.bounds.peak[:4]) for scene in part.scenes)


def topic_of(controller: Controller, namespace: str) -> str:
    """The full name of a controller's topic in a robot's namespace."""
    return in_namespace(controller.topic or f"{controller.name}_controller/{TOPICS[controller.interface]}", namespace)


def standing(channel: Channel, positions: Mapping[str, float]) -> Course:
    """A course in which the joints stand at these positions."""
    return Course(tuple(JointMotion(positions[joint.name], 0.0) for joint in channel.joints))


def current_course(
    channel: Channel,
    course: Course | None,
    measured: Mapping[str, float],
    *,
    begins: bool,
    from_measured: bool,
    rests: bool,
) -> Course | None:
    """The current course of joints; None if unknown. `measured` has their recent positions.

    When joints at rest begin to move, their course starts at the measured positions if these are off: somebody else
    moved the joints, or they never arrived. With `from_measured`, such as for beat 0, it always starts there. Joints
    that stand never follow their measured positions: an arm that hangs a little would sink further and further.
    """
    if course and (course.moves or not rests or not (begins or from_measured)):
        return course
    if all(joint.name in measured for joint in channel.joints):
        told = course and [motion.position for motion in course.motions]
        return (
            standing(channel, measured)
            if not told or from_measured or adrift(channel.joints, measured, told)
            else course
        )
    if course or channel.needs_positions:
        return course
    return standing(channel, {joint.name: joint.start for joint in channel.joints})


def turned(channel: Channel, before: Course, told: Mapping[str, JointMotion], at: float) -> Course:
    """The course after some of the joints get a new velocity at a time. The others continue.

    No joint exceeds its highest speed or passes its limits.
    """
    passed = at - before.since if before.since <= at else 0.0  # performance time may have started over
    pairs = zip(channel.joints, before.motions, strict=True)
    motions = tuple(_turned(joint, motion, told.get(joint.name), passed) for joint, motion in pairs)
    legs = (before.legs or (_Leg(before.since, before.motions),)) if before.since <= at else ()
    gone = sum(1 for later in legs[1:] if later.since <= at - channel.window)
    recent = legs[gone:]
    is_same = legs and [each.velocity for each in motions] == [each.velocity for each in legs[-1].motions]
    return Course(motions, at, recent if is_same else (*recent, _Leg(at, motions)))


def let_go(channel: Channel, before: Course, course: Course, measured: Mapping[str, tuple[float, float]]) -> Course:
    """Return the course with the joints that something holds back, such as a person or a protective stop, at their
    measured positions. Otherwise they would jump when released.

    `measured` has each joint's position and its age in seconds. Joints that stand may hang a little.
    """
    if not channel.needs_positions:
        return course
    offs = []
    for joint, last, motion in zip(channel.joints, before.motions, course.motions, strict=True):
        speed = max(abs(last.velocity), abs(motion.velocity))
        position, ago = measured.get(joint.name, (motion.position, 0.0))
        far = (FAR_SLIDE if joint.slides else FAR_TURN) + speed * (
            (LAG if motion.velocity else LAST_LAG) + ago + channel.window
        )
        is_held = speed and abs(position - motion.position) > far
        offs.append(position - motion.position if is_held else 0.0)
    return turned(channel, _shifted(course, offs), {}, course.since) if any(offs) else course


def _shifted(course: Course, offs: Sequence[float]) -> Course:
    def shift(motions: Sequence[JointMotion]) -> tuple[JointMotion, ...]:
        return tuple(JointMotion(at + off, speed) for (at, speed), off in zip(motions, offs, strict=True))

    return Course(shift(course.motions), course.since, tuple(_Leg(since, shift(each)) for since, each in course.legs))


def homing_channel(channel: Channel, course: Course) -> Channel | None:
    """The controller with joints that stop at their starts and move at a fifth of their highest speed; None if a
    joint that has to move has no highest speed. Velocity controllers don't come to rest by themselves, so they can't
    do this."""
    joints = []
    for joint, (position, _) in zip(channel.joints, course.motions, strict=True):
        start = position if joint.name in channel.held else joint.start
        if joint.max_velocity is None and position != start:
            return None
        least, most = sorted((position, start))
        slow = joint.max_velocity and joint.max_velocity / HOMING
        joints.append(replace(joint, min=least, max=most, max_velocity=slow, start=start))
    return replace(channel, joints=tuple(joints)) if channel.needs_positions else None


def homing_course(homing: Channel, course: Course, now: float) -> Course:
    """The course of joints that stand until now and then move to their starts."""
    told = {
        joint.name: JointMotion(at, math.copysign(joint.max_velocity or 0.0, joint.start - at))
        for joint, (at, _) in zip(homing.joints, course.motions, strict=True)
    }
    return turned(homing, replace(course, since=now), told, now)


def stopped(channel: Channel, course: Course, passed: float) -> Course:
    """The course with all joints stopped, this many seconds after it began."""
    still = {joint.name: JointMotion(0.0, 0.0) for joint in channel.joints}
    return turned(channel, course, still, course.since + passed)


def trajectory(
    channel: Channel, course: Course, until: float = math.inf, late: float = 0.0
) -> Iterator[TrajectoryPoint]:
    """The points of a course that is sent so many seconds `late`, and comes to rest by itself. Joints that stand have a
    single point. It ends where joints are at the time `until`, at the latest: they may turn around then."""
    end = course.since + min(CRUISE, max(until - course.since, 0.0))
    legs = course.legs or (_Leg(course.since, course.motions),)
    ways = [[*_way(joint, legs, number, end)] for number, joint in enumerate(channel.joints)]
    return points(ways, channel.window, course.since + late)


def message_of(
    channel: Channel, course: Course, pace: float = 1.0, until: float = math.inf, late: float = 0.0
) -> bytes:
    """The message for a controller at the present time of a course, in positions of its encoders. `trajectory` has the
    other arguments. By the controller's clock, such as a simulation's, `pace` seconds pass in one of a performance."""
    if channel.interface == "velocity":
        return numbers_message([velocity / pace for velocity in course.velocities])
    if channel.interface == "position":
        return numbers_message(_encoder_positions(channel, [motion.position for motion in course.motions]))
    found = [
        (seconds * pace, _encoder_positions(channel, positions), [velocity / pace for velocity in velocities])
        for seconds, positions, velocities in trajectory(channel, course, until, late)
    ]
    return trajectory_message(tuple(joint.name for joint in channel.joints), found)


def _encoder_positions(channel: Channel, positions: Sequence[float]) -> list[float]:
    return [position - joint.offset for joint, position in zip(channel.joints, positions, strict=True)]


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


def _turned(joint: Joint, motion: JointMotion, told: JointMotion | None, passed: float) -> JointMotion:
    if not (told or motion.velocity):
        return motion
    position = _after(passed, joint, motion)
    velocity = told.velocity if told else motion.velocity
    if joint.max_velocity is not None:
        velocity = max(-joint.max_velocity, min(velocity, joint.max_velocity))
    limit = joint.max if velocity > 0 else joint.min
    is_there = velocity and limit is not None and (position - limit) * velocity >= 0
    return JointMotion(position, 0.0 if is_there else velocity)


def _after(seconds: float, joint: Joint, motion: JointMotion) -> float:
    """The position of a joint after some seconds. It stops at its limits; a joint beyond a limit doesn't jump back."""
    position, velocity = motion
    later = position + velocity * seconds
    if velocity > 0 and joint.max is not None:
        return min(later, max(position, joint.max))
    if velocity < 0 and joint.min is not None:
        return max(later, min(position, joint.min))
    return later


def _way(joint: Joint, legs: Sequence[_Leg], number: int, end: float) -> Iterator[Stretch]:
    """Yield the stretches of a joint, until it stands from a time on, or stops at a limit before that."""
    way = [Stretch(since, *motions[number]) for since, motions in legs]
    for stretch, later in zip(way, [*(each.since for each in way[1:]), end], strict=True):
        since, position, velocity = stretch
        stop = _after(later - since, joint, JointMotion(position, velocity))
        yield stretch
        if velocity and stop != position + velocity * (later - since):
            yield Stretch(since + (stop - position) / velocity, stop, 0.0)
    if velocity and stop == position + velocity * (later - since):
        yield Stretch(later, stop, 0.0)
