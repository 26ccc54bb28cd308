"""The simulator of Thymio's makers, without a screen: Debian's package `aseba` has it."""

from __future__ import annotations

import os
import queue
import signal
import socket
import subprocess
from collections.abc import Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import Any

from improv_core.outputs.thymio.bus import Bus, wire_to
from tests.needs import need
from tests.waiting import until

LIMIT = 60.0
"""Seconds to wait for a simulator on a busy machine, on which it is slower than real time."""


@contextmanager
def playground(folder: Path, robots: Mapping[str, tuple[float, float]]) -> Iterator[str]:
    """Run robots at these places, in centimeters in a room of 3 m. Yield the address of all: a switch, such as a radio
    dongle is. They are numbered from 1, and look to the right."""
    need("asebaplayground")
    ports = [free_port() for _ in robots]
    placed = "".join(
        f'<robot type="thymio2" x="{x}" y="{y}" angle="0" port="{port}" nodeId="{node}" name="{name}"/>'
        for (node, (name, (x, y))), port in zip(enumerate(robots.items(), 1), ports, strict=True)
    )
    world = '<color name="white" r="1" g="1" b="1"/><world w="300" h="300" color="white"/>'
    text = f"<!DOCTYPE aseba-playground>\n<aseba-playground>{world}{placed}</aseba-playground>"
    (folder / "world.playground").write_text(text, encoding="utf-8")
    env = {**os.environ, "QT_QPA_PLATFORM": "offscreen", "HOME": str(folder)}
    command = [need("xvfb-run"), "-a", need("asebaplayground"), "world.playground"]
    with running(command, cwd=folder, env=env), ExitStack() as stack:
        for port in ports:
            wait_for(port)
        yield stack.enter_context(switch(*ports))


@contextmanager
def running(command: Sequence[str], **options: Any) -> Iterator[None]:
    """Run a program, and end it and all that it has started."""
    nothing = subprocess.DEVNULL
    process = subprocess.Popen(command, stdout=nothing, stderr=nothing, start_new_session=True, **options)
    try:
        yield
    finally:
        os.killpg(process.pid, signal.SIGTERM)
        process.wait(LIMIT)


@contextmanager
def switch(*ports: int) -> Iterator[str]:
    """Run a switch that joins what listens on these ports. Yield its address."""
    at = free_port()
    targets = [f"tcp:127.0.0.1;{each}" for each in ports]
    with running([need("asebaswitch"), "-p", str(at), *targets]):
        wait_for(at)
        yield f"tcp:127.0.0.1:{at}"


def free_port() -> int:
    with socket.create_server(("127.0.0.1", 0)) as server:
        return int(server.getsockname()[1])


def wait_for(port: int) -> None:
    """Wait until something listens at a port, without a connection: the simulator crashes if that is closed at once."""
    listens = f":{port:04X} 00000000:0000 0A"  # proc_net_tcp(5)
    until(lambda: listens in Path("/proc/net/tcp").read_text(encoding="ascii"), lambda: "the simulator doesn't listen")


class Watch:
    """Another client, which receives what the program on a robot reports."""

    def __init__(self, address: str, node: int) -> None:
        self.heard: queue.SimpleQueue[Sequence[int]] = queue.SimpleQueue()
        self._bus = Bus(address, wire_to(address))
        self._bus.listen(self._bus.find("", node), self.heard.put)

    def until(self, moves: bool) -> None:
        """Wait for a new report that it moves, or stands."""
        while not self.heard.empty():
            self.heard.get()
        while any(self.heard.get(timeout=LIMIT)[4:6]) != moves:
            pass

    def close(self) -> None:
        self._bus.close()
