"""Robots on another host: two network namespaces with real DDS between them."""

from __future__ import annotations

import subprocess
import sys
import threading
import time
from collections.abc import Iterator, Mapping
from contextlib import ExitStack, contextmanager
from pathlib import Path

import pytest

from improv_core.outputs.ros.nodes import TRANSPORTS
from tests.processes import lines_until
from tests.ros.conftest import LIMIT, Listener, Others, Publisher
from tests.ros.hosts import FIRST, SECOND, Host, behind_a_router, on_one_link, set_link

pytestmark = pytest.mark.slow("hosts of a network find each other")

TOML = '[ros]\nstop = "/e_stop"\n[robots.r]\nprofile = "turtlesim"\n'
PROGRAM = "r $ repeat forward\n"
SERVER = f"{FIRST}:11811"
HEARD = " listens for Twist on /r/cmd_vel"
DEAF = (
    "– r: an unnamed node listens for Twist on /r/cmd_vel: look again, and if it stays unnamed, "
    "restart it, because it started before its network was up and hears nothing"
)
UNHEARD = "– r: nothing is listening on /r/cmd_vel: start the robot"
GUARDED = " on /e_stop"

SNIFFER = """
import json, socket, sys, threading
packets = socket.socket(socket.AF_PACKET, socket.SOCK_RAW, socket.htons(3))  # all, to see its own packets
packets.bind(("eth0", 0))
sent = 0
def count():
    global sent
    while True:
        packet = packets.recv(65536)
        sent += packet[12:14].hex() == "0800" and packet[23] == 17 and socket.inet_ntoa(packet[26:30]) == sys.argv[1]
threading.Thread(target=count, daemon=True).start()
print(flush=True)
sys.stdin.read()
print(sent)
"""
"""A script that counts the UDP packets that leave a host, which also reach its own raw sockets."""


class Pair:
    """Improv on the second host, a robot and an emergency stop on the first."""

    def __init__(self, one: Host, two: Host, python: str, env: Mapping[str, str], folder: Path) -> None:
        self._two, self.env, self._folder = two, {**env}, folder
        (folder / "improv.toml").write_text(TOML)
        (folder / "dance.improv").write_text(PROGRAM)
        self._others = Others(one.wrapper(python, folder), env)
        self.robot = Listener(self._others, "/r/cmd_vel")
        self.stop = Publisher(self._others, "/e_stop", "std_msgs/Bool")

    def close(self) -> None:
        self._others.close()

    def improv(self, *arguments: str) -> subprocess.Popen[str]:
        command = self._two.command(sys.executable, "-m", "improv_core", *arguments, str(self._folder / "dance.improv"))
        pipe = subprocess.PIPE
        return subprocess.Popen(command, env=self.env, stdin=subprocess.DEVNULL, stdout=pipe, stderr=pipe, text=True)

    def doctor(self, *expected: str) -> str:
        """Return its output once lines end like this. On a busy machine, discovery may take longer than one look."""
        end = time.monotonic() + LIMIT
        while True:
            out, err = self.improv("doctor").communicate(timeout=LIMIT)
            assert err == ""
            if all(f"{part}\n" in out for part in expected) or time.monotonic() > end:
                return out

    def packets(self) -> subprocess.Popen[str]:
        """Start to count the packets that leave Improv's host."""
        pipe = subprocess.PIPE
        command = self._two.command(sys.executable, "-c", SNIFFER, SECOND)
        counting = subprocess.Popen(command, stdin=pipe, stdout=pipe, text=True)
        assert counting.stdout
        counting.stdout.readline()
        return counting


@pytest.fixture
def hosts() -> Iterator[ExitStack]:
    with ExitStack() as stack:
        yield stack


@contextmanager
def pair(
    stack: ExitStack, link: bool, python: str, env: Mapping[str, str], folder: Path, early: bool = False
) -> Iterator[Pair]:
    """Make a pair. With `early`, the robot starts before its network is up."""
    one, two = stack.enter_context(on_one_link() if link else behind_a_router())
    if "ROS_DISCOVERY_SERVER" in env:
        stack.enter_context(discovery_server(one, python))
    if early:
        set_link(one, False)
    made = Pair(one, two, python, env, folder)
    if early:
        set_link(one, True)
    try:
        yield made
    finally:
        made.close()


