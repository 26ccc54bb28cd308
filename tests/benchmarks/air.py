"""Machines on separate radio links, all on this machine (Linux, root): each has a network, a clock, and an sshd.

A link is a program that joins two network namespaces and delays, jitters, and drops packets. Its path is in
`IMPROV_LINK`, or it lies beside this repository.
"""

from __future__ import annotations

import os
import subprocess
import sys
import time
from collections.abc import Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager
from pathlib import Path

from tests.benchmarks.robots import ENV, LIMIT, PYTHON
from tests.hosts.sshd import client_config, server_config
from tests.ros.hosts import Host

LINK = Path(os.environ.get("IMPROV_LINK") or Path(__file__).parents[3] / "shared" / "tools" / "jitter_link.py")
BASE = "improv-air"
"""Namespace of the parent."""


class Machine:
    """A machine on a link. Its clock is `ahead` of ours by this many seconds, but only for processes that sshd starts
    there."""

    def __init__(self, number: int, folder: Path) -> None:
        self.number = number
        self.name = f"host{number}"
        self.namespace = f"{BASE}-{number}"
        self.address = f"10.9.{number}.2"
        self.ahead = 1000 * (number + 1)
        self._folder = folder / self.name
        self._folder.mkdir()

    @property
    def by(self) -> list[str]:
        """The command that runs another command in its network."""
        return entering(self.namespace)

    def serve(self, key: Path) -> subprocess.Popen[bytes]:
        """Start its sshd, which starts everything with the clock of the machine."""
        server = self._folder / "server"
        subprocess.run(["ssh-keygen", "-q", "-t", "ed25519", "-N", "", "-f", server], check=True)
        there = {
            "HOME": self._folder,
            "XDG_CACHE_HOME": self._folder / "cache",
            "PATH": f"{self._python()}:/usr/bin:/bin",
        }
        config = self._folder / "sshd_config"
        config.write_text(server_config(self.address, 22, server, key.with_suffix(".pub"), there))
        Path("/run/sshd").mkdir(mode=0o755, exist_ok=True)
        ahead = str(self.ahead)
        clock = ["unshare", "--time", "--monotonic", ahead, "--boottime", ahead, "--fork", "--kill-child"]
        return subprocess.Popen(
            [*self.by, *clock, "/usr/sbin/sshd", "-D", "-e", "-f", config], stderr=subprocess.DEVNULL
        )

    @property
    def known(self) -> str:
        """Line of known_hosts about it."""
        return f"{self.address} {' '.join((self._folder / 'server.pub').read_text().split()[:2])}\n"

    def config(self, key: Path, known: Path) -> str:
        """Return the ssh config about it."""
        return client_config(self.name, self.address, key, known)

    def _python(self) -> Path:
        """Make a folder with the Python there, which finds ROS."""
        folder = self._folder / "bin"
        folder.mkdir()
        script = folder / "python3"
        exports = "".join(f"export {name}={value}\n" for name, value in on_air(ENV).items() if name not in os.environ)
        runs = f'exec {sys.base_prefix}/bin/python3 "$@"'
        script.write_text(f"#!/bin/sh\nexport IMPROV_ROS_PYTHON={PYTHON}\n{exports}{runs}\n")
        script.chmod(0o755)
        return folder


def entering(namespace: str) -> list[str]:
    """Return the command that runs another command in a network, with its own shared memory."""
    return Host(namespace, namespace).command()


def on_air(env: Mapping[str, str]) -> dict[str, str]:
    """Return an environment in which DDS passes nothing through memory."""
    return {**env, "FASTDDS_BUILTIN_TRANSPORTS": "UDPv4", "ROS_AUTOMATIC_DISCOVERY_RANGE": "SUBNET"}


@contextmanager
def machines(count: int, folder: Path, link: Sequence[str]) -> Iterator[tuple[list[Machine], dict[str, str]]]:
    """Yield machines on links of this kind, and the environment in which a parent in `BASE` reaches them through
    ssh."""
    made = [Machine(number, folder) for number in range(count)]
    key, known, config = folder / "ours", folder / "known", folder / "ssh_config"
    subprocess.run(["ssh-keygen", "-q", "-t", "ed25519", "-N", "", "-f", key], check=True)
    with ExitStack() as stack:
        for each in made:
            ends = [BASE, f"10.9.{each.number}.1", each.namespace, each.address]
            joining = [sys.executable, str(LINK), *ends, *link, "--seed", str(each.number + 1)]
            process = subprocess.Popen(joining, stdin=subprocess.PIPE, stdout=subprocess.PIPE)
            stack.callback(_end, process)
            assert process.stdout
            if process.stdout.readline() != b"ready\n":
                raise RuntimeError(f"{LINK} has made no link: it needs Linux, root, and /dev/net/tun")
            server = each.serve(key)
            stack.callback(_kill, server)
        for each in made:
            _await(each)
        known.write_text("".join(each.known for each in made))
        config.write_text("".join(each.config(key, known) for each in made))
        programs = folder / "bin"
        programs.mkdir()
        (programs / "ssh").write_text(f'#!/bin/sh\nexec /usr/bin/ssh -F {config} "$@"\n')
        (programs / "ssh").chmod(0o755)
        allowed = folder / "config" / "improv" / "hosts"
        allowed.parent.mkdir(parents=True)
        allowed.write_text("".join(f"{each.name}\n" for each in made))
        paths = {"PATH": f"{programs}:{os.environ['PATH']}", "XDG_CONFIG_HOME": str(folder / "config")}
        yield made, {**ENV, **paths, "XDG_RUNTIME_DIR": str(folder)}


def _await(machine: Machine) -> None:
    """Wait until its sshd answers."""
    end = time.monotonic() + LIMIT
    ask = "import socket,sys; socket.create_connection((sys.argv[1], 22), 2).recv(4)"
    while subprocess.run(
        [*entering(BASE), sys.executable, "-c", ask, machine.address], stderr=subprocess.DEVNULL, check=False
    ).returncode:
        if time.monotonic() > end:
            raise RuntimeError(f"sshd on {machine.name} does not answer")


def _end(process: subprocess.Popen[bytes]) -> None:
    process.communicate(timeout=LIMIT)


def _kill(process: subprocess.Popen[bytes]) -> None:
    """Kill a process with SIGKILL: `unshare` ignores other signals while it waits for its child."""
    process.kill()
    process.wait(LIMIT)
