"""`improv doctor`: what is there to play with, and what to do about what is not. No robot is told anything."""

from __future__ import annotations

import json
import os
import platform
import re
import shutil
import subprocess
import sysconfig
import webbrowser
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from enum import Enum
from pathlib import Path

from improv_core import __version__
from improv_core.commands.ros_setup import AGAIN, DOWNLOAD, unsuited
from improv_core.diagnostics import Severity
from improv_core.playback.interpreter import SETUP, Interpreter, InterpreterError, find_ros_python, private_environment
from improv_core.program.analysis import Analysis, analyze
from improv_core.program.files import ReadError, analyze_file, robots_near
from improv_core.program.report import told
from improv_core.robots.config import FILE_NAME, Robot, Robots
from improv_core.stage.discovery import RANGE, REACH, advice, described, limited, reached
from improv_core.stage.graph import VELOCITIES
from improv_core.stage.protocol import FOLDER

LOOK_LIMIT = 30.0
"""Seconds a look at ROS 2's graph may take, on a busy machine."""
VERSION_LIMIT = 10.0
"""Seconds a program may take to say its version."""

Graph = Mapping[str, Mapping[str, Sequence[tuple[str, str]]]]
"""Per topic its `listeners` and `publishers`: the node and the type of each."""


class Mark(Enum):
    """How something is: it works, it is not there, it does not work."""

    GOOD = "✓"
    ABSENT = "–"
    BROKEN = "✗"


@dataclass(frozen=True, slots=True)
class Finding:
    """What was found out about one thing, and the one thing to do about it."""

    mark: Mark
    what: str
    advice: str = ""

    def __str__(self) -> str:
        return f"{self.mark.value} {self.what}" + (f": {self.advice}" if self.advice else "")


def examine(path: Path | None) -> Iterator[Finding]:
    """Look at everything in turn, for the robots of a program, or of the nearest `improv.toml` if none is given."""
    yield Finding(Mark.GOOD, f"Improv {__version__}, Python {platform.python_version()}")
    cast: Mapping[str, Robot] = {}
    try:
        analysis = analyze_file(path) if path else analyze("", robots_near(Path.cwd()))
    except ReadError as error:
        yield Finding(Mark.BROKEN, str(error))
    else:
        yield from program(path, analysis)
        cast = {name: analysis.cast.robot(name) for name in (analysis.robots if path else analysis.cast.robots)}
    yield works("the simulator", _start_simulator)
    yield works("the simulator's page", _open_page)
    yield browser(webbrowser.get)
    yield from _ros(cast)
    yield server(os.environ.get("PATH", ""), Path(sysconfig.get_path("scripts")))
    yield from editors(os.environ.get("PATH", ""))


def program(path: Path | None, analysis: Analysis) -> Iterator[Finding]:
    """Whether the program and its `improv.toml` are right."""
    robots = analysis.cast
    if path and any(each.severity is Severity.ERROR for each in analysis.diagnostics):
        yield Finding(Mark.BROKEN, f"{path} has mistakes", f"`improv check {path}` says which")
    elif path:
        yield Finding(Mark.GOOD, f"{path} is right")
    if robots.diagnostics:
        for line in told(Path(), analyze("", robots)):
            yield Finding(Mark.BROKEN, line)
    elif robots.path:
        yield Finding(Mark.GOOD, f"{robots.path}: {_named(robots)}")
    else:
        advice = f"{FILE_NAME} says what yours are like; without one they have a step of 2 m and no limits"
        yield Finding(Mark.ABSENT, f"no {FILE_NAME}", advice)


def works(name: str, start: Callable[[], None]) -> Finding:
    """Whether something of ours can be started."""
    try:
        start()
    except ImportError as error:
        return Finding(Mark.BROKEN, f"{name} does not work ({error})", "install Improv again")
    except OSError as error:
        return Finding(Mark.BROKEN, f"{name} can't be served ({error})", "let Improv open a port on 127.0.0.1")
    return Finding(Mark.GOOD, name)


def browser(get: Callable[[], object]) -> Finding:
    """Whether a browser can be opened to show the page."""
    try:
        get()
    except webbrowser.Error:
        return Finding(
            Mark.ABSENT, "no browser to open", "open the address that Improv prints in one, or in the editor"
        )
    return Finding(Mark.GOOD, "a browser to open it in")


