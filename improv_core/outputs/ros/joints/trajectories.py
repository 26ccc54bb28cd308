"""Commands for the controllers of a robot's joints. It never reads a clock. Standard library only.

Positions are in radians or meters, and times in seconds. A commanded position never jumps: it follows from what was
sent before, also if that was late. A joint that is behind the program catches up while the program moves it.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import NamedTuple

from improv_core.outputs.cdr import numbers_message, trajectory_message
from improv_core.outputs.ros.joints.channels import HOMING, WINDOW, Channel
from improv_core.outputs.ros.joints.smoothing import (
    EXACT,
    SOONEST,
    Blend,
    Brake,
    Stretch,
    TrajectoryPoint,
    blend_of,
    blended,
    points,
)
from improv_core.safety.joint_preflight import FAR_SLIDE, FAR_TURN, adrift, is_far
from improv_core.score.body import Joint
from improv_core.score.joints import JointMotion

CRUISE = 0.2
"""Seconds for which a trajectory keeps its velocity: a few commands may be late or get lost."""
LAG, LAST_LAG = 0.5, 0.2
"""Seconds by which joints may lag behind their commands: while they move, and when they are stopped. They still cover
that distance."""
HURRY = 0.5
"""A joint that is behind the program catches up faster or slower than the program by this share of its speed."""
SLACK = 0.01
"""Seconds by which a command may seem to come before the last one: how late it is isn't known while nothing plays."""
SOONEST_STOP = 0.05
"""Seconds in which a moving joint is stopped, at least, however fast it may brake: it lags by about as much."""


class _Leg(NamedTuple):
    """The positions of joints at a performance time, and their velocities from then until the next leg."""

    since: float
    motions: tuple[JointMotion, ...]


@dataclass(frozen=True, slots=True)
class Course:
    """The movement of a controller's joints, in their order, from a performance time on.

    `legs` are those that were sent and still smooth it, the present one, and those with which joints that catch up
    join the `program`, which has them there at this time. It moves them on `until` another time. Joints with a brake
    have been stopped, at where they come to rest; the others may have a blend.
    """

    motions: tuple[JointMotion, ...]
    since: float = 0.0
    legs: tuple[_Leg, ...] = field(default=(), compare=False)
    program: tuple[JointMotion, ...] = field(default=(), compare=False)
    until: float = field(default=math.inf, compare=False)
    brakes: tuple[Brake | None, ...] = field(default=(), compare=False)
    blends: tuple[Blend, ...] = field(default=(), compare=False)

    @property
    def velocities(self) -> list[float]:
        return [velocity for _, velocity in self.motions]

    @property
    def moves(self) -> bool:
        return any(self.velocities)

    @property
    def end(self) -> float:
        """The time at which the program's movement ends in its trajectory: joints may turn around `until` then."""
        return max(min(self.since + CRUISE, self.until), self.since)

    @property
    def sent(self) -> Sequence[_Leg]:
        """The legs of its trajectory."""
        legs = self.legs or (_Leg(self.since, self.motions),)
        return [leg for leg in legs if leg.since <= self.since or leg.since < self.end]


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


def turned(
    channel: Channel,
    before: Course,
    told: Mapping[str, JointMotion],
    at: float,
    late: float = 0.0,
    until: float = math.inf,
) -> Course:
    """The course after some of the joints get a new velocity at a time, `until` another one. The others continue.

    No joint exceeds its highest speed or passes its limits. If the command is `late`, what was sent before has happened
    until now, so joints continue from there. Those that are behind the program catch up while it moves them, or while
    they arrive, unless something has held them back. In a stop, which lasts no time, they brake.
    """
    now = at + late
    if before.since > now + SLACK:  # performance time has started over
        before = Course(before.motions, now)
    now = max(now, before.since)
    legs = _passed(channel, before, now)
    (since, last), passed = legs[-1], now - before.since
    program, motions, joins, brakes = [], list[JointMotion](), list[float](), list[Brake | None]()
    for number, joint in enumerate(channel.joints):
        here = JointMotion(last[number].after(now - since, joint), last[number].velocity)
        brake, command = before.brakes[number] if before.brakes else None, told.get(joint.name)
        if command:
            goal = JointMotion(command.after(now - at, joint), command.velocity)
        else:
            goal = before.program[number] if before.program else before.motions[number]
            goal = JointMotion(goal.after(passed, joint), goal.velocity)
        if brake and brake.until > now:
            here = JointMotion(here.position, 0.0)
        elif command and until <= at:
            brake = _brake(channel, before, number, now)
            here = JointMotion(brake.rest if brake else here.position, 0.0)
        else:
            arrives = here.velocity or before.motions[number].velocity if command else here.velocity
            brake, here = None, _toward(channel, joint, here, goal, arrives)
        gap, closing = goal.position - here.position, here.velocity - _within(joint, goal.velocity)
        program.append(goal)
        motions.append(here)
        brakes.append(brake)
        joins.append(now + gap / closing if gap * closing > 0 and not brake else math.inf)
    until = until if until > at else math.inf
    course = Course(tuple(motions), now, (), tuple(program), until, tuple(brakes))
    legs = [_Leg(leg.since, _at_rest(leg.motions, course)) for leg in legs if leg.since < now or leg is legs[0]]
    if course.velocities != [motion.velocity for motion in legs[-1].motions]:
        legs.append(_Leg(now, course.motions))
    gone = sum(1 for later in legs[1:] if later.since <= now - channel.window)
    ahead = (_joined(channel, course, joins, time) for time in sorted({*joins}) if time < course.end)
    course = replace(course, legs=(*legs[gone:], *ahead))
    return replace(course, blends=tuple(_blends(channel, before, course)))


