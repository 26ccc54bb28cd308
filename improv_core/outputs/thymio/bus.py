"""The robots at one address, over Aseba's binary protocol (aseba/common/msg/msg.h), versions 5 and later.

A message is its length, its source, and its type, each two bytes, least significant byte first; then its content.
The library thymiodirect speaks it, too, but takes the end of a TCP connection for silence and half a message for a
whole one, and so reports no robot that is gone.
"""

from __future__ import annotations

import os
import socket
import struct
import threading
import time
from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from typing import Any, Protocol

from improv_core.outputs.thymio.program import RobotMemory

VERSION = 5
DESCRIPTION, VARIABLE, EVENT, NATIVE = 0x9000, 0x9001, 0x9002, 0x9003
PRESENT, DEVICE_INFO = 0x900C, 0x900D
SET_BYTECODE, RUN, SET_VARIABLES = 0xA001, 0xA003, 0xA00C
DESCRIBE, LIST_NODES, GET_DEVICE_INFO = 0xA010, 0xA011, 0xA012
NAME = 2
"""The kind of information about a robot that is its name."""
CONNECT_LIMIT, ANSWER_LIMIT = 2.0, 10.0
"""Seconds for a connection, and for a robot to answer and to describe itself, which is slow over radio."""
ASK_PERIOD = 0.5
"""Seconds between two questions which robots are there."""
MAX_WORDS = 256
"""The most words of a program in one message."""

Report = Callable[[Sequence[int]], None]


class Wire(Protocol):
    """A connection: `recv` returns at least one byte, none after a while without any, and raises OSError at its end."""

    def recv(self) -> bytes: ...

    def send(self, data: bytes) -> None: ...

    def close(self) -> None: ...


@dataclass
class _Node:
    name: str = ""
    described: tuple[int, int, int] | None = None
    """The numbers of variables, events, and native functions that it has."""
    variables: dict[str, int] = field(default_factory=dict)
    free: int = 0
    events: list[str] = field(default_factory=list)
    natives: list[str] = field(default_factory=list)

    @property
    def is_known(self) -> bool:
        return self.described == (len(self.variables), len(self.events), len(self.natives))


class Bus:
    """The connection to an address, shared by the devices there. Threads may use it together."""

    _open: dict[str, Bus] = {}  # noqa: RUF012 - shared on purpose
    _opening = threading.Lock()

    def __init__(self, address: str, wire: Wire) -> None:
        self._address = address
        self._wire = wire
        self._changed = threading.Condition()
        self._sending = threading.Lock()
        self._nodes: dict[int, _Node] = {}
        self._reports: dict[int, Report] = {}
        self._users = 0
        self._problem = ""
        threading.Thread(target=self._read, daemon=True).start()

    @classmethod
    def join(cls, address: str) -> Bus:
        """Return the connection to an address, however it is spelled. Raises OSError."""
        place = _place(address)
        with cls._opening:
            bus = cls._open.get(place)
            if bus is None or bus._problem:
                bus = cls._open[place] = cls(address, wire_to(address))
            bus._users += 1
            return bus

    def leave(self) -> None:
        """Close the connection, unless another device uses it."""
        with self._opening:
            self._users -= 1
            if self._users == 0:
                self.close()
                for place in [each for each, bus in self._open.items() if bus is self]:
                    del self._open[place]

    def close(self) -> None:
        """Close the connection, whoever uses it."""
        self._problem = self._problem or "it was closed"
        self._wire.close()

    def check(self) -> None:
        """Raise OSError if the connection has ended."""
        if self._problem:
            raise OSError(self._problem)

    def find(self, name: str, number: int | None) -> int:
        """Return the number of the robot with this number or name, or of the only one. Raises OSError."""
        end = time.monotonic() + ANSWER_LIMIT
        while True:
            self._send(LIST_NODES, VERSION)
            with self._changed:
                self._changed.wait_for(lambda: number in self._nodes or self._problem, ASK_PERIOD)
                self.check()
                found = sorted(self._nodes)
                named = [each for each in found if self._nodes[each].name == name]
            if number is not None and number in found:
                return number
            if number is None and found and (named or len(found) == 1 or time.monotonic() > end):
                if len(found) == 1 or named:
                    return (named or found)[0]
                raise OSError(f"several Thymios are at {self._address}: add `node`, one of {_listed(found)}")
            if time.monotonic() > end:
                there = f"only {_listed(found)}" if found else "switch it on, and plug it in"
                raise OSError(f"no Thymio{'' if number is None else f' {number}'} is at {self._address}: {there}")

    def describe(self, number: int) -> RobotMemory:
        """Return the memory of a robot. Raises OSError if it doesn't tell."""
        with self._changed:
            before = self._nodes[number]
            node = self._nodes[number] = _Node(before.name)
        self._send(DESCRIBE, number, VERSION)
        with self._changed:
            self._changed.wait_for(lambda: node.is_known or self._problem, ANSWER_LIMIT)
            self.check()
            if not node.is_known:
                raise OSError(f"the Thymio {number} at {self._address} doesn't answer: switch it off and on")
            events = {name: 0xFFFE - index for index, name in enumerate(node.events)}
            natives = {name: index for index, name in enumerate(node.natives)}
            return RobotMemory(node.variables, node.free, events, natives)

    def listen(self, number: int, report: Report) -> None:
        """Have `report` get what a robot's program emits, on the thread that reads. Raises OSError if it is in use."""
        if self._reports.setdefault(number, report) != report:
            raise OSError(f"another robot here is the Thymio {number}, too: give each its own `node`")

    def run(self, number: int, words: Sequence[int]) -> None:
        """Have a robot run a program. Raises OSError."""
        for begin in range(0, len(words), MAX_WORDS):
            self._send(SET_BYTECODE, number, begin, *words[begin : begin + MAX_WORDS])
        self._send(RUN, number)

    def set(self, number: int, *values: tuple[int, Sequence[int]]) -> None:
        """Set variables of a robot, from these addresses on, in this order. Raises OSError."""
        self._write(b"".join(_message(SET_VARIABLES, number, address, *words) for address, words in values))

    def forget(self, number: int, report: Report) -> None:
        """Take no more reports of a robot, if they went to `report`."""
        if self._reports.get(number) == report:
            del self._reports[number]

    def _send(self, kind: int, *words: int) -> None:
        self._write(_message(kind, *words))

    def _write(self, data: bytes) -> None:
        self.check()
        try:
            with self._sending:
                self._wire.send(data)
        except OSError as error:
            self._lose(error)
            self.check()

    def _read(self) -> None:
        waiting = b""
        try:
            while not self._problem:
                waiting += self._wire.recv()
                while len(waiting) >= 6:
                    length, source, kind = struct.unpack_from("<HHH", waiting)
                    if len(waiting) < 6 + length:
                        break
                    content, waiting = waiting[6 : 6 + length], waiting[6 + length :]
                    self._take(source, kind, content)
        except Exception as error:  # whatever it is, a robot that nobody hears counts as lost
            self._lose(error)

    def _lose(self, why: Exception) -> None:
        with self._changed:
            reason = why.strerror if isinstance(why, OSError) and why.strerror else why
            self._problem = self._problem or f"the connection to {self._address} is lost ({reason})"
            self._changed.notify_all()

    def _take(self, source: int, kind: int, content: bytes) -> None:
        if kind == 0:
            if report := self._reports.get(source):
                report(struct.unpack(f"<{len(content) // 2}h", content))
            return
        with self._changed:
            if kind == PRESENT:
                if source not in self._nodes:
                    self._nodes[source] = _Node()
                    if struct.unpack_from("<H", content)[0] >= 6:
                        self._send(GET_DEVICE_INFO, source, NAME)
            elif node := self._nodes.get(source):
                if kind == DEVICE_INFO and content[0] == NAME:
                    node.name = _text(content[1:])
                elif kind == DESCRIPTION:
                    node.described = struct.unpack_from("<8xHHH", content[1 + content[0] :])
                elif kind == VARIABLE:
                    node.variables[_text(content[2:])] = node.free
                    node.free += struct.unpack_from("<H", content)[0]
                elif kind == EVENT:
                    node.events.append(_text(content))
                elif kind == NATIVE:
                    node.natives.append(_text(content))
            self._changed.notify_all()


