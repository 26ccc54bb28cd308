"""Moves robots through their devices: each has a thread that connects it, drives it, and connects it again.

A command waits nowhere: a thread that is late takes only the latest one, and drops it once it is too old.
"""

from __future__ import annotations

import math
import threading
import time
from collections.abc import Callable, Collection, Iterator
from contextlib import suppress

from improv_core.outputs.devices.device import Device, DeviceRobot
from improv_core.plain import one_line
from improv_core.protocol.output import Edge, RawPose, RawPoses, Sink
from improv_core.safety.allowed import HostError, is_approved, refusal
from improv_core.safety.pending_zeros import PERIOD, PendingZero, TopicFacts, check, pending_zero
from improv_core.score.motion import STILL, Pose, Twist
from improv_core.score.score import DeviceAddress, Part, Score
from improv_core.score.senses import ODOMETRY, BuiltIn, RobotSense, Topic

LOOK = 0.05
"""Seconds between two checks of a device that gets no commands."""
LATE = 0.25
"""Seconds after which a velocity is too old to be driven."""
AGAIN = 1.0
"""Seconds before a device that failed is made again."""
UNCONFIRMED = 1.0
"""Seconds after which a line names a robot that has not confirmed its zero."""
END = 1.5
"""Seconds that all devices together may take to be closed."""
_PALETTE = (
    "c04f00 0072b2 007a57 a83f82 593326 591a99 0d4066 8059d9 99331a 800059 0d40b2 806640 265900 664c66 806699 594ca6"
)
COLORS = tuple(
    (int(color[:2], 16) / 255, int(color[2:4], 16) / 255, int(color[4:], 16) / 255) for color in _PALETTE.split()
)
"""The colors of robots on a light page, in the order of a score (page/static/page.css)."""


