"""The stage's side of the process that reads sensors (see reader.py)."""

from __future__ import annotations

import json
import math
import threading
from collections.abc import Callable, Mapping
from dataclasses import asdict

from improv_core.ipc.child import Child, Policy
from improv_core.outputs.ros.sensors.process import PROMPT as URGENT
from improv_core.plain import message as in_plain_text
from improv_core.protocol.limits import helper
from improv_core.protocol.output import Edge, RawJoints, RawPose, RawPoses
from improv_core.protocol.reader_messages import FromReader, MeasuredPose, MeasuredPoses, SenseToRead, ToReader
from improv_core.score.motion import Pose
from improv_core.score.senses import RobotSense, Topic

START_LIMIT = 10.0
"""Seconds until a new process must show signs of life; on a quiet machine it takes half a second."""
SILENT_LIMIT = 0.3
"""Seconds without a sign of life after which nothing it has said counts anymore. There are twenty of them a second."""
ALIVE_LIMIT = 1.0
"""Seconds without a sign of life after which the process counts as hung."""
SURE = 3
"""Signs of life after which what it says counts again: by then, it has taken what came while it stalled."""
FIND_LIMIT = 5.0
"""Seconds that beat 0 waits for senses that are still silent, from when they were first asked for."""
AGAIN = 1.0
"""Seconds until a process that has failed is replaced: one that fails at once must not keep the machine busy."""
WAIT = 0.1
"""Seconds to wait at a time. Seconds without a sign of life are counted in these."""
POLICY = Policy(2.0, waits=False)
POSE_LIMIT = 1.0
"""Seconds for which a robot may move until its first pose."""

USUAL, PROMPT = 0.05, 0.02
"""Seconds between two looks for poses: usually, and while robots have to keep apart."""


