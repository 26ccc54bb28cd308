"""What fails in ROS, or is otherwise not as it should be there, while robots move."""

from __future__ import annotations

import os
import signal
import socket
import time
from collections.abc import Callable, Mapping
from itertools import pairwise
from pathlib import Path
from typing import Any

import pytest

from improv_core.stage.listeners import PATIENCE
from tests.ls.client import CAPABILITIES
from tests.processes import descendants
from tests.ros.conftest import Listen, Listener
from tests.ros.dance import (
    AFTER_SPEED,
    BEFORE,
    BEFORE_SPEED,
    BY_STANDBY,
    ENDED,
    SOON,
    Record,
    Server,
    at_speed,
    dances,
    stands,
    still,
    survives,
)

TWO = "turtle1 turtle2 $ repeat forward\n"
TOPICS = ("/turtle1/cmd_vel", "/turtle2/cmd_vel")
GAP = 1.0
"""Seconds between two commands to a robot that moves: 0.05, and what a busy machine adds."""
FOUND = 10.0
"""Seconds until a new listener is served: up to 1 until the player looks, and 0.1 to 3.5 for each discovery."""

BACKWARDS = """\
import time
ticks, began = time.monotonic, time.time() + 1000 * time.monotonic()
time.time = lambda: began - 1000 * ticks()
time.time_ns = lambda: int(time.time() * 1e9)
"""

BROKEN = """\
import os
try:
    from rclpy.publisher import Publisher
except ImportError:  # in the server's Python
    pass
else:
    publish = Publisher.publish

    def publish_unless_broken(self, message):
        if "turtle2" in self.topic_name and os.path.exists(os.path.join(os.path.dirname(__file__), "broken")):
            raise RuntimeError("failed to publish")
        publish(self, message)

    Publisher.publish = publish_unless_broken
"""
"""While there is a file `broken` beside it, nothing can be published for turtle2."""


def with_python_code(env: Mapping[str, str], folder: Path, code: str) -> dict[str, str]:
    """An environment in which every Python runs this first."""
    folder.joinpath("sitecustomize.py").write_text(code)
    return {**env, "PYTHONPATH": str(folder)}


def of(topic: str, fits: Callable[[Mapping[str, Any]], bool]) -> Callable[[Mapping[str, Any]], bool]:
    return lambda message: message["topic"] == topic and fits(message)


def after(moment: float) -> Callable[[Mapping[str, Any]], bool]:
    return lambda message: bool(message["at"] > moment)


def test_a_clock_that_runs_backwards(listen: Listen, ros_env: dict[str, str], tmp_path: Path) -> None:
    turtle = listen(TOPICS[0])
    with Server(with_python_code(ros_env, tmp_path, BACKWARDS)) as server:
        server.save("beat 120\nturtle1 $ forward left forward\n")
        moments = [turtle.wait(at_speed(4)), turtle.wait(at_speed(0)), turtle.wait(at_speed(4)), turtle.wait(still)]
        assert moments[1]["yaw"] > 0
        assert [after["at"] - before["at"] for before, after in pairwise(moments)] == pytest.approx([0.5] * 3, abs=0.25)


def test_a_robot_that_can_not_be_told_anything(
    listen: Listen, ros_env: dict[str, str], tmp_path: Path, record_property: Record
) -> None:
    """The others are stopped, what a new stage can't do is not tried forever, and each of the two says so once."""
    turtles = listen(*TOPICS)
    broken = tmp_path / "broken"
    with Server(with_python_code(ros_env, tmp_path, BROKEN)) as server:
        both_move(server, turtles)
        broken.touch()
        began = time.monotonic()
        zero = turtles.wait(lambda message: after(began)(message) and of(TOPICS[0], still)(message))["at"] - began
        record_property("seconds to zero", round(zero, 3))
        assert zero < SOON
        server.wait_for_line(
            "the stage failed: failed to publish: a new one is stopping the robots; save to play again"
        )
        server.wait_for_line("the stage failed: failed to publish: robots may still be moving; save to play again")
        assert descendants(server.pid) == {}
        broken.unlink()
        server.save("beat 90\n" + TWO)
        for topic in TOPICS:
            turtles.wait(of(topic, at_speed(AFTER_SPEED)))
        assert server.complaints() == []


def test_a_robot_that_is_gone_does_not_keep_others_from_being_stopped(
    listen: Listen, ros_env: dict[str, str], record_property: Record
) -> None:
    """By a new stage, which waits PATIENCE for listeners; nor does a hush meanwhile."""
    here, gone = listen(TOPICS[0]), listen(TOPICS[1])
    with Server(ros_env, {**CAPABILITIES, "experimental": {"improv": True}}) as server:
        server.save(TWO)
        here.wait(at_speed(BEFORE_SPEED))
        gone.close()
        stage, _ = descendants(server.pid)
        began = time.monotonic()
        os.kill(stage, signal.SIGKILL)
        server.wait_for_line(ENDED)
        server.complaints()  # and with them what was told before
        server.client.wait("improv/transport", lambda transport: transport["state"] == "waiting")
        server.client.request("workspace/executeCommand", {"command": "improv.hush"})
        stands(here, began, PATIENCE, record_property)