class DeviceSink(Sink):
    """A sink whose robots are devices of one class. `hear` is called on any thread; `warn` gets lines for people."""

    real = True

    def __init__(
        self,
        name: str,
        kind: type[Device],
        hear: Callable[[Edge | RawPoses], None],
        warn: Callable[[str], None],
        now: Callable[[], float] = time.monotonic,
    ) -> None:
        self.name = name
        self._kind = kind
        self._hear = hear
        self._warn = warn
        self._now = now
        self._links: dict[str, DeviceLink] = {}
        self._current: list[str] = []
        self._pending: dict[str, PendingZero] = {}
        self._named: set[str] = set()  # robots that a line has named, because their zeros are unconfirmed
        self.pending_zeros = self

    def preload(self, score: Score) -> Iterator[None]:
        return self._meet(score)

    def prepare(self, score: Score, restart: bool) -> None:
        for _ in self._meet(score):
            pass
        self._current = [name for name, part in score.parts.items() if not part.elsewhere]
        for name in self._current:
            part, link = score.parts[name], self._links[name]
            link.take(part)
            if not part.scenes:  # an earlier stage may have moved it
                self._await_stop(name)

    def _meet(self, score: Score) -> Iterator[None]:
        for index, (name, part) in enumerate(score.parts.items()):
            if part.elsewhere:
                continue
            before, color = self._links.get(name), COLORS[index % len(COLORS)]
            assert part.device, name
            robot = robot_for(name, part.device, self._kind, color)
            if before and before.robot._replace(color=color) == robot:
                continue
            if before:
                before.command(STILL, self._now())
                before.end()
            self._links[name] = DeviceLink(robot, self._kind, self._hear, self._now, before)
            yield

    def missing(self, robots: Collection[str] | None = None) -> dict[str, str]:
        found = {}
        for name in self._ours(robots):
            link = self._links[name]
            if link.problem is not None:
                found[name] = link.problem and f"{name}: {link.problem}"
            elif self._is_held(link):
                found[name] = f"{name} never stops by itself: set `accept_no_stop = true` in its profile to move it"
        return found

    def warnings(self, robots: Collection[str] | None = None) -> dict[str, str]:
        lines = {name: self._links[name].unread() for name in self._ours(robots)}
        return {name: f"{name} has no `{unread}`" for name, unread in lines.items() if unread}

    def send(self, robot: str, twist: Twist, at: float) -> None:
        """Hand the velocity to the robot's thread. Raises ValueError if a number isn't finite."""
        if robot not in self._current:
            return
        if not all(map(math.isfinite, (twist.x, twist.y, twist.z, twist.yaw))):
            raise ValueError(f"{robot} was given a speed that is not a finite number")
        link, now = self._links[robot], self._now()
        stands = twist == STILL or self._is_held(link)
        moved = link.command(STILL if stands else link.part.profile.command_for(twist), now)
        if not stands:
            self._pending.pop(robot, None)
        elif moved:
            self._await_stop(robot)

    @property
    def due(self) -> float:
        """The time at which `retry` is due, in monotonic seconds."""
        return min((each.due for each in self._pending.values()), default=math.inf)

    def retry(self, now: float) -> None:
        """Send zeros again to robots that have not confirmed one. A robot that is gone has stopped by itself."""
        for name, pending in [*self._pending.items()]:
            if pending.due > now:
                continue
            link = self._links[name]
            found = check(pending, now, TopicFacts(int(link.problem is None), confirmed=link.stands()))
            if found.sends:
                link.command(STILL, now)
            stopped = link.problem is not None and 0 < self._kind.stops_after < now - pending.since - PERIOD
            if stopped or not found.pending:
                del self._pending[name]
                continue
            self._pending[name] = found.pending
            if now > pending.since + UNCONFIRMED and name not in self._named:
                self._named.add(name)
                self._warn(f"{name} may still be moving: it has not confirmed the stop; look at the robot")

    def close(self) -> None:
        for link in self._links.values():
            link.end()
        end = time.monotonic() + END
        for link in self._links.values():
            link.wait(max(end - time.monotonic(), 0.0))

    def _ours(self, robots: Collection[str] | None) -> list[str]:
        return self._current if robots is None else [name for name in robots if name in self._current]

    def _await_stop(self, robot: str) -> None:
        self._pending[robot] = pending_zero(self._now(), 1, listened=True)
        self._named.discard(robot)

    def _is_held(self, link: DeviceLink) -> bool:
        return not self._kind.stops_after and not link.part.profile.accept_no_stop


def robot_for(name: str, at: DeviceAddress, kind: type[Device], color: tuple[float, float, float]) -> DeviceRobot:
    defaults = {each: setting.default for each, setting in kind.settings.items()}
    return DeviceRobot(name, at.address, at.node, color, {**defaults, **at.settings})


