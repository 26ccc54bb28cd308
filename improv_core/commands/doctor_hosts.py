"""Checks of `improv doctor --hosts` for other machines: what is installed there, and the errors of their clocks."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor

from improv_core.commands.finding import Finding, absent, broken, good
from improv_core.hosts.connect import ConnectError
from improv_core.hosts.probe import SeenHost, look
from improv_core.hosts.texts import of_far
from improv_core.robots.config import Robots
from improv_core.safety.allowed import HostError, approved
from improv_core.score.score import Host, is_host

GOOD_ERROR = 0.005
"""Seconds. A larger error of a clock lets robots be out of step with each other."""


def hosts_of(robots: Robots | None) -> list[Host]:
    """Return the hosts of these robots, or without robots, all that a person has allowed. Raises HostError."""
    if robots is None:
        return [Host(name) for name in approved() if is_host(name)]
    return [*dict.fromkeys(robot.host for robot in robots.robots.values() if robot.host and not robot.host.output)]


def examine_hosts(hosts: Sequence[Host], config: str | None = None) -> Iterator[Finding]:
    """Check all hosts at the same time. `config` is for ssh, for tests."""
    if not hosts:
        yield absent("no robot is on another machine", "`host` in improv.toml says so")
        return
    with ThreadPoolExecutor(len(hosts)) as pool:
        for host, seen in zip(hosts, pool.map(lambda host: _seen(host, config), hosts), strict=True):
            yield from findings(host, seen)


def findings(host: Host, seen: SeenHost | str) -> Iterator[Finding]:
    """Report the state of a host, or why it can't be reached."""
    if isinstance(seen, str):
        yield broken(host.name, seen)
        return
    holds, clock = seen.holds, seen.clock
    yield good(f"{host.name}: Python {holds['python']} on {holds.get('machine', 'a machine')}")
    if problem := holds.get("problem"):
        yield broken(f"{host.name}: no ROS 2", of_far(host.name, str(problem)))
    else:
        what = f"{holds.get('ros')} ({holds.get('ros_python')}): {holds.get('reach')}, {holds.get('rmw')} as RMW"
        yield good(f"{host.name}: {what}")
    apart = f"{abs(clock.offset):.3f} s {'ahead of' if clock.offset >= 0 else 'behind'}"
    known = f"its clock is {apart} ours, known to {1000 * clock.error:.1f} ms"
    takes = f"there and back in {1000 * clock.round_trip:.1f} ms at least, there in {1000 * seen.lag:.0f} ms at most"
    if clock.error > GOOD_ERROR:
        advice = "robots will be out of step by as much: bring it nearer to the access point, or use a cable"
        yield absent(f"{host.name}: {known}; {takes}", advice)
    else:
        yield good(f"{host.name}: {known}; {takes}")


def _seen(host: Host, config: str | None) -> SeenHost | str:
    try:
        return look(host.name, domain=host.domain, rmw=host.rmw, config=config)
    except (ConnectError, HostError) as error:
        return str(error)
