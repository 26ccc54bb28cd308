"""The stage's side of the process that reads sensors (see process.py)."""

from __future__ import annotations

import json
import math
import threading
from collections.abc import Callable, Mapping, Sequence, Set
from dataclasses import asdict
from typing import Any

from improv_core.ipc.child import Child, Policy
from improv_core.outputs.ros.joints.channels import joint_states_of
from improv_core.outputs.ros.nodes import is_published, unpublished
from improv_core.outputs.ros.sensors.process import PROMPT as URGENT
from improv_core.plain import message as in_plain_text
from improv_core.protocol.limits import helper_command
from improv_core.protocol.output import Edge, RawJoints, RawPose, RawPoses
from improv_core.protocol.reader_messages import FromReader, MeasuredPose, MeasuredPoses, Read
from improv_core.safety.fault_texts import in_one_phrase
from improv_core.score.motion import Pose
from improv_core.score.score import Part
from improv_core.score.senses import CUE, BuiltIn, RobotSense, Topic

START_LIMIT = 30.0
"""Seconds until a new process's first sign of life: 0.5 on a quiet machine, more than ten on one far too busy."""
SILENT_LIMIT = 0.3
"""Seconds without a sign of life after which nothing from the process counts anymore. It sends twenty a second."""
ALIVE_LIMIT = 1.0
"""Seconds without a sign of life after which the process counts as hung."""
SURE = 3
"""Signs of life after which its messages count again: by then, it has read everything that arrived while it stalled."""
FIND_LIMIT = 5.0
"""Seconds that beat 0 waits for silent senses and poses, from when they were added, or from when the process or another
one of them was heard first: a busy machine finds them late, but one after the other."""
POSES_LIMIT = 20.0
"""The same for poses that somebody publishes, and for the process itself."""
AGAIN = 1.0
"""Seconds before a failed process is replaced: one that fails at once must not keep the machine busy."""
WAIT = 0.1
"""Seconds per wait. The time without a sign of life is counted in these."""
POLICY = Policy(2.0, waits=False)
POSE_LIMIT = 1.0
"""Seconds that a robot may move before its first pose."""

USUAL, PROMPT = 0.05, 0.02
"""Seconds between checks for poses: usually, and while robots have to keep apart."""


def request_for(parts: Mapping[str, Part], period: float) -> Read:
    """Return the request to read what these parts need, with this many seconds between checks for poses."""
    return {
        "type": "read",
        "period": period,
        "senses": [
            {"robot": robot, "sense": sense, "source": asdict(source)}
            for robot, part in parts.items()
            for sense, source in part.senses.items()
            if isinstance(source, Topic)
        ],
        "odometry": {robot: part.odom for robot, part in parts.items() if part.odom},
        "bases": {robot: f"{part.namespace.strip('/')}/{part.frame}" for robot, part in parts.items() if part.odom},
        "batteries": {robot: part.battery for robot, part in parts.items() if part.battery},
        "joint_states": {robot: topic for robot, part in parts.items() if (topic := joint_states_of(part))},
    }