def _blends(channel: Channel, before: Course, course: Course) -> Iterator[Blend]:
    """Yield the blends of joints, of which those that brake have none."""
    if channel.interface != "trajectory":
        return
    lasts = before.blends or [Blend()] * len(channel.joints)
    for way, last, brake in zip(_ways(channel, course), lasts, course.brakes, strict=True):
        yield Blend() if brake else blend_of(way, channel.window, course.since, last)


def _passed(channel: Channel, before: Course, now: float) -> list[_Leg]:
    """The legs that have been performed until now. What was sent ends at rest, except for velocities."""
    legs = [leg for leg in before.sent if leg.since <= now]
    since, motions = legs[-1]
    if channel.needs_positions and now > before.end and any(velocity for _, velocity in motions):
        pairs = zip(channel.joints, motions, strict=True)
        rest = (JointMotion(motion.after(before.end - since, joint), 0.0) for joint, motion in pairs)
        legs.append(_Leg(before.end, tuple(rest)))
    return legs


def _toward(channel: Channel, joint: Joint, here: JointMotion, goal: JointMotion, arrives: float) -> JointMotion:
    """A joint's movement toward where the program has it, and moves it on.

    Velocity controllers know no positions. If the program has a joint stand, it doesn't begin to move: one that
    `arrives` at a speed continues, unless it is far from there. Then something has held it, and people may be near.
    """
    velocity, gap = _within(joint, goal.velocity), goal.position - here.position
    if channel.needs_positions and abs(gap) > EXACT:
        if velocity:
            fastest = (1 + HURRY) * abs(velocity)
            if joint.max_acceleration:  # so much that it may still reverse in a window
                fastest = max(min(fastest, joint.max_acceleration * channel.window / 2), abs(velocity))
            velocity += math.copysign(HURRY * velocity, gap)
            velocity = _within(joint, max(-fastest, min(velocity, fastest)))
        elif arrives and not is_far(joint, goal.position, here.position):
            velocity = math.copysign(arrives, gap)
    limit = joint.max if velocity > 0 else joint.min
    is_there = velocity and limit is not None and (here.position - limit) * velocity >= 0
    return JointMotion(here.position, 0.0 if is_there else velocity)


def _joined(channel: Channel, course: Course, joins: Sequence[float], time: float) -> _Leg:
    """The leg from a time on at which joints join the program."""
    found = zip(channel.joints, course.motions, course.program, joins, strict=True)
    return _Leg(
        time,
        tuple(
            JointMotion(goal.after(time - course.since, joint), _within(joint, goal.velocity))
            if join <= time
            else JointMotion(motion.after(time - course.since, joint), motion.velocity)
            for joint, motion, goal, join in found
        ),
    )


def _brake(channel: Channel, before: Course, number: int, now: float) -> Brake | None:
    """Return how a joint comes to rest in a trajectory; None if it stands, or has another controller. It brakes as fast
    as its stated acceleration allows, and takes at most as long as in the program, whose window has an upper limit.
    Without a stated acceleration, it takes the shortest window."""
    joint, last = channel.joints[number], before.blends[number] if before.blends else Blend()
    way = [*_way(joint, before.sent, number, before.end)]
    position, velocity = blended(way, channel.window, last, now)
    if not velocity or channel.interface != "trajectory":
        return None
    seconds = WINDOW
    if joint.max_acceleration:
        seconds = max(min(abs(velocity) / joint.max_acceleration, channel.window / 2), SOONEST_STOP)
    return Brake(now, position + velocity * seconds / 2, velocity, seconds)


