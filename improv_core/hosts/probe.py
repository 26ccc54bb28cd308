"""Looks at another machine, or sets up ROS 2 there, through the connection that a stage has. Starts no stage."""

from __future__ import annotations

import json
import time
from collections.abc import Callable, Mapping
from contextlib import suppress
from dataclasses import dataclass
from typing import Any

from improv_core.hosts import texts
from improv_core.hosts.clock_offset import Estimated
from improv_core.hosts.clock_queries import OFTEN, Asking, answered, asked, estimated, lag
from improv_core.hosts.connect import ConnectError, Connection, connect
from improv_core.hosts.frames import FrameError, time_in
from improv_core.outputs.ros.setup.proof import Proof
from improv_core.plain import message as in_plain_text

LIMIT = 60.0
"""Seconds that the search for ROS 2 there may take."""
DONE = b"done"
"""The last frame of a setup if all went well."""


@dataclass(frozen=True, slots=True)
class SeenHost:
    """The description of a host (`far.described_here`), and the state of its clock."""

    holds: Mapping[str, Any]
    clock: Estimated
    lag: float


def look(host: str, *, domain: int | None = None, rmw: str | None = None, config: str | None = None) -> SeenHost:
    """Look at a host with this domain and this middleware. Raises ConnectError."""
    domains = [] if domain is None else ["--domain", str(domain)]
    middleware = ["--rmw", rmw] if rmw else []
    connection = connect(host, [*domains, *middleware, "--look"], config)
    try:
        return _looked(connection)
    except FrameError as error:
        raise ConnectError(texts.strange(host, str(error))) from None
    finally:
        connection.ssh.close_input()
        connection.ssh.kill()
        connection.ssh.wait()


def _looked(connection: Connection) -> SeenHost:
    """Ask for the time until the clock and everything else is known."""
    begun = due = time.monotonic()
    asking, holds = Asking(begun), dict[str, Any]()
    while (now := time.monotonic()) < begun + LIMIT:
        asking = estimated(asking, now)
        if holds and asking.found:
            return SeenHost(holds, asking.found, lag(asking))
        if now >= due:
            due = now + OFTEN
            asking = asked(asking, asking.number + 1, time.monotonic())
            with suppress(OSError):  # ssh has ended; then its output has, too
                connection.ssh.write(b"c%d\n" % asking.number)
        for frame in connection.hear(max(due - time.monotonic(), 0.0)):
            if frame.letter == "c":
                asking = answered(asking, time_in(frame.rest), time.monotonic())
            elif frame.letter == "i":
                holds = _holds(frame.rest)
    raise ConnectError(texts.late(LIMIT))


def _holds(rest: bytes) -> dict[str, Any]:
    with suppress(ValueError, RecursionError):
        holds = json.loads(rest)
        if isinstance(holds, dict) and isinstance(holds.get("python"), str):
            return holds
    raise FrameError("it describes itself in words that we don't know")


def set_up_there(host: str, proof: Proof, say: Callable[[str], object], config: str | None = None) -> None:
    """Set up ROS 2 there, and `say` its lines. Raises ConnectError. The end of our process ends it there.

    `config` is of ssh, for tests.
    """
    connection = connect(host, ["--set-up", json.dumps([proof.topic, proof.score])], config)
    try:
        while True:
            for frame in connection.hear():
                if frame.letter == "t":
                    say(in_plain_text(frame.rest.decode(errors="replace")))
                elif frame.letter == "i" and frame.rest == DONE:
                    return
    finally:
        connection.ssh.end()
