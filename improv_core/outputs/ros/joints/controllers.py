"""The controllers of all robots' joints, on ROS 2 topics, and the joints that each lists in its parameter (nodes are
passed in; rcl_interfaces is imported lazily)."""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from importlib.util import find_spec
from typing import Any

from improv_core.outputs.ros.joints.channels import Channel, channels_of, window_of
from improv_core.outputs.ros.joints.controller import Measured, RosController, Surroundings
from improv_core.outputs.ros.joints.goals import Goals
from improv_core.outputs.ros.topic import Advertise, Now, RosTopic
from improv_core.outputs.ros.zero_sender import PendingZeros
from improv_core.protocol.output import Unfollowed
from improv_core.safety.joint_preflight import JointOff, line_of, line_of_moving
from improv_core.score.joints import JointMotion
from improv_core.score.score import Part

PATIENCE = 5.0
"""Seconds before people get a line about unknown joint positions: the first positions take a few seconds to arrive."""
AGAIN = 5.0
"""Seconds before they get another line, if it differs."""
ANSWER_LIMIT = 2.0
"""Seconds to wait for the service of a node, when it is asked first, and then for its response."""
STRING_ARRAY = 9
"""The type of that parameter: PARAMETER_STRING_ARRAY of rcl_interfaces/msg/ParameterType."""


class RosControllers:
    """The controllers of all robots so far. `advertise` creates publishers, and `measured` returns joint positions."""

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
        self._around = Surroundings(node.get_clock(), measured, pending_zeros, now)
        self._tell = tell
        self._now = now
        self._topics: dict[tuple[str, str, int], RosTopic] = {}
        self._goals: dict[str, Goals] = {}
        self._robots: dict[str, list[RosController]] = {}
        self._parts: dict[str, Part] = {}
        self._tempo = Fraction(60)
        self._joints = ControllerJoints(node, now)
        self._unanswered: set[str] = set()  # topics whose controllers haven't listed their joints
        self._awaited: set[str] = set()  # those of them that nothing is sent on, because a response may come soon
        self._current: Collection[str] = ()
        self._begins = False  # True until beat 0
        self._waits_since = 0.0
        self._line = ""
        self._line_until = 0.0

    def preload(self, part: Part) -> None:
        """Create publishers for a robot that will be prepared next."""
        for channel in channels_of(part, self._joints.of):
            self._joints.ask(channel.topic, again=False)
            self._topic(channel, at_once=True)

    def take(self, parts: Mapping[str, Part], restart: bool, tempo: Fraction) -> None:
        """Use the controllers of these parts. Controllers that a robot doesn't have anymore get a command to stand."""
        self._parts.update(parts)
        self._tempo = tempo
        for robot, part in parts.items():
            for channel in channels_of(part):
                self._joints.ask(channel.topic, again=restart)
                self._unanswered.add(channel.topic)
            self._make(robot, restart)
        self._current = [*parts]
        self._begins = restart
        self._waits_since, self._line = self._now(), ""
        self._await_joints()

    def _make(self, robot: str, restart: bool) -> None:
        """Make the controllers of a robot's part, and keep those that don't change."""
        part, before = self._parts[robot], {each.channel: each for each in self._robots.get(robot, ())}
        channels = channels_of(part, self._joints.of)
        self._robots[robot] = [
            before.get(each)
            or RosController(part, each, self._topic(each, at_once=not restart), self._around, self._goals_of(each))
            for each in channels
        ]
        for channel in before.keys() - channels:
            before[channel].leave()
        for controller in self._robots[robot]:
            controller.take(part, restart, window_of(part, controller.channel, self._tempo))

    def _await_joints(self) -> None:
        """Use the lists of joints that have come from controllers."""
        self._awaited = {topic for topic in self._unanswered if self._joints.awaited(topic)}
        found = {topic for topic in self._unanswered if self._joints.of(topic)} - self._awaited
        self._unanswered -= found
        for robot in self._current:
            if not found.isdisjoint(self.topics([robot])):
                self._make(robot, restart=False)

    def topics(self, robots: Collection[str]) -> set[str]:
        return {controller.topic.name for controller in self._of(robots)}

    def waits(self) -> bool:
        """Return whether beat 0 must wait until the joints' positions are known and the joints are at their starts."""
        self._await_joints()
        found = [each for controller in self._of(self._current) for each in controller.off()]
        moving = any(controller.homing for controller in self._of(self._current))
        self._begins = bool(found) or moving or bool(self._awaited)
        line, now = line_of(found, moving=moving) if found else "", self._now()
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
            controllers = self._robots[robot]
            if not self._begins or not any(each.off() for each in controllers if not each.moves_home):
                for controller in controllers:
                    if controller.topic.name not in self._awaited:
                        controller.ask()

    def home_joints(self, robots: Collection[str]) -> None:
        """Bring the joints of these robots to their starts, if `improv.toml` says so; the joints of all other robots
        stand. People get a line with the joints before these begin to move."""
        going, begin = list[RosController](), list[JointOff]()
        for robot in self._current:
            for controller in self._robots[robot]:
                stood = controller.homing is None
                if robot not in robots or not controller.moves_home:
                    controller.halt()
                elif controller.topic.name not in self._awaited and controller.steers_home():
                    going.append(controller)
                    begin += controller.off() if stood else ()
        if begin:
            self._tell(line_of_moving(begin))
        for controller in going:
            controller.go_home()

    def halt(self, robot: str) -> None:
        """Stop a robot's joints that are on their way to their starts."""
        for controller in self._robots[robot]:
            controller.halt()

    def missing(self, robot: str) -> str | None:
        """The reason why one of a robot's controllers would not receive a command now, or None; "" while listeners and
        publishers still find each other."""
        lines = [controller.missing() for controller in self._robots[robot]]
        found = [line for line in lines if line is not None]
        return max(found, key=bool) if found else None

    def warning(self, robot: str, others: Callable[[RosTopic, bool], Collection[str]]) -> str | None:
        """A line if one of a robot's controllers lacks a joint, or if other nodes publish on its topic. `others` lists
        them; its second argument says whether the standby also has a publisher there."""
        for controller in self._robots[robot]:
            if lacking := controller.channel.lacking:
                joints = ", ".join(joint.name for joint in controller.channel.joints)
                line = f"the controller on {controller.topic.name} has no {lacking[0]}, only {joints}"
                return f"{line}: correct its `joints` in improv.toml"
            if found := others(controller.topic, controller.needs_zeros):
                line = f"other nodes also publish to {controller.topic.name}: {', '.join(found)}; "
                return f"{line}joints obey all of them: stop the others"
        return None

    def send(
        self,
        robot: str,
        joints: Mapping[str, JointMotion],
        at: float,
        pace: float = 1.0,
        until: float = math.inf,
        late: float = 0.0,
    ) -> None:
        """Publish the commands for these joints, as `Sink.send_joints` says, this many seconds `late`.

        Controllers whose joint positions are unknown get nothing. Raises ValueError if a number isn't finite, and what
        rclpy raises.
        """
        if not all(math.isfinite(number) for motion in joints.values() for number in motion):
            raise ValueError(f"{robot} was given a joint's speed that is not a finite number")
        if self._awaited:
            self._await_joints()
        for controller in self._robots[robot]:
            if controller.topic.name in self._awaited:
                continue
            if line := controller.send(joints, at, pace, until, late):
                self._tell(line)

    def unfollowed(self) -> Mapping[str, Unfollowed]:
        """The robots whose joints don't follow, with the likely cause of one of their controllers."""
        found = {robot: [each.unfollowed for each in self._robots[robot]] for robot in self._current}
        return {robot: first for robot, each in found.items() if (first := next(filter(None, each), None))}

    def _of(self, robots: Collection[str]) -> Iterator[RosController]:
        for robot in robots:
            yield from self._robots[robot]

    def _goals_of(self, channel: Channel) -> Goals | None:
        """The goals for a controller; None if it gets no trajectories, or the type of the action isn't installed."""
        if channel.interface != "trajectory" or not find_spec("control_msgs"):
            return None
        if channel.topic not in self._goals:
            self._goals[channel.topic] = Goals(self._node, channel.topic, self._now)
        return self._goals[channel.topic]

    def _topic(self, channel: Channel, *, at_once: bool) -> RosTopic:
        joints = len(channel.joints) if channel.interface == "velocity" else 0  # as many zeros as the standby sends
        key = channel.topic, channel.interface, joints
        if key not in self._topics:
            advertise = self._advertise(channel)
            self._topics[key] = RosTopic(channel.topic, channel.message, self._node, advertise, self._now, at_once)
        return self._topics[key]


