"""Hosts of a network inside this machine (Linux, root): each has its own network, shared memory, and name.

Without its own `/dev/shm`, DDS would pass messages between them through memory, and tests would prove nothing.
"""

from __future__ import annotations

import os
import subprocess
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path

import pytest

from tests.needs import need
from tests.ros.conftest import LIMIT

FIRST, SECOND = "10.77.1.2", "10.77.2.2"
"""Addresses of two hosts; on one link, they are in one subnet."""

_INSIDE = 'mount -t tmpfs tmpfs /dev/shm && hostname "$0" && exec "$@"'


@dataclass(frozen=True)
class Host:
    """A network namespace."""

    namespace: str
    name: str

    def command(self, *command: str) -> list[str]:
        """Return a command that runs this one on this host."""
        return [
            "ip",
            "netns",
            "exec",
            self.namespace,
            "unshare",
            "--uts",
            "--mount",
            "sh",
            "-c",
            _INSIDE,
            self.name,
            *command,
        ]

    def wrapper(self, program: str, folder: Path) -> str:
        """Write an executable file that runs a program on this host. Return its path."""
        path = folder / f"{self.name}-{Path(program).name}"
        words = " ".join(f"'{word}'" for word in self.command(program))
        path.write_text(f'#!/bin/sh\nexec {words} "$@"\n')
        path.chmod(0o755)
        return str(path)


@contextmanager
def on_one_link() -> Iterator[tuple[Host, Host]]:
    """Make two hosts joined by a cable, in one subnet."""
    with _hosts("one", "two") as (one, two):
        _cable(one, "eth0", two)
        for host, address in ((one, FIRST), (two, SECOND)):
            _join(host, "eth0", f"{address}/16")
            _ip(host, "route add 224.0.0.0/4 dev eth0")
        _await_carrier(one, two)
        yield one, two


@contextmanager
def behind_a_router() -> Iterator[tuple[Host, Host]]:
    """Make two hosts in two subnets with a router between them, which passes no multicast."""
    with _hosts("one", "two", "router") as (one, two, router):
        for host, end, address in ((one, "eth1", FIRST), (two, "eth2", SECOND)):
            _cable(host, end, router)
            gateway = address.removesuffix("2") + "1"
            _join(router, end, f"{gateway}/24")
            _join(host, "eth0", f"{address}/24")
            _ip(host, f"route add default via {gateway}")
        forward = ["ip", "netns", "exec", router.namespace, "sh", "-c", "echo 1 > /proc/sys/net/ipv4/ip_forward"]
        subprocess.run(forward, check=True)
        _await_carrier(one, two)
        yield one, two


@contextmanager
def _hosts(*names: str) -> Iterator[list[Host]]:
    need("ip")
    need("unshare")
    hosts = [Host(f"improv-{os.getpid()}-{name}", name) for name in names]
    try:
        for host in hosts:
            try:
                subprocess.run(["ip", "netns", "add", host.namespace], check=True, capture_output=True, text=True)
                subprocess.run(host.command("true"), check=True, capture_output=True, text=True)
            except subprocess.CalledProcessError as refused:
                pytest.skip(f"the kernel refuses network namespaces: {refused.stderr.strip()}")
            _ip(host, "link set lo up")
        yield hosts
    finally:
        for host in hosts:
            with suppress(subprocess.CalledProcessError):
                subprocess.run(["ip", "netns", "delete", host.namespace], check=True, capture_output=True)


def _cable(host: Host, end: str, other: Host) -> None:
    """Make a cable from eth0 of a host to another."""
    try:
        _ip(host, f"link add eth0 type veth peer name {end} netns", other.namespace)
    except subprocess.CalledProcessError as refused:
        pytest.skip(f"the kernel refuses veth pairs: exit code {refused.returncode}")


def set_link(host: Host, up: bool) -> None:
    """Unplug the cable of a host that is `on_one_link`, or plug it in."""
    _ip(host, f"link set eth0 {'up' if up else 'down'}")
    if up:
        _ip(host, "route replace 224.0.0.0/4 dev eth0")  # it was lost with the link


def _join(host: Host, end: str, address: str) -> None:
    _ip(host, f"addr add {address} dev {end}")
    _ip(host, f"link set {end} up")


def _await_carrier(*hosts: Host) -> None:
    """Wait until the kernel says that these hosts can send, up to a second after both ends of a cable are up.

    A process that starts before that announces 127.0.0.1 forever: Fast DDS looks for addresses once, and leaves out
    interfaces that aren't running (Fast-DDS#664).
    """
    end = time.monotonic() + LIMIT
    for host in hosts:
        show = ["ip", "-n", host.namespace, "-o", "link", "show", "eth0"]
        while " state UP " not in subprocess.run(show, check=True, capture_output=True, text=True).stdout:
            assert time.monotonic() < end, f"eth0 of {host.name} doesn't run"


def _ip(host: Host, words: str, *more: str) -> None:
    subprocess.run(["ip", "-n", host.namespace, *words.split(), *more], check=True)