def ros(found: Interpreter | InterpreterError | None, private: Path, env: Mapping[str, str]) -> Finding:
    """Which Python plays ROS 2, if any does; `private` is where `improv ros setup` puts its own."""
    if isinstance(found, Interpreter):
        release = f" {found.env['ROS_DISTRO']}" if found.env.get("ROS_DISTRO") else ""
        return Finding(Mark.GOOD, f"ROS 2{release}, by {found.origin}: {found.python}")
    if found:
        return Finding(Mark.BROKEN, str(found))
    if private.exists():
        return Finding(Mark.BROKEN, f"the ROS 2 in {private} does not work", AGAIN)
    if "AMENT_PREFIX_PATH" in env:
        return Finding(Mark.BROKEN, "a ROS 2 is sourced, and no Python has its rclpy", "install `ros-…-rclpy` with apt")
    if problem := unsuited():
        return Finding(Mark.ABSENT, "no ROS 2, only the simulator plays", problem)
    return Finding(Mark.ABSENT, "no ROS 2, only the simulator plays", f"{SETUP} gets it ({DOWNLOAD} MB)")


def reach(env: Mapping[str, str]) -> Finding:
    """Which robots a stage started in this environment reaches, and how to change that."""
    stage, domain = limited(env), env.get("ROS_DOMAIN_ID") or "0"
    if not domain.isdecimal() or int(domain) > MOST_DOMAIN:
        return Finding(Mark.BROKEN, f"ROS_DOMAIN_ID is {domain}", "set it to a number from 0 to 101")
    if stage[RANGE] not in REACH:
        return Finding(Mark.BROKEN, f"{RANGE} is {stage[RANGE]}", f"set it to {', '.join(REACH)}, or unset it")
    what, reaches = described(stage), reached(stage)
    if reaches == "LOCALHOST":
        return Finding(Mark.GOOD, what, f"set {advice(env, 'SUBNET')} to reach robots on the network")
    if reaches == "OFF":
        return Finding(Mark.ABSENT, what, f"unset {RANGE} to find robots on this machine")
    return Finding(Mark.GOOD, what, f"set {advice(env, 'LOCALHOST')} after sourcing ROS to stay on this machine")


MOST_DOMAIN = 232
"""As in Fast DDS and Cyclone DDS, whose ports end there."""


def listeners(cast: Mapping[str, Robot], seen: Graph) -> Iterator[Finding]:
    """Per robot who listens where its velocities go, and who else publishes there; for no robot, all who listen."""
    hearing = {topic: ends["listeners"] for topic, ends in seen.items() if ends["listeners"]}
    spare = sorted(hearing.keys() - {robot.topic for robot in cast.values()})
    for name, robot in cast.items():
        yield _listener(name, robot, hearing.get(robot.topic, ()), spare)
        others = {node for node, _ in seen[robot.topic]["publishers"] if not node.startswith(OURS)}
        for node in sorted(others):
            what = f"{name}: {node} publishes on {robot.topic} too"
            yield Finding(Mark.ABSENT, what, "end it while Improv plays, or the robot stutters between the two")
    if not cast:
        for topic, ends in hearing.items():
            yield Finding(Mark.GOOD, f"{_nodes(ends)} on {topic}")
        if not hearing:
            yield Finding(Mark.ABSENT, "no robot listens", "start one, in this domain")


OURS = "/improv"
"""What the names of our own stages' nodes begin with."""


def server(path: str, scripts: Path) -> Finding:
    """Whether editors find our language server on the PATH."""
    found, own = shutil.which("improv-ls", path=path), scripts / "improv-ls"
    if not found:
        return Finding(Mark.ABSENT, "improv-ls is not on the PATH", f"add {scripts} to it, for editors to find it")
    if Path(found).resolve() != own.resolve():
        return Finding(Mark.ABSENT, f"improv-ls is another Improv's, {found}", f"put {scripts} before it on the PATH")
    return Finding(Mark.GOOD, f"improv-ls for editors, {found}")


def editors(path: str) -> Iterator[Finding]:
    """Which of the editors that Improv has an extension for are there, and whether they are new enough."""
    programs = {
        name: next(filter(None, (shutil.which(each, path=path) for each in commands)), None)
        for name, (commands, _) in EDITORS.items()
    }
    with ThreadPoolExecutor() as pool:
        versions = dict(zip(programs, pool.map(_version, programs.values()), strict=True))
    for name, program in programs.items():
        least, version = EDITORS[name][1], versions[name]
        if program and not version:
            yield Finding(Mark.ABSENT, f"{name} does not say its version", f"see that `{program} --version` works")
        elif version and version < least:
            yield Finding(Mark.ABSENT, f"{name} {_dotted(version)}", f"Improv wants {_dotted(least)} or newer")
        elif version:
            yield Finding(Mark.GOOD, f"{name} {_dotted(version)}")
    if absent := [name for name, program in programs.items() if not program]:
        yield Finding(Mark.ABSENT, f"no {', no '.join(absent)}", "any editor does with `improv watch FILE`")


