"""The stop sockets of stages: each stage listens on its own, and whoever stops robots asks all stages in parallel.

So a stop needs nobody's help, not even the session's. The sockets of a performance are files whose names begin with one
path, its `show`. A stage that dies leaves its socket there: it counts as one that has not answered, until another stage
has taken over its robots and listens in its place.
"""

from __future__ import annotations

import re
import zlib
from collections.abc import Collection, Iterable, Sequence
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING

from improv_core.safety.stop_request import StopRequest

if TYPE_CHECKING:  # `improv stop` needs neither
    from improv_core.protocol.commands import Stop
    from improv_core.protocol.messages import TransportMessage
    from improv_core.safety.stop_server import StopServer, Take

SUFFIX = ".stage"
"""The end of the names of these sockets."""
SIMULATOR, HERE = "simulator", "ros"
"""The names of two stages: the simulator's, and that of the real robots without a host. Others have their host's."""
LONGEST_NAME = 40
"""The most characters of a stage's name in that of its socket, whose path may have 107 bytes."""
OBEYED = "obeyed\n"
"""The answer of a stage, once its output has all zeros."""


def stop_stages(show: Path, stop: Stop, limit: float) -> Sequence[str] | None:
    """Have all stages of a performance stop, in parallel. Returns the names, for people, of those that have not obeyed
    within `limit` seconds although they move real robots, or of the simulator if there are no others. None if no stage
    can be asked like this."""
    found = sockets_of(show)
    with StopRequest(stop) as request:
        for path in found:
            request.ask(path)
        obeyed = [path for path, answer in request.answers(limit).items() if answer == OBEYED]
    return stages_not_stopped(map(stage_of, found), [stage_of(path) for path in obeyed]) if found else None


def stages_not_stopped(stages: Iterable[str], obeyed: Collection[str]) -> list[str]:
    """Return the names, for people, of those stages that have to obey before robots count as stopped, and have not."""
    asked = {*stages}
    real = asked - {SIMULATOR}
    here = "the stage here" if len(real) > 1 else "the real robots"
    names = {SIMULATOR: "the simulator", HERE: here}
    return [names.get(stage, stage) for stage in sorted((real or asked) - {*obeyed})]


def socket_of(show: Path, stage: str) -> Path:
    name = re.sub(r"[^\w@.:-]", "_", stage, flags=re.ASCII)[:LONGEST_NAME]
    return show.with_name(f"{show.name}.{name if name == stage else f'{name}~{zlib.crc32(stage.encode()):x}'}{SUFFIX}")


def stage_of(path: Path) -> str:
    """Return the name of the stage with this socket; of a long name, the beginning."""
    return path.name.removesuffix(SUFFIX).partition(".")[2].partition("~")[0]


def sockets_of(show: Path) -> list[Path]:
    """Return the sockets of a performance, also those of stages that have died."""
    with suppress(OSError):
        return sorted(show.parent.glob(f"{show.name}.*{SUFFIX}"))
    return []


def forget(show: Path, stage: str | None = None) -> None:
    """Remove the socket of a stage that has died and left no robot moving, or those of all stages."""
    for path in sockets_of(show) if stage is None else [socket_of(show, stage)]:
        with suppress(OSError):
            path.unlink(missing_ok=True)


class StageSocket:
    """The stop socket of a stage, on which `take` gets each stop, and answers `OBEYED` once the stage has obeyed it.

    If an earlier stage of this name has died, its robots may still move, and the new stage doesn't know them yet. So it
    listens only once it reports that it moves those robots or has stopped them. Raises OSError.
    """

    def __init__(self, show: Path, stage: str, take: Take) -> None:
        self._path = socket_of(show, stage)
        self._take = take
        self._server: StopServer | None = None
        if not self._path.exists():
            self._listen()

    def hear(self, message: TransportMessage) -> None:
        """Take a report of the stage: perhaps it moves the robots of a dead stage now."""
        if message["generation"] and message["state"] != "waiting" and self._server is None:
            with suppress(OSError, RuntimeError):  # it counts as one that has not answered
                self._listen()

    def _listen(self) -> None:
        from improv_core.safety.stop_server import StopServer

        self._server = StopServer(self._path, self._take)

    def close(self) -> None:
        """Stop listening: the robots stand, and nobody moves them any more."""
        if self._server:
            self._server.close()