class RosReader:
    """Has another process read senses and poses, starts it when the first is needed, and passes on edges and poses on a
    thread of its own.

    `arguments` are ROS's own. If that process fails, all senses are silent until the next one receives something.
    """

    def __init__(
        self,
        node: str,
        arguments: Sequence[str],
        hear: Callable[[Edge | RawPoses | RawJoints], None],
        clock: Callable[[], float],
    ) -> None:
        self._node = node
        self._arguments = arguments
        self._hear = hear
        self._clock = clock
        self.problem: str | None = None
        """The problem with the process, in one line."""
        self.unread: dict[str, str] = {}
        """Topics that can't be read, with the reasons."""
        self._wanted = request_for({}, USUAL)
        self._asked = -math.inf  # when the latest sense was added
        self._found = -math.inf  # when something that was asked for was heard first
        self._told = -math.inf  # when the latest sense was added whose wait people know of
        self._reported: dict[RobotSense, bool | None] = {}  # the latest values from the process
        self._values: dict[RobotSense, bool | None] = {}  # the values that count
        self._missing_signs = 0  # the signs of life still missing until its messages count again
        self.alive = -math.inf
        """The time of the latest sign of life: everything that arrived before it has been read."""
        self.batteries: dict[str, float] = {}
        """The battery levels of robots, from 0 to 1."""
        self.joints: dict[str, Mapping[str, tuple[float, float]]] = {}
        """The positions of robots' joints, with their times of arrival."""
        self.posed: frozenset[str] = frozenset()
        """The robots whose first pose has arrived."""
        self._closing = threading.Event()
        self._thread = threading.Thread(target=self._run, daemon=True)

    def read(self, wanted: Read) -> None:
        """Read only this from now on."""
        before, self._wanted = self._wanted, wanted
        same = before["odometry"].items() & wanted["odometry"].items()
        if len(same) < len(wanted["odometry"]) or any(each not in before["senses"] for each in wanted["senses"]):
            self._asked = self._clock()
        self.posed &= {robot for robot, _ in same}
        kept = before["joint_states"].items() & wanted["joint_states"].items()
        self.joints = {robot: self.joints.get(robot, {}) for robot, _ in kept}
        self.batteries = {robot: share for robot, share in self.batteries.items() if robot in wanted["batteries"]}
        needed = wanted["senses"] or wanted["odometry"] or wanted["batteries"] or wanted["joint_states"]
        if needed and not self._thread.ident:
            self._thread.start()

    def under_way(self, is_published: Callable[[str], bool]) -> bool:
        """Return whether a recently added sense or pose is still missing, and may come soon."""
        waited = self._waited
        silent = any(self.is_silent(RobotSense(each["robot"], each["sense"])) for each in self._wanted["senses"])
        if waited >= POSES_LIMIT or not (self._unposed or silent):
            return False
        if waited < FIND_LIMIT or self.alive < self._asked:
            return True
        return any(is_published(self._wanted["odometry"][robot]) for robot in self._unposed)

    def slowness(self) -> str | None:
        """Return the line about poses for which beat 0 waits long, once."""
        if self._waited < FIND_LIMIT or self._told == self._asked or not self._unposed:
            return None
        self._told = self._asked
        return f"waiting for poses of {in_one_phrase(sorted(self._unposed))}"

    @property
    def _unposed(self) -> Set[str]:
        """The robots of which no pose has come."""
        return self._wanted["odometry"].keys() - self.posed

    @property
    def _waited(self) -> float:
        """The seconds since something was asked for, or found."""
        return self._clock() - max(self._asked, self._found)

    def lacks_poses(self, robot: str, since: float) -> bool:
        """Return whether a robot that has moved since a time has never sent a pose. Poses that stop later are a fault
        of the robot (safety/fault_rules.py)."""
        return robot in self._wanted["odometry"] and robot not in self.posed and self.alive > since + POSE_LIMIT

    def is_silent(self, sense: RobotSense) -> bool:
        return self._values.get(sense) is None

    def close(self) -> None:
        self._closing.set()
        if self._thread.ident:
            self._thread.join()

    def _run(self) -> None:
        """Keep one process running until the reader is closed."""
        while not self._closing.is_set():
            haste = URGENT if self._wanted["period"] == PROMPT else ""
            try:
                child = Child(
                    helper_command("outputs.ros.sensors.process", self._node, haste, *self._arguments), POLICY
                )
            except OSError as error:
                what = f"can't start: {error}"
            else:
                what = self._listen(child)
                if not self._closing.is_set():
                    child.kill()
                child.end()
            self._silence_all()
            self._reported, self._missing_signs = {}, 0
            self.problem = f"the process that reads sensors {what}: another one starts"
            self._closing.wait(AGAIN)

    def _listen(self, child: Child) -> str:
        """Pass on edges until the reader is closed or the process ends or hangs. Returns the reason, in words."""
        asked: object = None
        waited, limit = 0.0, START_LIMIT
        while not self._closing.is_set():
            if asked != (wanted := self._wanted):
                asked, self.unread = wanted, {}
                child.write(json.dumps(wanted).encode() + b"\n")
            try:
                lines = child.read(WAIT)
            except EOFError:
                return "has ended"
            if not lines:
                waited += WAIT  # not by a clock, so that a stall of the stage doesn't count against the process
                if waited >= SILENT_LIMIT and limit == ALIVE_LIMIT:
                    self._missing_signs = SURE
                    self._silence_all()
                if waited >= limit:
                    return f"was silent for {limit} s"
                continue
            waited, limit, self.problem = 0.0, ALIVE_LIMIT, None
            try:
                for line in lines:
                    self._take(json.loads(line))
            except (ValueError, LookupError, TypeError) as error:
                return f"sent an unreadable line ({type(error).__name__})"
        return "is not needed"

    def _take(self, message: FromReader) -> None:
        if message["type"] == "edge":
            sense = RobotSense(message["robot"], message["sense"])
            self._reported[sense] = message["value"]
            if not self._missing_signs:
                self._change(sense, message["value"], message["at"])
        elif message["type"] == "alive":
            now, before = self._clock(), self.alive
            self.alive, self._found = now, now if before < self._asked else self._found
            if self._missing_signs:
                self._missing_signs -= 1
                if not self._missing_signs:
                    for sense, value in self._reported.items():
                        self._change(sense, value, self.alive)
        elif message["type"] == "poses":
            self._measure(message)
        elif message["type"] == "batteries":
            self.batteries = {**self.batteries, **message["batteries"]}
        elif message["type"] == "joints":
            if message["robot"] in self._wanted["joint_states"]:
                new = {joint: (position, message["at"]) for joint, position in message["positions"].items()}
                self.joints = {**self.joints, message["robot"]: {**self.joints.get(message["robot"], {}), **new}}
                self._hear(RawJoints(message["robot"], message["positions"], message["at"]))
        elif message["type"] == "unread":
            self.unread[message["topic"]] = in_plain_text(" ".join(message["message"].split()))

    def _measure(self, message: MeasuredPoses) -> None:
        asked = [each for each in message["poses"] if self._wanted["odometry"].get(each["robot"]) == each["topic"]]
        if asked:  # others are from topics that counted until just now
            robots = {each["robot"] for each in asked}
            if not robots <= self.posed:
                self._found = self._clock()
            self.posed |= robots
            self._hear(RawPoses([_pose(each) for each in asked]))

    def _change(self, sense: RobotSense, value: bool | None, at: float) -> None:
        if self._values.get(sense) != value:
            if self._values.get(sense) is None:
                self._found = self._clock()
            self._values[sense] = value
            self._hear(Edge(sense, value, at))

    def _silence_all(self) -> None:
        now = self._clock()
        for sense in list(self._values):
            self._change(sense, None, now)


