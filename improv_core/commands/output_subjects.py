"""The robots that `improv output check` moves, and what sees them move: never the stage that is checked."""

from __future__ import annotations

import json
import math
import threading
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, closing, contextmanager
from dataclasses import dataclass, replace
from functools import partial

from improv_core.commands.exit_codes import CommandError
from improv_core.ipc.child import Child, Policy
from improv_core.outputs.devices.device import Device, ReportMotion
from improv_core.outputs.devices.opening import device_class
from improv_core.outputs.devices.sink import robot_for
from improv_core.program.analysis import analyze
from improv_core.program.compiler import score_of
from improv_core.protocol.limits import FOLDER
from improv_core.robots.config import Robots, read_robots
from improv_core.score.motion import Twist
from improv_core.score.profiles import Profile
from improv_core.score.score import DeviceAddress, Host, Score

ROBOT = "improv_check"
VIRTUAL = f'[robots.{ROBOT}]\nprofile = "check"\n[profiles.check]\nbase = "thymio2"\ndynamics = "motors"\n'
"""The robot for ROS 2 and the simulator: only we listen on its topic."""


@dataclass(frozen=True, slots=True)
class Subject:
    """A robot that is checked: the score that turns it slowly, and the one that asks for more than its limits.

    `host` is that of a device's stage; `watch` begins to see the robot, and raises OSError if nothing can."""

    output: str
    robot: str
    slow: Score
    fast: Score | None
    profile: Profile
    host: Host | None
    watch: Callable[[ReportMotion], AbstractContextManager[None]]

    @property
    def device(self) -> DeviceAddress | None:
        return self.slow.parts[self.robot].device

    @property
    def is_real(self) -> bool:
        return self.output != "simulator"

    def at(self, address: str) -> Score:
        """Return the slow score for the robot at another address."""
        part = self.slow.parts[self.robot]
        assert part.device
        return replace(self.slow, parts={self.robot: replace(part, device=replace(part.device, address=address))})


def subject_for(output: str, robot: str | None, robots: Robots) -> Subject:
    """Return what is to be checked of an output. Raises CommandError if no robot has it."""
    if output in ("ros", "simulator"):
        robots, found = read_robots(VIRTUAL), ROBOT
        watch = _watch_topic if output == "ros" else _watch_nothing
        return _subject(output, found, robots, None, watch)
    ours = [name for name, each in robots.robots.items() if each.host == Host(output, output=True)]
    if not ours or (robot and robot not in ours):
        raise CommandError(f'no robot{f" {robot}" if robot else ""} in improv.toml has `output = "{output}"`: add one')
    found = robot or ours[0]
    place = robots.robots[found].device
    assert place
    try:
        kind = device_class(output)
    except ImportError as error:
        raise CommandError(str(error)) from None
    device = kind(robot_for(found, place, kind, (0.0, 0.0, 0.0)), _Deaf())
    return _subject(output, found, robots, Host(output, output=True), partial(_watch_device, device))


def _subject(
    output: str,
    robot: str,
    robots: Robots,
    host: Host | None,
    watch: Callable[[ReportMotion], AbstractContextManager[None]],
) -> Subject:
    profile = robots.profile_of(robot)
    turns = "turn" in profile.motions and not profile.turning_radius
    slow = "slow 2 left" if turns else "slow 2 (forward 10cm backward 10cm)"
    times = math.ceil(1.5 * profile.max_angular / profile.quarter_turn) if turns and profile.max_angular else 0
    scores = [
        score_of(analyze(f"{robot} $ repeat {dance}", robots))
        for dance in (slow, f"fast {times} left" if times else slow)
    ]
    first, second = (replace(score, parts={robot: score.parts[robot]}) for score in scores)
    return Subject(output, robot, first, second if times else None, profile, host, watch)


@contextmanager
def _watch_nothing(report: ReportMotion) -> Iterator[None]:
    """Watch no robot: the simulator's stage itself reports how it moves."""
    yield


@contextmanager
def _watch_device(device: Device, report: ReportMotion) -> Iterator[None]:
    with closing(device):
        device.watch(report)
        yield


class _Deaf:
    """Takes no readings."""

    def sense(self, name: str, value: bool | float) -> None: ...

    def pose(self, pose: object) -> None: ...


@contextmanager
def _watch_topic(report: ReportMotion) -> Iterator[None]:
    from improv_core.outputs.ros.discovery import limited
    from improv_core.outputs.ros.setup.interpreter import find_ros_python

    found = find_ros_python(None)
    if not found:
        raise CommandError("no Python with rclpy was found: run `improv ros setup`")
    command = [found.python, str(FOLDER), "outputs.ros.graph", "twists", f"/{ROBOT}/cmd_vel"]
    child = Child(command, Policy(5.0), limited(found.env))
    threading.Thread(target=_read_twists, args=(child, report), daemon=True).start()
    try:
        yield
    finally:
        child.kill()


def _read_twists(child: Child, report: ReportMotion) -> None:
    try:
        while True:
            for velocity in map(json.loads, child.read()):
                if velocity:
                    report(Twist(*velocity))
    except EOFError:
        pass
