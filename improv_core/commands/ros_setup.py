"""`improv ros setup`: ROS 2's Python packages in an environment of their own, proven to carry a Twist."""

from __future__ import annotations

import asyncio
import contextlib
import importlib.metadata
import json
import os
import platform
import re
import shutil
import subprocess
import sys
import time
from collections.abc import AsyncIterator, Callable, Mapping, Sequence
from contextlib import asynccontextmanager
from pathlib import Path

from improv_core.playback.interpreter import PROVEN, VARIABLE, InterpreterError, find_ros_python, private_environment
from improv_core.playback.stage_process import Message, Stage, StageError
from improv_core.program.analysis import analyze
from improv_core.program.compiler import score_of
from improv_core.score.score import to_json
from improv_core.stage.discovery import RANGE
from improv_core.stage.protocol import FOLDER

PYTHONS = (10, 14)
"""The minor versions of CPython 3 that ROS 2's wheels are built for, both included (PyPI, ros-rclpy 7.1)."""
DOWNLOAD, SIZE = 75, 270
"""Megabytes to download, and of the environment they make, as measured with ros-rclpy 7.1.6 and numpy 2.4."""
SPARE = 2
"""Times `SIZE` that has to be free: pip unpacks and installs."""
PROOF_LIMIT = 60.0
"""Seconds the proof's Twist may take, with everything that has to start for it."""
PROOF_DOMAIN = "101"
"""The last domain that is safe beside Linux's ephemeral ports: few robots are in it."""
ELSEWHERE = f"source a ROS 2 (`source /opt/ros/…/setup.bash`), or set {VARIABLE} to a Python with rclpy"
AGAIN = "run `improv ros setup` again"

Say = Callable[[str], object]


class SetupError(Exception):
    """ROS 2 can't be set up; one plain line that says what to do."""


def set_up(say: Say) -> None:
    """Make the private environment, unless it is there and works, and prove that a Twist goes through it.

    What is there and does not work is made anew; what was interrupted does not count. Raises SetupError.
    """
    place, requirements = private_environment(), _requirements()
    python, marker = place / "bin" / "python", place / PROVEN
    if _is_made_of(requirements, marker):
        try:
            _prove(python, say)
        except SetupError:
            say(f"What is in {place} does not work: it is made anew.")
        else:
            say(f"It is there already, in {place}.")
            _say_who_comes_first(python, say)
            return
    if problem := unsuited():
        raise SetupError(problem)
    say(f"Installing {' and '.join(requirements)}")
    say(f"into {place}: about {DOWNLOAD} MB to download, {SIZE} MB on disk.")
    try:
        _make(place, requirements, say)
        _prove(python, say)
        marker.write_text("\n".join(requirements), encoding="utf-8")
    except BaseException:
        shutil.rmtree(place, ignore_errors=True)
        raise
    _say_who_comes_first(python, say)


def unsuited() -> str | None:
    """Why ROS 2's wheels can't be had on this machine, and what to do instead; None if they can."""
    here = f"{platform.system()} on {platform.machine()}"
    if (sys.platform, platform.machine()) != ("linux", "x86_64"):
        return f"ROS 2's packages on PyPI are for Linux on x86_64, and this is {here}: {ELSEWHERE}"
    if platform.libc_ver()[0] != "glibc":
        return f"ROS 2's packages on PyPI are for Linux with glibc, and this one has another C library: {ELSEWHERE}"
    least, most = PYTHONS
    if platform.python_implementation() != "CPython" or not (3, least) <= sys.version_info[:2] <= (3, most):
        this = f"{platform.python_implementation()} {platform.python_version()}"
        return (
            f"ROS 2's packages on PyPI are for CPython 3.{least} to 3.{most}, and this is {this}: "
            f"install Improv with one of those, {ELSEWHERE}"
        )
    return None


def _requirements() -> list[str]:
    """What the extra `ros` of our package asks for; its platforms are those that `unsuited` tells in words."""
    split = (line.partition(";") for line in importlib.metadata.requires("improv") or ())
    return [requirement.strip() for requirement, _, marker in split if re.search(r"""extra == ['"]ros['"]""", marker)]


def _is_made_of(requirements: Sequence[str], marker: Path) -> bool:
    with contextlib.suppress(OSError):
        return marker.read_text(encoding="utf-8").splitlines() == requirements
    return False


def _make(place: Path, requirements: Sequence[str], say: Say) -> None:
    """Make the environment from nothing. Raises SetupError."""
    try:
        (place / PROVEN).unlink(missing_ok=True)  # first: from here on it is half there
        if place.exists():
            shutil.rmtree(place)
        place.parent.mkdir(parents=True, exist_ok=True)
        free = shutil.disk_usage(place.parent).free // 10**6
    except OSError as error:
        problem = (error.strerror or "it can't be made").lower()
        raise SetupError(f"{place}: {problem}: see that it can be written, then {AGAIN}") from None
    if free < SPARE * SIZE:
        raise _no_space(place)
    _run([sys.executable, "-m", "venv", str(place)], _venv_problem, lambda line: None)
    pip = [str(place / "bin" / "python"), "-m", "pip", "install", "--no-input", "--disable-pip-version-check"]
    _run([*pip, "--progress-bar", "off", *requirements], lambda lines: _pip_problem(lines, place), _tell_progress(say))


def _run(command: Sequence[str], problem: Callable[[Sequence[str]], SetupError], tell: Say) -> None:
    """Run a command, telling each line it prints; raise what `problem` makes of them if it fails."""
    env = {name: value for name, value in os.environ.items() if name != "PYTHONPATH"}  # nothing of a sourced ROS
    lines: list[str] = []
    pipe = subprocess.PIPE
    with subprocess.Popen(
        command, env=env, stdin=subprocess.DEVNULL, stdout=pipe, stderr=subprocess.STDOUT, text=True, errors="replace"
    ) as process:
        assert process.stdout
        try:
            for line in process.stdout:
                lines.append(line.rstrip())
                tell(lines[-1])
        except BaseException:
            process.kill()
            raise
    if process.returncode:
        raise problem(lines)


