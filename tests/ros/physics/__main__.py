"""Run robots in MuJoCo until standard input ends, then write their real poses.

It prints lines of JSON when robots can be driven, when the first is told to move, and when each fault begins and ends,
with the monotonic time `at`.
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
from typing import Any

from tests.ros.physics.apart import Apart, apart
from tests.ros.physics.camera import Camera, Pose
from tests.ros.physics.faults import KINDS, Fault, parsed

FOLDER = Path(__file__).parent
CACHE = FOLDER.parents[2] / ".cache"
MUJOCO = CACHE / "mujoco" / "bin" / "python"
ROS = os.environ.get("IMPROV_ROS_PYTHON") or str(CACHE / "ros" / "bin" / "python")
PICTURE_PERIOD = 1 / 30
"""Seconds between two pictures of the camera."""
NAP = 0.001
Inbox = queue.SimpleQueue[list[Any] | None]
"""Lines of bridges, and None at the end of standard input or of a bridge."""


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
        Path(options.out).write_text(json.dumps(running.ends()))


def _options(arguments: Sequence[str]) -> argparse.Namespace:
    kinds = "\n".join(f"  {kind}:{what}" for kind, what in KINDS.items())
    parser = argparse.ArgumentParser(
        prog="python -m tests.ros.physics",
        description=__doc__,
        epilog=f"faults, as KIND:ROBOT[=AMOUNT][@START[-END]], in seconds since the first robot moved:\n{kinds}",
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("robots", nargs="+", metavar="NAME[=X,Y,HEADING]", help="meters, and degrees")
    parser.add_argument("--out", default=os.devnull, help="the file to write the robots' last poses to, as JSON")
    parser.add_argument("--fault", action="append", default=[], help="see below")
    parser.add_argument("--loss", type=float, default=0.0, help="the share of the camera's poses that get lost")
    parser.add_argument("--apart", help="a robot that is on a host of its own (needs root and discovery of the subnet)")
    return parser.parse_args(arguments)


class Running:
    """The world, the camera, and the bridges; their clock is the machine's."""

    def __init__(self, options: argparse.Namespace, stack: ExitStack) -> None:
        from tests.ros.physics.world import World

        starts = dict(map(_start, options.robots))
        self._faults = [parsed(text, list(starts)) for text in options.fault]
        self._world = World(starts)
        self._camera = Camera(options.loss)
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
            while line := self._inbox.get():  # somebody may send a velocity already
                pass
            assert line is not None, "a bridge has ended"
        threading.Thread(target=self._await_end, daemon=True).start()
        self._now = time.monotonic()
        self._begins: float | None = None
        self._on: set[Fault] = set()

    def run(self) -> None:
        """Run until standard input ends."""
        from tests.ros.physics.world import STEP

        _say(ready=True)
        picture_at = self._now
        while self._hear():
            self._change_faults()
            lifted, stuck = self._having("lift"), self._having("stuck")
            while self._now + STEP <= time.monotonic():
                self._now += STEP
                self._world.step(self._now, lifted, stuck)
            if self._now >= picture_at:
                picture_at = max(picture_at + PICTURE_PERIOD, self._now - PICTURE_PERIOD)
                self._camera.look(self._world.poses(), list(self._on), self._now)
            for robot, pose, at in self._camera.say(self._now):
                self._bridges[robot].send(robot, *pose, time.time() - time.monotonic() + at)
            time.sleep(NAP)

    def ends(self) -> dict[str, Pose]:
        """Return the robots' last poses, in meters and degrees."""
        return {name: (x, y, math.degrees(heading)) for name, (x, y, heading) in self._world.poses().items()}

    def _hear(self) -> bool:
        """Pass on all velocities up to now. Return whether input continues."""
        while not self._inbox.empty():
            if (line := self._inbox.get()) is None:
                return False
            robot, linear, angular, at = line
            self._world.tell(robot, linear, angular, at)
            if (linear or angular) and self._begins is None:
                self._begins = at
                _say(begins=robot)
        return True

    def _change_faults(self) -> None:
        """Begin and end faults that are due."""
        if self._begins is None:
            return
        since = self._now - self._begins
        on = {fault for fault in self._faults if fault.start <= since < fault.end}
        for fault in on ^ self._on:
            begins = fault in on
            if fault.kind == "gone":
                self._bridges[fault.robots[0]].send(fault.robots[0], not begins)
            elif fault.kind == "cut" and self._apart:
                self._apart.set_radio(works=not begins)
            _say(fault=fault.kind, robots=fault.robots, on=begins)
        self._on = on

    def _having(self, kind: str) -> list[str]:
        return [robot for fault in self._on if fault.kind == kind for robot in fault.robots]

    def _await_end(self) -> None:
        sys.stdin.read()
        self._inbox.put(None)


def _say(**what: Any) -> None:
    print(json.dumps({**what, "at": time.monotonic()}), flush=True)


def _start(text: str) -> tuple[str, Pose]:
    name, _, where = text.partition("=")
    x, y, heading = map(float, where.split(",")) if where else (0.0, 0.0, 0.0)
    return name, (x, y, math.radians(heading))


class Bridge:
    """The process with the nodes of some robots."""

    def __init__(self, robots: Sequence[str], inbox: Inbox, host: Apart | None = None) -> None:
        command = [ROS, str(FOLDER / "bridge.py"), *robots]
        env = {**os.environ, "FASTDDS_BUILTIN_TRANSPORTS": "UDPv4"} if host else None
        self._process = subprocess.Popen(
            host.command(command) if host else command, env=env, stdin=subprocess.PIPE, stdout=subprocess.PIPE
        )
        threading.Thread(target=self._read, args=(inbox,), daemon=True).start()

    def send(self, *what: str | float) -> None:
        """Send a line, which bridge.py describes."""
        assert self._process.stdin
        self._process.stdin.write(json.dumps(what).encode() + b"\n")
        self._process.stdin.flush()

    def __enter__(self) -> Bridge:
        return self

    def __exit__(self, *failure: object) -> None:
        self._process.communicate()

    def _read(self, inbox: Inbox) -> None:
        assert self._process.stdout
        for line in self._process.stdout:
            inbox.put(json.loads(line))
        inbox.put(None)


if __name__ == "__main__":
    main()
