"""`improv hosts`, and `improv doctor --hosts` with a real ssh server on this machine."""

from __future__ import annotations

import os
import re
import signal
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import pytest

from improv_core.commands.doctor import elsewhere
from improv_core.commands.doctor_hosts import examine_hosts, findings, hosts_of
from improv_core.commands.ros_setup import proof
from improv_core.hosts.clock_offset import Estimated
from improv_core.hosts.connect import ConnectError
from improv_core.hosts.probe import SeenHost, set_up_there
from improv_core.robots.config import read_robots
from improv_core.score.score import Host as HostOfRobots
from tests.commands.command_line import run
from tests.commands.test_ros_setup import environment_maker
from tests.hosts.sshd import LIMIT, Host, a_host
from tests.processes import command_of, descendants, wait_until_gone
from tests.stage.test_process import SITE

TOML = '[robots.a]\nhost = "pi@anna"\n[robots.b]\nhost = "pi@anna"\n[robots.c]\n[hosts."pi@anna"]\ndomain = 7\n'


@pytest.fixture(autouse=True)
def config(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setenv("XDG_CONFIG_HOME", str(tmp_path / "config"))
    return tmp_path / "config"


def test_a_host_is_allowed_listed_and_removed() -> None:
    assert (
        run("hosts", "list").stderr == "Improv may not use any other machine: allow one with `improv hosts allow HOST` "
        f"({os.environ['XDG_CONFIG_HOME']}/improv/hosts lists them)\n"
    )
    assert run("hosts", "allow", "pi@anna.local").returncode == 0
    assert run("hosts", "list").stdout == "pi@anna.local\n"
    assert run("hosts", "remove", "pi@anna.local").returncode == 0
    again = run("hosts", "remove", "pi@anna.local")
    assert (again.returncode, again.stderr) == (2, "improv: pi@anna.local was not allowed\n")
    assert run("hosts", "list").stdout == ""


def test_an_invalid_host_can_not_be_allowed() -> None:
    refused = run("hosts", "allow", "--", "-oProxyCommand=x")
    assert refused.returncode == 2
    assert refused.stderr.startswith("improv: `-oProxyCommand=x` is not a host")


def test_the_hosts_of_a_program_are_those_of_its_robots() -> None:
    robots = read_robots(TOML)
    assert robots.diagnostics == ()
    assert [(host.name, host.domain) for host in hosts_of(robots)] == [("pi@anna", 7)]
    assert hosts_of(None) == []
    run("hosts", "allow", "bob")
    assert hosts_of(None) == [HostOfRobots("bob")]


def test_doctor_names_robots_on_other_machines() -> None:
    robots = read_robots(TOML)
    (line,) = elsewhere({name: robots.robot(name) for name in robots.robots}, Path("dance.improv"))
    assert str(line) == (
        "– not seen from here: a on pi@anna, b on pi@anna: look there with `improv doctor --hosts dance.improv`"
    )
    assert [*elsewhere({"c": robots.robot("c")}, None)] == []


@pytest.fixture
def robot(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Host]:
    with a_host(tmp_path, {}) as host:
        monkeypatch.setenv("XDG_CONFIG_HOME", host.env["XDG_CONFIG_HOME"])
        yield host


def test_doctor_describes_a_host_and_the_error_of_its_clock(robot: Host) -> None:
    python, ros, clock = map(str, examine_hosts([HostOfRobots("robot")], str(robot.config)))
    assert python.startswith("✓ robot: Python 3.")
    assert ros == (
        "✗ robot: no ROS 2: no Python there has rclpy: run `improv ros setup --host robot`, or install ROS 2 there"
    )
    assert re.search(r"robot: its clock is 0\.0\d+ s .*known to \d+\.\d ms", clock)  # the machine decides how well


def test_doctor_says_why_a_host_is_out_of_reach(robot: Host) -> None:
    robot.authorized.write_text("")
    (line,) = map(str, examine_hosts([HostOfRobots("robot")], str(robot.config)))
    assert line.startswith("✗ robot: it takes none of your ssh keys")


def test_doctor_names_the_domain_and_middleware_there() -> None:
    holds = {"python": "3.12.3", "machine": "aarch64", "ros": "jazzy", "ros_python": "/usr/bin/python3"}
    holds |= {"reach": "domain 7, this machine only", "rmw": "rmw_cyclonedds_cpp"}
    seen = SeenHost(holds, Estimated(at=0.0, offset=-12.5, drift=0.0, error=0.02, round_trip=0.004), lag=0.05)
    assert [*map(str, findings(HostOfRobots("anna"), seen))] == [
        "✓ anna: Python 3.12.3 on aarch64",
        "✓ anna: jazzy (/usr/bin/python3): domain 7, this machine only, rmw_cyclonedds_cpp as RMW",
        "– anna: its clock is 12.500 s behind ours, known to 20.0 ms; there and back in 4.0 ms at least, there in 50 "
        "ms at most: robots will be out of step by as much: bring it nearer to the access point, or use a cable",
    ]


def set_up_with(pip: str, robot: Host) -> None:
    """Set up ROS on a host on which `pip` is this shell script."""
    maker = environment_maker(robot.bin, pip)
    robot.install_python({"PYTHONPATH": str(SITE), "IMPROV_TEST_CODE": f"import sys; sys.executable = {maker!r}"})
    set_up_there("robot", proof(), lambda line: None, str(robot.config))


def test_ros_that_can_not_be_set_up_there_is_one_line_here(robot: Host) -> None:
    with pytest.raises(ConnectError, match=r"^cannot reach PyPI: connect to the network"):
        set_up_with("echo 'WARNING: Retrying (Retry(total=0))'; exit 1", robot)
    assert not (robot.home / "data" / "improv" / "ros").exists()


def test_a_setup_whose_link_ends_leaves_nothing_there(robot: Host) -> None:
    before = descendants(os.getpid())
    begun = robot.folder / "begun"
    os.mkfifo(begun)
    with ThreadPoolExecutor(1) as pool:
        setup = pool.submit(set_up_with, f"echo > {begun}; exec sleep {LIMIT}", robot)
        begun.read_text()  # once pip works
        started = {pid: fd for pid, fd in descendants(os.getpid()).items() if pid not in before}
        (ssh,) = [pid for pid in started if command_of(pid).startswith(b"ssh\0")]
        assert any(b"ros/bin/" in command or b"sleep" in command for command in map(command_of, started)), "that is pip"
        assert (robot.home / "data" / "improv" / "ros").exists()
        os.kill(ssh, signal.SIGTERM)
        with pytest.raises(ConnectError):
            setup.result(LIMIT)
        wait_until_gone(started, LIMIT)
    assert not (robot.home / "data" / "improv" / "ros").exists()