def _tell_progress(say: Say) -> Say:
    """Tells what pip gets, of the many things it says: `ros-rclpy 7.1.6, 2.6 MB`."""

    def tell(line: str) -> None:
        if got := re.match(r"\s+Downloading ([^/\s-]+)-([^-\s]+)-\S+\.whl \((.+)\)", line):
            name, version, size = got.groups()
            say(f"  {name.replace('_', '-')} {version}, {size}")
        elif line.startswith("Installing collected packages"):
            say(f"  unpacking {line.count(',') + 1} packages")

    return tell


def _venv_problem(lines: Sequence[str]) -> SetupError:
    said = "\n".join(lines)
    if "ensurepip" in said or "No module named venv" in said:
        package = f"python3.{sys.version_info.minor}-venv"
        return SetupError(
            f"{sys.executable} can't make environments: install its venv "
            f"(on Debian and Ubuntu `sudo apt install {package}`), then {AGAIN}"
        )
    return SetupError(f"{sys.executable} can't make an environment ({_last(lines)}): {ELSEWHERE}")


_OFFLINE = ("Retrying (", "Max retries", "ConnectionError", "Temporary failure in name resolution", "timed out")


def _pip_problem(lines: Sequence[str], place: Path) -> SetupError:
    said = "\n".join(lines)
    if "No space left on device" in said:
        return _no_space(place)
    if any(sign in said for sign in _OFFLINE):
        return SetupError(f"PyPI can't be reached: connect to the network, then {AGAIN}")
    errors = [line.removeprefix("ERROR: ") for line in lines if line.startswith("ERROR: ")]
    return SetupError(f"pip could not install ROS 2 ({_last(errors or lines)}): {AGAIN}, or {ELSEWHERE}")


def _no_space(place: Path) -> SetupError:
    return SetupError(f"there is too little space for {place}: free {SPARE * SIZE} MB, then {AGAIN}")


def _last(lines: Sequence[str]) -> str:
    return next((line.strip() for line in reversed(lines) if line.strip()), "it says nothing")


def _prove(python: Path, say: Say) -> None:
    """Send a Twist from a real stage to a listener in another process. Raises SetupError."""
    env = {
        **os.environ,
        RANGE: "LOCALHOST",
        "ROS_STATIC_PEERS": "",
        "ROS_DOMAIN_ID": PROOF_DOMAIN,
    }
    try:
        seconds = asyncio.run(asyncio.wait_for(_sent_and_received(str(python), env), PROOF_LIMIT))
    except asyncio.TimeoutError:
        raise SetupError(
            "ROS 2 starts, but a Twist does not arrive: let a firewall pass UDP on this machine's own addresses, "
            f"then {AGAIN}"
        ) from None
    except (StageError, OSError) as error:
        raise SetupError(f"ROS 2 does not start ({error}): {AGAIN}, or {ELSEWHERE}") from None
    say(f"ROS 2 works: a Twist was sent and received in {seconds:.1f} s")


async def _sent_and_received(python: str, env: Mapping[str, str]) -> float:
    """Seconds from the command to play until its first Twist has arrived, discovery included."""
    robot = f"improv_setup_{os.getpid()}"  # no robot's name, so that none moves
    score = score_of(analyze(f"{robot} $ forward\n"))
    folder = FOLDER
    failed: asyncio.Future[None] = asyncio.get_running_loop().create_future()

    def hear(_: Stage, message: Message) -> None:
        if message["type"] in ("error", "gone") and not failed.done():
            failed.set_exception(StageError(message["message"]))

    async with _receiver([python, str(folder / "graph.py"), "receive", score.parts[robot].topic], env) as lines:
        sender = await Stage.start([python, str(folder), "--sink", "ros"], env, hear)
        try:
            began = time.monotonic()
            sender.send(
                {"type": "load", "generation": 1, "score": to_json(score), "when": "restart", "backend": "the proof"}
            )
            received = asyncio.create_task(_next(lines))
            await asyncio.wait([received, failed], return_when=asyncio.FIRST_COMPLETED)
            for each in (received, failed):
                if each.done():
                    each.result()
                each.cancel()
            return time.monotonic() - began
        finally:
            await sender.close()


@asynccontextmanager
async def _receiver(command: Sequence[str], env: Mapping[str, str]) -> AsyncIterator[asyncio.StreamReader]:
    """A process that listens; on leaving, it is ended."""
    pipe, nothing = asyncio.subprocess.PIPE, asyncio.subprocess.DEVNULL
    process = await asyncio.create_subprocess_exec(*command, env=env, stdin=nothing, stdout=pipe, stderr=nothing)
    try:
        assert process.stdout
        await _next(process.stdout)
        yield process.stdout
    finally:
        with contextlib.suppress(ProcessLookupError):
            process.kill()
        await process.wait()


async def _next(lines: asyncio.StreamReader) -> None:
    """Wait until a receiver says that it got on."""
    if not json.loads(await lines.readline() or "false"):
        raise StageError("its listener ended")


def _say_who_comes_first(python: Path, say: Say) -> None:
    """Tell that another Python plays ROS 2, if so."""
    try:
        found = find_ros_python(None)
    except InterpreterError as error:
        say(f"It is not used: {error}")
        return
    if found and found.python != str(python):
        say(f"It waits: {found.origin} comes first, with {found.python}")
