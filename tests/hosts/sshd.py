"""A machine that can be reached through ssh: this one, by a server of the test's own, which listens on 127.0.0.1 only.

It has keys, a home, and a cache of its own, and so has the ssh that reaches it. Nothing of the person who runs the
tests is used or changed.
"""

from __future__ import annotations

import getpass
import os
import shlex
import socket
import subprocess
import sys
import time
from collections.abc import Iterator, Mapping
from contextlib import contextmanager, suppress
from pathlib import Path

from improv_core.session.start import REMOTE
from tests.needs import lacking, need

NAME = "robot"
"""The name of the host here."""
LIMIT = 60.0
TRIES = 5
"""The ports to try: a free one may be taken before the server listens."""
SSHD = Path("/usr/sbin/sshd")


class Host:
    """The machine called `robot`; `there` are variables of its environment, which a test may change at any time."""

    def __init__(self, folder: Path, there: Mapping[str, str]) -> None:
        need("ssh")
        if not SSHD.exists():
            lacking("openssh-server is not installed")
        self.folder = folder
        self.cache = folder / "there" / "cache"
        self.config = folder / "ssh_config"
        self.authorized = folder / "authorized"
        self.known = folder / "known"
        self.home = folder / "there" / "home"
        self.bin = folder / "there" / "bin"
        for path in (self.home, self.bin, self.cache):
            path.mkdir(parents=True)
        self.install_python(there)
        self.make_key("server")
        self.make_key("ours")
        self.authorized.write_text((folder / "ours.pub").read_text())
        if os.getuid() == 0:
            Path("/run/sshd").mkdir(mode=0o755, exist_ok=True)  # where it wants to be if it runs as root
        self.server = self._started()

    @property
    def env(self) -> dict[str, str]:
        """The environment here: the person has allowed the host."""
        return {**os.environ, "XDG_CONFIG_HOME": str(self.folder / "here"), "IMPROV_HISTORY": "off"}

    def allow(self, *hosts: str) -> None:
        """As `improv hosts allow`."""
        path = self.folder / "here" / "improv" / "hosts"
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text("".join(f"{host}\n" for host in hosts))

    def command(self, *stage: str, host: str = NAME, by: str | None = None, domain: int | None = None) -> list[str]:
        """Return the command of a link, as a parent starts it, except for the configuration of ssh."""
        named = [*(["--from", by] if by else []), *([] if domain is None else ["--domain", str(domain)])]
        return [sys.executable, str(REMOTE), "near", host, "--ssh-config", str(self.config), *named, *stage]

    def install_python(self, there: Mapping[str, str]) -> None:
        lines = ["export PATH=/usr/bin:/bin"]
        lines += [f"export {name}={shlex.quote(value)}" for name, value in there.items()]
        self.install("python3", *lines, f'exec {shlex.quote(sys.executable)} "$@"')

    def run_first(self, code: str) -> None:
        """Have Python there run this code before its input."""
        whole = f"import sys\n{code}\nexec(open(0, 'rb', 0, closefd=False).readline())"
        self.install("python3", f"exec {shlex.quote(sys.executable)} -I -c {shlex.quote(whole)}")

    def install(self, name: str, *lines: str) -> None:
        """Install a script there that hides all other programs of this name."""
        script = self.bin / name
        script.write_text("\n".join(["#!/bin/sh", *lines, ""]))
        script.chmod(0o755)

    def make_key(self, name: str) -> None:
        for path in (self.folder / name, self.folder / f"{name}.pub"):
            path.unlink(missing_ok=True)
        command = ["ssh-keygen", "-q", "-t", "ed25519", "-N", "", "-C", name, "-f", str(self.folder / name)]
        subprocess.run(command, check=True)

    def trust(self) -> None:
        """As if a person had connected once and checked the key of the host."""
        kind, key, _ = (self.folder / "server.pub").read_text().split()
        self.known.write_text(f"[127.0.0.1]:{self.port} {kind} {key}\n")

    def relay(self) -> None:
        """Reach the host by relay.py, which a test may halt."""
        way = shlex.join([sys.executable, str(Path(__file__).with_name("relay.py")), "%h", "%p"])
        self.config.write_text(f"{self.config.read_text()}  ProxyCommand {way}\n")

    def versions(self) -> list[Path]:
        stages = self.cache / "improv" / "stages"
        return [path for path in stages.glob("*") if not path.name.startswith("taken-")]

    def close(self) -> None:
        self.server.terminate()
        self.server.wait(LIMIT)

    def _started(self) -> subprocess.Popen[bytes]:
        for _ in range(TRIES):
            self.port = _free_port()
            self.trust()
            self._write_configs()
            server = subprocess.Popen([SSHD, "-D", "-e", "-f", self.folder / "sshd_config"], stderr=subprocess.DEVNULL)
            end = time.monotonic() + LIMIT
            while server.poll() is None:  # nothing else shows that it listens
                assert time.monotonic() < end, "sshd does not listen"
                with suppress(OSError), socket.create_connection(("127.0.0.1", self.port), LIMIT) as connection:
                    if connection.recv(4) == b"SSH-":
                        return server
        raise AssertionError("sshd does not start")

    def _write_configs(self) -> None:
        there = {
            "HOME": self.home,
            "XDG_CACHE_HOME": self.cache,
            "XDG_DATA_HOME": self.home / "data",
            "PATH": self.bin,
        }
        config = server_config("127.0.0.1", self.port, self.folder / "server", self.authorized, there)
        (self.folder / "sshd_config").write_text(config)
        careless = {
            "Port": self.port,
            "StrictHostKeyChecking": "no",  # Improv must not be
            "ForwardAgent": "yes",
            "ControlMaster": "auto",
            "ControlPath": self.folder / "control",
            "RemoteCommand": "touch ran",
        }
        self.config.write_text(client_config(NAME, "127.0.0.1", self.folder / "ours", self.known, careless))


def server_config(address: str, port: int, key: Path, authorized: Path, there: Mapping[str, object]) -> str:
    """Return the configuration of a server whose programs get these variables."""
    lines = {
        "Port": port,
        "ListenAddress": address,
        "HostKey": key,
        "AuthorizedKeysFile": authorized,
        "PidFile": "none",
        "UsePAM": "no",
        "StrictModes": "no",
        "PasswordAuthentication": "no",
        "KbdInteractiveAuthentication": "no",
        "PermitRootLogin": "prohibit-password",
        "SetEnv": " ".join(f"{name}={value}" for name, value in there.items()),
    }
    return "".join(f"{name} {value}\n" for name, value in lines.items())


def client_config(name: str, address: str, key: Path, known: Path, others: Mapping[str, object] | None = None) -> str:
    """Return the configuration of ssh about a host, which uses nothing of the person's own."""
    lines = {
        "HostName": address,
        "User": getpass.getuser(),
        "IdentityFile": key,
        "IdentitiesOnly": "yes",
        "IdentityAgent": "none",
        "UserKnownHostsFile": known,
        "GlobalKnownHostsFile": "/dev/null",
        **(others or {}),
    }
    return f"Host {name}\n" + "".join(f"  {key} {value}\n" for key, value in lines.items())


@contextmanager
def a_host(folder: Path, there: Mapping[str, str]) -> Iterator[Host]:
    host = Host(folder, there)
    try:
        host.allow(NAME)
        yield host
    finally:
        host.close()


def _free_port() -> int:
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        return int(free.getsockname()[1])
