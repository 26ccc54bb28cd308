"""The simulator's model of a base, beside a base that is made of two wheels (tests/ros/base.py)."""

from __future__ import annotations

import math
from argparse import Namespace

import pytest

from improv_core.commands.rehearsal import perform
from improv_core.outputs.simulator.simulator import Simulator
from improv_core.program.analysis import analyze
from improv_core.program.compiler import score_of
from improv_core.robots.config import read_robots
from improv_core.score.motion import Twist
from tests.ros.base import Base, Planar

SQUARE = "beat 60\nanna $ repeat 4 (forward slow 2 left)\n"
SECONDS = 12.0
REST = 1.0


class Beside(Simulator):
    """A simulator with a base beside it, which gets the same commands."""

    def __init__(self, base: Base) -> None:
        super().__init__(period=None)
        self.base = base

    def send(self, robot: str, twist: Twist, at: float) -> None:
        super().send(robot, twist, at)
        self.base.command(twist.x, twist.yaw, at)


@pytest.mark.parametrize(
    ("wheels", "noise", "loss", "near", "nearly", "drifts"),
    [((1.0, 1.0), 0.0, 0.0, 0.001, 0.2, False), ((0.96, 0.94), 0.01, 0.05, 0.02, 2.0, True)],
    ids=["exact", "worn"],
)
def test_a_square(
    wheels: tuple[float, float], noise: float, loss: float, near: float, nearly: float, drifts: bool
) -> None:
    """`near` is in meters, `nearly` in degrees. Its encoders can't see its wheels: it believes that it is exact."""
    drift = f'dynamics = "motors"\nwheel_error = {[*wheels]}\n'
    robots = read_robots(f'[profiles.base]\nbase = "turtlebot4"\n{drift}[robots.anna]\nprofile = "base"\n')
    assert robots.ok
    options = Namespace(wheel_error=wheels, noise=noise, loss=loss, seed=1, start=(0.0, 0.0, 0.0))
    beside = Beside(Base(options, 0.0))
    perform(score_of(analyze(SQUARE, robots)), beside)
    base, expected = beside.base, beside.poses()["anna"]
    base.advance(SECONDS + REST)
    off, turned = apart(base.true, Planar(expected.x, expected.y, expected.heading))
    assert off < near
    assert turned < nearly
    off, turned = apart(base.true, base.counted)
    assert (off > 0.03 and turned > 10) == drifts
    assert drifts or (off, turned) == pytest.approx((0, 0))


def apart(one: Planar, other: Planar) -> tuple[float, float]:
    """Meters and degrees."""
    turn = math.remainder(one.heading - other.heading, math.tau)
    return math.dist((one.x, one.y), (other.x, other.y)), math.degrees(abs(turn))
