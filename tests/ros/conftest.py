"""A private ROS 2 for tests: its interpreter, its own environment, and real subscribers."""

from __future__ import annotations

import fcntl
import json
import math
import os
import queue
import random
import subprocess
import tempfile
import threading
import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import ExitStack, contextmanager, suppress
from itertools import count, islice
from pathlib import Path
from typing import Any

import pytest

import improv_core
from improv_core.outputs.ros.nodes import OURS, PROFILES
from improv_core.safety import heartbeat
from tests.needs import lacking

LIMIT = 60.0
"""Seconds to wait for an event: discovery alone may take several on a busy machine."""

DRIVER = Path(__file__).parent / "driver.py"
SITE = Path(__file__).parent / "site"
BASE = Path(__file__).parent / "base.py"
OTHERS = Path(__file__).parent / "others.py"
OWN = Path(__file__).parents[2] / ".cache" / "ros" / "bin" / "python"
Fields = dict[str, Any]


class Others:
    """A process with other nodes of ROS; others.py lists their kinds."""

    def __init__(self, python: str, env: Mapping[str, str]) -> None:
        self._numbers = count()
        self._inboxes: dict[int, Callable[[Fields], None]] = {}
        self._done: queue.SimpleQueue[bool] = queue.SimpleQueue()
        self.process = subprocess.Popen([python, OTHERS], env=env, stdin=subprocess.PIPE, stdout=subprocess.PIPE)
        threading.Thread(target=self._read, daemon=True).start()

    @property
    def pid(self) -> int:
        return self.process.pid

    def make(self, what: str, take: Callable[[Fields], None], **options: Any) -> int:
        """Make a node, and return its number. `take` gets its messages."""
        number = next(self._numbers)
        self._inboxes[number] = take
        self.tell(number, what, **options)
        return number

    def tell(self, number: int, what: str, **options: Any) -> None:
        """Send a node a command, and wait until it has obeyed."""
        assert self.process.stdin
        self.process.stdin.write(json.dumps([number, what, options]).encode() + b"\n")
        self.process.stdin.flush()
        assert self._done.get(timeout=LIMIT), "it has ended"

    def end(self, number: int) -> None:
        """End a node, which may have ended before."""
        if number in self._inboxes and self.process.poll() is None:
            self.tell(number, "close")
            del self._inboxes[number]

    def leave(self, domain: int) -> None:
        """Have every node in a domain leave."""
        self.tell(-1, "leave", domain=domain)

    def kill(self) -> None:
        """Kill all of them, so that they vanish silently."""
        self.process.kill()
        self.process.wait(LIMIT)

    def close(self) -> None:
        """Have all of them leave."""
        assert self.process.stdin
        self.process.stdin.close()
        try:
            self.process.wait(LIMIT)
        finally:
            self.process.kill()

    def _read(self) -> None:
        assert self.process.stdout
        for line in self.process.stdout:
            number, what = json.loads(line)
            if "done" in what:
                self._done.put(True)
            elif take := self._inboxes.get(number):
                take(what)
        self._done.put(False)


