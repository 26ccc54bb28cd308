"""Joints of real robots: the time until they rest after a fault, and the punctuality of their changes."""

from __future__ import annotations

import os
import signal
import subprocess
import tempfile
import time
from collections import defaultdict
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager, suppress
from pathlib import Path
from statistics import median

from tests.benchmarks.robots import ENV, HERE, LIMIT, PYTHON
from tests.benchmarks.tables import machine, p99, print_head, print_row
from tests.commands.command_line import IMPROV
from tests.processes import players
from tests.ros.hosts import Host, on_one_link, set_link
from tests.ros.test_controllers import CONTROLLER, TOML, arguments_of

JOINTS = ("trajectory", "", "", "velocity")
"""Interfaces of the joints of the watched robot: its messages have positions of joints."""
TURNS = "ada $ repeat (head left || arm up || hand up)\n"
MOVES, AFTER, UNEVEN = 1.0, 2.5, 0.1
"""Seconds for which joints move, those for which they are watched after a fault, and the jitter of messages."""
ROBOTS, COUNT, RATE = 10, 12, 50
PROFILE = """
[profiles.arm]
step = 1
command_rate = {rate}
joint_states = "joint_states"
[profiles.arm.controllers.all]
joints = {joints}
"""
Cause = Callable[[subprocess.Popen[bytes]], None]
FAULTS: dict[str, Cause] = {
    "stage killed": lambda playing: os.kill(next(iter(players(playing.pid))), signal.SIGKILL),
    "stage halted": lambda playing: os.kill(next(iter(players(playing.pid))), signal.SIGSTOP),
    "parent halted": lambda playing: playing.send_signal(signal.SIGSTOP),
}
NO_NETWORK = "network gone"
"""Joints are on one host, and Improv on another. Nothing stops those that a velocity controller moves."""


def run(quick: bool) -> None:
    """Measure and print; `quick` does it once, and for a few seconds."""
    rounds, seconds = (1, 6) if quick else (5, 20)
    print(f"{machine()}\n")
    print("Milliseconds from a fault until joints are at rest (50 messages a second say so), worst of each\n")
    interfaces = [each for each in JOINTS if each]
    print_head("fault", "times", *interfaces)
    for fault in (*FAULTS, NO_NETWORK):
        found = [_rest_after(fault) for _ in range(rounds)]
        worst = (max(each[which] for each in found) for which in interfaces)
        print_row(fault, f"{rounds}", *("never" if each >= AFTER - UNEVEN else f"{1000 * each:.0f}" for each in worst))
    print(
        f"\n{ROBOTS} robots with {COUNT} joints at {RATE} Hz, all alike, another velocity each second: how late changes"
    )
    print("are received, beside the earliest of all, in milliseconds\n")
    print_head("who", "changes", "p50", "p99")
    for who, late in (("Improv", _punctual(True, seconds)), ("a plain loop with rclpy", _punctual(False, seconds))):
        print_row(who, f"{len(late)}", f"{1000 * median(late):.1f}", f"{1000 * p99(late):.1f}")


def _rest_after(fault: str) -> dict[str, float]:
    """Return the seconds that joints took to rest, by their interfaces."""
    with ExitStack() as stack:
        folder = stack.enter_context(tempfile.TemporaryDirectory())
        there, here = stack.enter_context(on_one_link()) if fault == NO_NETWORK else (None, None)
        stack.enter_context(_ros(CONTROLLER, "ada", *arguments_of("velocity"), host=there))
        watching = stack.enter_context(_ros(HERE / "ros_joints.py", "states", "/ada/joint_states", host=there))
        playing = stack.enter_context(_improv(folder, TOML.format(home="", hand="velocity"), TURNS, here))
        cause = FAULTS[fault] if there is None else lambda _: set_link(there, up=False)
        lines = _velocities(watching)
        begin = next(at for at, velocities in lines if all(map(_moves, velocities, JOINTS)))
        next(at for at, _ in lines if at > begin + MOVES)
        failed = time.monotonic()
        cause(playing)
        rests = dict.fromkeys(filter(None, JOINTS), 0.0)
        for at, velocities in lines:
            if at > failed + AFTER:
                return rests
            for velocity, interface in zip(velocities, JOINTS, strict=True):
                if velocity and interface:
                    rests[interface] = at - failed
    raise SystemExit("nobody says where joints are")


