"""The contract of an output for robots that Improv reaches directly: a subclass of `Device` (docs/outputs.md).

Improv makes one device for each robot and calls it from one thread of its own, so its methods may wait: `connect` for
some seconds, the others for a tenth of one. Improv takes care of timing, limits, calibration, stops, late commands,
retries, and approval.
"""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType
from typing import NamedTuple, Protocol

from improv_core.score.installed import Setting, Value
from improv_core.score.motion import Pose, Twist


class DeviceRobot(NamedTuple):
    """The robot that a device moves: its name in programs, its `address` and its `node` there from `improv.toml` (None:
    not given), its color on the page: red, green, and blue, each from 0 to 1, and its settings, with the defaults of
    those that the file doesn't have."""

    name: str
    address: str
    node: int | None
    color: tuple[float, float, float]
    settings: Mapping[str, Value] = MappingProxyType({})


class Readings(Protocol):
    """The sensors of a robot report to this, on any thread."""

    def sense(self, name: str, value: bool | float) -> None:
        """Report a reading: `near` and `bump` are those senses; other names are topics of `[senses.NAME]`."""

    def pose(self, pose: Pose) -> None:
        """Report where the robot is by its odometry, in meters and radians from where it was when it connected."""


class ReportMotion(Protocol):
    """Takes a velocity, and its time in seconds on the robot's clock, if there is one: a simulator's may be slow."""

    def __call__(self, twist: Twist, at: float | None = None) -> None: ...


class Device:
    """One robot. Its methods raise OSError with one line for people if they fail; Improv then closes the device, and
    makes another one a second later."""

    settings: Mapping[str, Setting] = MappingProxyType({})
    """The keys that people may set in `[robots.NAME.settings]`. Editors complete them; only valid values come here."""
    stops_after: float = 0.0
    """Seconds after its last command in which the robot stops by itself, whatever happens to Improv; 0 if it never
    does. Improv moves such a robot only if its profile says `accept_no_stop`."""

    def __init__(self, robot: DeviceRobot, readings: Readings) -> None:
        self.robot = robot
        self.readings = readings

    def connect(self) -> None:
        """Reach the robot, and make sure that it will stop by itself as promised. Called once, first."""
        raise NotImplementedError

    def drive(self, twist: Twist) -> None:
        """Set the velocity, in m/s and rad/s; STILL stops the robot. While it moves, this comes again at the
        `command_rate` of its profile."""
        raise NotImplementedError

    def stands(self) -> bool:
        """Return whether the robot has confirmed the latest STILL. By default, to send it is enough."""
        return True

    def watch(self, report: ReportMotion) -> None:
        """Connect beside another process that drives the robot, and report each velocity at which its motors are set,
        on any thread: `improv output check` needs eyes of its own. It asks a person if this raises OSError."""
        raise OSError(f"nothing sees {self.robot.name} move")

    def check(self) -> None:
        """Raise OSError if the robot can no longer be reached. Called at least ten times a second."""

    def close(self) -> None:
        """Release what `connect` took, also if that failed."""