class Listener:
    """A subscriber among the other nodes, and its messages: dicts of topic, at, x, y, z, yaw."""

    def __init__(
        self,
        others: Others,
        *topics: str,
        type: str = "geometry_msgs/Twist",
        name: str = "",
        domain: int | None = None,
        **options: Any,
    ) -> None:
        self.heard: list[Fields] = []
        self._others = others
        self._publishers = 0
        self._changed = threading.Condition()
        self._inbox: queue.SimpleQueue[Fields] = queue.SimpleQueue()
        kind = type.rpartition("/")[2]
        options |= {"topics": topics, "type": type, "domain": domain}
        self._number = others.make("listener", self._take, name=name or NAMES.get(kind, kind.lower()), **options)

    def wait(self, fits: Callable[[Fields], bool]) -> Fields:
        """Wait for the next message that fits, which may have come before this call, and return it."""
        end = time.monotonic() + LIMIT
        while True:
            try:
                message = self._inbox.get(timeout=max(end - time.monotonic(), 0))
            except queue.Empty:
                raise AssertionError(f"not heard within {LIMIT} s; heard {self.heard[-5:]}") from None
            self.heard.append(message)
            if fits(message):
                return message

    def hear_all(self) -> None:
        """Put all messages up to now into `heard`."""
        while not self._inbox.empty():
            self.heard.append(self._inbox.get())

    def wait_for_publishers(self, fits: Callable[[int], bool]) -> None:
        """Wait until the number of publishers that it has found on its topics fits."""
        with self._changed:
            assert self._changed.wait_for(lambda: fits(self._publishers), LIMIT)

    def close(self) -> None:
        """End it unless it has already ended; `heard` then has all messages."""
        self._others.end(self._number)
        self.hear_all()

    def _take(self, message: Fields) -> None:
        if "publishers" in message:
            with self._changed:
                self._publishers = message["publishers"]
                self._changed.notify_all()
        else:
            self._inbox.put(message)


NAMES = {"Twist": "listener"}
"""The nodes of listeners that aren't named for their types: a node can't have two types on one topic."""


class Publisher:
    """A publisher of fields, nested ones with dots, which repeats them until others come, or once. None is silence."""

    def __init__(
        self,
        others: Others,
        topic: str,
        type: str,
        *,
        hz: float = 20,
        name: str = "publisher",
        domain: int | None = None,
        **options: Any,
    ) -> None:
        self._others = others
        options |= {"topic": topic, "type": type, "hz": hz, "name": name, "domain": domain}
        self._number = others.make("publisher", lambda what: None, **options)

    def __call__(self, fields: Fields | None, *, once: bool = False) -> None:
        self._others.tell(self._number, "publish", fields=fields, once=once)

    def close(self) -> None:
        self._others.end(self._number)


class Sink:
    """The sink in its own process: `sink("missing")` calls the method and returns its answer."""

    def __init__(self, python: str, env: Mapping[str, str], *arguments: str) -> None:
        self.process = subprocess.Popen(
            [python, DRIVER, *arguments], env=env, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
        )
        self.description = self._answer()

    def __call__(self, method: str, *arguments: Any, **named: Any) -> Any:
        assert self.process.stdin
        self.process.stdin.write(json.dumps([method, arguments, named]) + "\n")
        self.process.stdin.flush()
        return self._answer()

    def repeat(self, listener: Listener, method: str, *arguments: Any) -> None:
        """Repeat this call, as the player does, until the listener hears a message."""
        end = time.monotonic() + LIMIT
        while not listener.heard:
            assert time.monotonic() < end
            self(method, *arguments)
            listener.hear_all()

    def close(self) -> None:
        self.process.communicate(timeout=LIMIT)

    def _answer(self) -> Any:
        assert self.process.stdout
        is_done, value = json.loads(self.process.stdout.readline())
        assert is_done, value
        return value


SHORT_LEASE = {PROFILES: str(Path(__file__).with_name("short_lease.xml"))}
"""Settings with which a killed node's lease, and so its place in the graph, ends after 2 s instead of 20 s."""
Listen = Callable[..., Listener]
Publish = Callable[..., Publisher]
Start = Callable[..., Sink]

PATIENT = {
    "protocol.limits.HANG_LIMIT": 20.0,
    "protocol.limits.SILENCE_LIMIT": 20.0,
    "outputs.ros.subscriber_check.ANSWER_LIMIT": 20.0,
    "outputs.ros.standby.client.ANSWER_LIMIT": 20.0,
    "outputs.ros.standby.process.LOOK": 1.0,
    "outputs.ros.standby.client.START_LIMIT": LIMIT,
    "outputs.ros.standby.client.READY_LIMIT": LIMIT,
    "player.decide.LATE": 20.0,
    "safety.fault_rules.LATE": 20.0,
    "outputs.ros.standby.client.FIND_LIMIT": 20.0,
    "outputs.ros.reset.LIMIT": 20.0,
    "outputs.ros.sensors.client.START_LIMIT": LIMIT,
    "outputs.ros.sensors.client.SILENT_LIMIT": 20.0,
    "outputs.ros.sensors.client.ALIVE_LIMIT": 20.0,
    "outputs.ros.setup.interpreter.PROBE_LIMIT": LIMIT,
    "safety.heartbeat.HARMLESS_HANG_LIMIT": 20.0,
}
"""Limits with which our processes don't count as failed on a busy machine, and beat 0 waits for the standby."""


