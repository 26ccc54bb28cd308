"""Sends commands to the controllers of robots' joints, on ROS 2 topics (nodes are passed in)."""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any

from improv_core.outputs.cdr import numbers_message
from improv_core.outputs.ros.joints.trajectories import (
    Channel,
    Course,
    channels_of,
    current_course,
    homing_channel,
    homing_course,
    joint_states_of,
    let_go,
    message_of,
    paced,
    stopped,
    turned,
)
from improv_core.outputs.ros.topic import Advertise, Now, RosTopic
from improv_core.outputs.ros.zero_sender import PendingZeros
from improv_core.safety.joint_preflight import FRESH, JointOff, joints_off, line_of, line_of_moving
from improv_core.safety.zeros import LAST_ZEROS
from improv_core.score.joints import JointMotion
from improv_core.score.score import Part

SETTLED = 0.5
"""Seconds after which stopped joints have come to rest, so that their measured positions count."""
PATIENCE = 5.0
"""Seconds before people get a line about unknown joint positions: the first positions take a few seconds to arrive."""
AGAIN = 5.0
"""Seconds before they get another line, if it differs."""

PERIOD = 0.05
"""Seconds between two messages to joints that move to their starts."""

OFTEN = 0.75
"""Repeat a command only after this share of its period. Each body part asks for its own repeats, and a controller that
moves several gets all of them."""

Measured = Callable[[str], Mapping[str, tuple[float, float]]]
"""Returns the positions of a robot's joints, each with its time of arrival in monotonic seconds."""


