"""A stage on another machine, through a real ssh server and with a real robot: its parent treats it like any other."""

from __future__ import annotations

import asyncio
import os
import signal
import threading
import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pytest

from improv_core.hosts import texts
from improv_core.hosts.near import QUIET
from improv_core.ipc.stage_process import RunningStage, Stage, StageError
from improv_core.program.analysis import analyze
from improv_core.program.compiler import score_of
from improv_core.protocol.messages import ToStage
from improv_core.safety.stops import Stops
from improv_core.score.score_json import to_json
from tests.hosts.sshd import Host, a_host
from tests.processes import command_of, descendants, wait_until_gone
from tests.ros.conftest import LIMIT, Listen, Listener, be_patient, with_limits

pytestmark = pytest.mark.slow("a real ssh server, and a stage of ROS 2 that finds its robots")


ADA, BOB = "ada@laptop/1", "bob@desk/2"


@pytest.fixture
def host(tmp_path: Path, ros_env: Mapping[str, str], monkeypatch: pytest.MonkeyPatch) -> Iterator[Host]:
    """The machine of the robots. Variables of this machine don't apply there."""
    be_patient(monkeypatch)
    with a_host(tmp_path, set_there(ros_env)) as host:
        yield host


def set_there(env: Mapping[str, str], **limits: float) -> dict[str, str]:
    """Return the variables that tests set there, with these limits. ROS's Python is one, even if it is set here."""
    limited = {**env, **with_limits(**limits)} if limits else env
    python = {"IMPROV_ROS_PYTHON": env["IMPROV_ROS_PYTHON"]}
    return python | {name: value for name, value in limited.items() if os.environ.get(name) != value}


class Parent:
    """A parent, on its own event loop."""

    def __init__(self, host: Host, command: list[str]) -> None:
        self.heard: list[Any] = []
        self._changed = threading.Condition()
        self._loop = asyncio.new_event_loop()
        threading.Thread(target=self._loop.run_forever, daemon=True).start()
        env = {**host.env, **with_limits()}
        self.stage: Stage = self._do(Stage.start(command, env, self._hear, Stops()))

    def send(self, message: ToStage) -> None:
        self._loop.call_soon_threadsafe(self.stage.send, message)

    def load(self, program: str, **fields: Any) -> None:
        score = to_json(score_of(analyze(program)))
        load: Any = {"type": "load", "generation": 1, "score": score, "when": "restart", "backend": "ros"}
        loads: Any = {**load, **fields}
        self.send(loads)

    def wait(self, fits: Callable[[Any], bool]) -> Any:
        """Wait for the first message that fits, and return it."""
        with self._changed:
            assert self._changed.wait_for(lambda: any(map(fits, self.heard)), LIMIT), self.heard[-5:]
            return next(filter(fits, self.heard))

    def close(self) -> None:
        self._do(self.stage.close())
        self._loop.call_soon_threadsafe(self._loop.stop)

    def _do(self, work: Any) -> Any:
        return asyncio.run_coroutine_threadsafe(work, self._loop).result(LIMIT)

    def _hear(self, stage: RunningStage, message: Any, stops: int) -> None:
        with self._changed:
            self.heard.append(message)
            self._changed.notify_all()


@contextmanager
def a_parent(host: Host, *options: str, **named: Any) -> Iterator[Parent]:
    parent = Parent(host, host.command(*options, **named))
    try:
        yield parent
    finally:
        parent.close()


def says(kind: str, **fields: Any) -> Callable[[Any], bool]:
    return lambda message: message["type"] == kind and fields.items() <= message.items()


