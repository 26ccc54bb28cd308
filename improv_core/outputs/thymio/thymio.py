"""Drives a Thymio II, which keeps its last motor targets by itself: only the program on it (`program`) stops it when
commands end. So no robot moves before that program has reported."""

from __future__ import annotations

import math
import threading
import time
from collections.abc import Sequence

from improv_core.outputs.devices.device import Device, DeviceRobot, Readings, ReportMotion
from improv_core.outputs.thymio.bus import Bus
from improv_core.outputs.thymio.program import FED, MOTOR_PERIOD, PERIOD, program
from improv_core.score.motion import STILL, Pose, Twist

UNITS = 500 / 0.166
"""Motor units for each meter per second: 500 are 16.6 cm/s in Enki (enki/robots/thymio2/Thymio2.cpp). A ROS driver of
its makers has 2,930 (thymio_navigation_driver, SPEED_COEF)."""
WHEELS = 0.094
"""Meters between its wheels (Enki, as above; the driver has 95 mm)."""
MAX_WHEEL_SPEED = 500
"""The highest motor target."""
SILENT = 2.0
"""Seconds without a report after which the robot counts as lost. It reports ten times a second."""
MAX_LOOKS = int(0.5 / (PERIOD / 1000))
"""The most checks of the program between reports of the wheels: after more, 16 bits are too few for the distance."""
START_LIMIT = 10.0
"""Seconds within which the program begins to report."""
FRONT = ("prox_0", "prox_1", "prox_2", "prox_3", "prox_4")
NAMES = (
    *FRONT,
    *("prox_5", "prox_6", "ground_left", "ground_right"),
    *("button_backward", "button_left", "button_center", "button_forward", "button_right"),
)
"""The names of its readings, in the order of the program's report."""


class Thymio(Device):
    """A Thymio II at `serial:PORT` or `tcp:HOST:PORT`."""

    stops_after = 0.5

    def __init__(self, robot: DeviceRobot, readings: Readings) -> None:
        super().__init__(robot, readings)
        self._bus: Bus | None = None
        self._number = -1
        self._fed = self._targets = 0  # the addresses of these variables
        self._reported = threading.Event()
        self._heard = -math.inf
        self._before: Sequence[int] | None = None  # the report before
        self._zeroed = 0.0  # when it was sent zeros
        self._stood = -math.inf  # when it last reported zeros
        self._pose = Pose()

    def connect(self) -> None:
        self._bus = bus = Bus.join(self.robot.address)
        self._number = bus.find(self.robot.name, self.robot.node)
        bus.listen(self._number, self._report)
        memory = bus.describe(self._number)
        if memory.lacks:
            raise OSError(f"its firmware is too old, it has no `{memory.lacks}`: update it with Thymio Suite")
        self._fed, self._targets = memory.fed, memory.variables["motor.left.target"]
        bus.set(self._number, (self._targets, (0, 0)))
        bus.run(self._number, program(memory, self.robot.color))
        if not self._reported.wait(START_LIMIT):
            bus.check()
            raise OSError("it doesn't run the program that stops its motors: switch it off and on")

    def drive(self, twist: Twist) -> None:
        assert self._bus
        left, right = targets(twist)
        moves = twist != STILL
        self._bus.set(self._number, (self._fed, (FED if moves else 0,)), (self._targets, (left, right)))
        if not moves:
            self._zeroed = time.monotonic()

    def stands(self) -> bool:
        return self._stood > self._zeroed

    def watch(self, report: ReportMotion) -> None:
        self._bus = bus = Bus.join(self.robot.address)
        self._number = bus.find(self.robot.name, self.robot.node)
        looks = 0

        def see(words: Sequence[int]) -> None:
            nonlocal looks
            looks += (words[0] - looks) % 65_536  # it counts in 16 bits
            report(rolling(words[4], words[5]), looks * PERIOD / 1000)

        bus.listen(self._number, see)

    def check(self) -> None:
        if self._bus:
            self._bus.check()
        if time.monotonic() > self._heard + SILENT:
            raise OSError(f"it has sent nothing for {SILENT:g} s: is it switched on, and near?")

    def close(self) -> None:
        if self._bus:
            self._bus.forget(self._number, self._report)
            self._bus.leave()
            self._bus = None

    def _report(self, words: Sequence[int]) -> None:
        """Take what the program reports, on the thread of the bus."""
        before, self._before = self._before or words, words
        left_target, right_target, *read = words[4:]
        if len(read) != len(NAMES):
            return
        self._heard = now = time.monotonic()
        self._pose = advanced(self._pose, before, words)
        self.readings.pose(self._pose)
        if left_target == right_target == 0:
            self._stood = now
        for name, value in zip(NAMES, read, strict=True):
            self.readings.sense(name, bool(value) if name.startswith("button") else float(value))
        self.readings.sense("near", any(read[: len(FRONT)]))
        self.readings.sense("bump", words[1] != before[1])
        self._reported.set()


def targets(twist: Twist) -> tuple[int, int]:
    """Return the motor targets, left and right, for a velocity; of one that is too fast, in the same proportion."""
    wheels = [UNITS * (twist.x + side * twist.yaw * WHEELS / 2) for side in (-1, 1)]
    scale = min(MAX_WHEEL_SPEED / max(*map(abs, wheels), MAX_WHEEL_SPEED), 1.0)
    left, right = (round(wheel * scale) for wheel in wheels)
    return left, right


def rolling(left: int, right: int) -> Twist:
    """Return the velocity of a robot whose wheels have these speeds, in motor units."""
    return Twist((left + right) / 2 / UNITS, yaw=(right - left) / WHEELS / UNITS)


def advanced(pose: Pose, before: Sequence[int], now: Sequence[int]) -> Pose:
    """Return the pose of a robot that was at this one, by its report then and the next one."""
    if (now[0] - before[0]) % 65_536 > MAX_LOOKS:
        return pose
    left, right = ((now[wheel] - before[wheel] + 32_768) % 65_536 - 32_768 for wheel in (2, 3))
    return pose.after(rolling(left, right), MOTOR_PERIOD)
