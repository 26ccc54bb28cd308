"""From a save to a base that drives: what it counts, where it really is, and what the simulator expects of it."""

from __future__ import annotations

import math
import subprocess
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path

import pytest

from improv_core.commands.rehearsal import perform
from improv_core.program.analysis import analyze
from improv_core.program.compiler import score_of
from improv_core.robots.config import read_robots
from improv_core.score.motion import Pose
from improv_core.stage.sinks.simulator import Simulator
from tests.ls.client import Client
from tests.ros.conftest import LIMIT, Listen, Listener

BASE = Path(__file__).with_name("base.py")
PROGRAM = "beat 60\nexact worn $ repeat 4 (forward slow 2 left)\n"
ROBOTS = """
[profiles.base]
base = "turtlebot4"

[robots.exact]
profile = "base"
start = { x = 0, y = 0 }

[profiles.drifting]
base = "base"

[robots.worn]
profile = "drifting"
start = { x = 0, y = 2 }
"""
STARTS = {"exact": Pose(), "worn": Pose(y=2.0)}
DRIFT = 'dynamics = "motors"\nwheel_error = [0.96, 0.94]'
SECONDS = 12.0
NEAR, NEARLY = 0.08, 10.0
"""Meters and degrees: what a command that is 0.2 s late on a busy machine makes of a step or a turn."""

Start = Callable[..., None]


@pytest.fixture
def start(ros_python: str, ros_env: Mapping[str, str]) -> Iterator[Start]:
    """Starts bases, with the arguments of base.py."""
    bases: list[subprocess.Popen[bytes]] = []

    def begin(*arguments: str) -> None:
        pipe = subprocess.PIPE
        bases.append(subprocess.Popen([ros_python, BASE, *arguments], env=ros_env, stdin=pipe, stdout=pipe))
        stdout = bases[-1].stdout
        assert stdout
        assert stdout.readline() == b"true\n"

    yield begin
    for base in bases:
        base.communicate(timeout=LIMIT)


def expected(program: str, robots: str) -> dict[str, Pose]:
    """Where the simulator says that robots end, relative to where they start."""
    analysis = analyze(program, read_robots(robots))
    simulator = Simulator(period=None)
    perform(score_of(analysis), simulator)
    return {name: Pose(pose.x, pose.y - STARTS[name].y, 0.0, pose.heading) for name, pose in simulator.poses().items()}


def last(listener: Listener, since: float) -> Pose:
    """The first pose from a time on, when the base has long come to rest."""
    heard = listener.wait(lambda message: message["at"] >= since)
    return Pose(heard["x"], heard["y"], 0.0, heard["heading"])


def apart(one: Pose, other: Pose) -> tuple[float, float]:
    """Meters and degrees."""
    turn = math.remainder(one.heading - other.heading, math.tau)
    return math.dist((one.x, one.y), (other.x, other.y)), math.degrees(abs(turn))


def test_a_square_on_bases_that_drift(
    start: Start, listen: Listen, ros_env: dict[str, str], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    start("exact", "--noise", "0", "--loss", "0")
    start("worn", "--wheel-error", "0.96", "0.94", "--noise", "0.01", "--loss", "0.05")
    counted = {name: listen(f"/{name}/odom", "--odometry", "--name", f"{name}_counted") for name in STARTS}
    true = {name: listen(f"/{name}/true_pose", "--pose", "--name", f"{name}_true") for name in STARTS}
    (tmp_path / "improv.toml").write_text(ROBOTS)
    program = tmp_path / "dance.improv"
    program.write_text(PROGRAM)
    with Client({"backend": "ros", "page": {"open": False}}, env=ros_env) as client:
        client.open(program.as_uri(), PROGRAM)
        client.save(program.as_uri())
        client.wait_for_line("▶")
        began = max(counted[name].wait(lambda message: message["x"] > 0.01)["at"] for name in STARTS)
        end = began + SECONDS + 1.0
        odometry = {name: last(counted[name], end) for name in STARTS}
        reality = {name: last(true[name], end) for name in STARTS}

    ideal = expected(PROGRAM, ROBOTS)
    motors = expected(PROGRAM, ROBOTS.replace('"turtlebot4"', '"turtlebot4"\ndynamics = "motors"'))
    drifting = expected(PROGRAM, ROBOTS.replace('base = "base"', f'base = "turtlebot4"\n{DRIFT}'))
    rows = []
    for name in STARTS:
        columns = {"simulator": drifting[name], "odometry": odometry[name], "true": reality[name]}
        offs = {what: apart(pose, ideal[name]) for what, pose in columns.items()}
        cells = [f"{what} {off:.3f} m {turn:.1f}°" for what, (off, turn) in offs.items()]
        rows.append(f"{name}, off the ideal: {', '.join(cells)}")
    with capsys.disabled():
        print("\n" + "\n".join(rows))

    assert apart(ideal["exact"], Pose()) == pytest.approx((0, 0), abs=1e-6)
    off, turn = apart(odometry["exact"], motors["exact"])
    assert off < NEAR
    assert turn < NEARLY
    assert apart(odometry["exact"], reality["exact"]) == pytest.approx((0, 0), abs=1e-3)
    # The encoders of the other one see nothing of its wheels: it believes that it did the same.
    off, turn = apart(odometry["worn"], odometry["exact"])
    assert off < NEAR
    assert turn < NEARLY
    # Where it really is, the simulator has foreseen, but for the noise.
    off, turn = apart(reality["worn"], drifting["worn"])
    assert off < NEAR
    assert turn < NEARLY
    off, turn = apart(reality["worn"], odometry["worn"])
    assert off > 0.03
    assert turn > 10
