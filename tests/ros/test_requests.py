"""Requests of other nodes in ROS 2 to Improv's node: services, parameters, names, and remapping."""

from __future__ import annotations

import json
import subprocess
import sys
import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pytest

from improv_core.protocol.play_again import STOPPED
from tests.ros.conftest import LIMIT, Listen, Publish, Sink
from tests.ros.dance import Server, at_speed, still

pytestmark = pytest.mark.slow("starts what plays, and somebody who asks")

ASKER = Path(__file__).with_name("asker.py")
PROGRAM = "turtle1 $ repeat forward\n"
SPEED = 2.0
"""m/s of a step of 2 m at tempo 60."""

Ask = Callable[[str], Any]


@pytest.fixture(scope="module")
def ask(ros_python: str, ros_env: Mapping[str, str]) -> Iterator[Ask]:
    """Send requests of the kinds that asker.py understands."""
    pipe = subprocess.PIPE
    process = subprocess.Popen([ros_python, ASKER], env=ros_env, stdin=pipe, stdout=pipe, text=True)
    assert process.stdout
    process.stdout.readline()

    def answer(line: str) -> Any:
        print(line, file=process.stdin, flush=True)
        assert process.stdout
        return json.loads(process.stdout.readline())

    yield answer
    process.communicate(timeout=LIMIT)


