"""Publishes velocities on ROS 2 topics from one node that lives as long as the stage (rclpy, imported lazily)."""

from __future__ import annotations

import math
import os
import threading
import time
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from functools import partial
from typing import Any

from improv_core.ipc.arrivals import End
from improv_core.outputs.ros.base import RosBase, publish_all
from improv_core.outputs.ros.buttons import Buttons
from improv_core.outputs.ros.clock import CLOCK, ClockListener, NodeTime
from improv_core.outputs.ros.discovery import described
from improv_core.outputs.ros.joints.channels import Channel, needs_base
from improv_core.outputs.ros.joints.controllers import RosControllers
from improv_core.outputs.ros.nodes import PUBLISHER, READER, Nodes, is_harmless, is_published, node_name, without_name
from improv_core.outputs.ros.publisher.client import PublisherClient
from improv_core.outputs.ros.requests import Ask, Requests
from improv_core.outputs.ros.reset import Resets
from improv_core.outputs.ros.sensors.client import PROMPT, USUAL, RosReader, request_for, silence
from improv_core.outputs.ros.standby.client import PULSE_PERIOD, Standby
from improv_core.outputs.ros.topic import Advertise, RosTopic, message_class
from improv_core.outputs.ros.zero_sender import ZERO, PendingZeros
from improv_core.plain import one_line
from improv_core.protocol.messages import FromStage, SentAs
from improv_core.protocol.output import Alarm, BaseCommand, Edge, Noticed, RawJoints, RawPoses, Sink
from improv_core.safety.pending_zeros import LINGER
from improv_core.score.joints import JointMotion
from improv_core.score.motion import STILL
from improv_core.score.peer_clock import Anchor
from improv_core.score.profiles import PUPPET
from improv_core.score.score import Part, Score
from improv_core.score.senses import RobotSense

REST = 0.005
"""Seconds between two reads: /clock may arrive a thousand times a second, but only the latest message counts."""