@dataclass(slots=True)
class _Call:
    """A request to a controller's node; `ends` is the time until which its response is awaited."""

    client: Any
    ends: float
    answer: Any = None


class ControllerJoints:
    """Reads the joints of controllers. Nothing here blocks; the executor that spins `node` receives the responses."""

    def __init__(self, node: Any, now: Now) -> None:
        self._node = node
        self._now = now
        self._calls: dict[str, _Call] = {}
        self._joints: dict[str, tuple[str, ...]] = {}

    def ask(self, topic: str, *, again: bool) -> None:
        """Ask the controller that listens on a topic, or ask it `again`: another one may have taken its place."""
        before = self._calls.get(topic)
        if before and again:
            self._calls[topic] = _Call(before.client, self._now())
        elif not before:
            self._calls[topic] = _Call(self._client(topic), self._now() + ANSWER_LIMIT)

    def awaited(self, topic: str) -> bool:
        """Return whether the response about a topic may come soon. Call it repeatedly: it asks nodes as they appear."""
        call = self._calls[topic]
        if call.answer is None and call.client.service_is_ready():
            call.answer = call.client.call_async(call.client.srv_type.Request(names=["joints"]))
            call.ends = self._now() + ANSWER_LIMIT
        if call.answer is None or not call.answer.done():
            return self._now() < call.ends
        for value in () if call.answer.exception() else call.answer.result().values:
            if value.type == STRING_ARRAY:
                self._joints[topic] = tuple(value.string_array_value)
        return False

    def of(self, topic: str) -> Sequence[str]:
        """The joints of the controller that listens on a topic, in its order; none if they are unknown."""
        return self._joints.get(topic, ())

    def _client(self, topic: str) -> Any:
        from rcl_interfaces.srv import GetParameters

        # The topics of a controller are in the namespace of its node's name.
        return self._node.create_client(GetParameters, f"{topic.rpartition('/')[0]}/get_parameters")
