"""Distances of bases that drift from their ideal poses, calibrated or following or not, by their true poses."""

from __future__ import annotations

import math
import os
import re
import subprocess
import time
from collections.abc import Iterator, Mapping
from contextlib import ExitStack, contextmanager
from pathlib import Path
from tempfile import TemporaryDirectory

from improv_core.outputs.simulator.simulator import Simulator
from improv_core.program.analysis import analyze
from improv_core.program.compiler import score_of
from improv_core.robots.config import read_robots
from improv_core.score.motion import Pose
from improv_core.score.score import Score
from improv_core.stage.dry_run import perform
from tests.benchmarks.robots import ENV, PYTHON, base, end_of
from tests.benchmarks.tables import machine, print_head, print_row
from tests.commands.command_line import IMPROV
from tests.ros.conftest import Listener, Others

FOLDER = Path(__file__).parents[2] / "examples" / "robots"
A_MINUTE = {
    "repeat kick": "repeat 15 kick",
    "repeat (": "repeat 10 (",
    "repeat sway": "repeat 7 sway",
    "repeat ring": "repeat 7 ring",
}
"""Statements that end groove.improv after a minute."""
DRIFT = ("--wheel-error", "0.96", "0.94", "--noise", "0.01", "--loss", "0.05")
ROBOT = "first"
REST = 1.0
"""Seconds after a program until its bases surely stand."""

Ends = Mapping[str, Pose]


def run(quick: bool) -> None:
    """Measure and print; `quick` measures the square only."""
    print(f"{machine()}\n")
    robots = (FOLDER / "improv.toml").read_text()
    corrected = _calibrated(robots)
    print("How far off the worst robot ends: wheels 4% and 6% short, 1% noise, 5% of commands lost\n")
    print_head("program", "time", "ideal", "measured", "calibrated", "followed", "both")
    for name in ("square",) if quick else ("square", "canon", "groove"):
        program = (FOLDER / f"{name}.improv").read_text()
        if name == "groove":
            for endless, minute in A_MINUTE.items():
                program = program.replace(endless, minute)
        score = score_of(analyze(program, read_robots(robots)))
        ideal = _simulated(score)
        columns = [
            ideal,
            *(_driven(program, each, score) for each in (robots, corrected, _following(robots), _following(corrected))),
        ]
        seconds = f"{score.seconds(score.beats):.0f} s"
        print_row(name, seconds, *(_worst(ends, ideal) for ends in columns))


def _worst(ends: Ends, ideal: Ends) -> str:
    off = max(math.dist((pose.x, pose.y), (ideal[robot].x, ideal[robot].y)) for robot, pose in ends.items())
    turns = (math.remainder(pose.heading - ideal[robot].heading, math.tau) for robot, pose in ends.items())
    return f"{off:.3f} m, {math.degrees(max(map(abs, turns))):.1f}°"


def _simulated(score: Score) -> Ends:
    simulator = Simulator(period=None)
    perform(score, simulator)
    return simulator.poses()


def _calibrated(robots: str) -> str:
    """Return the file with the values that `improv calibrate` finds, for all robots of the profile."""
    environment = _environment()
    with TemporaryDirectory() as folder, _base(ROBOT, Pose(), 0, environment):
        file = Path(folder) / "improv.toml"
        file.write_text(
            f'[profiles.ours]\nbase = "turtlebot4"\n[robots.{ROBOT}]\nprofile = "ours"\nodom = "true_pose"\n'
        )
        command = [*IMPROV, "calibrate", ROBOT, "--backend", "ros", "--write"]
        answers = "\n" * 50
        done = subprocess.run(
            command, input=answers, capture_output=True, text=True, cwd=folder, env=environment, check=True
        )
        told = [line for line in done.stdout.splitlines() if line.startswith(("the values", "before", "after"))]
        print("\n".join(told), "\n")
        profile, _, _ = file.read_text().partition("[robots.")
    return profile + robots[robots.index("[robots.") :]


def _following(robots: str) -> str:
    """Return the file in which all robots follow their paths, measured from outside."""
    return re.sub(r"(\[robots\..*\])", r'\1\nodom = "true_pose"\nfollow = true', robots)


def _driven(program: str, robots: str, score: Score) -> Ends:
    """Measure the true poses of bases after a program, if they begin at its starts."""
    environment = _environment()
    topics = {f"/{robot}/true_pose": robot for robot in score.parts}
    with TemporaryDirectory() as folder, ExitStack() as stack:
        (Path(folder) / "improv.toml").write_text(robots)
        (Path(folder) / "dance.improv").write_text(program)
        for seed, (robot, part) in enumerate(score.parts.items(), 1):
            stack.enter_context(_base(robot, part.start, seed, environment))
        others = Others(PYTHON, environment)
        stack.callback(others.close)
        listener = Listener(others, *topics, type="geometry_msgs/PoseStamped")
        command = [*IMPROV, "play", "dance.improv", "--backend", "ros"]
        subprocess.run(command, cwd=folder, env=environment, check=True, capture_output=True)
        end, found = time.monotonic() + REST, dict[str, Pose]()
        while found.keys() != score.parts.keys():
            heard = listener.wait(lambda message: message["at"] >= end)
            found[topics[heard["topic"]]] = Pose(heard["x"], heard["y"], 0.0, heard["heading"])
    return found


@contextmanager
def _base(robot: str, start: Pose, seed: int, environment: Mapping[str, str]) -> Iterator[None]:
    process = base(robot, (start.x, start.y, start.heading), [*DRIFT, "--seed", str(seed)], env=environment)
    try:
        yield
    finally:
        end_of(process)


def _environment() -> dict[str, str]:
    return {**ENV, "ROS_DOMAIN_ID": str(1 + os.getpid() % 100)}
