"""Messages about twelve robots in MuJoCo when one of them fails, and the final poses of all of them.

Their wheels roll 3 and 5 % less far than their encoders count, and a camera measures them, 80 ms later.
"""

from __future__ import annotations

import json
import math
import re
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple

from improv_core.program.compiler import score_of
from improv_core.program.files import analyze_file
from improv_core.score.movement import near
from improv_core.score.path import pose_at
from tests.benchmarks.robots import ENV, LIMIT
from tests.benchmarks.tables import machine, print_head, print_row
from tests.commands.command_line import IMPROV

ROBOTS = [f"r{number}" for number in range(12)]
PROGRAM = f"beat 30\n{' '.join(ROBOTS)} $ repeat {{}} (forward forward left) rest\n"
BEGINS, ENDS = 4.0, 7.0
"""Seconds after the first movement between which the fault lasts."""
TOML = """
[ros]
odom_frame = "world"
rejoin = "{}"
[world]
keep_apart = 0.1
[formation]
shape = "grid"
distance = 1.5
"""
ROBOT = """
[robots.{}]
profile = "turtlebot3_burger"
odom = "world_pose"
follow = true
"""
Pose = tuple[float, float, float]
"""Meters and degrees."""


class Case(NamedTuple):
    """A fault, in the words of `python -m tests.ros.physics --help`, and more of its options."""

    name: str
    faults: Sequence[str] = ()
    options: Sequence[str] = ()
    rejoin: str = "continue"
    rounds: int = 3
    """Length of the dance: each round takes 6 s."""


CASES = [
    Case("nothing"),
    Case("of all poses, 20 % get lost", options=("--loss", "0.2")),
    Case("r0 and r5 swapped", ("swap:r0,r5",)),
    Case("the camera sees r0 1 m beside itself", ("jump:r0=1",)),
    Case("r0 lifted off the floor", ("lift:r0",)),
    Case("the motors of r0 blocked", ("stuck:r0",)),
    Case("no pose of r0", ("lost:r0",)),
    Case("poses of r0 0.3 s later", ("late:r0=0.3",)),
    Case("the node of r0 ends", ("gone:r0",)),
    Case('the same, with `rejoin = "return"`', ("gone:r0",), rejoin="return", rounds=8),
    Case("the network of r0 down", ("cut:r0",), ("--apart", "r0")),
]


@dataclass(frozen=True, slots=True)
class Seen:
    """Result of a case: the lines with the seconds since its beginning and since its end, the exit code, and the
    distance of each robot from its place at the end, in meters and degrees."""

    lines: Sequence[tuple[float, float, str]]
    code: int
    off: Mapping[str, tuple[float, float]]


def run(quick: bool) -> None:
    """Measure and print; `quick` tries three cases."""
    print(f"{machine()}\n")
    print(f"{len(ROBOTS)} robots; what is wrong is so from {BEGINS:g} s to {ENDS:g} s after the first movement.")
    print("Lines about commands that leave late, which are about this machine, are only counted.\n")
    print_head(
        "what is wrong",
        "seconds after that",
        "since it is over",
        "what is said",
        "r0 ends off",
        "others at most",
        "late",
    )
    for case in CASES[:3] if quick else CASES:
        seen = _try(case)
        late = [line for _, _, line in seen.lines if LATE in line]
        lines = [each for each in seen.lines if LATE not in each[2]] or [(math.nan, math.nan, "nothing")]
        others = [seen.off[robot] for robot in ROBOTS[1:]]
        most = max(far for far, _ in others), max(turn for _, turn in others)
        begin, end = [case.name], [_readable(seen.off["r0"]), _readable(most), str(len(late))]
        for since, over, line in lines:
            print_row(*begin, _seconds(since), _seconds(over), line, *end)
            begin, end = [""], ["", "", ""]
        if seen.code:
            print_row("", "", "", f"exit code {seen.code}", "", "", "")


LATE = ": commands for "
"""Part of the lines about late commands."""


def _try(case: Case) -> Seen:
    with tempfile.TemporaryDirectory() as folder:
        program, truth = Path(folder, "dance.improv"), Path(folder, "truth.json")
        program.write_text(PROGRAM.format(case.rounds))
        Path(folder, "improv.toml").write_text(TOML.format(case.rejoin) + "".join(map(ROBOT.format, ROBOTS)))
        score = score_of(analyze_file(program))
        starts = {
            robot: (part.start.x, part.start.y, math.degrees(part.start.heading)) for robot, part in score.parts.items()
        }
        beats = near(float(score.beats))
        places = {robot: pose_at(part, beats) for robot, part in score.parts.items()}
        env = {**ENV, "ROS_AUTOMATIC_DISCOVERY_RANGE": "SUBNET"} if "--apart" in case.options else ENV
        command = [sys.executable, "-m", "tests.ros.physics", *case.options, "--out", str(truth)]
        command += [f"{robot}={x:.4f},{y:.4f},{heading:.2f}" for robot, (x, y, heading) in starts.items()]
        for fault in case.faults:
            command += ["--fault", f"{fault}@{BEGINS:g}-{ENDS:g}"]
        pipe = subprocess.PIPE
        with subprocess.Popen(command, env=env, stdin=pipe, stdout=pipe, text=True) as physics:
            assert physics.stdin
            assert physics.stdout
            if "ready" not in physics.stdout.readline():
                raise SystemExit("the physics did not start")
            says: list[Mapping[str, Any]] = []
            reading = threading.Thread(target=lambda: says.extend(map(json.loads, physics.stdout or ())))
            reading.start()
            code, lines = _play(folder, env)
            physics.stdin.close()
            physics.wait(LIMIT)
            reading.join()
        ends = json.loads(truth.read_text())
    on = next((said["at"] for said in says if said.get("on")), math.nan)
    off = next((said["at"] for said in says if said.get("on") is False), math.nan)
    told = [(at - on, at - off, line) for at, line in lines]
    return Seen(told, code, {robot: _off(ends[robot], places[robot]) for robot in ROBOTS})


def _play(folder: str, env: Mapping[str, str]) -> tuple[int, list[tuple[float, str]]]:
    """Return the exit code, and all lines about faults, with their times. The dance begins wherever robots stand: on a
    busy machine, poses may come late."""
    command = [*IMPROV, "play", "--backend", "ros", "--no-browser", "--force", "dance.improv"]
    null = subprocess.DEVNULL
    playing = subprocess.Popen(command, cwd=folder, env=env, stdin=null, stdout=null, stderr=subprocess.PIPE, text=True)
    assert playing.stderr
    lines = [(time.monotonic(), re.sub(r"^improv: ", "", line.strip())) for line in playing.stderr]
    return playing.wait(), lines


def _off(end: Pose, place: Any) -> tuple[float, float]:
    turned = math.remainder(math.radians(end[2]) - place.heading, math.tau)
    return math.dist(end[:2], (place.x, place.y)), abs(math.degrees(turned))


def _readable(off: tuple[float, float]) -> str:
    return f"{off[0]:.2f} m, {off[1]:.0f}°"


def _seconds(value: float) -> str:
    return "" if math.isnan(value) else f"{value:.1f}"