def _pose(each: MeasuredPose) -> RawPose:
    where = each["robot"], each["source"], Pose(**each["pose"]), each["at"]
    return RawPose(*where, each["frame"], each["stamp"], each["topic"])


def silence(part: Part, moves_since: float | None, reader: RosReader, node: Any) -> str | None:
    """Return one line about a sense of a robot that is silent, or about the unknown position of one that has moved
    since a time; None if everything arrives."""
    robot = part.robot
    for sense, source in part.senses.items():
        if isinstance(source, BuiltIn) and sense != CUE:
            return f"no topic provides `{sense}` for real robots: add [senses.{sense}] to improv.toml"
        if isinstance(source, Topic) and reader.is_silent(RobotSense(robot, sense)):
            problem = reader.unread.get(source.topic) or _unheard(source, node)
            return f"{problem}, so {robot} stands still where it reads `{sense}`"
    topic = part.odom
    if not topic or moves_since is None or not reader.lacks_poses(robot, moves_since):
        return None
    silent = "no poses arrive" if is_published(node, topic) else "nobody publishes"
    return f"{reader.unread.get(topic) or f'{silent} on {topic}'}: {robot}'s real position is unknown"


def _unheard(source: Topic, node: Any) -> str:
    kind = source.message.replace("/", "/msg/")
    return unpublished(node, source.topic, kind) or f"nothing usable comes on {source.topic}"