def with_limits(**limits: float) -> dict[str, str]:
    """Return variables that set these limits for our processes, else patient ones: `player__decide__LATE=1`."""
    named = {name.replace("__", "."): limit for name, limit in limits.items()}
    for name in named.keys() | PATIENT.keys():
        module, _, limit = name.rpartition(".")
        source = Path(improv_core.__file__).parent.joinpath(*module.split(".")).with_suffix(".py")
        assert f"\n{limit} = " in source.read_text(encoding="utf-8"), f"there is no {name}"
    return {"IMPROV_TEST_LIMITS": json.dumps(PATIENT | named), "PYTHONPATH": str(SITE)}


def be_patient(monkeypatch: pytest.MonkeyPatch) -> None:
    """Set patient limits for stages of a playback in this process, for which no variable sets limits."""
    monkeypatch.setattr(heartbeat, "HANG_LIMIT", LIMIT)
    monkeypatch.setattr(heartbeat, "HARMLESS_HANG_LIMIT", LIMIT)


def let_stages_be_late(monkeypatch: pytest.MonkeyPatch) -> None:
    """Be patient, and set patient limits for all processes that this one starts."""
    be_patient(monkeypatch)
    monkeypatch.setenv("IMPROV_TEST_LIMITS", with_limits()["IMPROV_TEST_LIMITS"])
    monkeypatch.setenv("PYTHONPATH", str(SITE), prepend=os.pathsep)


def with_code(code: str) -> dict[str, str]:
    """Return variables that make every Python run this code first."""
    return {"IMPROV_TEST_CODE": code, "PYTHONPATH": str(SITE)}


NOISE = """\
try:
    import os, rclpy.node
except ImportError:
    pass
else:
    make = rclpy.node.Node.__init__
    def print_and_make(*arguments, **named):
        os.write(1, b"a line\\nno line end")
        make(*arguments, **named)
    rclpy.node.Node.__init__ = print_and_make
"""
"""Code that prints a text for each node, as a library could."""


_domains = count(random.SystemRandom().randrange(100))


@contextmanager
def a_domain() -> Iterator[int]:
    """Reserve a domain that no other worker and no other run on this machine uses."""
    for number in islice(_domains, 100):
        # The domains that are safe beside Linux's ephemeral ports end at 101, in which nobody listens.
        domain = 1 + number % 100
        with ExitStack() as stack, suppress(BlockingIOError, PermissionError):
            file = stack.enter_context(Path(tempfile.gettempdir(), f"improv-tests-domain-{domain}").open("w"))
            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
            yield domain
            return
    raise AssertionError("all domains are taken")


@pytest.fixture(scope="session")
def ros_python() -> str:
    """Return the path of a Python that imports rclpy."""
    python = os.environ.get("IMPROV_ROS_PYTHON") or (str(OWN) if OWN.exists() else "")
    if not python:
        lacking("no ROS 2: run `sh tests/ros/fetch.sh`, or set IMPROV_ROS_PYTHON to a Python with rclpy")
    return python


@pytest.fixture(scope="session")
def ros_env(ros_python: str) -> Iterator[dict[str, str]]:
    """Return an environment in which our server finds ROS 2 on this machine only, in this worker's own domain."""
    with a_domain() as domain:
        yield {
            **os.environ,
            **with_limits(),
            "IMPROV_ROS_PYTHON": ros_python,
            "ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST",
            "ROS_DOMAIN_ID": str(domain),
            PROFILES: str(OURS),
        }