@contextmanager
def discovery_server(host: Host, python: str) -> Iterator[None]:
    """Run Fast DDS's own discovery server, as people start it on one of their hosts."""
    prefix = Path(python).parent.parent
    program = prefix / "bin" / "fast-discovery-server"
    # The one from the wheels doesn't find the libraries beside it by itself.
    libraries = [prefix / "lib", *prefix.glob("lib/python*/site-packages/ros_fastrtps.libs")]
    path = ":".join(map(str, libraries))
    command = host.command("env", f"LD_LIBRARY_PATH={path}", str(program), "-i", "0", "-l", FIRST, "-p", "11811")
    server = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
    assert server.stdout
    try:
        assert "Server is running" in server.stdout.readline()
        threading.Thread(target=server.stdout.read, daemon=True).start()
        yield
    finally:
        server.kill()
        server.wait(LIMIT)


def hears_and_is_heard(pair: Pair) -> None:
    """Check that the robot over there moves, and that the emergency stop over there stops it."""
    playing = pair.improv("play", "--backend", "ros")
    try:
        pair.robot.wait(lambda message: message["x"] > 0)
        pair.stop({"data": True})
        pair.robot.wait(lambda message: message["x"] == 0)
        lines_until("the emergency stop on /e_stop is on", playing.stderr)
    finally:
        playing.terminate()
        playing.communicate(timeout=LIMIT)


def test_robots_in_one_subnet_are_found(
    hosts: ExitStack, ros_python: str, ros_env: Mapping[str, str], tmp_path: Path
) -> None:
    env = {**ros_env, "ROS_AUTOMATIC_DISCOVERY_RANGE": "SUBNET"}
    with pair(hosts, True, ros_python, env, tmp_path) as both:
        counting = both.packets()
        hears_and_is_heard(both)
        assert int(counting.communicate(timeout=LIMIT)[0]) > 0


def test_nothing_leaves_this_machine_if_discovery_is_limited_to_it(
    hosts: ExitStack, ros_python: str, ros_env: Mapping[str, str], tmp_path: Path
) -> None:
    with pair(hosts, True, ros_python, ros_env, tmp_path) as both:
        counting = both.packets()
        playing = both.improv("play", "--backend", "ros")
        lines_until("nothing is listening on /r/cmd_vel", playing.stderr)
        playing.terminate()
        playing.communicate(timeout=LIMIT)
        assert both.robot.heard == []
        assert int(counting.communicate(timeout=LIMIT)[0]) == 0


def test_only_a_discovery_server_finds_robots_in_another_subnet(
    hosts: ExitStack, ros_python: str, ros_env: Mapping[str, str], tmp_path: Path
) -> None:
    """The doctor finds the listener and the emergency stop, and commands arrive."""
    env = {**ros_env, "ROS_AUTOMATIC_DISCOVERY_RANGE": "SUBNET", "ROS_DISCOVERY_SERVER": SERVER}
    with pair(hosts, False, ros_python, env, tmp_path) as both:
        said = both.doctor(HEARD, GUARDED)
        assert f"{HEARD}\n" in said
        assert f"{GUARDED}\n" in said
        assert f"✓ domain {env['ROS_DOMAIN_ID']}, all robots listed by the discovery server {SERVER}: " in said
        hears_and_is_heard(both)
        del both.env["ROS_DISCOVERY_SERVER"]
        assert f"{UNHEARD}\n" in both.doctor()


def test_a_robot_that_started_before_its_network_is_found_by_a_server_and_hears_nothing(
    hosts: ExitStack, ros_python: str, ros_env: Mapping[str, str], tmp_path: Path
) -> None:
    """The doctor and the player report it."""
    env = {**ros_env, "ROS_AUTOMATIC_DISCOVERY_RANGE": "SUBNET", "ROS_DISCOVERY_SERVER": SERVER}
    with pair(hosts, True, ros_python, env, tmp_path, early=True) as both:
        assert f"{DEAF}\n" in both.doctor(DEAF)
        playing = both.improv("play", "--backend", "ros")
        lines_until("check whether it hangs or started before its network was up", playing.stderr)
        playing.terminate()
        playing.communicate(timeout=LIMIT)
        both.robot.hear_all()
        assert both.robot.heard == []


def test_nodes_use_no_shared_memory_because_checking_it_delays_commands(
    hosts: ExitStack, ros_python: str, ros_env: Mapping[str, str]
) -> None:
    here, _ = hosts.enter_context(on_one_link())
    node = "import os; from improv_core.outputs.ros.nodes import Nodes; a = Nodes('a'); print(os.listdir('/dev/shm'))"

    def shared(**env: str) -> str:
        command = here.command(ros_python, "-c", node)
        env = {**ros_env, "ROS_AUTOMATIC_DISCOVERY_RANGE": "SUBNET", **env}
        return subprocess.run(command, env=env, capture_output=True, text=True, timeout=LIMIT, check=True).stdout

    assert "fastrtps_" in shared(**{TRANSPORTS: "DEFAULT"})
    assert "fastrtps_" not in shared()
