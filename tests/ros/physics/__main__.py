"""Run robots in MuJoCo until standard input ends, then write their real poses.

It prints lines of JSON when robots can be driven, when the first is told to move, and when each fault begins and ends,
with the monotonic time `at` and Unix time `wall`. Each line of input is another fault, whose times count from then.
"""

from __future__ import annotations

import argparse
import json
import math
import os
import queue
import subprocess
import sys
import threading
import time
from collections.abc import Sequence
from contextlib import ExitStack
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING, Any

from tests.ros.physics.apart import Apart, apart
from tests.ros.physics.camera import Camera, Pose
from tests.ros.physics.faults import KINDS, Fault, parsed
from tests.ros.physics.messages import FromBridge, ToBridge

if TYPE_CHECKING:
    from tests.ros.physics.world import World

FOLDER = Path(__file__).parent
CACHE = FOLDER.parents[2] / ".cache"
MUJOCO = CACHE / "mujoco" / "bin" / "python"
ROS = os.environ.get("IMPROV_ROS_PYTHON") or str(CACHE / "ros" / "bin" / "python")
WHEELS_PERIOD, PICTURE_PERIOD, BATTERY_PERIOD, TRACE_PERIOD = 0.02, 1 / 30, 1.0, 0.1
"""Seconds between two messages of a robot's encoders, of the camera, of a battery, and between two entries of the
trace."""
FULL = 0.8
"""The level of all batteries, from 0 to 1."""
NAP = 0.001
Inbox = queue.SimpleQueue[FromBridge | str | None]
"""Messages of bridges, faults from standard input, and None at its end or a bridge's."""


def main() -> None:
    options = _options(sys.argv[1:])
    if find_spec("mujoco") is None:
        if not MUJOCO.exists():
            sys.exit("no MuJoCo: run `sh tests/ros/physics/fetch.sh`")
        os.chdir(FOLDER.parents[2])
        os.execv(MUJOCO, [str(MUJOCO), "-m", "tests.ros.physics", *sys.argv[1:]])
    with ExitStack() as stack:
        running = Running(options, stack)
        running.run()
        Path(options.out).write_text(json.dumps(running.truth()))