@pytest.fixture(scope="session")
def others(ros_python: str, ros_env: Mapping[str, str]) -> Iterator[Others]:
    """One process for all listeners and publishers; a test that kills some starts another."""
    others = Others(ros_python, ros_env)
    yield others
    others.close()


@pytest.fixture
def alone(ros_env: Mapping[str, str], others: Others) -> Iterator[dict[str, str]]:
    """The environment with this test's own domain: it kills or halts a process of ROS, which stays in the graph for a
    while."""
    with a_domain() as domain:
        yield {**ros_env, "ROS_DOMAIN_ID": str(domain)}
        others.leave(domain)


@pytest.fixture
def fragile(ros_python: str, alone: Mapping[str, str]) -> Iterator[Others]:
    """Other nodes that the test kills."""
    others = Others(ros_python, {**alone, **SHORT_LEASE})
    yield others
    others.kill()


@pytest.fixture
def where(request: pytest.FixtureRequest) -> int | None:
    """The domain of this test's listeners and publishers: its own, if it has one."""
    if "alone" in request.fixturenames:
        return int(request.getfixturevalue("alone")["ROS_DOMAIN_ID"])
    return None


@pytest.fixture
def listen(others: Others, where: int | None) -> Iterator[Listen]:
    """Start listeners: `listen("/r/cmd_vel", type=STAMPED)`; others.py has their options."""
    with ExitStack() as stack:

        def start(*topics: str, **options: Any) -> Listener:
            listener = Listener(others, *topics, domain=where, **options)
            stack.callback(listener.close)
            return listener

        yield start


@pytest.fixture
def publish(others: Others, where: int | None) -> Iterator[Publish]:
    """Start publishers: `publish("/e_stop", "std_msgs/Bool", best_effort=True)`."""
    with ExitStack() as stack:

        def start(topic: str, type: str, **options: Any) -> Publisher:
            publisher = Publisher(others, topic, type, domain=where, **options)
            stack.callback(publisher.close)
            return publisher

        yield start


@pytest.fixture(scope="session")
def driver(ros_python: str, ros_env: Mapping[str, str]) -> Iterator[Sink]:
    driver = Sink(ros_python, ros_env)
    driver("leave")
    yield driver
    driver.close()


@pytest.fixture
def sink(driver: Sink) -> Iterator[Sink]:
    """A new sink, in a process that already runs."""
    driver.description = driver("renew")
    yield driver
    driver("leave")


@pytest.fixture
def start(ros_python: str, alone: Mapping[str, str]) -> Iterator[Start]:
    """Start sinks in their own processes, with variables that differ from the environment of all tests."""
    with ExitStack() as stack:

        def begin(*arguments: str, **variables: str) -> Sink:
            sink = Sink(ros_python, {**alone, **variables}, *arguments)
            stack.callback(sink.close)
            return sink

        yield begin


STAMPED = "geometry_msgs/TwistStamped"
SCAN = {"angle_min": -math.pi, "angle_max": math.pi, "angle_increment": math.pi / 180, "range_min": 0.1}
SCAN |= {"range_max": 10.0}


def scan(ahead: float) -> Fields:
    """Return a scan with an obstacle straight ahead, and no other."""
    return {**SCAN, "ranges": [math.inf] * 175 + [ahead] * 10 + [math.inf] * 175}


Script = Callable[..., "subprocess.Popen[str]"]


@pytest.fixture
def script(ros_python: str, ros_env: dict[str, str]) -> Iterator[Script]:
    """Start scripts in ROS's interpreter. Each is ready when it prints a line, and ends when its input does."""
    started: list[subprocess.Popen[str]] = []

    def start(path: Path, *arguments: str, **variables: str) -> subprocess.Popen[str]:
        pipe, env = subprocess.PIPE, {**ros_env, **variables}
        process = subprocess.Popen([ros_python, path, *arguments], env=env, stdin=pipe, stdout=pipe, text=True)
        started.append(process)
        assert process.stdout
        process.stdout.readline()
        return process

    yield start
    for process in started:
        process.communicate(timeout=LIMIT)