def _moves(velocity: float, interface: str) -> bool:
    return not interface or bool(velocity)


def _velocities(watching: subprocess.Popen[bytes]) -> Iterator[tuple[float, list[float]]]:
    """Yield the time of each message, and the velocities."""
    assert watching.stdout
    for line in watching.stdout:
        at, *velocities = map(float, line.split())
        yield at, velocities


def _punctual(ours: bool, seconds: int) -> list[float]:
    """Return how late changes are received, in seconds."""
    listening = seconds + LIMIT / 3
    script = HERE / "ros_joints.py"
    times: dict[int, list[float]] = defaultdict(list)
    with tempfile.TemporaryDirectory() as folder, _ros(script, "listen", ROBOTS, COUNT, listening) as listener:
        playing = _improv(folder, *_dance(seconds)) if ours else _ros(script, "loop", ROBOTS, COUNT, seconds, RATE)
        with playing:
            assert listener.stdout
            for line in listener.stdout:
                with suppress(ValueError):  # the line that says it is ready
                    robot, at = line.split()
                    times[int(robot)].append(float(at))
    late = [at - number for each in times.values() for number, at in enumerate(each)]
    if len(late) < ROBOTS * (seconds - 1):
        raise SystemExit(f"only {len(late)} changes were heard")
    return [each - min(late) for each in late]


def _dance(seconds: int) -> tuple[str, str]:
    """Return improv.toml and a program."""
    joints = [f"joint{number}" for number in range(COUNT)]
    parts = [(f"part{number}", joints[3 * number : 3 * number + 3]) for number in range(COUNT // 3)]
    toml = PROFILE.format(rate=RATE, joints=joints)
    for part, (one, two, three) in parts:
        directions = zip(("left", "up", "forward"), (one, two, three), strict=True)
        toml += f"[profiles.arm.body.{part}]\n"
        toml += "".join(f'{word} = {{ joint = "{joint}", degrees = 57.29578 }}\n' for word, joint in directions)
    toml += "".join(f'[robots.arm{robot}]\nprofile = "arm"\n' for robot in range(ROBOTS))
    there, back = "(left || up || forward)", "(right || down || backward)"
    moves = " || ".join(f"{part} (repeat {seconds // 2} ({there} {back}))" for part, _ in parts)
    arms = " ".join(f"arm{robot}" for robot in range(ROBOTS))
    return toml, f"beat 60\n{arms} $ {moves}\n"


@contextmanager
def _improv(folder: str, toml: str, program: str, host: Host | None = None) -> Iterator[subprocess.Popen[bytes]]:
    Path(folder, "improv.toml").write_text(toml)
    Path(folder, "dance.improv").write_text(program)
    command = [*IMPROV, "play", "--backend", "ros", "--no-browser", "dance.improv"]
    null = subprocess.DEVNULL
    command, env = _on(host, command)
    with subprocess.Popen(command, cwd=folder, env=env, stdin=null, stdout=null, stderr=null) as playing:
        try:
            yield playing
        finally:
            playing.send_signal(signal.SIGCONT)
            playing.terminate()


@contextmanager
def _ros(script: Path, *arguments: object, host: Host | None = None) -> Iterator[subprocess.Popen[bytes]]:
    command, env = _on(host, [PYTHON, str(script), *map(str, arguments)])
    pipe = subprocess.PIPE
    with subprocess.Popen(command, env=env, stdin=pipe, stdout=pipe) as process:
        try:
            yield process
        finally:
            process.kill()


def _on(host: Host | None, command: list[str]) -> tuple[list[str], dict[str, str]]:
    """Return the command that runs another command on a host, and its environment."""
    if host is None:
        return command, ENV
    network = {"ROS_AUTOMATIC_DISCOVERY_RANGE": "SUBNET", "FASTDDS_BUILTIN_TRANSPORTS": "UDPv4"}
    return host.command(*command), {**ENV, **network}
