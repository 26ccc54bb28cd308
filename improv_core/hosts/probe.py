"""Looks at another machine through the same connection that a stage there has, but starts none."""

from __future__ import annotations

import json
import time
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import dataclass, field
from typing import Any

from improv_core.hosts import texts
from improv_core.hosts.clock_offset import Estimated
from improv_core.hosts.clock_queries import OFTEN, Asking, asked, estimated, lag, told
from improv_core.hosts.connect import ConnectError, connect
from improv_core.hosts.frames import LONGEST_UP, UP, FrameError, Incoming, time_in
from improv_core.ipc.child import Child

LIMIT = 60.0
"""Seconds that the search for ROS 2 there may take."""


@dataclass(frozen=True, slots=True)
class SeenHost:
    """The description of a host (`far.described_here`), and the state of its clock."""

    holds: Mapping[str, Any]
    clock: Estimated
    lag: float


@dataclass
class _Look:
    asking: Asking
    holds: dict[str, Any] = field(default_factory=dict)


def look(host: str, *, domain: int | None = None, rmw: str | None = None, config: str | None = None) -> SeenHost:
    """Look at a host with this domain and this middleware. Raises ConnectError."""
    domains = [] if domain is None else ["--domain", str(domain)]
    middleware = ["--rmw", rmw] if rmw else []
    connection = connect(host, [*domains, *middleware, "--look"], config)
    try:
        return _looked(host, connection.ssh, connection.said)
    except FrameError as error:
        raise ConnectError(texts.strange(host, str(error))) from None
    finally:
        connection.ssh.close_input()
        connection.ssh.kill()
        connection.ssh.wait()


def _looked(host: str, ssh: Child, said: bytes) -> SeenHost:
    """Ask for the time until the clock and everything else is known."""
    incoming = Incoming(UP, LONGEST_UP)
    begun = due = time.monotonic()
    look = _Look(Asking(begun))
    while (now := time.monotonic()) < begun + LIMIT:
        _hear(host, look, incoming, said, now)
        look.asking = estimated(look.asking, now)
        if look.holds and look.asking.found:
            return SeenHost(look.holds, look.asking.found, lag(look.asking))
        if now >= due:
            due = now + OFTEN
            number = look.asking.number + 1
            look.asking = asked(look.asking, number, time.monotonic())
            with suppress(OSError):  # ssh has ended; then its output has, too
                ssh.write(b"c%d\n" % number)
        try:
            said = ssh.read_some(max(due - time.monotonic(), 0.0))
        except EOFError:
            ssh.wait()
            raise ConnectError(texts.of_ssh(host, [*ssh.errors])) from None
    raise ConnectError(texts.late(LIMIT))


def _hear(host: str, look: _Look, incoming: Incoming, said: bytes, now: float) -> None:
    for frame in incoming.take(said):
        if frame.letter == "c":
            look.asking = told(look.asking, time_in(frame.rest), now)
        elif frame.letter == "i":
            look.holds = _holds(frame.rest)
        elif frame.letter == "e":
            raise ConnectError(texts.of_far(host, frame.rest.decode(errors="replace")))


def _holds(rest: bytes) -> dict[str, Any]:
    with suppress(ValueError, RecursionError):
        holds = json.loads(rest)
        if isinstance(holds, dict) and isinstance(holds.get("python"), str):
            return holds
    raise FrameError("it describes itself in words that we don't know")