class RosSink(Sink):
    """A sink that publishes `geometry_msgs/Twist` or `TwistStamped`, within the limits of each robot's profile.

    `hear` gets edges, poses, alarms, anchors of /clock, and the end if no more messages can be received; `ask` gets
    requests from ROS 2. Other threads call both. `tell` gets lines for people. `node` is the node's name, if it needn't
    be unique; `arguments` are ROS's own. Raises ImportError without rclpy, and rclpy's errors about wrong arguments.
    """

    name = "ROS 2"
    real = True
    period = PULSE_PERIOD

    def __init__(
        self,
        standby: Standby,
        hear: Callable[[Edge | RawPoses | RawJoints | Alarm | Anchor | End], None],
        ask: Ask,
        node: str | None = None,
        arguments: Sequence[str] = (),
        tell: Callable[[str], None] = lambda line: None,
    ) -> None:
        now = time.monotonic
        name, arguments = without_name(arguments)
        self._standby = standby
        standby.alarm = lambda line: hear(Alarm(line))
        from rclpy.executors import SingleThreadedExecutor

        name = name or node or node_name()
        self._nodes = Nodes(name, arguments)
        message_class("Twist")  # imported before the first robot waits for it
        self._node = self._nodes.first
        self._requests = Requests(self._node, ask)
        self._clock = self._node.get_clock()
        standby.time = lambda: self._clock.now().nanoseconds
        self._time = NodeTime(self._node)
        self._executor: Any = SingleThreadedExecutor(context=self._node.context)
        self._executor.add_node(self._node)
        self._hear = hear
        self._closing = threading.Event()
        self._receiving = threading.Thread(target=self._receive, daemon=True)
        self._receiving.start()
        self._now, self._tell = now, tell
        self._resets = Resets(self._node, now)
        self._clock_listener = ClockListener(self._node, hear, now)
        self._buttons = Buttons(self._node, hear, now)
        self._reader = RosReader(name + READER, arguments, hear, now)
        if self._clock.ros_time_is_active:  # the parameter may be for the stage's node only
            arguments += ["-p", "use_sim_time:=true"]
        self._publisher = PublisherClient(name + PUBLISHER, arguments, now)
        self.pending_zeros: PendingZeros = PendingZeros(self._standby, self._clock, self._others, tell, now)
        """The zeros that robots may not have received."""
        where = lambda robot: self._reader.joints.get(robot, {})  # noqa: E731
        self._controllers = RosControllers(self._node, self._advertise_for, where, self.pending_zeros, tell, now)
        self._robots: dict[str, RosBase] = {}
        self._topics: dict[str, RosTopic] = {}
        self._unprepared: set[str] = set()  # topics whose robots aren't prepared yet
        self._current: list[str] = []
        self._elsewhere: Collection[str] = ()  # robots that other stages move
        self._other_publishers: dict[str, Collection[str]] = {}
        self._standby.wait()

    @property
    def description(self) -> str:
        """The domain and the range of discovery, in words."""
        return f"{self.name}, {described(os.environ)}"

    def show(self, message: FromStage) -> None:
        """Pass a message of the stage on to ROS 2."""
        self._requests.show(message)
        self._publisher.show(message)
        if message["type"] == "transport":
            zero = message["monotonic"] - message["performed"]
            self._publisher.health.zero = zero if message["state"] == "playing" else None

    def announce(self, score: Score, generation: int) -> None:
        """Publish a score to ROS 2 before it plays."""
        self._publisher.take(score, generation)

    def preload(self, score: Score) -> Iterator[None]:
        """Create publishers for new topics, so that they find their listeners before the score begins."""
        for part in _here(score).values():
            if part.topic not in self._topics:
                self._advertise_new(part, at_once=True)
                self._unprepared.add(part.topic)
                self._standby.live()
                yield
            self._controllers.preload(part)

    def prepare(self, score: Score, restart: bool) -> None:
        """Create publishers for new topics. Existing ones are kept, because discovery can take seconds.

        With `restart`, stop the robots that have a reset service and call the service.
        """
        self._standby.renew()
        self._buttons.take(score.safety)
        parts = _here(score)
        self._elsewhere = score.parts.keys() - parts.keys()
        self._publisher.health.keep(parts.keys())
        if restart:
            self._publisher.health.zero = None  # performance time starts over
        is_urgent = score.world.keep_apart is not None or score.safety.sight
        self._reader.read(request_for(parts, PROMPT if is_urgent else USUAL))
        self._current = list(parts)
        self._controllers.take(parts, restart, score.tempo)
        self._time.simulate(any(part.use_sim_time for part in parts.values()))
        self._clock_listener.follow(score.clock is not None and score.clock.follow == "ros")
        for robot, part in parts.items():
            self._advertise_new(part, at_once=not restart)
            if restart and part.topic in self._unprepared:
                self._topics[part.topic].distrust()
            self._topics[part.topic].take(part.profile.message)
            self._robots[robot] = RosBase(
                part,
                self._topics[part.topic],
                is_simulated=part.profile == PUPPET,
                needs_base=needs_base(part),
                is_held=not self._standby.wanted and part.profile.needs_standby,
            )
            if not part.scenes:  # it only has to stop, because an earlier stage may have moved it
                self.pending_zeros.note_inherited(robot, self._topics[part.topic], part.frame)
        self._unprepared.clear()
        if restart:
            self._standby.await_listeners()
            reset = [(part.reset, robot, self._topics[part.topic]) for robot, part in parts.items() if part.reset]
            self.ready([BaseCommand(robot, STILL, 0.0) for _, robot, _ in reset])()
            self._resets.begin(reset)

    def guard(self, topics: Collection[str]) -> None:
        """Listen for the release of these emergency stops, which are on, even if no score names them."""
        self._buttons.guard(topics)

    def resetting(self, homing: Collection[str] = ()) -> bool:
        topics = {self._robots[robot].topic.name for robot in self._current} | self._controllers.topics(self._current)
        # Each call makes progress, so none may be skipped.
        waits = [
            self._resets.under_way(),
            self._buttons.under_way(),
            self._standby.under_way(topics),
            self._reader.under_way(partial(is_published, self._node)),
        ]
        if any(waits) and (line := self._reader.slowness()):
            self._tell(line)
        joints_wait = self._controllers.waits()
        self._controllers.home_joints(() if any(waits) else self._ours(homing))
        return joints_wait or any(waits)

    def posed(self) -> Collection[str]:
        return self._reader.posed

    def ask(self, robots: Collection[str]) -> None:
        robots = self._ours(robots)
        for known in map(self._robots.__getitem__, robots):
            known.topic.ask(ZERO, self._clock, known.part.frame)
        self._controllers.ask(robots)

    def missing(self, robots: Collection[str] | None = None) -> dict[str, str]:
        found = {}
        asked = self._ours(robots)
        for robot in asked:
            known = self._robots[robot]
            topic = known.topic
            problem = topic.missing(known.moves_since is not None) if known.needs_base else None
            if problem is None:
                problem = self._controllers.missing(robot)
            if known.is_held and known.needs_base:
                found[robot] = (
                    f"{robot} never stops by itself, and no standby could stop it: "
                    "turn on `ros.standby`, or set `accept_no_stop = true` in its profile"
                )
            elif problem is not None:
                found[robot] = problem and f"{problem} ({self.description})"
            elif topic.is_stamped and self._clock.ros_time_is_active and not self._clock.now().nanoseconds:
                found[robot] = (
                    f"no time has arrived on /clock, so messages on {topic.name} are stamped 0: start the simulation"
                )
        self._publisher.health.asked(asked, found)
        return found

    def warnings(self, robots: Collection[str] | None = None) -> dict[str, str]:
        asked = self._ours(robots)
        found = {robot: line for robot, line in self._resets.warnings().items() if robot in asked}
        if self._standby.problem:
            found[self._standby.problem] = self._standby.problem
        found |= self._buttons.warnings()
        for problem in (self._reader.problem, self._publisher.problem):
            if problem:
                found[problem] = problem
        clocked = not self._clock.ros_time_is_active and is_published(self._node, CLOCK)
        for robot in asked:
            known = self._robots[robot]
            topic = known.topic
            self._other_publishers.pop(robot, None)
            if known.is_simulated:
                found[robot] = (
                    f"{robot} is a puppet, which only the simulator has: "
                    "to move a real robot, give it the profile of one in improv.toml"
                )
            elif others := self._others(topic):
                self._other_publishers[robot] = others
                found[robot] = (
                    f"other nodes also publish to {topic.name}: {', '.join(others)}; "
                    "robots obey all of them: stop the others or use twist_mux"
                )
            elif clocked and topic.is_stamped:
                found.setdefault(
                    robot,
                    f"messages on {topic.name} carry this machine's time, but a node publishes /clock: "
                    "if the robot is simulated, set `use_sim_time = true` under [ros] in improv.toml",
                )
            elif line := self._controllers.warning(robot, self._others):
                found[robot] = line
            elif silent := silence(known.part, known.moves_since, self._reader, self._node):
                found.setdefault(robot, silent)
        return found

    def other_publishers(self) -> Mapping[str, Collection[str]]:
        return self._other_publishers

    def ready(self, commands: Sequence[BaseCommand]) -> Callable[[], None]:
        """Serialize commands. Raises ValueError if a number isn't finite. The function that publishes them raises what
        rclpy raises. The stage then stops all robots."""
        ours = [(command, self._robots[command.robot]) for command in commands if command.robot not in self._elsewhere]
        ready = [base.serialized(command, self._clock) for command, base in ours if not base.is_simulated]

        def send() -> None:
            for _, base, stands, _ in ready:
                if not stands and self._standby.moving.get(base.topic.name) != base.part.frame:
                    self.pending_zeros.note_velocity(base.topic, base.part.frame)
            problems = publish_all(ready)
            now = self._now()
            for (robot, _, at), base, stands, _ in ready:
                base.moves_since = None if stands else base.moves_since or now
                if robot in problems:
                    continue
                if stands:
                    self._controllers.halt(robot)
                    self.pending_zeros.note_zero(robot, base.topic, base.part.frame)
                self._publisher.health.sent(robot, at, now, base.is_clipped)
            for problem in problems.values():
                raise problem

        return send

    def sent_as(self, robot: str) -> SentAs:
        if robot not in self._robots:
            return {}
        topic = self._robots[robot].topic
        return {"topic": topic.seen_as, "stamped": topic.is_stamped} if topic.was_heard else {"topic": topic.seen_as}

    def send_joints(
        self, robot: str, joints: Mapping[str, JointMotion], at: float, pace: float = 1.0, until: float = math.inf
    ) -> None:
        """Publish now. Raises ValueError if a number isn't finite, and what rclpy raises; the stage then stops all
        robots."""
        if robot in self._elsewhere:
            return
        zero = self._publisher.health.zero
        late = 0.0 if zero is None else max(self._now() - zero - at, 0.0)
        self._controllers.send(robot, joints, at, pace, until, late)
        self._publisher.health.sent(robot, at, self._now(), False)

    def advance(self, to: float, asked: Collection[RobotSense] = ()) -> list[Edge]:
        """Send the standby a sign of life, and the publisher a report of how well commands reach robots."""
        self._standby.live()
        self._publisher.report()
        return []

    def noticed(self) -> Noticed:
        late, unfollowed = self._publisher.health.take_late(), self._controllers.unfollowed()
        frozen = self._time.is_frozen(self._now())
        return Noticed(self._reader.alive, late, self._reader.batteries, unfollowed, frozen)

    def close(self) -> None:
        self._standby.close()
        self._reader.close()
        self._publisher.close()
        time.sleep(LINGER)
        self._closing.set()
        self._executor.shutdown()
        self._receiving.join()
        self._nodes.close()

    def _receive(self) -> None:
        """Receive simulated time, service responses, requests, and buttons, on a thread of its own.

        If that fails, the stage ends: it would no longer receive an emergency stop or the release of a deadman button.
        """
        try:
            while not self._closing.wait(REST):
                self._executor.spin_once()
        except Exception as error:  # rclpy raises what its callbacks raise, such as for a negative time on /clock
            if not self._closing.is_set():
                self._hear(End(f"a message from ROS 2 can't be handled ({one_line(error)})"))

    def _advertise_new(self, part: Part, *, at_once: bool) -> None:
        if part.topic not in self._topics:
            message = part.profile.message
            self._topics[part.topic] = RosTopic(part.topic, message, self._node, self._advertise, self._now, at_once)

    def _advertise_for(self, channel: Channel) -> Advertise:
        """Return a function that makes publishers for a controller. The standby has none for controllers that come to
        rest by themselves."""
        if channel.interface == "velocity":
            return lambda kind, topic, second: self._advertise(kind, topic, second, len(channel.joints))
        return self._nodes.advertise

    def _advertise(self, kind: Any, topic: str, second: bool, joints: int = 0) -> tuple[Any, Callable[[], None]]:
        publisher, destroy = self._nodes.advertise(kind, topic, second)
        self._standby.publish(topic, kind.__name__, second, publisher.get_subscription_count, joints)

        def withdraw() -> None:
            destroy()
            self._standby.withdraw(topic, kind.__name__)

        return publisher, withdraw

    def _others(self, topic: RosTopic, guarded: bool = True) -> list[str]:
        """The other nodes that send something on a topic. The standby publishes on `guarded` topics."""
        standby = guarded and self._standby.works
        return [name for name in topic.others(self._nodes.names, standby) if not is_harmless(name)]

    def _ours(self, robots: Collection[str] | None) -> Collection[str]:
        """The robots of these that this stage moves; if None, those of the latest `prepare`."""
        return self._current if robots is None else [robot for robot in robots if robot not in self._elsewhere]


def _here(score: Score) -> dict[str, Part]:
    """The parts of the robots that this stage moves."""
    return {robot: part for robot, part in score.parts.items() if not part.elsewhere}
