"""Starts the stages that play a performance, and those of hosts again and again. Standard library only."""

from __future__ import annotations

import asyncio
import os
import sys
from collections.abc import Awaitable, Callable, Mapping, Sequence
from dataclasses import dataclass
from itertools import chain, repeat
from pathlib import Path
from typing import Protocol, TypeAlias
from zlib import crc32

from improv_core.ipc.stage_process import HearStage, RunningStage, Stage, StageError
from improv_core.music.osc_link import Reach
from improv_core.protocol.limits import FOLDER, STOP_SOCKETS
from improv_core.safety.stops import Stops
from improv_core.score.score import Host
from improv_core.session.state import HERE, Output, StageKey

REMOTE = FOLDER.parent / "hosts"
"""The path that Python gets to run a link to another machine."""
PAGE = FOLDER.parent / "page"
"""The path that Python gets to run the page's server."""
PAUSES = (1.0, 2.0, 4.0, 8.0, 15.0)
"""Seconds before each attempt to reach a host again; the last one repeats."""
SLOW = 5.0
"""Seconds after which a line names the hosts that have not answered."""
LATEST = 15.0
"""Seconds after which the others begin without a host that has not answered: its stage joins them once it does."""


class RosPython(Protocol):
    """A Python that can import rclpy, and the environment it needs."""

    @property
    def python(self) -> str: ...

    @property
    def env(self) -> Mapping[str, str]: ...


class FindPython(Protocol):
    """Finds a Python with rclpy, given the setting; None if there is none. Called on a thread."""

    def __call__(self, setting: str | None, *, proves: bool) -> RosPython | None:
        """Return the likeliest Python; with `proves`, one that has been proven to import rclpy. Raises StageError if
        the user named one that can't import it."""


PORTS = range(20_000, 30_000)
"""The usual ports of pages: below those that systems give to other programs."""


@dataclass(frozen=True, slots=True)
class Options:
    """The options of a performance. The ROS fields are as in the settings."""

    backend: str = "auto"
    """auto, sim, ros, or both."""
    port: int = 0
    """The page's port; 0 stands for the `usual_port`, or if that is taken, any free one."""
    ros_python: str | None = None
    find_python: FindPython | None = None
    """Finds a Python with rclpy; without it, there is none."""
    discovery: str | None = None
    standby: bool = True
    report_sent: bool = False
    """True if stages report every velocity they send."""
    page: bool = False
    """True if real robots have a page even without the simulator."""
    takes_start_poses: bool = False
    """True for a listener that handles `place` requests: only then does the page have start poses written into the
    program."""
    node: str | None = None
    """The name of the node in ROS 2; None stands for a unique one."""
    ros_arguments: Sequence[str] = ()
    """ROS's own: `--ros-args …`."""
    host: Host | None = None
    """The machine of a stage, if it isn't this one."""
    osc: Reach = "here"
    """The addresses for OSC messages."""
    show: Path | None = None
    """The path with which the names of the stages' stop sockets begin; without it, they have none."""
    usual_port: int = 0


def usual_port(path: str) -> int:
    """Return the same port for the same path: a browser keeps unsaved text, and a tunnel its way, by address."""
    return PORTS[crc32(path.encode()) % len(PORTS)]


StartStage: TypeAlias = Callable[[Output, Options, str, HearStage, Stops], Awaitable[RunningStage | None]]
"""The type of `start_stage`."""


async def start_stage(output: Output, options: Options, token: str, hear: HearStage, stops: Stops) -> Stage | None:
    """Start a stage and return it when it is ready. `token` opens the page. Raises StageError.

    None if it is that of real robots here, the backend is auto, and no Python has rclpy.
    """
    if output == "ros":
        starting = (
            _start_there(options.host, options, hear, stops) if options.host else _start_here(options, hear, stops)
        )
        return await starting
    simulating = ["--simulate", *_reporting(options)] if output == "simulator" else []
    taking = ["--takes-start-poses"] if options.takes_start_poses else []
    arguments = [*simulating, "--port", str(options.port), "--usual-port", str(options.usual_port), *taking]
    env = {**_with_sockets(os.environ, options), "IMPROV_PAGE_TOKEN": token}
    return await Stage.start([sys.executable, str(PAGE), *arguments], env, hear, stops)