class RosControllers:
    """The controllers of all robots that a score has had. `advertise` creates publishers on a topic, and `measured`
    returns joint positions. Only velocity controllers never stop by themselves, so `pending_zeros` gets their topics. A
    trajectory ends at rest, and a position is one at which a joint stands."""

    def __init__(
        self,
        node: Any,
        advertise: Callable[[Channel], Advertise],
        measured: Measured,
        pending_zeros: PendingZeros,
        tell: Callable[[str], None],
        now: Now,
    ) -> None:
        self._node = node
        self._advertise = advertise
        self._measured = measured
        self._pending_zeros = pending_zeros
        self._tell = tell
        self._now = now
        self._topics: dict[tuple[str, str, int], RosTopic] = {}
        self._robots: dict[str, _Robot] = {}
        self._current: Collection[str] = ()
        self._begins = False  # True until beat 0
        self._waits_since = 0.0
        self._line = ""
        self._line_until = 0.0
        self._held_line_until = 0.0

    def preload(self, part: Part) -> None:
        """Create publishers for a robot that will be prepared next."""
        for channel in channels_of(part):
            self._topic(channel, at_once=True)

    def take(self, parts: Mapping[str, Part], restart: bool) -> None:
        """Use the controllers of these parts. Controllers that a robot doesn't have anymore get a command to stand."""
        for robot, part in parts.items():
            old = self._robots[robot].controllers if robot in self._robots else []
            before = {controller.channel: controller for controller in old}
            channels = channels_of(part)
            controllers = [
                before.get(each) or _Controller(each, self._topic(each, at_once=not restart)) for each in channels
            ]
            for channel in before.keys() - channels:
                self._leave(robot, before[channel])
            self._robots[robot] = _Robot(part, controllers)
            for controller in controllers:
                controller.from_measured = controller.from_measured or restart
                controller.homing_tried = controller.homing_tried and not restart
                if not part.scenes:  # it only has to stop, because an earlier stage may have moved it
                    zero = numbers_message([0.0] * len(controller.channel.joints))
                    self._pending_zeros.note_inherited(robot, controller.topic, "", zero)
        self._current = [*parts]
        self._begins = restart
        self._waits_since, self._line = self._now(), ""

    def topics(self, robots: Collection[str]) -> set[str]:
        """The topics of these robots' controllers."""
        return {controller.topic.name for robot in robots for controller in self._robots[robot].controllers}

    def waits(self) -> bool:
        """Return whether beat 0 must wait until the joints' positions are known and the joints are at their starts."""
        found = [each for robot in self._current for each in self._off(robot)]
        moving = any(controller.homing for robot in self._current for controller in self._robots[robot].controllers)
        self._begins = bool(found) or moving
        line, now = line_of(found, moving=moving), self._now()
        patience = PATIENCE if any(each.is_unknown for each in found) else 0.0
        if line != self._line and now >= max(self._waits_since + patience, self._line_until if self._line else 0.0):
            self._line, self._line_until = line, now + AGAIN
            if line:
                self._tell(line)
        return self._begins

    def ask(self, robots: Collection[str]) -> None:
        """Have the listeners of these standing robots confirm a command that moves nothing. Before beat 0, skip joints
        that people have to bring to their starts themselves."""
        for robot in robots:
            if self._begins and not self._robots[robot].moves_home and any(self._off(robot)):
                continue
            for controller in self._robots[robot].controllers:
                if course := self._course(robot, controller, begins=False):
                    controller.topic.ask(message_of(controller.channel, course), self._node.get_clock(), b"")

    def home_joints(self, robots: Collection[str]) -> None:
        """Bring the joints of these robots to their starts, if `improv.toml` says so; the joints of all other robots
        stand. People get a line with the joints before these begin to move."""
        told, begin = list[_Controller](), list[JointOff]()
        for robot in self._current:
            if robot not in robots or not self._robots[robot].moves_home:
                self.halt(robot)
                continue
            for controller in self._robots[robot].controllers:
                stood = controller.homing is None
                if self._steers_home(robot, controller):
                    told.append(controller)
                    begin += self._off_in(robot, controller) if stood else ()
        if begin:
            self._tell(line_of_moving(begin))
        for controller in told:
            self._publish(controller)
            if controller.moves:
                controller.moved = self._now()
            else:
                controller.homing_tried, controller.homing = True, None

    def halt(self, robot: str) -> None:
        """Stop a robot's joints that are on their way to their starts."""
        for controller in self._robots[robot].controllers:
            self._halt(controller)

    def missing(self, robot: str) -> str | None:
        """The reason why one of a robot's controllers would not receive a command now, or None; "" while listeners and
        publishers still find each other."""
        lines = [controller.topic.missing(controller.moves) for controller in self._robots[robot].controllers]
        found = [line for line in lines if line is not None]
        return max(found, key=bool) if found else None

    def warning(self, robot: str, others: Callable[[RosTopic, bool], Collection[str]]) -> str | None:
        """A line if other nodes publish on the topic of one of a robot's controllers. `others` lists them; its second
        argument says whether the standby also has a publisher there."""
        for controller in self._robots[robot].controllers:
            if found := others(controller.topic, controller.channel.interface == "velocity"):
                line = f"other nodes also publish to {controller.topic.name}: {', '.join(found)}; "
                return f"{line}joints obey all of them: stop the others"
        return None

    def send(self, robot: str, joints: Mapping[str, JointMotion], at: float, pace: float = 1.0) -> None:
        """Publish the commands for these joints from performance time `at` on, where `pace` performance seconds pass in
        a second. Controllers whose joint positions are unknown get nothing. Raises ValueError if a number isn't finite,
        and what rclpy raises."""
        if not all(math.isfinite(number) for motion in joints.values() for number in motion):
            raise ValueError(f"{robot} was given a joint's speed that is not a finite number")
        for controller in self._robots[robot].controllers:
            if any(joint.name in joints for joint in controller.channel.joints):
                self._send(robot, controller, joints, at, pace)

    def _send(
        self, robot: str, controller: _Controller, joints: Mapping[str, JointMotion], at: float, pace: float
    ) -> None:
        self._halt(controller)
        begins = any(joint.name in joints and joints[joint.name].velocity for joint in controller.channel.joints)
        before = self._course(robot, controller, begins=begins)
        if before is None:
            return
        controller.from_measured = controller.from_measured and not begins
        controller.course = course = self._without_jump(
            robot, controller, before, turned(controller.channel, before, joints, at)
        )
        if (
            course.moves
            and course.velocities == before.velocities
            and self._now() < controller.sent + OFTEN * self._robots[robot].period
        ):
            return  # the same command was just sent for another body part
        topic, message = controller.topic, message_of(controller.channel, paced(course, pace))
        needs_zeros = controller.channel.interface == "velocity"
        if course.moves and needs_zeros:
            self._pending_zeros.note_velocity(topic, "")
        topic.publish(message, self._node.get_clock(), b"")
        controller.sent = self._now()
        if course.moves:
            controller.moved = controller.sent
        elif needs_zeros:
            self._pending_zeros.note_zero(robot, topic, "", message)

    def _without_jump(self, robot: str, controller: _Controller, before: Course, course: Course) -> Course:
        now, free = self._now(), let_go(controller.channel, before, course, self._recent(robot))
        pairs = zip(controller.channel.joints, course.motions, free.motions, strict=True)
        held = [joint.name for joint, motion, other in pairs if motion.position != other.position]
        if held and course.moves and now >= self._held_line_until:
            self._held_line_until = now + AGAIN
            self._tell(
                f"something holds back {held[0]} of {robot}: it continues from its real position, not the program's"
            )
        return free

    def _homing_without_jump(self, robot: str, homing: Channel, before: Course, now: float) -> Course:
        """The course of joints on their way to their starts. If something holds one back, they all stay where they
        are."""
        course = turned(homing, before, {}, now)
        free = let_go(homing, before, course, self._recent(robot))
        return course if free == course else stopped(homing, free, 0.0)

    def _steers_home(self, robot: str, controller: _Controller) -> bool:
        """Update the course of joints that move to their starts, and return whether to send it now. They try only once,
        because something may block them."""
        now = self._now()
        if (
            controller.homing_tried
            or now < controller.sent + PERIOD
            or controller.topic.missing(controller.moves) is not None
        ):
            return False
        if controller.homing and controller.course:
            controller.course = self._homing_without_jump(robot, controller.homing, controller.course, now)
            return True
        course = self._course(robot, controller, begins=False)
        if not course or not (homing := homing_channel(controller.channel, course)):
            return False
        controller.homing, controller.course = homing, homing_course(homing, course, now)
        return True

    def _halt(self, controller: _Controller) -> None:
        if controller.homing and controller.course:
            controller.course = stopped(controller.homing, controller.course, self._now() - controller.course.since)
            controller.homing = None
            self._publish(controller)

    def _publish(self, controller: _Controller) -> None:
        assert controller.course
        controller.topic.publish(
            message_of(controller.homing or controller.channel, controller.course), self._node.get_clock(), b""
        )
        controller.sent = self._now()

    def _leave(self, robot: str, controller: _Controller) -> None:
        """Stop joints that another controller moves from now on."""
        if controller.course:
            course = stopped(controller.channel, controller.course, max(self._now() - controller.sent, 0.0))
            for _ in range(LAST_ZEROS):
                controller.topic.publish(message_of(controller.channel, course), self._node.get_clock(), b"")
            if controller.channel.interface == "velocity":
                self._pending_zeros.note_zero(robot, controller.topic, "", message_of(controller.channel, course))

    def _course(self, robot: str, controller: _Controller, *, begins: bool) -> Course | None:
        """The current course of a controller's joints, before a new command; None if unknown."""
        rests = self._now() >= controller.moved + SETTLED
        controller.course = current_course(
            controller.channel,
            controller.course,
            self._fresh(robot),
            begins=begins,
            from_measured=controller.from_measured,
            rests=rests,
        )
        return controller.course

    def _fresh(self, robot: str) -> dict[str, float]:
        """The known current positions of a robot's joints."""
        return {joint: position for joint, (position, _) in self._recent(robot).items()}

    def _recent(self, robot: str) -> dict[str, tuple[float, float]]:
        """These positions, each with its age in seconds."""
        now, body = self._now(), self._robots[robot].part.profile.body
        return {
            name: (position + body.joint[name].offset, max(now - at, 0.0))
            for name, (position, at) in self._measured(robot).items()
            if at >= now - FRESH and body and name in body.joint
        }

    def _off(self, robot: str) -> Iterator[JointOff]:
        """The joints that aren't at their starts or whose positions are unknown."""
        for controller in self._robots[robot].controllers:
            yield from self._off_in(robot, controller)

    def _off_in(self, robot: str, controller: _Controller) -> Iterator[JointOff]:
        """The joints of one controller that aren't at their starts or whose positions are unknown."""
        part = self._robots[robot].part
        topic, needed = joint_states_of(part), controller.channel.needs_positions
        if part.scenes and (topic or needed):
            brought = self._robots[robot].moves_home and not controller.homing_tried and needed
            yield from joints_off(robot, controller.channel.joints, topic, self._fresh(robot), brought)

    def _topic(self, channel: Channel, *, at_once: bool) -> RosTopic:
        key = channel.topic, channel.interface, len(channel.joints)
        if key not in self._topics:
            advertise = self._advertise(channel)
            self._topics[key] = RosTopic(channel.topic, channel.message, self._node, advertise, self._now, at_once)
        return self._topics[key]


@dataclass(slots=True)
class _Controller:
    """A controller of a robot and its latest course; None until the positions of its joints are known."""

    channel: Channel
    topic: RosTopic
    course: Course | None = None
    sent: float = -math.inf
    moved: float = -math.inf
    """The time at which it last got a command to move."""
    from_measured: bool = True
    """True if its next course starts at the measured positions of its joints."""
    homing: Channel | None = None
    """The channel that brings its joints to their starts, while they move there."""
    homing_tried: bool = False
    """True after it has tried to bring its joints to their starts."""

    @property
    def moves(self) -> bool:
        return self.course is not None and self.course.moves


@dataclass(slots=True)
class _Robot:
    part: Part
    controllers: list[_Controller] = field(default_factory=list)

    @property
    def moves_home(self) -> bool:
        """True if its joints are brought to their starts before beat 0."""
        body = self.part.profile.body
        return body is not None and body.home == "move"

    @property
    def period(self) -> float:
        """Seconds between two equal commands."""
        return 1 / self.part.profile.command_rate