@contextmanager
def play(env: Mapping[str, str], folder: Path, program: str, *arguments: str) -> Iterator[subprocess.Popen[str]]:
    path = folder / "dance.improv"
    path.write_text(program)
    command = [sys.executable, "-m", "improv_core", "play", str(path), "--backend", "ros", *arguments]
    playing = subprocess.Popen(command, env=env, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    try:
        yield playing
    finally:
        playing.terminate()
        playing.communicate(timeout=LIMIT)


def until(ask: Ask, line: str, expected: Any) -> None:
    """Ask again until this is the answer."""
    end = time.monotonic() + LIMIT
    while (found := ask(line)) != expected:
        assert time.monotonic() < end, found


def test_services_and_parameters_work(ask: Ask, listen: Listen, ros_env: Mapping[str, str], tmp_path: Path) -> None:
    """Services play, pause, and stop; the parameter speed can be set, and tempo can only be read."""
    robot = listen("/turtle1/cmd_vel")
    (tmp_path / "improv.toml").write_text('[ros]\nnode = "conductor"\n')
    with Server(ros_env, uri=(tmp_path / "dance.improv").as_uri()) as editor:
        editor.save(PROGRAM)
        robot.wait(at_speed(SPEED))
        until(ask, "call /conductor/play", [True, "it plays already"])
        assert ask("call /conductor/pause") == [True, "pausing"]
        robot.wait(still)
        until(ask, "call /conductor/pause", [False, "nothing plays"])
        assert ask("call /conductor/play") == [True, "continuing"]
        robot.wait(at_speed(SPEED))
        assert ask("call /conductor/stop") == [True, "all robots are being stopped"]
        robot.wait(still)
        until(ask, "call /conductor/play", [True, "playing again from the beginning"])
        robot.wait(at_speed(SPEED))

        editor.save("beat 30\n" + PROGRAM)
        robot.wait(at_speed(SPEED / 2))
        until(ask, "get /conductor tempo", 30.0)
        assert ask("set /conductor speed 2.0") == [True, ""]
        robot.wait(at_speed(SPEED))
        assert ask("get /conductor speed") == 2.0
        refused, why = ask("set /conductor tempo 90")
        assert (refused, why) == (False, "tempo is read-only: set speed, or change `beat` in the program")
        accepted, _ = ask("set /conductor speed 40")
        assert not accepted
        editor.complaints()


def test_the_first_sink_already_offers_its_services(ask: Ask, sink: Sink) -> None:
    assert ask(f"call {sink('node')}/stop") == [True, "all robots are being stopped"]
    assert ask(f"call {sink('node')}/pause") == [False, "nothing plays"]


def test_an_armed_dance_with_ros_arguments_begins_with_the_service(
    ask: Ask, listen: Listen, publish: Publish, ros_env: Mapping[str, str], tmp_path: Path
) -> None:
    """The arguments set a name, remapping (also for the standby), QoS, and the file of parameters from `ros2 launch`,
    whose time is also that of messages for monitors. Before the service, a robot hears only zeros."""
    publish("/clock", "rosgraph_msgs/Clock")({"clock.sec": 12})
    diagnostics = listen("/diagnostics", type="diagnostic_msgs/DiagnosticArray")
    (tmp_path / "improv.toml").write_text("[ros]\npublish = true\n")
    robot = listen("/base/cmd_vel", best_effort=True)
    reliable = listen("/base/cmd_vel", name="reliable")
    best_effort = "qos_overrides./base/cmd_vel.publisher.reliability:=best_effort"
    parameters = tmp_path / "launch_params"
    parameters.write_text("dancer:\n  ros__parameters:\n    speed: 0.5\n    use_sim_time: true\n")
    words = ["-r", "__node:=dancer", "-r", "/turtle1/cmd_vel:=/base/cmd_vel", "-p", best_effort]
    with play(ros_env, tmp_path, PROGRAM, "--armed", "--ros-args", *words, "--params-file", str(parameters)) as playing:
        assert playing.stdout
        lines = iter(playing.stdout.readline, "")
        assert any("armed: all is ready, and begins with the service ~/play" in line for line in lines)
        assert ask("call /dancer/play")[0]
        assert diagnostics.wait(lambda message: message["header"]["stamp"] == {"sec": 12, "nanosec": 0})
        begun = robot.wait(at_speed(SPEED / 2))
        assert all(map(still, robot.heard[: robot.heard.index(begun)]))
        robot.wait_for_publishers(lambda count: count == 2)
        assert ask("get /dancer speed") == 0.5
        assert all(still(message) or message["x"] == SPEED / 2 for message in robot.heard)
        assert ask("call /dancer/stop") == [True, "all robots are being stopped"]
        robot.wait(still)
        assert reliable.heard == []


def test_arguments_that_ros_refuses_end_the_player_with_one_line(ros_env: Mapping[str, str], tmp_path: Path) -> None:
    with play(ros_env, tmp_path, PROGRAM, "--ros-args", "-r", "what") as playing:
        _, err = playing.communicate(timeout=LIMIT)
        assert playing.returncode != 0
        assert "what" in err
        assert len(err.splitlines()) == 1


def test_a_dance_that_a_person_has_stopped_is_played_by_a_person(
    ask: Ask, listen: Listen, ros_env: Mapping[str, str], tmp_path: Path
) -> None:
    robot = listen("/turtle1/cmd_vel")
    (tmp_path / "improv.toml").write_text('[ros]\nnode = "assistant"\n')
    with Server(ros_env, uri=(tmp_path / "dance.improv").as_uri()) as editor:
        editor.save(PROGRAM)
        robot.wait(at_speed(SPEED))
        editor.client.request("workspace/executeCommand", {"command": "improv.stop"})
        stopped = robot.wait(still)
        until(ask, "call /assistant/play", [False, STOPPED])
        assert ask("call /assistant/stop") == [True, "all robots are being stopped"]
        editor.client.request("workspace/executeCommand", {"command": "improv.seek", "arguments": [4]})
        assert ask("call /assistant/play") == [False, STOPPED]
        robot.hear_all()
        assert all(map(still, robot.heard[robot.heard.index(stopped) :]))
        end = time.monotonic() + LIMIT
        while not at_speed(SPEED)(robot.heard[-1]):
            assert time.monotonic() < end
            # A busy server may pass ROS's stop on only after this seek: then nothing is paused.
            editor.client.request("workspace/executeCommand", {"command": "improv.seek", "arguments": [4]})
            editor.client.request("workspace/executeCommand", {"command": "improv.resume"})
            robot.wait(lambda message: True)