async def wait_for_stages(
    starting: Mapping[StageKey, asyncio.Task[bool]], any_robots: Callable[[], bool], say: Callable[[str], None]
) -> list[StageKey]:
    """Wait until all stages have started or failed, for a limited time for those on hosts. Returns those of hosts that
    have to be tried again. Raises StageError if one here has failed, or if there are hosts and no stage has robots."""
    here = [each for key, each in starting.items() if key.host == HERE]
    robots = {key: each for key, each in starting.items() if key.output == "ros"}
    away = {key: each for key, each in starting.items() if key.host != HERE}

    def late() -> list[str]:
        return [key.host for key, each in away.items() if not each.done()]

    if away:
        await asyncio.wait(robots.values(), timeout=SLOW)
    if late():
        say(f"{', '.join(late())} has not answered for {SLOW:g} s: the others wait for up to {LATEST:g} s")
        await asyncio.wait(robots.values(), timeout=LATEST - SLOW)
    await asyncio.wait(here)  # wait for all even if one fails, so that no stage is left running unnoticed
    while late() and not any_robots():
        await asyncio.wait([each for each in away.values() if not each.done()], return_when=asyncio.FIRST_COMPLETED)
    if late():
        say(f"{', '.join(late())} has not answered for {LATEST:g} s: the others begin, and it joins them")
    failed = [key for key, each in away.items() if each.done() and each.exception()]
    for each in (*here, *(away[key] for key in failed if not any_robots())):
        each.result()
    if away and not any_robots():
        raise StageError("no stage could be started")
    return [key for key, each in away.items() if key in failed or not each.done()]


async def keep_reaching(
    host: str, start: Callable[[], Awaitable[bool]], say: Callable[[str], None], first: Awaitable[bool] | None = None
) -> None:
    """Try to start the stage of a host until it works, after a `first` attempt, if there is one. The same reason for
    several failures is reported once."""
    told = ""
    for pause in chain(PAUSES, repeat(PAUSES[-1])):
        if first is None:
            await asyncio.sleep(pause)
        try:
            await (first or start())
        except StageError as error:
            if str(error) != told:
                told = str(error)
                say(f"{host or 'the stage here'} can't be reached: {told} (Improv keeps trying)")
            first = None
        else:
            return


async def _start_here(options: Options, hear: HearStage, stops: Stops) -> Stage | None:
    """Return the stage of the robots that this machine moves.

    If it starts, its Python has rclpy. Only if it doesn't, a proof finds the reason or another Python.
    """
    find = options.find_python
    likely = await asyncio.to_thread(find, options.ros_python, proves=False) if find else None
    if find and likely:
        try:
            return await _start_by(likely, options, hear, stops)
        except StageError:
            found = await asyncio.to_thread(find, options.ros_python, proves=True)
            if found and found.python == likely.python:
                raise
        if found:
            return await _start_by(found, options, hear, stops)
    if options.backend == "auto":
        return None
    raise StageError(
        "no Python with rclpy was found: run `improv ros setup`, source your ROS 2 "
        "(`source /opt/ros/…/setup.bash`), or set IMPROV_ROS_PYTHON to a Python that has it"
    )


async def _start_by(found: RosPython, options: Options, hear: HearStage, stops: Stops) -> Stage:
    discovery = ["--discovery", options.discovery] if options.discovery else []
    alone = [] if options.standby else ["--no-standby"]
    named = ["--node", options.node] if options.node else []
    theirs = options.ros_arguments  # last: they take all the rest
    arguments = ["--sink", "ros", *discovery, *alone, *_reporting(options), *named, *theirs]
    return await Stage.start([found.python, str(FOLDER), *arguments], _with_sockets(found.env, options), hear, stops)


async def _start_there(host: Host, options: Options, hear: HearStage, stops: Stops) -> Stage:
    """Return the stage of a host's robots, the near end of its link; an output runs here, in our own Python."""
    if host.output:
        named = ["--sink", "devices", "--name", host.name, *_reporting(options), host.name]
        return await Stage.start([sys.executable, str(FOLDER), *named], _with_sockets(os.environ, options), hear, stops)
    domain = [] if host.domain is None else ["--domain", str(host.domain)]
    rmw = ["--rmw", host.rmw] if host.rmw else []
    command = [sys.executable, str(REMOTE), "near", host.name, *domain, *rmw, *_reporting(options)]
    return await Stage.start(command, _with_sockets(os.environ, options), hear, stops)


def _with_sockets(env: Mapping[str, str], options: Options) -> Mapping[str, str]:
    return {**env, STOP_SOCKETS: str(options.show)} if options.show else env


def _reporting(options: Options) -> list[str]:
    return ["--report-sent"] if options.report_sent else []
