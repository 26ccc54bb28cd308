"""The command that connects two machines: the system's ssh, with a person's keys and configuration, and no more rights
than it takes to run one program there."""

from __future__ import annotations

from collections.abc import Sequence

from improv_core.safety.allowed import HostError, checked, is_approved, refusal, split

THERE = """exec python3 -I -c "exec(open(0,'rb',0,closefd=False).readline())\""""
"""The command that runs on any host: it reads the rest as its first line. All usual shells understand it alike."""
CONNECT_LIMIT = 10
"""Seconds that connecting may take."""
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


def ssh_command(host: str, config: str | None = None) -> list[str]:
    """Return the command that connects. `config` replaces the person's own, for tests. Raises HostError, also for a
    host that nobody has allowed."""
    if not is_approved(checked(host)):
        raise HostError(refusal(host))
    name, port = split(host)
    own = ["-F", config] if config else []
    ports = ["-p", port] if port else []
    options: Sequence[str] = [word for key, value in OPTIONS.items() for word in ("-o", f"{key}={value}")]
    return ["ssh", "-T", *own, *ports, *options, "--", name, THERE]
