"""The modules of ours that run between a save and the first Twist, and between Stop on the page and the zero.

Starts `improv-ls` from a checkout as an editor does, saves a program, and presses Stop on the page, three times, after
`sys.setprofile` in every process. A save is followed in all threads, whose idle ticks count, too, so the result is the
least of three walks; a Stop only where it is passed on.
"""

from __future__ import annotations

import os
import re
import subprocess
import time
import urllib.request
from collections import defaultdict
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import NamedTuple

from tests.ls.client import QUIET, ProcessClient

TRACING = Path(__file__).parent / "tracing"
DANCE = "beat 60\nturtle1 $ repeat 3 (forward left)\n"
LIMIT = 120.0
"""Seconds to wait for anything: traced code is slow."""
_SERVES_STOPS = ("improv_core/page/routes.py", "improv_core/safety/stop_request.py")
_READS_STOPS, _QUEUE = "improv_core/safety/stop_server.py", "improv_core/ipc/arrivals.py"
LISTENER = (
    "import rclpy; from geometry_msgs.msg import Twist; rclpy.init(); node = rclpy.create_node('walk_base')\n"
    "node.create_subscription(Twist, '/turtle1/cmd_vel', lambda message: None, 10); rclpy.spin(node)"
)


class Call(NamedTuple):
    """A function of ours that began at some monotonic nanosecond, in a thread of a process."""

    at: int
    thread: tuple[str, int]
    main: bool
    command: str
    module: str
    line: str


class Walk(NamedTuple):
    """Functions that run in between. `modules` are those of the main thread and of the other threads of each process,
    which its command names. `hops` counts changes from one module to another within a thread."""

    milliseconds: float
    modules: Mapping[str, frozenset[str]]
    functions: int
    hops: int

    @property
    def all_modules(self) -> frozenset[str]:
        return frozenset().union(*self.modules.values())


def run(root: Path, ros: str | None, names: bool) -> None:
    """Print both walks in a checkout; with ROS's Python `ros`, those to the ROS stage. `names` lists the modules."""
    with TemporaryDirectory(prefix="walk-") as folder, _listener(ros):
        saves, stops = _walks(root, Path(folder), ros)
    for title, walks in (("save -> first Twist", saves), ("Stop on the page -> zero", stops)):
        least = min(walks, key=lambda walk: len(walk.all_modules))
        processes = {name.partition(",")[0] for name in least.modules}
        print(f"{title}: {len(least.all_modules)} modules, {least.hops} hops, {len(processes)} processes")
        for walk in walks:
            count = len(walk.all_modules)
            print(f"  {walk.milliseconds:7.1f} ms, {count} modules, {walk.functions} functions, {walk.hops} hops")
        for threads, modules in sorted(least.modules.items()):
            print(f"  {len(modules)} modules: {threads}")
            if names:
                print(*(f"    {module}" for module in sorted(modules)), sep="\n")


def _walks(root: Path, folder: Path, ros: str | None) -> tuple[list[Walk], list[Walk]]:
    trace, project = folder / "trace", folder / "project"
    trace.mkdir()
    project.mkdir()
    file = project / "dance.improv"
    file.write_text(DANCE, encoding="utf-8")
    env = dict(os.environ, IMPROV_WALK=str(trace), IMPROV_WALKED=str(root), PYTHONPATH=f"{TRACING}{os.pathsep}{root}")
    if ros:
        env["IMPROV_ROS_PYTHON"] = str(Path(ros).absolute())  # its links make it an environment
    output = "ros" if ros else "simulator"
    between: list[tuple[int, int]] = []
    with ProcessClient({**QUIET, "backend": "both" if ros else "sim"}, env=env) as editor:
        editor.open(file.as_uri(), DANCE)
        address = _address_of_page(editor, file.as_uri())
        home = address.partition("/?")[0]
        with urllib.request.urlopen(address) as page:
            token = re.search(r'improv-token" content="([^"]*)"', page.read().decode())
        assert token
        for number in range(4):
            saved = time.monotonic_ns()
            editor.save(file.as_uri(), DANCE)
            moves = _wait_for_sent(trace, "moves", output, saved)
            pressed = time.monotonic_ns()
            query = f"token={token[1]}&page=abcdefghijklmnop&number={number}"
            stop = urllib.request.Request(f"{home}/stop?{query}", b"", {"Origin": home}, method="POST")
            with urllib.request.urlopen(stop, timeout=LIMIT):
                between += [(saved, moves), (pressed, _wait_for_sent(trace, "zero", output, pressed))]
            time.sleep(2)  # idle again
    found = [_calls(trace, begin, end, root) for begin, end in between[2:]]
    # The first save finds the dance that opened the page still playing.
    stops = [_passed_on(calls, "--sink ros" if ros else "--simulate") for calls in found[1::2]]
    if not any(stops):
        raise SystemExit("each stop reached the stage through the session first: is the machine very busy?")
    return [_walk(calls) for calls in found[::2]], [_walk(calls) for calls in stops if calls]


