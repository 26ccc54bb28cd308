"""The ways from an output to its stage."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from improv_core.ipc.arrivals import Arrival
from improv_core.protocol.commands import PageRequest


@dataclass(frozen=True, slots=True)
class OutputChannel:
    """The functions that an output may call, on any thread.

    `hear` gets edges, poses, alarms, and anchors, and the end if the output can receive nothing more. `ask` gets the
    requests of people who use the output's own tools. `warn` gets lines for people.
    """

    hear: Callable[[Arrival], None]
    ask: Callable[[PageRequest], None]
    warn: Callable[[str], None]