def _options(arguments: Sequence[str]) -> argparse.Namespace:
    kinds = "\n".join(f"  {kind}:{what}" for kind, what in KINDS.items())
    parser = argparse.ArgumentParser(
        prog="python -m tests.ros.physics",
        description=__doc__,
        epilog=f"faults, as KIND:ROBOT[=AMOUNT][@START[-END]], in seconds since the first robot moved:\n{kinds}",
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("robots", nargs="+", metavar="NAME[=X,Y,HEADING]", help="meters, and degrees")
    parser.add_argument("--out", default=os.devnull, help="the file to write the truth to, as JSON")
    parser.add_argument("--bias", type=float, nargs=2, default=(0.03, 0.05), help="of left and right wheels")
    parser.add_argument("--fault", action="append", default=[], help="see below")
    parser.add_argument("--latency", type=float, default=0.08, help="seconds by which the camera's poses are late")
    parser.add_argument("--loss", type=float, default=0.0, help="the share of the camera's poses that get lost")
    parser.add_argument("--apart", help="a robot that is on a host of its own (needs root and discovery of the subnet)")
    parser.add_argument("--seed", type=int, default=1)
    return parser.parse_args(arguments)


class Running:
    """The world, the camera, and the bridges; their clock is the machine's."""

    def __init__(self, options: argparse.Namespace, stack: ExitStack) -> None:
        from tests.ros.physics.world import World

        starts = dict(map(_start, options.robots))
        self._faults = [parsed(text, list(starts)) for text in options.fault]
        self._world: World = World(starts, dict.fromkeys(starts, tuple(options.bias)))
        self._camera = Camera(options.latency, options.loss, options.seed)
        self._inbox: Inbox = queue.SimpleQueue()
        self._apart: Apart | None = None
        self._bridges: dict[str, Bridge] = {}
        if together := [name for name in starts if name != options.apart]:
            self._bridges |= dict.fromkeys(together, stack.enter_context(Bridge(together, self._inbox)))
        if options.apart:
            self._apart = stack.enter_context(apart())
            bridge = Bridge([options.apart], self._inbox, self._apart)
            self._bridges[options.apart] = stack.enter_context(bridge)
        for _ in set(self._bridges.values()):
            while (said := self._inbox.get()) != {"type": "ready"}:  # somebody may send a velocity already
                assert said is not None, "a bridge has ended"
        threading.Thread(target=_read_faults, args=(self._inbox,), daemon=True).start()
        self._now = self._zero = time.monotonic()
        self._begins: float | None = None
        self._on: set[Fault] = set()
        self._said: list[dict[str, Any]] = []
        self._told: dict[str, list[tuple[float, float, float]]] = {name: [] for name in starts}
        self._trace: dict[str, list[Pose]] = {name: [] for name in starts}
        self._times: list[float] = []

    def run(self) -> None:
        """Run until standard input ends."""
        self._say(ready=True)
        due = dict.fromkeys((self._turn_wheels, self._look, self._check_batteries, self._note), self._zero)
        periods = (WHEELS_PERIOD, PICTURE_PERIOD, BATTERY_PERIOD, TRACE_PERIOD)
        from tests.ros.physics.world import STEP

        while self._take(self._now):
            self._change_faults()
            lifted, stuck = self._having("lift"), self._having("stuck")
            while self._now + STEP <= time.monotonic():
                self._now += STEP
                self._world.step(self._now, lifted, stuck)
            for (work, at), period in zip(list(due.items()), periods, strict=True):
                if self._now >= at:
                    due[work] = max(at + period, self._now - period)
                    work()
            for robot, (x, y, heading), at in self._camera.say(self._now):
                stamp = self._stamp(robot, at)
                self._send(robot, {"type": "seen", "robot": robot, "x": x, "y": y, "heading": heading, "stamp": stamp})
            time.sleep(NAP)

    def truth(self) -> dict[str, Any]:
        """Return the robots' first and last poses and paths; times are seconds since the first one was told to move."""
        begins = self._begins or self._zero
        ends = self._world.poses()
        return {
            "begins": self._begins,
            "robots": {
                name: {
                    "start": _readable(robot.start),
                    "end": _readable(ends[name]),
                    "counted": _readable(robot.counted),
                    "told": [[at - begins, *velocity] for at, *velocity in self._told[name]],
                    "trace": [[at - begins, *_readable(pose)] for at, pose in zip(self._times, trace, strict=True)],
                }
                for (name, robot), trace in zip(self._world.robots.items(), self._trace.values(), strict=True)
            },
            "said": self._said,
        }

    def _take(self, now: float) -> bool:
        """Take all messages up to now. Return whether input continues."""
        while not self._inbox.empty():
            message = self._inbox.get()
            if message is None:
                return False
            if isinstance(message, str):
                since = now - self._begins if self._begins else 0.0
                fault = parsed(message, list(self._world.robots))
                self._faults.append(
                    Fault(fault.kind, fault.robots, fault.amount, fault.start + since, fault.end + since)
                )
                self._begins = self._begins or now
            elif message["type"] == "told":
                self._hear(message["robot"], message["linear"], message["angular"], message["at"])
        return True

    def _hear(self, robot: str, linear: float, angular: float, at: float) -> None:
        self._world.tell(robot, linear, angular, at)
        told = self._told[robot]
        if not told or told[-1][1:] != (linear, angular):
            told.append((at, linear, angular))
        if (linear or angular) and self._begins is None:
            self._begins = at
            self._say(begins=robot)

    def _change_faults(self) -> None:
        """Begin and end faults that are due."""
        if self._begins is None:
            return
        since = self._now - self._begins
        on = {fault for fault in self._faults if fault.start <= since < fault.end}
        for fault in on ^ self._on:
            begins = fault in on
            if fault.kind == "gone":
                self._send(fault.robots[0], {"type": "there", "robot": fault.robots[0], "there": not begins})
            elif fault.kind == "cut" and self._apart:
                self._apart.set_radio(works=not begins)
            self._say(fault=fault.kind, robots=fault.robots, on=begins)
        self._on = on

    def _having(self, kind: str) -> list[str]:
        return [robot for fault in self._on if fault.kind == kind for robot in fault.robots]

    def _turn_wheels(self) -> None:
        for name, robot in self._world.robots.items():
            x, y, heading = robot.counted
            stamp = self._stamp(name, self._now)
            self._send(
                name,
                {
                    "type": "wheels",
                    "robot": name,
                    "x": x,
                    "y": y,
                    "heading": heading,
                    "linear": robot.linear,
                    "angular": robot.angular,
                    "stamp": stamp,
                },
            )

    def _look(self) -> None:
        self._camera.look(self._world.poses(), list(self._on), self._now)

    def _check_batteries(self) -> None:
        for name in self._world.robots:
            flat = [fault.amount for fault in self._on if fault.kind == "flat" and name in fault.robots]
            stamp = self._stamp(name, self._now)
            self._send(name, {"type": "battery", "robot": name, "share": min(flat, default=FULL), "stamp": stamp})

    def _note(self) -> None:
        self._times.append(self._now)
        for name, pose in self._world.poses().items():
            self._trace[name].append(pose)

    def _stamp(self, robot: str, at: float) -> float:
        """Return the Unix time of a monotonic time, by the clock that stamps this robot's messages."""
        ahead = sum(fault.amount for fault in self._on if fault.kind == "clock" and robot in fault.robots)
        return time.time() - time.monotonic() + at + ahead

    def _send(self, robot: str, message: ToBridge) -> None:
        stream = self._bridges[robot].stdin
        assert stream
        stream.write(json.dumps(message).encode() + b"\n")
        stream.flush()

    def _say(self, **what: Any) -> None:
        line = {**what, "at": time.monotonic(), "wall": time.time()}
        self._said.append(line)
        print(json.dumps(line), flush=True)


def _start(text: str) -> tuple[str, Pose]:
    name, _, where = text.partition("=")
    x, y, heading = map(float, where.split(",")) if where else (0.0, 0.0, 0.0)
    return name, (x, y, math.radians(heading))


def _readable(pose: Pose) -> tuple[float, float, float]:
    """Return a pose in meters and degrees."""
    return pose[0], pose[1], math.degrees(pose[2])


class Bridge:
    """The process with the nodes of some robots."""

    def __init__(self, robots: Sequence[str], inbox: Inbox, host: Apart | None = None) -> None:
        command = [ROS, str(FOLDER / "bridge.py"), *robots]
        env = {**os.environ, "FASTDDS_BUILTIN_TRANSPORTS": "UDPv4"} if host else None
        self._process = subprocess.Popen(
            host.command(command) if host else command, env=env, stdin=subprocess.PIPE, stdout=subprocess.PIPE
        )
        self.stdin = self._process.stdin
        threading.Thread(target=self._read, args=(inbox,), daemon=True).start()

    def __enter__(self) -> Bridge:
        return self

    def __exit__(self, *failure: object) -> None:
        self._process.communicate()

    def _read(self, inbox: Inbox) -> None:
        assert self._process.stdout
        for line in self._process.stdout:
            inbox.put(json.loads(line))
        inbox.put(None)


def _read_faults(inbox: Inbox) -> None:
    for line in sys.stdin:
        inbox.put(line.strip())
    inbox.put(None)


if __name__ == "__main__":
    main()
