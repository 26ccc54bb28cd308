"""Lets `improv stop` reach everything that plays: each session listens on Unix sockets of its own, and each stage, too
(`stage_stops`).

The sockets are files in folders that only this user can enter. Nothing is reachable over a network. A terminal, an
editor, cron, and ssh may each name another runtime folder, or none. So each process also listens in a folder that no
environment variable names, and `improv stop` looks into all of them.

A process that is still starting has no socket yet. So `improv stop` first leaves a note there, which such a process
reads as soon as it listens.
"""

from __future__ import annotations

import os
import socket
import time
from collections import defaultdict
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from itertools import groupby
from pathlib import Path
from typing import TYPE_CHECKING

from improv_core.safety.private_folder import is_private, private_folder
from improv_core.safety.stage_stops import OBEYED, SIMULATOR, SUFFIX, stage_of, stages_not_stopped
from improv_core.safety.stop_request import StopRequest

if TYPE_CHECKING:  # `improv stop` needs none of them
    from improv_core.protocol.commands import Stop
    from improv_core.safety.stop_server import StopServer
    from improv_core.safety.stops import Stops

SUPPORTED = hasattr(socket, "AF_UNIX")
"""True if this system has Unix sockets."""
SHARED, RUNTIME = Path("/tmp"), Path("/run/user")
"""The folders that have a folder for each user. The environment doesn't name them, because it could hide what plays
from `improv stop`; tests replace them inside the asking process."""
IDLE = "nothing was playing"
"""The answer of a process that had nothing to stop."""
LIMIT = 2.0
"""Seconds to wait for a process that does not answer."""
NOTE = "stopped"
"""The file that has the latest `improv stop`: the machine's boot id, and the monotonic time."""
BOOT = Path("/proc/sys/kernel/random/boot_id")
"""The file from which Linux names the current boot: after the next one, its monotonic times mean nothing."""


class StopSocketError(Exception):
    """The sockets can't be used. The message is one line with the reason."""


class StopSocket:
    """Calls `stop` from a thread whenever `improv stop` asks for it, and answers with the line that `stop` returns. The
    stop has also gone straight to stages. Raises StopSocketError if `improv stop` might not find it."""

    def __init__(self, stop: Callable[[Stop], str]) -> None:
        from improv_core.safety.stop_server import StopServer

        self._stop = stop
        self._servers: list[StopServer] = []
        name = f"{_own_name()}.sock"
        folders = [fixed_folder()]  # without it, an `improv stop` with another environment would not find us
        with suppress(StopSocketError):
            user = os.getuid()
            folders += [folder for each in _runtime_folders(user) if (folder := private_folder(each, user))]
        for path in (folder / name for folder in dict.fromkeys(folders)):
            try:
                self._servers.append(StopServer(path, lambda stop, answer: answer(self._stop(stop))))
            except (OSError, RuntimeError) as error:
                if not self._servers:
                    raise StopSocketError(f"{path}: {getattr(error, 'strerror', None) or error}") from None

    def close(self) -> None:
        for server in self._servers:
            server.close()


def new_show() -> Path | None:
    """Return the path with which the names of the stop sockets of a performance's stages begin; None on Windows.

    Raises StopSocketError.
    """
    return fixed_folder() / _own_name() if SUPPORTED else None


def _own_name() -> str:
    """Return a new name that shows which process has the socket."""
    return f"{os.getpid()}-{os.urandom(4).hex()}"


def listening(stop: Callable[[Stop], str], stops: Stops, started: float) -> StopSocket | None:
    """Return a socket for as long as a process runs. If it can't be made, `stops` keep the reason.

    An `improv stop` since the process `started`, in monotonic seconds, counts as one that comes now.
    """
    if not SUPPORTED:
        return None
    with suppress(StopSocketError):  # an earlier process with our number may have been killed
        for path in fixed_folder().glob(f"{os.getpid()}-*{SUFFIX}"):
            path.unlink(missing_ok=True)
    try:
        made = StopSocket(stop)
    except StopSocketError as error:
        stops.unreachable = f"its socket can't be made: {error}"
        return None
    if stopped_since(started):  # only now: from here on, `improv stop` finds the socket
        stops.stop()
    return made


def stopped_since(started: float) -> bool:
    """Return whether somebody has run `improv stop` since a monotonic time."""
    for folder in _folders(os.getuid()):
        with suppress(OSError, ValueError):
            boot, at = (folder / NOTE).read_text().split()
            if boot == _boot() and started < float(at) <= time.monotonic():
                return True
    return False