HANGING = """\
import ctypes, os
try:
    from rclpy.publisher import Publisher
except ImportError:  # in the server's Python
    pass
else:
    publish = Publisher.publish
    trigger = os.path.join(os.path.dirname(__file__), "hang")

    def publish_or_hang(self, message):
        if os.path.exists(trigger):
            os.remove(trigger)
            ctypes.PyDLL(None).sleep(60)
        publish(self, message)

    Publisher.publish = publish_or_hang
"""
"""Once there is a file `hang` beside it, the next publisher stays in a C function that keeps all threads waiting."""


def test_a_stage_that_hangs_in_a_c_call(
    listen: Listen, ros_env: dict[str, str], tmp_path: Path, record_property: Record
) -> None:
    turtle = listen(TOPICS[0])
    with Server(with_python_code(ros_env, tmp_path, HANGING)) as server:
        line = ": its robots were stopped; save to play again"  # on a busy machine, its standby may be first to kill it
        survives(server, turtle, lambda _: (tmp_path / "hang").touch(), line, BY_STANDBY, record_property)


def test_a_standby_that_is_killed(listen: Listen, ros_env: dict[str, str], record_property: Record) -> None:
    """One line says so, the dance goes on, and the next score has another standby."""
    turtle = listen(TOPICS[0])
    with Server(ros_env) as server:
        dances(server, turtle)
        _, standby = descendants(server.pid)
        os.kill(standby, signal.SIGKILL)
        server.wait_for_line("the standby process has ended, so if the stage dies, robots keep moving until a new ")
        killed = time.monotonic()
        turtle.wait(lambda message: after(killed)(message) and at_speed(BEFORE_SPEED)(message))
        assert server.complaints() == []
        survives(server, turtle, lambda stage: os.kill(stage, signal.SIGKILL), ENDED, BY_STANDBY, record_property)


def test_no_standby(listen: Listen, ros_env: dict[str, str]) -> None:
    """Then a new stage finds the robots and stops them."""
    turtle = listen(TOPICS[0])
    with Server(ros_env, standby=False) as server:
        dances(server, turtle)
        (stage,) = descendants(server.pid)
        os.kill(stage, signal.SIGKILL)
        server.wait_for_line("the stage exited unexpectedly: a new one is stopping the robots; save to play again")
        turtle.wait(still)


def both_move(server: Server, *turtles: Listener) -> None:
    """The first listener hears the first robot, and the last one the last."""
    server.save(TWO)
    for topic, listener in ((TOPICS[0], turtles[0]), (TOPICS[1], turtles[-1])):
        listener.wait(of(topic, at_speed(BEFORE_SPEED)))
    server.complaints()


def test_a_listener_that_vanishes_takes_no_other_with_it(
    listen: Listen, ros_env: dict[str, str], record_property: Record
) -> None:
    """And is served when it is back."""
    here, gone = listen(TOPICS[0]), listen(TOPICS[1])
    with Server(ros_env) as server:
        server.save(TWO)
        here.wait(at_speed(BEFORE_SPEED))
        gone.wait(at_speed(BEFORE_SPEED))
        gone.kill()
        killed = time.monotonic()
        here.wait(lambda message: message["at"] > killed + 2)
        moments = [message["at"] for message in here.heard]
        assert max(after - before for before, after in pairwise(moments)) < GAP
        assert all(map(at_speed(BEFORE_SPEED), here.heard))
        is_served(listen(TOPICS[1]), record_property)


def test_listeners_that_come_late(listen: Listen, ros_env: dict[str, str], record_property: Record) -> None:
    """While another of the same type, or of the other one, has been there before."""
    early = listen(TOPICS[0])
    with Server(ros_env) as server:
        dances(server, early)
        for kind in ([], ["--stamped"]):
            is_served(listen(TOPICS[0], *kind), record_property)
            assert at_speed(BEFORE_SPEED)(early.wait(after(time.monotonic())))
        assert server.complaints() == []


def test_a_robot_that_goes_away_and_comes_back(listen: Listen, ros_env: dict[str, str]) -> None:
    here, gone = listen(TOPICS[0]), listen(TOPICS[1])
    with Server(ros_env) as server:
        both_move(server, here, gone)
        gone.close()
        server.wait_for_line(f"nothing is listening on {TOPICS[1]}")
        back = listen(TOPICS[1])
        server.wait_for_line(f"a robot listens on {TOPICS[1]} again, and continues in the middle of the program")
        back.wait(at_speed(BEFORE_SPEED))
        assert server.complaints() == []


def is_served(late: Listener, record: Record) -> None:
    """A listener that is ready now soon hears what plays."""
    ready = time.monotonic()
    heard = late.wait(at_speed(BEFORE_SPEED))["at"] - ready
    record("seconds to the first command", round(heard, 3))
    assert heard < FOUND


def test_two_servers_on_one_robot_name_each_other(listen: Listen, ros_env: dict[str, str]) -> None:
    turtle = listen(TOPICS[0])
    with Server(ros_env) as one, Server(ros_env) as two:
        dances(one, turtle)
        two.save(BEFORE)
        for server, other in ((one, two), (two, one)):
            rival, _ = descendants(other.pid)
            server.wait_for_line(f"other nodes also publish to {TOPICS[0]}: /improv_{socket.gethostname()}_{rival}; ")
        assert one.complaints() == two.complaints() == []
