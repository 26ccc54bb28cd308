"""One robot's own host: a network namespace with a cable to this machine's (Linux, root)."""

from __future__ import annotations

import os
import subprocess
from collections.abc import Iterator, Sequence
from contextlib import contextmanager

_INSIDE = 'mount -t tmpfs tmpfs /dev/shm && exec "$@"'  # otherwise DDS would pass messages through memory


class Apart:
    """A namespace at the end of a cable."""

    def __init__(self) -> None:
        self._namespace = f"improv-apart-{os.getpid()}"
        self._here = f"iap{os.getpid()}"

    def command(self, command: Sequence[str]) -> list[str]:
        """Return a command that runs this one on that host."""
        inside = ["unshare", "--mount", "sh", "-c", _INSIDE, "sh"]
        return ["ip", "netns", "exec", self._namespace, *inside, *command]

    def set_radio(self, works: bool) -> None:
        """Lose all packets on the cable, or none. Neither end notices."""
        change = "del dev {} root" if works else "add dev {} root blackhole"
        for inside, end in ((["-n", self._namespace], "eth0"), ([], self._here)):
            subprocess.run(["tc", *inside, "qdisc", *change.format(end).split()], check=True)

    def open(self) -> None:
        """Make it. Raise CalledProcessError if the kernel or its permissions refuse that."""
        _ip(f"netns add {self._namespace}")
        _ip(f"link add {self._here} type veth peer name eth0 netns {self._namespace}")
        _ip(f"addr add 10.78.0.1/24 dev {self._here}")
        _ip(f"link set {self._here} up")
        for change in ("link set lo up", "addr add 10.78.0.2/24 dev eth0", "link set eth0 up"):
            _ip(f"-n {self._namespace} {change}")
        _ip(f"-n {self._namespace} route add 224.0.0.0/4 dev eth0")

    def close(self) -> None:
        subprocess.run(["ip", "netns", "delete", self._namespace], check=False, capture_output=True)
        subprocess.run(["ip", "link", "delete", self._here], check=False, capture_output=True)


@contextmanager
def apart() -> Iterator[Apart]:
    """Make a robot's own host, and remove it on exit."""
    host = Apart()
    try:
        host.open()
        yield host
    finally:
        host.close()


def _ip(words: str) -> None:
    subprocess.run(["ip", *words.split()], check=True)
