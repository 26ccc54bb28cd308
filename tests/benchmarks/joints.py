"""Time until joints rest after a fault, by the interfaces of their controllers."""

from __future__ import annotations

import math
import os
import signal
import subprocess
import tempfile
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path

from tests.benchmarks.robots import ENV, PYTHON
from tests.benchmarks.tables import machine, print_head, print_row
from tests.commands.command_line import IMPROV
from tests.processes import players
from tests.ros.conftest import Listener, Others
from tests.ros.hosts import Host, on_one_link, set_link
from tests.ros.test_controllers import CONTROLLER, STATES, TOML, arguments_of

JOINTS = {"yaw": "trajectory", "wrist": "velocity"}
"""Joints of the watched robot, and the interfaces of their controllers."""
TURNS = "ada $ repeat (head left || arm up || hand up)\n"
MOVES, AFTER, UNEVEN = 1.0, 2.5, 0.1
"""Seconds for which joints move, those for which they are watched after a fault, and the jitter of messages."""
Cause = Callable[[subprocess.Popen[bytes]], None]
FAULTS: dict[str, Cause] = {
    "stage killed": lambda playing: os.kill(next(iter(players(playing.pid))), signal.SIGKILL),
    "stage halted": lambda playing: os.kill(next(iter(players(playing.pid))), signal.SIGSTOP),
    "parent halted": lambda playing: playing.send_signal(signal.SIGSTOP),
}
NO_NETWORK = "network gone"
"""Joints are on one host, and Improv on another. Nothing stops those that a velocity controller moves."""


def run(quick: bool) -> None:
    """Measure and print; `quick` does it once."""
    rounds = 1 if quick else 5
    print(f"{machine()}\n")
    print("Milliseconds from a fault until joints are at rest (50 messages a second say so), worst of each\n")
    print_head("fault", "times", *JOINTS.values())
    for fault in (*FAULTS, NO_NETWORK):
        found = [_rest_after(fault) for _ in range(rounds)]
        worst = (max(each[joint] for each in found) for joint in JOINTS)
        print_row(fault, f"{rounds}", *("never" if each >= AFTER - UNEVEN else f"{1000 * each:.0f}" for each in worst))


def _rest_after(fault: str) -> dict[str, float]:
    """Return the seconds that joints took to rest."""
    with ExitStack() as stack:
        folder = Path(stack.enter_context(tempfile.TemporaryDirectory()))
        there, here = stack.enter_context(on_one_link()) if fault == NO_NETWORK else (None, None)
        network = {"ROS_AUTOMATIC_DISCOVERY_RANGE": "SUBNET", "FASTDDS_BUILTIN_TRANSPORTS": "UDPv4"}
        env = {**ENV, **(network if there else {})}
        python = there.wrapper(PYTHON, folder) if there else PYTHON
        controllers = [python, str(CONTROLLER), "ada", *arguments_of("velocity")]
        pipe = subprocess.PIPE
        moved = stack.enter_context(subprocess.Popen(controllers, env=env, stdin=pipe, stdout=pipe))
        stack.callback(moved.kill)
        others = Others(python, env)
        stack.callback(others.close)
        joints = Listener(others, STATES, type="sensor_msgs/JointState")
        playing = stack.enter_context(_improv(folder, here, env))
        before = joints.wait(lambda message: True)["positions"]
        rests = dict.fromkeys(JOINTS, 0.0)

        def watch(until: float) -> None:
            """Note the latest time at which each joint moves."""
            nonlocal before
            while True:
                message = joints.wait(lambda _: True)
                at, now = message["at"], message["positions"]
                rests.update({joint: at for joint in JOINTS if now[joint] != before[joint]})
                before = now
                if at >= until:
                    return

        while not all(rests.values()):
            assert playing.poll() is None, "improv has ended before all joints have moved"
            watch(-math.inf)
        watch(time.monotonic() + MOVES)
        failed = time.monotonic()
        if there:
            set_link(there, up=False)
        else:
            FAULTS[fault](playing)
        watch(failed + AFTER)
        return {joint: max(at - failed, 0.0) for joint, at in rests.items()}


@contextmanager
def _improv(folder: Path, host: Host | None, env: dict[str, str]) -> Iterator[subprocess.Popen[bytes]]:
    (folder / "improv.toml").write_text(TOML.format(home="", hand="velocity"))
    (folder / "dance.improv").write_text(TURNS)
    command = [*IMPROV, "play", "--backend", "ros", "--no-browser", "dance.improv"]
    command, null = host.command(*command) if host else command, subprocess.DEVNULL
    with subprocess.Popen(command, cwd=folder, env=env, stdin=null, stdout=null, stderr=null) as playing:
        try:
            yield playing
        finally:
            playing.send_signal(signal.SIGCONT)
            playing.terminate()