def _address_of_page(editor: ProcessClient, uri: str) -> str:
    """Return the page's URL. The save that starts the stages for it is not followed."""
    editor.play(uri, DANCE)
    editor.command("page")
    return editor.wait_for_line("page: ").removeprefix("page: ")


def _wait_for_sent(trace: Path, kind: str, output: str, after: int) -> int:
    """Wait for the time at which the output first got such a velocity after some time, in monotonic nanoseconds."""
    end = time.monotonic() + LIMIT
    while time.monotonic() < end:
        for line in (trace / "sent").read_text(encoding="utf-8").splitlines() if (trace / "sent").exists() else ():
            at, found, name = line.split("\t")
            if found == kind and int(at) > after and output in name:
                return int(at)
        time.sleep(0.02)
    raise SystemExit("no velocity was sent in time: is the machine very busy?")


def _walk(calls: Sequence[Call]) -> Walk:
    modules, functions, hops, last = defaultdict[str, set[str]](set), set(), 0, dict[tuple[str, int], str]()
    for call in calls:
        modules[f"{call.command}, {'main thread' if call.main else 'others'}"].add(call.module)
        functions.add((call.module, call.line))
        hops += last.get(call.thread, call.module) != call.module
        last[call.thread] = call.module
    found = {threads: frozenset(names) for threads, names in modules.items()}
    return Walk((calls[-1].at - calls[0].at) / 1e6, found, len(functions), hops)


def _calls(trace: Path, begin: int, end: int, root: Path) -> list[Call]:
    """Return all calls between two times, oldest first."""
    found = []
    for file in trace.glob("*.calls"):
        main, _, command = file.with_suffix(".process").read_text(encoding="utf-8").partition(" ")
        for line in file.read_text(encoding="utf-8").splitlines():
            at, thread, module, number = line.split("\t")
            if begin <= int(at) <= end:
                found.append(
                    Call(int(at), (file.stem, int(thread)), thread == main, _short(command, root), module, number)
                )
    return sorted(found)


def _passed_on(calls: Sequence[Call], stage: str) -> list[Call]:
    """Return the calls that pass a Stop on to a stage, which these words of its command name: those of the page's
    threads that serve its request, until the stage's socket has a line; of the thread that reads it, until that puts
    the stop into the stage's queue; then of the stage's main thread. Robots play on meanwhile: that is left out. There
    are none if the stop reached the stage through the session first."""
    of_page = {call.thread for call in calls if call.module in _SERVES_STOPS}
    of_socket = {call.thread for call in calls if call.module == _READS_STOPS and stage in call.command}
    put = max((call.at for call in calls if call.thread in of_socket and call.module == _QUEUE), default=None)
    if put is None:
        return []
    arrived = next(call.at for call in calls if call.thread in of_socket)
    (process,) = {thread[0] for thread in of_socket}
    return [
        call
        for call in calls
        if (call.thread in of_page and call.at < arrived)
        or (call.thread in of_socket and call.at <= put)
        or (call.main and call.thread[0] == process and call.at > put)
    ]


def _short(command: str, root: Path) -> str:
    """Return the command of a process without its Python and with short paths."""
    return command.partition(" ")[2].replace(f"{root}{os.sep}", "")


@contextmanager
def _listener(ros: str | None) -> Iterator[None]:
    """Start a robot that listens, if ROS's Python is given."""
    if not ros:
        yield
        return
    robot = subprocess.Popen([ros, "-c", LISTENER])
    try:
        yield
    finally:
        robot.kill()
        robot.wait()
