"""`improv class`: children write dances in their browsers, and the teacher plays what they send."""

from __future__ import annotations

import asyncio
import gc
import ipaddress
import socket
import sys
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path

import click

from improv_core.classroom.children import Children, check_site
from improv_core.classroom.desk import Desk
from improv_core.commands.exit_codes import INTERRUPTED, CommandError
from improv_core.commands.parameters import LiveOptions
from improv_core.commands.terminal import TerminalSession, first, performance, run
from improv_core.page.own_machine import listen
from improv_core.program.files import robots_in
from improv_core.robots.config import Robots
from improv_core.session.start import Options, usual_port

NOWHERE = ("192.0.2.1", 9)
"""An address for examples (RFC 5737). A UDP socket that is connected to it sends nothing, but has a local address."""


@click.command("class")
@click.argument("site", type=click.Path(path_type=Path, file_okay=False, exists=True))
@click.option("--address", metavar="ADDRESS", help="This machine's address on the room's network; default: asks.")
@click.option(
    "--port",
    type=click.IntRange(0, 65535),
    metavar="PORT",
    default=8080,
    show_default=True,
    help="Port for the children; 0 picks a free one.",
)
@click.option(
    "--folder",
    metavar="FOLDER",
    type=click.Path(path_type=Path, file_okay=False),
    default="class-dances",
    show_default=True,
    help="Keeps all that children send. The next class with this folder continues.",
)
@click.option(
    "--robots",
    "file",
    metavar="FILE",
    type=click.Path(path_type=Path, dir_okay=False, exists=True),
    help="An improv.toml: the teacher may have one of its real robots perform a dance.",
)
def command(site: Path, address: str | None, port: int, folder: Path, file: Path | None) -> None:
    """Let a class write dances on tablets, and play them in the simulator.

    SITE is a folder that `improv site` has built. Everybody on the room's network can load it from this machine, and
    send dances with the room's code. Only this machine has the teacher's page. Ctrl-C ends the class.
    """
    robots = _robots(file) if file else None
    options = LiveOptions("both", 0, browser=False).options(file) if file else Options(backend="sim")
    check_site(site)
    children = Children(site, folder, _confirmed(address, port), port)
    try:
        sys.exit(run(teach(children, options, robots, usual_port(str(folder.resolve())))))
    finally:
        children.close()
        gc.freeze()  # otherwise Python looks through all objects as it ends: up to half a second


def _robots(file: Path) -> Robots:
    """Return the real robots that may perform. Raises ReadError and CommandError."""
    robots = robots_in(file)
    if not robots.ok:
        raise CommandError(f"{file} has errors: `improv check {file}` shows them")
    if not robots.robots:
        raise CommandError(f"{file} names no robots: add a section such as [robots.turtle1]")
    return robots


def _confirmed(address: str | None, port: int) -> str:
    """Return the address to listen on, which a person has named or confirmed. Raises CommandError."""
    if address is None:
        found = _own_address()
        if not found or not sys.stdin.isatty():
            raise CommandError("name this machine's address on the room's network with --address")
        if not click.confirm(f"Let everybody on this network load the class from http://{found}:{port}/?"):
            raise CommandError("name another address with --address")
        return found
    try:
        named = ipaddress.IPv4Address(address)
    except ValueError:
        raise CommandError(f"{address} is not an IP address: write one such as 192.168.1.20") from None
    if named.is_unspecified or named.is_multicast:
        raise CommandError(f"{address} stands for many networks: name one address of this machine")
    return str(named)


def _own_address() -> str | None:
    """Return this machine's address on the network that leads elsewhere."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        try:
            probe.connect(NOWHERE)
        except OSError:
            return None
        return str(probe.getsockname()[0])


async def teach(children: Children, options: Options, robots: Robots | None = None, port: int = 0) -> int:
    """Hold a class until interrupted, with the teacher's page on this port if it is free. Return the exit code. Raises
    StageError, and CommandError if the children's server ends."""
    async with performance(options, browser=False, hears_keys=False) as performing:
        await Class(performing, children, robots, port).teach()
    return INTERRUPTED


class Class:
    """A class: its children, and the desk and the page of its teacher."""

    def __init__(
        self, performing: TerminalSession, children: Children, robots: Robots | None = None, port: int = 0
    ) -> None:
        from improv_core.classroom.teacher_server import TeacherPage  # only now: that takes long

        self._loop = asyncio.get_running_loop()
        self._performing, self.children = performing, children
        self._ended: asyncio.Future[str] = self._loop.create_future()
        self.desk = Desk(performing.playback, lambda message: self.teacher.publish(message), children.remove, robots)
        performing.follow = self.desk.follow
        self.teacher = TeacherPage(
            listen(port),
            self.desk,
            lambda command: self._soon(self.desk.take, command, performing.stops.count),
            self._stop,
            performing.playback.link,
            lambda link: self._soon(self._offer, link),
        )

    async def teach(self) -> None:
        """Serve children and teacher until interrupted. Raises CommandError if the children's server ends."""
        performing, children = self._performing, self.children
        performing.screen.say(f"children: {children.address}, code {children.code}")
        self._offer(self.teacher.link())
        self.desk.open()
        children.listen(
            lambda news: self._soon(self.desk.hear, news),
            lambda why: self._soon(self._end, why),
        )
        try:
            self.teacher.open(children.address, children.code)
            # Not until a stage ends: another one takes its place.
            await first(asyncio.shield(self._ended), performing.interrupted.wait())
        finally:
            children.close()
            self.desk.close()
            self.teacher.close()
        if self._ended.done():
            raise CommandError(self._ended.result())

    def _offer(self, link: str) -> None:
        self._performing.screen.say(f"teacher: {link} (opens once)")

    def _soon(self, what: Callable[..., None], *values: object) -> None:
        """Have the event loop call a function, from any thread."""
        with suppress(RuntimeError):  # the loop is closed
            self._loop.call_soon_threadsafe(what, *values)

    def _end(self, why: str) -> None:
        if not self._ended.done():
            self._ended.set_result(why)

    def _stop(self) -> None:
        """Stop everything, from any thread."""
        self._performing.stops.stop()
        self._soon(self.desk.stopped)