class RosReader:
    """Has another process read senses and poses, starts it for the first of them, and passes on edges and poses on a
    thread of its own.

    If that process fails, all senses are silent until the next one hears something.
    """

    def __init__(
        self, node: str, hear: Callable[[Edge | RawPoses | RawJoints], None], clock: Callable[[], float]
    ) -> None:
        self._node = node
        self._hear = hear
        self._clock = clock
        self.problem: str | None = None
        """What is wrong with the process, in one line."""
        self.unread: dict[str, str] = {}
        """Topics that can't be read, and why."""
        self._sources: Mapping[RobotSense, Topic] = {}
        self._asked = -math.inf  # when the latest sense was asked for
        self._said: dict[RobotSense, bool | None] = {}  # by the process
        self._values: dict[RobotSense, bool | None] = {}  # that count
        self._doubts = 0  # how many signs of life are missing until what it says counts again
        self._odometry: Mapping[str, str] = {}
        self._batteries: Mapping[str, str] = {}
        self._joint_states: Mapping[str, str] = {}
        self._period = USUAL
        self.alive = -math.inf
        """When the process last showed signs of life: all that came by then has been heard."""
        self.batteries: dict[str, float] = {}
        """How full the batteries of robots are, from 0 to 1."""
        self.joints: dict[str, Mapping[str, tuple[float, float]]] = {}
        """Where the joints of robots are, and when that came."""
        self._posed: set[str] = set()  # robots of which a pose has come
        self._closing = threading.Event()
        self._thread = threading.Thread(target=self._run, daemon=True)

    def read(
        self,
        sources: Mapping[RobotSense, Topic],
        odometry: Mapping[str, str],
        batteries: Mapping[str, str],
        joint_states: Mapping[str, str],
        period: float = USUAL,
    ) -> None:
        """From now on, read these senses, and the poses, batteries, and joint states of these robots (robot: topic),
        and no others.

        `period` is the seconds between two looks for poses.
        """
        if sources.items() - self._sources.items() or odometry.items() - self._odometry.items():
            self._asked = self._clock()
        self._posed = {robot for robot in self._posed if self._odometry.get(robot) == odometry.get(robot)}
        self._sources, self._odometry, self._batteries = dict(sources), dict(odometry), dict(batteries)
        joints = {robot: self.joints.get(robot, {}) for robot in joint_states}
        self.joints = {
            robot: known for robot, known in joints.items() if self._joint_states.get(robot) == joint_states[robot]
        }
        self._joint_states = dict(joint_states)
        self._period = period
        self.batteries = {robot: share for robot, share in self.batteries.items() if robot in batteries}
        if (sources or odometry or batteries or joint_states) and not self._thread.ident:
            self._thread.start()

    def under_way(self) -> bool:
        """Whether a sense or a robot's pose that was asked for lately is still missing."""
        if self._clock() >= self._asked + FIND_LIMIT:
            return False
        return any(map(self.is_silent, self._sources)) or not self._odometry.keys() <= self._posed

    def lacks_poses(self, robot: str, since: float) -> bool:
        """Whether no pose of a robot has ever come, although it has been told to move since a time. Poses that no
        longer come are a fault of the robot (safety/fault_rules.py)."""
        return robot in self._odometry and robot not in self._posed and self.alive > since + POSE_LIMIT

    def is_silent(self, sense: RobotSense) -> bool:
        """Whether nothing is known of a sense."""
        return self._values.get(sense) is None

    def close(self) -> None:
        """End the process."""
        self._closing.set()
        if self._thread.ident:
            self._thread.join()

    def _run(self) -> None:
        """Keep a process that reads, until we are closed."""
        while not self._closing.is_set():
            try:
                child = Child(helper("reader", self._node, *([URGENT] if self._period == PROMPT else [])), POLICY)
            except OSError as error:
                what = f"can't start: {error}"
            else:
                what = self._listen(child)
                if not self._closing.is_set():
                    child.kill()
                child.end()
            self._fall_silent()
            self._said, self._doubts = {}, 0
            self.problem = f"the process that reads sensors {what}: another one starts"
            self._closing.wait(AGAIN)

    def _listen(self, child: Child) -> str:
        """Pass on edges until we are closed, or the process ends or hangs. Returns which, in words."""
        asked: object = None
        waited, limit = 0.0, START_LIMIT
        while not self._closing.is_set():
            if asked != (wanted := self._wanted):
                asked, self.unread = wanted, {}
                child.write(_request(*wanted))
            try:
                lines = child.read(WAIT)
            except EOFError:
                return "has ended"
            if not lines:
                waited += WAIT  # not by a clock, so that the process isn't blamed while we ourselves stall
                if waited >= SILENT_LIMIT and limit == ALIVE_LIMIT:
                    self._doubts = SURE
                    self._fall_silent()
                if waited >= limit:
                    return f"was silent for {limit} s"
                continue
            waited, limit, self.problem = 0.0, ALIVE_LIMIT, None
            try:
                for line in lines:
                    self._take(json.loads(line))
            except (ValueError, LookupError, TypeError) as error:
                return f"sent what can't be read ({type(error).__name__})"
        return "is not needed"

    @property
    def _wanted(self) -> _Wanted:
        return self._sources, self._odometry, self._batteries, self._joint_states, self._period

    def _take(self, message: FromReader) -> None:
        if message["type"] == "edge":
            sense = RobotSense(message["robot"], message["sense"])
            self._said[sense] = message["value"]
            if not self._doubts:
                self._turn(sense, message["value"], message["at"])
        elif message["type"] == "alive":
            self.alive = self._clock()
            if self._doubts:
                self._doubts -= 1
                if not self._doubts:
                    for sense, value in self._said.items():
                        self._turn(sense, value, self.alive)
        elif message["type"] == "poses":
            self._measure(message)
        elif message["type"] == "batteries":
            self.batteries = {**self.batteries, **message["batteries"]}
        elif message["type"] == "joints":
            if message["robot"] in self._joint_states:
                new = {joint: (position, message["at"]) for joint, position in message["positions"].items()}
                self.joints = {**self.joints, message["robot"]: {**self.joints.get(message["robot"], {}), **new}}
                self._hear(RawJoints(message["robot"], message["positions"], message["at"]))
        elif message["type"] == "unread":
            self.unread[message["topic"]] = in_plain_text(" ".join(message["message"].split()))

    def _measure(self, message: MeasuredPoses) -> None:
        asked = [each for each in message["poses"] if self._odometry.get(each["robot"]) == each["topic"]]
        if asked:  # others come from topics that counted until just now
            self._posed |= {each["robot"] for each in asked}
            self._hear(RawPoses([_pose(each) for each in asked]))

    def _turn(self, sense: RobotSense, value: bool | None, at: float) -> None:
        if self._values.get(sense) != value:
            self._values[sense] = value
            self._hear(Edge(sense, value, at))

    def _fall_silent(self) -> None:
        now = self._clock()
        for sense in list(self._values):
            self._turn(sense, None, now)


def _pose(each: MeasuredPose) -> RawPose:
    where = each["robot"], each["source"], Pose(**each["pose"]), each["at"]
    return RawPose(*where, each["frame"], each["stamp"], each["topic"])


_Wanted = tuple[Mapping[RobotSense, Topic], Mapping[str, str], Mapping[str, str], Mapping[str, str], float]


def _request(
    sources: Mapping[RobotSense, Topic],
    odometry: Mapping[str, str],
    batteries: Mapping[str, str],
    joint_states: Mapping[str, str],
    period: float,
) -> bytes:
    senses: list[SenseToRead] = [
        {"robot": robot, "sense": sense, "source": asdict(source)} for (robot, sense), source in sources.items()
    ]
    request: ToReader = {
        "type": "read",
        "period": period,
        "senses": senses,
        "odometry": odometry,
        "batteries": batteries,
        "joint_states": joint_states,
    }
    return json.dumps(request).encode() + b"\n"