EDITORS: Mapping[str, tuple[Sequence[str], tuple[int, ...]]] = {
    "VS Code": (("code", "codium"), (1, 91)),
    "Neovim": (("nvim",), (0, 10)),
    "Helix": (("hx", "helix"), (25, 7)),
    "Emacs": (("emacs",), (30,)),
    "Vim": (("vim",), (9,)),
}
"""Per editor its commands, and the oldest version that its extension is for."""


def _ros(cast: Mapping[str, Robot]) -> Iterator[Finding]:
    found: Interpreter | InterpreterError | None
    try:
        found = find_ros_python(None)
    except InterpreterError as error:
        found = error
    yield ros(found, private_environment(), os.environ)
    if isinstance(found, Interpreter):
        env = limited(found.env)
        yield (how_far := reach(found.env))
        if how_far.mark is not Mark.BROKEN:
            seen = _look(found, env, [robot.topic for robot in cast.values()])
            yield from [seen] if isinstance(seen, Finding) else listeners(cast, seen)


def _look(found: Interpreter, env: Mapping[str, str], topics: Sequence[str]) -> Graph | Finding:
    command = [found.python, str(FOLDER / "graph.py"), "look", *topics]
    try:
        done = subprocess.run(
            command, env=env, stdin=subprocess.DEVNULL, capture_output=True, timeout=LOOK_LIMIT, check=True
        )
    except subprocess.TimeoutExpired:
        return Finding(Mark.BROKEN, "ROS 2 does not start in time", "try again")
    except subprocess.CalledProcessError as error:
        lines = error.stderr.decode(errors="replace").strip().splitlines()
        return Finding(
            Mark.BROKEN, f"ROS 2 does not start ({lines[-1] if lines else 'it says nothing'})", _repair(found)
        )
    graph: Graph = json.loads(done.stdout)
    return graph


def _repair(found: Interpreter) -> str:
    return AGAIN if found.origin == SETUP else f"see that `{found.python} -c 'import rclpy; rclpy.init()'` works"


def _listener(name: str, robot: Robot, ends: Sequence[tuple[str, str]], spare: Sequence[str]) -> Finding:
    if not ends:
        advice = f'write `topic = "{spare[0]}"` for it in {FILE_NAME}: there somebody listens' if spare else "start it"
        return Finding(Mark.ABSENT, f"{name}: nobody listens on {robot.topic}", advice)
    types = {kind for _, kind in ends}
    if not types & set(VELOCITIES):
        what = f"{name}: {_nodes(ends)} on {robot.topic}, which is neither Twist nor TwistStamped"
        return Finding(Mark.BROKEN, what, f"write another `topic` for it in {FILE_NAME}")
    if robot.message != "auto" and f"geometry_msgs/msg/{robot.message}" not in types:
        advice = f'write `message = "auto"` for it in {FILE_NAME}'
        return Finding(Mark.BROKEN, f"{name}: {_nodes(ends)} on {robot.topic}, not {robot.message}", advice)
    return Finding(Mark.GOOD, f"{name}: {_nodes(ends)} on {robot.topic}")


def _nodes(ends: Sequence[tuple[str, str]]) -> str:
    return " and ".join(f"{node} listens for {kind.rpartition('/')[2]}" for node, kind in ends)


def _named(robots: Robots) -> str:
    return ", ".join(f"{name} ({robot.profile.name})" for name, robot in robots.robots.items()) or "no robots"


def _version(program: str | None) -> tuple[int, ...]:
    """The version a program says it has; empty if there is none."""
    if not program:
        return ()
    try:
        done = subprocess.run(
            [program, "--version"], stdin=subprocess.DEVNULL, capture_output=True, timeout=VERSION_LIMIT, check=True
        )
    except (OSError, subprocess.SubprocessError):
        return ()
    said = re.search(rb"\d+(\.\d+)+", done.stdout)
    return tuple(map(int, said[0].split(b"."))) if said else ()


def _dotted(version: Sequence[int]) -> str:
    return ".".join(map(str, version))


def _start_simulator() -> None:
    from improv_core.stage.sinks.simulator import Simulator

    Simulator().close()


def _open_page() -> None:
    from improv_core.stage.sinks.simulator import Simulator
    from improv_core.stage.viewer.server import Viewer

    Viewer(0, Simulator().snapshot, lambda command: None).close()