class _Tcp:
    def __init__(self, host: str, port: int) -> None:
        self._socket = socket.create_connection((host, port), CONNECT_LIMIT)
        self._socket.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)

    def recv(self) -> bytes:
        try:
            data = self._socket.recv(4096)
        except TimeoutError:
            return b""
        if not data:
            raise OSError("it was closed there")
        return data

    def send(self, data: bytes) -> None:
        self._socket.sendall(data)

    def close(self) -> None:
        self._socket.close()


class _Serial:
    def __init__(self, port: str) -> None:
        try:
            import serial
        except ImportError:
            raise OSError("serial ports need pyserial: run `pip install 'improv-ls[thymio]'`") from None
        try:
            self._port: Any = serial.Serial(port, 115_200, timeout=0.5, write_timeout=0.5, exclusive=True)
        except OSError as error:
            if "lock" in str(error):
                raise OSError(f"another program uses {port}: end it") from None
            raise OSError(
                f"{port} can't be opened: plug the robot or its dongle in, and allow yourself to use it"
            ) from None

    def recv(self) -> bytes:
        try:
            data: bytes = self._port.read(max(self._port.in_waiting, 1))
        except OSError:  # of pyserial, whose words are about its own code
            raise OSError("it was unplugged") from None
        return data

    def send(self, data: bytes) -> None:
        self._port.write(data)

    def close(self) -> None:
        self._port.close()


def wire_to(address: str) -> Wire:
    """Connect to an address. Raises OSError."""
    kind, _, rest = address.partition(":")
    host, _, port = rest.rpartition(":")
    if kind == "serial":
        return _Serial(rest)
    if kind != "tcp" or not host or not port.isdigit() or not 0 < int(port) < 65_536:
        raise OSError("write the `address` of a Thymio as `serial:PORT` or `tcp:HOST:PORT`")
    try:
        return _Tcp(host, int(port))
    except OSError as error:
        raise OSError(f"nothing answers at {address} ({error.strerror or error})") from None


def _place(address: str) -> str:
    """Return the same text for all names of a port or a host."""
    kind, _, rest = address.partition(":")
    host, _, port = rest.rpartition(":")
    if kind == "serial":
        return f"serial:{os.path.realpath(rest)}"
    with suppress(OSError, UnicodeError):
        return f"tcp:{socket.gethostbyname(host)}:{port}"
    return address


def _message(kind: int, *words: int) -> bytes:
    return struct.pack(f"<HHH{len(words)}H", 2 * len(words), 0, kind, *(word & 0xFFFF for word in words))


def _text(content: bytes) -> str:
    return content[1 : 1 + content[0]].decode()


def _listed(numbers: Sequence[int]) -> str:
    return ", ".join(map(str, numbers))
