"""Connects to another machine through the system's ssh, with a person's keys and configuration and no more rights than
it takes to run one program there, and sends the far end if it isn't there yet."""

from __future__ import annotations

import json
import subprocess
import sys
import time
from collections.abc import Sequence
from contextlib import suppress
from typing import Any

from improv_core.hosts import texts
from improv_core.hosts.bundle import boot_line, bundle
from improv_core.hosts.frames import LONGEST_UP, UP, FrameError, Incoming, LinkFrame
from improv_core.ipc.child import Child, Policy
from improv_core.safety.allowed import HostError, checked, is_approved, refusal, split

BEGIN_LIMIT = 45.0
"""Seconds that the far end may take to begin, on a slow network."""
MAX_SAID = 65_536
"""The most bytes that the other machine's shell may print before our program does, such as a greeting."""
POLICY = Policy(2.0, errors=subprocess.PIPE)
"""ssh stays in our session, so that it ends with us, even if we are killed."""
THERE = """exec python3 -I -c "exec(open(0,'rb',0,closefd=False).readline())\""""
"""The command that runs on any host: it reads the rest as its first line. All usual shells understand it alike."""
CONNECT_LIMIT = 10
"""The most seconds in which a connection is made."""
OPTIONS = {
    "BatchMode": "yes",  # never ask for a password
    "StrictHostKeyChecking": "yes",  # nor accept an unknown key, whatever the person's configuration says
    "ForwardAgent": "no",
    "ForwardX11": "no",
    "ClearAllForwardings": "yes",
    "Tunnel": "no",
    "PermitLocalCommand": "no",
    "RemoteCommand": "none",
    "ControlMaster": "no",  # a connection of its own: in a shared one, a stop could wait behind somebody's copy
    "ControlPath": "none",
    "ConnectTimeout": str(CONNECT_LIMIT),
    "ServerAliveInterval": "5",
    "ServerAliveCountMax": "4",
    "IPQoS": "af21",  # otherwise OpenSSH marks it as bulk, which Wi-Fi sends after everything else
    "Compression": "no",
}


class ConnectError(Exception):
    """There is no far end. The message is one line with the advice."""


class Connection:
    """ssh, connected to the far end on a host, and what that has sent so far."""

    def __init__(self, host: str, ssh: Child, said: bytes) -> None:
        self.host, self.ssh, self.said = host, ssh, said
        self._incoming = Incoming(UP, LONGEST_UP)

    def hear(self, limit: float | None = None) -> list[LinkFrame]:
        """Return the next frames; perhaps none, after `limit` seconds. Raises ConnectError if the far end ends."""
        try:
            said, self.said = self.said or self.ssh.read_some(limit), b""
            frames = self._incoming.take(said)
        except EOFError:
            self.ssh.wait()
            raise ConnectError(texts.of_ssh(self.host, [*self.ssh.errors])) from None
        except FrameError as error:
            raise ConnectError(texts.strange(self.host, str(error))) from None
        for frame in frames:
            if frame.letter == "e":
                raise ConnectError(texts.of_far(self.host, frame.rest.decode(errors="replace")))
        return frames


def connect(host: str, arguments: Sequence[str], config: str | None = None) -> Connection:
    """Connect, with these arguments for the far end. Raises ConnectError."""
    if sys.platform == "win32":
        raise ConnectError("robots on other machines can't be moved from Windows: use Linux, macOS, or WSL")
    try:
        ssh = Child(ssh_command(host, config), POLICY)
    except HostError as error:
        raise ConnectError(str(error)) from None
    except OSError as error:
        raise ConnectError(f"ssh can't be started: {str(error.strerror).lower()}") from None
    try:
        return _begun(host, ssh, arguments)
    except BaseException:
        ssh.kill()
        ssh.wait()
        raise


def ssh_command(host: str, config: str | None = None) -> list[str]:
    """Return the command that connects; tests pass a `config`. Raises HostError, also for hosts that nobody allowed."""
    if not is_approved(checked(host)):
        raise HostError(refusal(host))
    name, port = split(host)
    own = ["-F", config] if config else []
    ports = ["-p", port] if port else []
    options: Sequence[str] = [word for key, value in OPTIONS.items() for word in ("-o", f"{key}={value}")]
    return ["ssh", "-T", *own, *ports, *options, "--", name, THERE]


def _begun(host: str, ssh: Child, arguments: Sequence[str]) -> Connection:
    carried = bundle()
    unread, length = b"", 0
    end = time.monotonic() + BEGIN_LIMIT
    with suppress(OSError):  # ssh has ended; then its output has, too
        ssh.write(boot_line(carried, arguments))
    while True:
        try:
            data = ssh.read_some(end - time.monotonic())
        except EOFError:
            ssh.wait()
            raise ConnectError(texts.of_ssh(host, [*ssh.errors])) from None
        if not data:
            raise ConnectError(texts.late(BEGIN_LIMIT))
        *lines, unread = (unread + data).split(b"\n")
        for at, line in enumerate(lines):
            said = _fields_in(line)
            if "problem" in said:
                raise ConnectError(texts.of_bootstrap(said))
            if said.get("wants") is True:
                with suppress(OSError):
                    ssh.write(carried.data)
            if said.get("begins") is True:
                return Connection(host, ssh, b"\n".join([*lines[at + 1 :], unread]))
        length += len(data)
        if length > MAX_SAID:
            raise ConnectError(texts.strange(host, "it prints much that is none of ours"))


def _fields_in(line: bytes) -> dict[str, Any]:
    """Return the fields of a line from the bootstrap; empty for any other line."""
    if line.startswith(b"improv "):
        with suppress(ValueError, RecursionError):
            fields = json.loads(line[len(b"improv ") :])
            if isinstance(fields, dict):
                return fields
    return {}