def _at_rest(motions: tuple[JointMotion, ...], course: Course) -> tuple[JointMotion, ...]:
    """These positions and velocities; joints that brake stand where they come to rest."""
    found = zip(motions, course.brakes, strict=True)
    return tuple(JointMotion(brake.rest, 0.0) if brake else motion for motion, brake in found)


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
    if not any(offs):
        return course
    course = replace(_shifted(course, offs), blends=before.blends)
    return turned(channel, course, {}, course.since, until=course.until)


def _shifted(course: Course, offs: Sequence[float]) -> Course:
    def shift(motions: Sequence[JointMotion]) -> tuple[JointMotion, ...]:
        return tuple(JointMotion(at + off, speed) for (at, speed), off in zip(motions, offs, strict=True))

    legs = tuple(_Leg(since, shift(each)) for since, each in course.legs)
    brakes = tuple(None if off else brake for brake, off in zip(course.brakes, offs, strict=False))  # none yet
    return replace(course, motions=shift(course.motions), legs=legs, brakes=brakes)


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
    return turned(homing, Course(course.motions, now), told, now)


def stopped(channel: Channel, course: Course, passed: float) -> Course:
    """The course with all joints stopped, this many seconds after it began."""
    still = {
        joint.name: JointMotion(motion.position, 0.0)
        for joint, motion in zip(channel.joints, course.motions, strict=True)
    }
    at = course.since + passed
    return turned(channel, course, still, at, until=at)


def leaves_out(before: Course, course: Course, now: float, soon: bool = False) -> bool:
    """Return whether to leave a course out that only repeats the one before, which was sent: it comes `soon` after it,
    or joints change right afterwards."""
    sent = [leg for leg in before.sent if leg.since <= now]
    repeats = course.moves and sent and course.velocities == [velocity for _, velocity in sent[-1].motions]
    if not repeats or abs(replace(before, until=course.until).end - before.end) > EXACT:
        return False
    return soon or course.until < now + SOONEST


def trajectory(channel: Channel, course: Course) -> Iterator[TrajectoryPoint]:
    """The points of a course, which comes to rest by itself. Joints that stand have a single point."""
    return points(_ways(channel, course), channel.window, course.since, course.brakes, course.blends)


def message_of(channel: Channel, course: Course, pace: float = 1.0) -> bytes:
    """The message for a controller at the present time of a course, in positions of its encoders. By the controller's
    clock, such as a simulation's, `pace` seconds pass in one of a performance."""
    if channel.interface == "velocity":
        return numbers_message([velocity / pace for velocity in course.velocities])
    if channel.interface == "position":
        return numbers_message(_encoder_positions(channel, [motion.position for motion in course.motions]))
    found = [
        (seconds * pace, _encoder_positions(channel, positions), [velocity / pace for velocity in velocities])
        for seconds, positions, velocities in trajectory(channel, course)
    ]
    return trajectory_message(tuple(joint.name for joint in channel.joints), found)


def _encoder_positions(channel: Channel, positions: Sequence[float]) -> list[float]:
    return [position - joint.offset for joint, position in zip(channel.joints, positions, strict=True)]


def _within(joint: Joint, velocity: float) -> float:
    """The velocity, or the joint's highest speed in its direction."""
    return velocity if joint.max_velocity is None else max(-joint.max_velocity, min(velocity, joint.max_velocity))


def _ways(channel: Channel, course: Course) -> list[list[Stretch]]:
    return [[*_way(joint, course.sent, number, course.end)] for number, joint in enumerate(channel.joints)]


def _way(joint: Joint, legs: Sequence[_Leg], number: int, end: float) -> Iterator[Stretch]:
    """Yield the stretches of a joint, until it stands from a time on, or stops at a limit before that."""
    way = [Stretch(since, *motions[number]) for since, motions in legs]
    for stretch, later in zip(way, [*(each.since for each in way[1:]), end], strict=True):
        since, position, velocity = stretch
        stop = JointMotion(position, velocity).after(later - since, joint)
        yield stretch
        if velocity and stop != position + velocity * (later - since):
            yield Stretch(since + (stop - position) / velocity, stop, 0.0)
    if velocity and stop == position + velocity * (later - since):
        yield Stretch(later, stop, 0.0)
