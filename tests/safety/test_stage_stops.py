"""The stop sockets of stages: who has obeyed, and all that may be wrong with a socket."""

from __future__ import annotations

import os
import socket
import tempfile
import threading
from collections.abc import Iterator, Sequence
from contextlib import ExitStack
from pathlib import Path
from unittest.mock import Mock

import pytest

from improv_core.protocol.commands import Stop
from improv_core.safety import stop_server, stop_socket
from improv_core.safety.stage_stops import (
    OBEYED,
    forget,
    socket_of,
    sockets_of,
    stage_of,
    stages_not_stopped,
    stop_stages,
)
from improv_core.safety.stop_request import ASK
from improv_core.safety.stop_server import MAX_SILENT
from improv_core.safety.stop_socket import StopSocket, stop_all
from tests.safety.stages import Stages, die
from tests.session.story import at
from tests.waiting import until

LIMIT = 60.0
SHORT = 0.3
STOP: Stop = {"type": "stop", "direct": "p 1", "by": "osc"}
PI = "pi@pi.local:22"


@pytest.fixture
def show(monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    """A performance of process 7, in the folder where `improv stop` looks."""
    with tempfile.TemporaryDirectory(dir="/tmp") as folder:
        monkeypatch.delenv("XDG_RUNTIME_DIR", raising=False)
        monkeypatch.setattr(stop_socket, "RUNTIME", Path(folder, "users"))
        monkeypatch.setattr(stop_socket, "SHARED", Path(folder))
        monkeypatch.setattr(stop_socket, "LIMIT", SHORT)
        yield stop_socket.fixed_folder() / "7-abc"


@pytest.mark.parametrize(
    ("stages", "obeyed", "who"),
    [
        (["simulator"], ["simulator"], []),
        (["simulator"], [], ["the simulator"]),
        (["ros", "simulator"], ["ros"], []),
        (["ros", "simulator"], ["simulator"], ["the real robots"]),
        (["ros", PI, "simulator"], [PI], ["the stage here"]),
        (["ros", PI, "simulator"], ["ros"], [PI]),
        (["ros", PI], ["ros", PI], []),
        ([PI, "simulator"], [], [PI]),
    ],
)
def test_stages_of_real_robots_have_to_obey_or_the_simulator_alone(
    stages: Sequence[str], obeyed: Sequence[str], who: Sequence[str]
) -> None:
    assert stages_not_stopped(stages, obeyed) == who


def test_all_stages_get_a_stop_at_once_and_those_that_have_not_obeyed_are_named(show: Path) -> None:
    assert stop_stages(show, STOP, SHORT) is None, "there is no stage"
    stages = Stages(show, "simulator", "ros", PI, hangs=PI)
    other = Stages(show.with_name("7-abcd"), "ros")
    assert stop_stages(show, STOP, SHORT) == [PI]
    assert sorted(name for name, _ in stages.stops) == [PI, "ros", "simulator"]
    assert all(stop == STOP for _, stop in stages.stops)
    assert other.stops == []
    stages.close()
    assert sockets_of(show) == []
    other.close()


def test_a_stop_with_no_details_or_with_strange_ones_is_a_stop(show: Path) -> None:
    stages = Stages(show, "ros")
    for text in (b"", b"{", b'{"type": "load"}\n', b'{"type": "stop", "direct": 7}', b'{"type": "stop"}', b"x" * 2_000):
        with socket.socket(socket.AF_UNIX) as asking:
            asking.connect(str(socket_of(show, "ros")))
            asking.sendall(ASK + text)
            assert asking.recv(100) == OBEYED.encode()
    assert len({stop["direct"] for _, stop in stages.stops}) == 6
    assert all(stop.keys() == {"type", "direct"} for _, stop in stages.stops)
    stages.close()


def test_a_dead_stage_has_not_obeyed_until_another_one_has_taken_over_its_robots(show: Path) -> None:
    die(show, "ros")
    stages = Stages(show, "simulator", "ros")
    assert stop_stages(show, STOP, SHORT) == ["the real robots"]
    stages.sockets["ros"].hear(at("playing", 1, 0.0, 0.0))
    stages.sockets["ros"].hear(at("playing", 1, 0.0, 0.0))
    assert stop_stages(show, STOP, LIMIT) == []
    stages.close()


def test_a_dead_stage_has_not_obeyed_either_if_the_one_in_its_place_cannot_listen(
    show: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    die(show, "ros")
    stages = Stages(show, "simulator", "ros")
    with monkeypatch.context() as full:
        full.setattr(socket.socket, "listen", Mock(side_effect=OSError(24, "too many open files")))
        stages.sockets["ros"].hear(at("playing", 1, 0.0, 0.0))
    assert stop_stages(show, STOP, SHORT) == ["the real robots"]
    stages.close()


def test_a_stage_that_dies_while_it_is_asked_has_not_obeyed(show: Path) -> None:
    with socket.socket(socket.AF_UNIX) as dies:
        dies.bind(str(socket_of(show, "ros")))
        dies.listen()

        def die() -> None:
            with dies.accept()[0] as asking:
                asking.recv(1_000)

        thread = threading.Thread(target=die)
        thread.start()
        assert stop_stages(show, STOP, LIMIT) == ["the real robots"]
        thread.join()


def test_a_dead_stage_that_has_left_no_robot_moving_is_forgotten(show: Path) -> None:
    die(show, "ros")
    die(show, PI)
    forget(show, "ros")
    stages = Stages(show, "ros")
    assert stop_stages(show, STOP, LIMIT) == [PI]
    stages.close()
    forget(show)
    assert sockets_of(show) == []


def test_only_the_user_can_open_a_socket(show: Path) -> None:
    stages = Stages(show, "ros")
    assert socket_of(show, "ros").stat().st_mode & 0o777 == 0o600
    assert show.parent.stat().st_mode & 0o777 == 0o700
    stages.close()


@pytest.mark.parametrize("host", ["a" * 300, "../../etc", "ä@ö", "a/b"])
def test_any_host_has_a_socket_of_its_own_whose_path_is_short_enough(show: Path, host: str) -> None:
    stages = Stages(show, host, host + "2")
    assert len({*sockets_of(show)}) == 2
    assert all(path.parent == show.parent and len(os.fsencode(path)) < 108 for path in sockets_of(show))
    assert len(stage_of(socket_of(show, host))) <= 40
    assert stop_stages(show, STOP, LIMIT) == []
    stages.close()


def test_a_folder_with_a_path_that_is_too_long_has_no_sockets(tmp_path: Path) -> None:
    folder = tmp_path / ("x" * 100)
    folder.mkdir()
    with pytest.raises(OSError, match="too long"):
        Stages(folder / "7-abc", "ros")
    assert list(folder.iterdir()) == []


def test_a_flood_of_connections_that_stay_silent_delays_no_stop_and_is_bounded(
    show: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(stop_server, "READ_LIMIT", 10 * LIMIT)  # no connection ends by itself
    stages, before = Stages(show, "ros"), answering()
    with ExitStack() as stack:
        for _ in range(3 * MAX_SILENT):
            silent = stack.enter_context(socket.socket(socket.AF_UNIX))  # which waits if it has to
            silent.connect(str(socket_of(show, "ros")))
        assert stop_stages(show, STOP, LIMIT) == []
        until(lambda: len(answering() - before) <= MAX_SILENT)
    stages.close()


def answering() -> set[threading.Thread]:
    """Return the threads of connections, which end soon after these."""
    return {thread for thread in threading.enumerate() if thread.name.endswith("(_answer)")}


def test_a_stage_that_is_flooded_with_stops_obeys_and_answers_each(show: Path) -> None:
    stages, results = Stages(show, "ros"), list[Sequence[str] | None]()

    def flood() -> None:
        for _ in range(50):
            results.append(stop_stages(show, STOP, LIMIT))

    threads = [threading.Thread(target=flood) for _ in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert results == [[]] * 200
    assert len(stages.stops) == 200
    stages.close()


class TestImprovStop:
    """`improv stop` asks sessions and stages in parallel."""

    @pytest.fixture(autouse=True)
    def _of_process_7(self, monkeypatch: pytest.MonkeyPatch) -> None:
        monkeypatch.setattr(stop_socket, "_own_name", lambda: "7-session")

    def check(self, *lines: str) -> None:
        assert list(stop_all()) == list(lines)

    def test_it_stops_stages_and_their_session_with_one_identity(self, show: Path) -> None:
        expected: list[Stop] = []

        def stopped(stop: Stop) -> str:
            expected.append(stop)
            return "stopped"

        session = StopSocket(stopped)
        stages = Stages(show, "simulator", "ros")
        self.check("stopped")
        assert [stop for _, stop in stages.stops] == expected * 2
        stages.close()
        session.close()

    @pytest.mark.parametrize("dead", [False, True])
    def test_a_stage_that_hangs_or_has_died_is_named_although_its_session_has_stopped(
        self, show: Path, dead: bool
    ) -> None:
        session = StopSocket(lambda _: "stopped dance.improv on ROS 2")
        if dead:
            die(show, "ros")
        stages = Stages(show, "simulator", *([] if dead else ["ros"]), hangs="ros")
        self.check("no answer from the real robots: look at them (stopped dance.improv on ROS 2)")
        stages.close()
        session.close()

    def test_robots_stop_although_their_session_hangs(self, show: Path) -> None:
        stages = Stages(show, "ros")
        with socket.socket(socket.AF_UNIX) as hangs:
            hangs.bind(str(show.with_name("7-session.sock")))
            hangs.listen()
            self.check("stopped the robots of process 7, which does not answer: end it with `kill`")
        stages.close()

    def test_a_session_that_hangs_with_its_stage_is_named_with_it(self, show: Path) -> None:
        stages = Stages(show, "ros", hangs="ros")
        with socket.socket(socket.AF_UNIX) as hangs:
            hangs.bind(str(show.with_name("7-session.sock")))
            hangs.listen()
            self.check("no answer from the real robots: look at them, and end process 7 with `kill`")
        stages.close()

    def test_real_robots_whose_stage_and_session_were_killed_are_named_once(self, show: Path) -> None:
        die(show, "ros")
        die(show, "simulator")
        with socket.socket(socket.AF_UNIX) as killed:
            killed.bind(str(show.with_name("7-session.sock")))
        self.check("no answer from the real robots: look at them, since process 7 and their stage were killed")
        assert {path.suffix for path in show.parent.iterdir()} == {""}, "only the note is left"
        die(show, "simulator")
        self.check()