class DeviceLink:
    """A robot's device and its thread. `problem` is why it can't be driven, empty at first, None once it can be."""

    def __init__(
        self,
        robot: DeviceRobot,
        kind: type[Device],
        hear: Callable[[Edge | RawPoses], None],
        now: Callable[[], float],
        before: DeviceLink | None = None,
    ) -> None:
        self.robot = robot
        self._before = before  # it may drive the same robot until it has ended
        self.part: Part
        self.problem: str | None = ""
        self._kind = kind
        self._hear = hear
        self._now = now
        self._changed = threading.Condition()
        self._wanted: tuple[Twist, float] | None = None  # the latest velocity, and its time
        self._moves = False  # the latest velocity that it was given is none
        self._device: Device | None = None
        self._connected = math.inf
        self._closing = False
        self._reads: dict[str, list[tuple[RobotSense, Topic | None]]] = {}  # the senses that each reading decides
        self._readings: dict[str, bool | float] = {}
        self._values: dict[RobotSense, bool | None] = {}
        self._odom: str | None = None
        self._thread = threading.Thread(target=self._run, daemon=True)
        self._thread.start()

    def take(self, part: Part) -> None:
        """Take the part of a new score, and report the senses that it reads."""
        reads: dict[str, list[tuple[RobotSense, Topic | None]]] = {}
        for name, source in part.senses.items():
            if isinstance(source, Topic):
                reading = source.topic.removeprefix(f"{part.namespace}/")
                reads.setdefault(reading, []).append((RobotSense(part.robot, name), source))
            elif isinstance(source, BuiltIn):
                reads.setdefault(source.built_in, []).append((RobotSense(part.robot, name), None))
        reads.pop("cue", None)
        with self._changed:
            self.part, self._odom, self._reads, self._values = part, part.odom, reads, {}
            for name, value in self._readings.items():
                self._report(name, value)

    def command(self, twist: Twist, now: float) -> bool:
        """Have it drive like this. Returns whether it may have moved before."""
        with self._changed:
            moved, self._moves = self._moves, twist != STILL
            if self.problem is None or twist == STILL:
                self._wanted = twist, now
                self._changed.notify_all()
            return moved

    def stands(self) -> bool:
        """Return whether the robot has confirmed that it stands."""
        with self._changed:
            device, waits = self._device, self._wanted is not None
        return device is not None and not waits and device.stands()

    def unread(self) -> str | None:
        """Return the name of a reading that a sense needs and that has not come for a while."""
        if self._now() < self._connected + AGAIN:
            return None
        return next((name for name in self._reads if name not in self._readings), None)

    def sense(self, name: str, value: bool | float) -> None:
        with self._changed:
            self._readings[name] = value
            self._report(name, value)

    def pose(self, pose: Pose) -> None:
        if self._odom:
            self._hear(RawPoses([RawPose(self.robot.name, ODOMETRY, pose, self._now(), topic=self._odom)]))

    def end(self) -> None:
        """Have its thread drive what waits, and end."""
        with self._changed:
            self._closing = True
            self._changed.notify_all()

    def wait(self, limit: float) -> None:
        """Wait until its thread has ended, for some seconds at most."""
        self._thread.join(limit)

    def _report(self, name: str, value: bool | float | None) -> None:
        for what, topic in self._reads.get(name, ()):
            holds = None if value is None else topic.compare(value) if topic and type(value) is float else bool(value)
            if self._values.get(what) is not holds:
                self._values[what] = holds
                self._hear(Edge(what, holds, self._now()))

    def _run(self) -> None:
        if self._before:
            self._before.wait(END)
            self._before = None
        while not self._closing:
            device = None
            try:
                if not is_approved(self.robot.address):
                    raise HostError(refusal(self.robot.address))
                device = self._kind(self.robot, self)
                device.connect()
                device.drive(STILL)
                self._begin(device)
                while self._serve(device):
                    pass
            except (OSError, HostError) as error:
                self.problem = one_line(error)
            except Exception as error:  # an error in an output stops only this robot
                self.problem = f"the output failed: {type(error).__name__}: {one_line(error)}"
            self._lose(device)
            with self._changed:
                self._changed.wait_for(lambda: self._closing, AGAIN)

    def _begin(self, device: Device) -> None:
        with self._changed:
            self._device, self._connected = device, self._now()
            if self._wanted and self._wanted[0] != STILL:
                self._wanted = None
            self.problem = None

    def _serve(self, device: Device) -> bool:
        """Drive the latest velocity, or look after the device. Returns whether to continue."""
        with self._changed:
            if self._wanted is None and not self._closing:
                self._changed.wait(LOOK)
            wanted, closing = self._wanted, self._closing
        if wanted:
            twist, since = wanted
            if twist == STILL or self._now() <= since + LATE:
                device.drive(twist)
            with self._changed:
                if self._wanted is wanted:
                    self._wanted = None
        elif closing:
            return False
        device.check()
        return True

    def _lose(self, device: Device | None) -> None:
        with self._changed:
            self._device, self._wanted = None, None
            self._readings = {}
            for name in self._reads:
                self._report(name, None)
        if device:
            with suppress(Exception):
                device.close()
