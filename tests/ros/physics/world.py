"""A floor with two-wheeled robots in MuJoCo."""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import mujoco

from tests.ros.physics.camera import Pose

STEP = 0.004
"""Seconds of one step of the physics."""
WHEEL, SEPARATION, RADIUS = 0.033, 0.160, 0.09
"""Meters: a wheel's radius, the distance of the wheels (both of a TurtleBot3 Burger), and the robot's radius."""
ACCELERATION = 2.5
"""m/s² of the rim of a wheel."""
TIMEOUT = 0.5
"""Seconds without a command after which a robot stops."""
GRIP = 0.7
"""The wheels' coefficient of friction."""
HELD = 0.15
"""Meters above the floor at which a lifted robot is held."""


BIAS = 0.03, 0.05
"""The shares by which the left and the right wheel of each robot roll less far than their encoders count."""


@dataclass(slots=True)
class Robot:
    """A robot's controller: it regulates the count of its encoders, which is more than its wheels really roll."""

    name: str
    body: int
    wanted: tuple[float, float] = (0.0, 0.0)
    heard: float = -math.inf
    told: deque[tuple[float, tuple[float, float]]] = field(default_factory=deque)  # velocities that it hasn't heard yet
    rims: list[float] = field(default_factory=lambda: [0.0, 0.0])  # the speeds that it regulates, in m/s
    held: tuple[float, ...] | None = None  # its pose while it is held


class World:
    """Robots that begin at their starts."""

    def __init__(self, starts: Mapping[str, Pose]) -> None:
        self._model = mujoco.MjModel.from_xml_string(_floor(starts))
        self._data = mujoco.MjData(self._model)
        self._robots = {name: Robot(name, self._model.body(name).id) for name in starts}
        self._addresses = {name: int(self._model.body(name).jntadr[0]) for name in starts}
        mujoco.mj_forward(self._model, self._data)

    def tell(self, name: str, linear: float, angular: float, at: float) -> None:
        """Give a robot a velocity at a time, in seconds."""
        self._robots[name].told.append((at, (linear, angular)))

    def step(self, now: float, lifted: Sequence[str], stuck: Sequence[str]) -> None:
        """Make one step, at a time in seconds."""
        for number, robot in enumerate(self._robots.values()):
            self._drive(robot, number, now, robot.name in stuck)
            self._hold(robot, robot.name in lifted)
        mujoco.mj_step(self._model, self._data)

    def poses(self) -> dict[str, Pose]:
        """Return the real poses of robots."""
        return {name: self._pose(robot) for name, robot in self._robots.items()}

    def _drive(self, robot: Robot, number: int, now: float, stuck: bool) -> None:
        while robot.told and robot.told[0][0] <= now:  # steps that the machine was late for come before it
            robot.heard, robot.wanted = robot.told.popleft()
        linear, angular = robot.wanted if now < robot.heard + TIMEOUT and not stuck else (0.0, 0.0)
        half = angular * SEPARATION / 2
        for side, wanted in enumerate((linear - half, linear + half)):
            most = math.inf if stuck else ACCELERATION * STEP
            robot.rims[side] += max(-most, min(most, wanted - robot.rims[side]))
            self._data.ctrl[2 * number + side] = robot.rims[side] / WHEEL * (1 - BIAS[side])

    def _hold(self, robot: Robot, held: bool) -> None:
        joint = self._addresses[robot.name]
        where, speed = int(self._model.jnt_qposadr[joint]), int(self._model.jnt_dofadr[joint])
        if held:
            robot.held = robot.held or tuple(self._data.qpos[where : where + 7])
            x, y, z, *turned = robot.held
            self._data.qpos[where : where + 7] = (x, y, z + HELD, *turned)
            self._data.qvel[speed : speed + 6] = 0
        elif robot.held:
            self._data.qpos[where : where + 7] = robot.held
            robot.held = None

    def _pose(self, robot: Robot) -> Pose:
        x, y, _ = self._data.xpos[robot.body]
        ahead = self._data.xmat[robot.body]
        return float(x), float(y), math.atan2(float(ahead[3]), float(ahead[0]))


def _floor(starts: Mapping[str, Pose]) -> str:
    bodies = "".join(_body(name, *start) for name, start in starts.items())
    motors = "".join(
        f'<velocity joint="{name}/{side}" kv="0.2" forcerange="-0.5 0.5"/>' for name in starts for side in SIDES
    )
    return f"""
<mujoco>
  <compiler angle="radian"/>
  <option timestep="{STEP}" integrator="implicitfast" cone="elliptic"/>
  <worldbody>
    <geom type="plane" size="50 50 0.1" friction="1 0.005 0.0001"/>
    {bodies}
  </worldbody>
  <actuator>{motors}</actuator>
</mujoco>"""


SIDES = {"left": 1, "right": -1}


def _body(name: str, x: float, y: float, heading: float) -> str:
    wheels = "".join(
        f'<body pos="0 {side * SEPARATION / 2} 0"><joint name="{name}/{which}" axis="0 1 0" damping="0.001"/>'
        f'<geom type="cylinder" size="{WHEEL} 0.009" euler="1.5707963 0 0" mass="0.05" priority="1"'
        f' friction="{GRIP} 0.005 0.0001"/></body>'
        for which, side in SIDES.items()
    )
    casters = "".join(
        f'<geom type="sphere" size="0.016" pos="{end * 0.06} 0 {0.0165 - WHEEL}" mass="0.02" priority="1" condim="1"/>'
        for end in (1, -1)
    )
    return (
        f'<body name="{name}" pos="{x} {y} {WHEEL}" euler="0 0 {heading}"><freejoint/>'
        f'<geom type="cylinder" size="{RADIUS} 0.03" pos="0 0 0.04" mass="1" condim="1"/>{casters}{wheels}</body>'
    )
