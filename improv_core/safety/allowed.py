"""The machines and robots that a person lets Improv reach. Standard library only.

A program's `improv.toml` names the host or the address of a robot, and may be a stranger's. So no host is contacted
with a person's keys, and no serial port or TCP address opened, until that person has allowed it once, in a file outside
all projects.
"""

from __future__ import annotations

import getpass
import os
import socket
from collections.abc import Sequence
from contextlib import suppress
from pathlib import Path

from improv_core import LineError
from improv_core.score.score import is_address, is_host


class HostError(LineError):
    """A host can't be used. The message is one line with the advice."""


def checked(host: str) -> str:
    """Return the host, if its name may reach ssh. Raises HostError."""
    if not is_host(host):
        raise HostError(f"`{host}` is not a host: write `name`, `user@name`, or `user@name:port`")
    return host


def split(host: str) -> tuple[str, str]:
    """Return a host without its port, and the port; empty if it has none."""
    name, _, port = host.partition(":")
    return name, port


def approved_file() -> Path:
    """Return the file with the hosts that a person has allowed."""
    config = os.environ.get("XDG_CONFIG_HOME", "")
    folder = Path(config) if Path(config).is_absolute() else Path.home() / ".config"
    return folder / "improv" / "hosts"


def approved() -> list[str]:
    """Return the hosts that a person has allowed, in the order of the file. Raises HostError if it can't be read."""
    try:
        lines = approved_file().read_text(encoding="utf-8", errors="replace").splitlines()
    except FileNotFoundError:
        return []
    except OSError as error:
        raise HostError(f"{approved_file()} can't be read: {error.strerror}") from None
    return list(dict.fromkeys(line for line in map(str.strip, lines) if line and not line.startswith("#")))


def is_approved(host: str) -> bool:
    """Return whether a person has allowed exactly this host. Raises HostError."""
    return host in approved()


def approve(host: str) -> None:
    """Remember that a person has allowed a host. Raises HostError."""
    if not is_address(host):
        checked(host)
    if not is_approved(host):
        _write([*approved(), host])


def withdraw(host: str) -> bool:
    """Forget that. Returns whether it was remembered. Raises HostError."""
    hosts = approved()
    if host not in hosts:
        return False
    _write([each for each in hosts if each != host])
    return True


def refusal(host: str) -> str:
    """Return the line about a program that needs a host that nobody has allowed."""
    return f"nobody has allowed Improv to use it: if you trust it, run `improv hosts allow {host}`"


def who(process: int) -> str:
    """Return the name of a parent on a host that two want to play on: `user@machine`, a slash, and the process."""
    user = "somebody"
    with suppress(KeyError, OSError, ImportError):
        user = getpass.getuser()
    return f"{user}@{socket.gethostname() or 'somewhere'}/{process}"


def _write(hosts: Sequence[str]) -> None:
    path = approved_file()
    new = path.with_name(f"{path.name}.{os.getpid()}")
    try:
        path.parent.mkdir(mode=0o700, parents=True, exist_ok=True)
        with os.fdopen(os.open(new, os.O_WRONLY | os.O_CREAT | os.O_TRUNC, 0o600), "w", encoding="utf-8") as file:
            file.writelines(f"{host}\n" for host in hosts)
        new.replace(path)
    except OSError as error:
        raise HostError(f"{path} can't be written: {error.strerror}") from None
