"""`improv doctor`: checks what Improv can play with, and advises how to get what is missing. It sends nothing to
robots."""

from __future__ import annotations

import os
import platform
import sys
import sysconfig
from collections.abc import Callable, Iterator, Mapping
from fractions import Fraction
from pathlib import Path

import click

from improv_core import __version__
from improv_core.commands.doctor_controllers import JointedRobot, jointed
from improv_core.commands.doctor_editors import editors, server
from improv_core.commands.doctor_hosts import examine_hosts, hosts_of
from improv_core.commands.doctor_ros import examine_ros
from improv_core.commands.echo import echo
from improv_core.commands.exit_codes import PROBLEMS
from improv_core.commands.finding import BROKEN, Finding, absent, broken, good
from improv_core.diagnostics import Severity
from improv_core.page.browser import has_browser
from improv_core.program.analysis import Analysis, analyze
from improv_core.program.compiler import starts_of
from improv_core.program.files import ReadError, analyze_file, robots_near
from improv_core.program.report import as_lines
from improv_core.protocol.drawn import Snapshot
from improv_core.robots.config import FILE_NAME, Robot, Robots
from improv_core.safety.allowed import HostError, is_approved, refusal
from improv_core.safety.stop_socket import IDLE, SUPPORTED, StopSocket, StopSocketError, fixed_folder
from improv_core.score.motion import Pose
from improv_core.score.score import Safety, Score


@click.command("doctor")
@click.argument("file", required=False, type=click.Path(path_type=Path))
@click.option("--hosts", is_flag=True, help="Look at the machines of the robots instead, or at all you have allowed.")
def command(file: Path | None, hosts: bool) -> None:
    """Check what works here, and which robots listen. Exit code 1 if anything is broken."""
    marks = set()
    for finding in _hosts(file) if hosts else examine(file):
        echo(str(finding))
        marks.add(finding.mark)
    sys.exit(PROBLEMS if BROKEN in marks else 0)


def _hosts(path: Path | None) -> Iterator[Finding]:
    try:
        yield from examine_hosts(hosts_of(robots_near(path.parent) if path else None))
    except HostError as error:
        yield broken(str(error))


def examine(path: Path | None) -> Iterator[Finding]:
    """Check everything in turn, for the robots of a program, or of the nearest `improv.toml` without one."""
    yield good(f"Improv {__version__}, Python {platform.python_version()}")
    examined: Mapping[str, Robot] = {}
    safety, places = Safety(), dict[str, Pose]()
    bodies: list[JointedRobot] = []
    try:
        analysis = analyze_file(path) if path else analyze("", robots_near(Path.cwd()))
    except ReadError as error:
        yield broken(str(error))
    else:
        yield from program(path, analysis)
        robots, safety = analysis.opening.config, analysis.config.safety
        examined = {name: robots.robot(name) for name in (analysis.robots if path else robots.robots)}
        bodies = jointed([*examined], robots)
        starts = starts_of(analysis) if path and analysis.ok else {}
        yield from elsewhere(examined, path)
        yield from addresses(examined)
        examined = {name: robot for name, robot in examined.items() if not robot.host}
        places = {name: pose for name, robot in examined.items() if (pose := starts.get(name, robot.start))}
    yield works("the simulator", _simulate)
    yield works("the simulator's page", _open_page)
    yield browser(has_browser())
    yield stopping()
    yield from examine_ros(examined, safety, bodies, places)
    yield server(os.environ.get("PATH", ""), Path(sysconfig.get_path("scripts")))
    yield from editors(os.environ.get("PATH", ""))


def elsewhere(examined: Mapping[str, Robot], path: Path | None) -> Iterator[Finding]:
    """Report robots whose own machines have to be checked."""
    machines = {name: robot.host for name, robot in examined.items() if robot.host and not robot.host.output}
    if far := [f"{name} on {host.name}" for name, host in machines.items()]:
        command = f"improv doctor --hosts {path}" if path else "improv doctor --hosts"
        yield absent(f"not seen from here: {', '.join(far)}", f"look there with `{command}`")


def addresses(examined: Mapping[str, Robot]) -> Iterator[Finding]:
    """Report the addresses of robots that outputs move, and whether Improv may use them. Raises HostError."""
    named: dict[str, list[str]] = {}
    for name, robot in examined.items():
        if robot.device:
            named.setdefault(robot.device.address, []).append(name)
    for address, robots in named.items():
        if is_approved(address):
            yield good(f"{', '.join(robots)} at {address}, which Improv may use")
        else:
            yield absent(f"{', '.join(robots)} at {address}", refusal(address))


def program(path: Path | None, analysis: Analysis) -> Iterator[Finding]:
    """Report errors in the program and its `improv.toml`."""
    robots = analysis.config
    if path and any(each.severity is Severity.ERROR for each in analysis.diagnostics):
        yield broken(f"{path} has errors", f"run `improv check {path}` to see them")
    elif path:
        yield good(f"no errors in {path}")
    if robots.diagnostics:
        for line in as_lines(Path(), analyze("", robots)):
            yield broken(line)
    elif robots.path:
        yield good(f"{robots.path}: {_named(robots)}")
    else:
        yield absent(f"no {FILE_NAME}", "describe your robots in one; without it, a step is 2 m and speed has no limit")


def works(name: str, start: Callable[[], None]) -> Finding:
    """Report a part of Improv, which works if `start` raises nothing."""
    try:
        start()
    except ImportError as error:
        return broken(f"{name} does not work ({error})", "reinstall improv-ls")
    except OSError as error:
        return broken(f"{name} cannot be served ({error})", "allow Improv to open a port on 127.0.0.1")
    return good(name)


def stopping() -> Finding:
    """Report whether `improv stop` can reach a performance."""
    if not SUPPORTED:
        return absent("`improv stop` needs Unix sockets", "press Ctrl-C, or Stop on the page")
    try:
        StopSocket(lambda stop: IDLE).close()
    except StopSocketError as error:
        return broken("`improv stop` does not work", str(error))
    return good(f"`improv stop` works through {fixed_folder()}")


def browser(found: bool) -> Finding:
    """Report whether a browser can open to show the page."""
    if found:
        return good("a browser to show the page")
    return absent("no browser to show the page", "open the address that Improv prints in a browser or your editor")


def _named(robots: Robots) -> str:
    return ", ".join(f"{name} ({robot.profile.name})" for name, robot in robots.robots.items()) or "no robots"


def _simulate() -> None:
    from improv_core.stage.dry_run import simulate

    simulate(Score(Fraction(60), {}), 0.0, lambda message: None)


def _open_page() -> None:
    from improv_core.page.server import PageServer

    PageServer(0, Snapshot, lambda command: None).close()
