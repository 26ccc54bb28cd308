"""A simulation's time on a real /clock, from its messages to the velocities of a robot in it."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from pathlib import Path

import pytest

from tests.ros.conftest import STAMPED, Fields, Listener, Others
from tests.ros.dance import Terminal

pytestmark = pytest.mark.slow("processes of ROS find each other, and a simulation runs for some seconds")

ROBOTS = """
[clock]
follow = "ros"
[robots.ada]
message = "TwistStamped"
"""
DANCE = "beat 120\nada $ repeat (forward left)\n"
"""A program whose beats take half a second of the simulation's time each."""


class Simulation:
    """A simulation whose time advances so many seconds a second, on /clock a hundred times a second."""

    def __init__(self, others: Others) -> None:
        self._others = others
        self._number = others.make("simulation", lambda what: None, name="simulation", domain=None)

    def run(self, rate: float) -> None:
        self._others.tell(self._number, "rate", rate=rate)

    def close(self) -> None:
        self._others.end(self._number)


@pytest.fixture
def simulation(others: Others) -> Iterator[Simulation]:
    simulation = Simulation(others)
    yield simulation
    simulation.close()


def beats(robot: Listener, count: int) -> list[Fields]:
    """Return the first message of each of the next beats."""
    found: list[Fields] = []
    kind = ""
    while len(found) < count:
        message = robot.wait(lambda each: bool(each["x"] or each["yaw"]))
        if kind != (kind := "x" if message["x"] else "yaw"):
            found.append(message)
    return found


def lasted(beats: list[Fields], clock: str) -> float:
    """Return the seconds from the first to the last of them. Any of them may be late on a busy machine."""
    return float(beats[-1][clock] - beats[0][clock])


def test_a_dance_follows_the_time_of_a_simulation(
    ros_env: Mapping[str, str], others: Others, simulation: Simulation, tmp_path: Path
) -> None:
    (tmp_path / "improv.toml").write_text(ROBOTS)
    robot = Listener(others, "/ada/cmd_vel", type=STAMPED)
    with Terminal("play", tmp_path / "dance.improv", ros_env, DANCE) as dance:
        dance.wait_for_line("paused until /clock goes on")
        simulation.run(0.5)
        _, _, *slow = beats(robot, 8)
        assert lasted(slow, "at") > 4
        assert {round(each["x"] + each["yaw"], 3) for each in slow} == {4.0, 3.142}, "as at full speed"
        assert lasted(slow, "stamp") == pytest.approx(2.5, abs=0.5)
        simulation.run(0)
        robot.wait(lambda each: not (each["x"] or each["yaw"]))
        dance.wait_for_line("paused until /clock goes on")
        simulation.run(1)
        _, _, *fast = beats(robot, 6)
        assert lasted(fast, "at") > 0.5
    robot.close()