def test_a_dance_is_played_where_the_robots_are_and_stops_with_its_parent(host: Host, listen: Listen) -> None:
    turtle = listen("/turtle1/cmd_vel")
    before = descendants(os.getpid())
    with a_parent(host, "--report-sent") as parent:
        assert parent.stage.ready["real"]
        (version,) = host.versions()
        assert f"{version}/improv_core/stage".encode() in command_of(process_of("--sink ros"))
        asked, asked_wall = time.monotonic(), time.time()
        parent.load("turtle1 $ repeat forward")
        turtle.wait(lambda heard: heard["x"] == 2)
        playing = parent.wait(says("transport", state="playing"))
        assert asked < playing["monotonic"] < time.monotonic()
        assert asked_wall < playing["wall"] < time.time()
        link = parent.wait(says("link"))
        assert link["host"] == "robot"
        assert abs(link["offset"]) < max(link["error"], 0.002)  # both clocks are the same
        parent.send({"type": "pause"})
        turtle.wait(lambda heard: heard["x"] == 0)
        parent.wait(says("transport", state="paused"))
        parent.send({"type": "resume"})
        turtle.wait(lambda heard: heard["x"] == 2)
        started = {pid: fd for pid, fd in descendants(os.getpid()).items() if pid not in before}
        assert not any(message["type"] in ("error", "gone") for message in parent.heard)
    turtle.wait(lambda heard: heard["x"] == 0)
    wait_until_gone(started, LIMIT)
    assert host.versions() == [version]
    assert [path.name for path in host.home.iterdir() if path.name != ".ros"] == []


def plays(parent: Parent, turtle: Listener, **fields: Any) -> None:
    """Make a robot dance there without end."""
    parent.load("turtle1 $ repeat forward", **fields)
    turtle.wait(lambda heard: heard["x"] == 2)


def process_of(*words: str) -> int:
    """Return the one process below this one whose command contains these words."""
    commands = {pid: command_of(pid).decode().replace("\0", " ") for pid in descendants(os.getpid())}
    (pid,) = [pid for pid, command in commands.items() if all(word in command for word in words)]
    return pid


def test_another_parent_learns_who_plays_and_the_same_one_takes_over(host: Host, listen: Listen) -> None:
    turtle = listen("/turtle1/cmd_vel")
    with a_parent(host, by=ADA) as first:
        plays(first, turtle)
        with pytest.raises(StageError, match=r"^ada@laptop plays on it, so you can't: ask them to stop\. "):
            Parent(host, host.command(by=BOB))
        with a_parent(host, by=ADA) as again:
            first.wait(
                says("error", message="its end of the link has ended: another link of the same Improv takes over")
            )
            turtle.wait(lambda heard: heard["x"] == 0)
            plays(again, turtle)


def test_a_link_that_falls_silent_stops_its_robots_and_is_given_up(
    host: Host, ros_env: Mapping[str, str], listen: Listen
) -> None:
    host.install_python(set_there(ros_env, protocol__limits__SILENCE_LIMIT=3.0))
    turtle = listen("/turtle1/cmd_vel")
    with a_parent(host) as parent:
        plays(parent, turtle, patience=3.0)
        os.kill(process_of("ssh -T"), signal.SIGSTOP)
        turtle.wait(lambda heard: heard["x"] == 0)
        parent.wait(says("warning", message=texts.quiet(QUIET, 3.0)))
        parent.wait(says("error", message=texts.silent(4.0)))
        parent.wait(says("gone"))


@pytest.mark.parametrize("words", ["hosts far", "ssh -T"])
def test_robots_stop_if_any_part_of_a_link_is_killed(host: Host, listen: Listen, words: str) -> None:
    turtle = listen("/turtle1/cmd_vel")
    with a_parent(host) as parent:
        plays(parent, turtle)
        os.kill(process_of(words), signal.SIGKILL)
        turtle.wait(lambda heard: heard["x"] == 0)
        parent.wait(says("gone"))


def test_a_stage_that_hangs_is_ended_beside_the_robots(host: Host, ros_env: Mapping[str, str], listen: Listen) -> None:
    host.install_python(set_there(ros_env, protocol__limits__HANG_LIMIT=0.9))
    turtle = listen("/turtle1/cmd_vel")
    with a_parent(host) as parent:
        plays(parent, turtle)
        os.kill(process_of("improv_core/stage --sink ros"), signal.SIGSTOP)
        turtle.wait(lambda heard: heard["x"] == 0)
        told = parent.wait(says("error"))["message"]  # the standby beside it may have been first
        assert told in ("its stage did not answer for 0.9 s, so it was ended", "its stage failed: it was killed")