def stop_all() -> Iterator[str]:
    """Stop everything of this user that plays; under sudo, also of the user who called it.

    Yields the answer of each process, or the reason why there was none. If its stages have not all obeyed, the line
    names those. Raises StopSocketError.
    """
    if not SUPPORTED:
        raise StopSocketError("this system has no Unix sockets")
    stop: Stop = {"type": "stop", "direct": f"improv-stop-{os.urandom(8).hex()}", "at": time.monotonic()}
    with StopRequest(stop) as request:
        # Ask all before the first answer is awaited: one process that hangs must not delay the others.
        sessions = dict[str, Path]()  # by name, since each has a socket in several folders
        stages, killed = defaultdict[str, list[Path]](list), defaultdict[str, list[Path]](list)  # by process
        for user in _users():
            with _acting_as(user):
                _leave_note(user)  # first: a process that listens from now on reads it, and the loop finds the others
                listens = {path: request.ask(path) for path in _sockets(user, SUFFIX)}
                for path in _sockets(user, ".sock"):
                    if path.name not in sessions and request.ask(path):
                        sessions[path.name] = path
                    elif path.name not in sessions:  # its process was killed
                        with suppress(OSError):
                            path.unlink(missing_ok=True)
                processes = {_process_of(path) for path in sessions.values()}
                for path, is_there in listens.items():
                    if is_there or _process_of(path) in processes:
                        stages[_process_of(path)].append(path)
                    else:  # its process and its session were killed
                        with suppress(OSError):  # it has just ended by itself
                            path.unlink()
                            killed[_process_of(path)].append(path)
        answers = request.answers(LIMIT)
    for path in sessions.values():
        process = _process_of(path)
        yield _line(process, answers.get(path, ""), stages.pop(process, []), answers)
    for process, own in stages.items():  # sessions without a socket: only their stages have answered
        yield _line(process, "", own, answers)
    for process, own in killed.items():  # perhaps nobody has stopped their robots
        if names := ", ".join(stages_not_stopped({*map(stage_of, own)} - {SIMULATOR}, ())):
            yield f"no answer from {names}: look at them, since process {process} and their stage were killed"


def _line(process: str, answer: str, stages: Sequence[Path], answers: Mapping[Path, str]) -> str:
    """Return the line about a process: its `answer` (perhaps empty) if the stages of its performances have obeyed."""
    late = list[str]()
    for _, found in groupby(stages, lambda path: path.name.partition(".")[0]):
        show = {path: stage_of(path) for path in found}
        late += stages_not_stopped(show.values(), [show[path] for path in show if answers.get(path) == OBEYED])
    if late:
        end = f" ({answer})" if answer else f", and end process {process} with `kill`"
        return f"no answer from {', '.join(late)}: look at them{end}"
    if answer or not stages:
        return answer or f"process {process} does not answer: end it with `kill`"
    return f"stopped the robots of process {process}, which does not answer: end it with `kill`"


def _process_of(path: Path) -> str:
    return path.name.partition("-")[0]


def fixed_folder() -> Path:
    """Return the folder of the sockets that depends on nothing but the user. Raises StopSocketError.

    If another user has taken its name, the folder has a random name, and its owner identifies it.
    """
    if not SUPPORTED:
        raise StopSocketError("this system has no Unix sockets")
    return _fixed_folder(os.getuid())


def _fixed_folder(user: int) -> Path:
    if (usual := private_folder(SHARED / f"improv-{user}", user)) is not None:
        return usual
    for folder in _random_folders(user):
        return folder
    own = SHARED / f"improv-{user}-{os.urandom(4).hex()}"
    try:
        own.mkdir(0o700)
    except OSError as error:
        raise StopSocketError(f"{SHARED}: {error.strerror or error}") from None
    return own


def _leave_note(user: int) -> None:
    with suppress(OSError, StopSocketError):
        note = _fixed_folder(user) / NOTE
        draft = note.with_suffix(f".{os.getpid()}")
        draft.write_text(f"{_boot()} {time.monotonic()}")
        draft.replace(note)


def _boot() -> str:
    """Return the id of the machine's boot, in one word."""
    with suppress(OSError):
        return BOOT.read_text().strip()
    return "unknown"


def _runtime_folders(user: int) -> Iterator[Path]:
    """Yield the folders that sessions have for sockets, which the system may remove while something plays."""
    if (given := os.environ.get("XDG_RUNTIME_DIR")) and user == os.getuid():
        yield Path(given, "improv")
    yield Path(RUNTIME, str(user), "improv")


def _random_folders(user: int) -> Iterator[Path]:
    return (folder for folder in sorted(SHARED.glob(f"improv-{user}-*")) if is_private(folder, user))


def _folders(user: int) -> Iterator[Path]:
    """Return all folders in which a user's sockets may be."""
    named = (*_runtime_folders(user), SHARED / f"improv-{user}", *_random_folders(user))
    return (folder for folder in dict.fromkeys(named) if is_private(folder, user))


def _sockets(user: int, suffix: str) -> Iterator[Path]:
    for folder in _folders(user):
        with suppress(OSError):
            yield from sorted(folder.glob(f"*{suffix}"))


def _users() -> Iterator[int]:
    """Yield the users whose dances to stop."""
    yield os.getuid()
    caller = os.environ.get("SUDO_UID", "")
    if os.getuid() == 0 and caller.isascii() and caller.isdigit() and 0 < int(caller) < 2**32 - 1:
        yield int(caller)


@contextmanager
def _acting_as(user: int) -> Iterator[None]:
    """Open another user's files with that user's rights, so nobody can trick root into opening something else."""
    before = os.geteuid()
    if user == before:
        yield
        return
    os.seteuid(user)
    try:
        yield
    finally:
        os.seteuid(before)
