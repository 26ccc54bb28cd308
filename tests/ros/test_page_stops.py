"""A stop on the page of a simulator beside real robots: the page confirms it once the real ones' stage has obeyed."""

from __future__ import annotations

import os
import signal
import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from functools import partial

import pytest

from tests.open_page import live_behind, stop_by
from tests.processes import command_of, halt, players
from tests.ros.conftest import LIMIT, Listen, Listener, with_limits
from tests.ros.dance import AFTER, AFTER_SPEED, Server, dances, still

pytestmark = pytest.mark.slow("starts a server and its stages, and robots drive")

Press = Callable[[], tuple[int, str]]
"""A call that sends a page's stop, or repeats it, and returns the answer's status and the stages yet to obey."""


@contextmanager
def dancing(env: Mapping[str, str], robot: Listener, *, standby: bool = True) -> Iterator[tuple[Server, int, Press]]:
    """Run a server, its stage with real robots that move, and a page."""
    with Server(env, backend="both", standby=standby) as server:
        dances(server, robot)
        (stage,) = (pid for pid in players(server.pid) if b"stage\0--sink\0ros" in command_of(pid))
        url = server.client.request("workspace/executeCommand", {"command": "improv.page"})
        yield server, stage, partial(stop_by, live_behind(url))


def confirmed(press: Press) -> None:
    """Repeat it as a page does, until it is confirmed."""
    end = time.monotonic() + LIMIT
    while (answer := press()) != (204, ""):
        assert answer == (202, "the real robots")
        assert time.monotonic() < end


@pytest.fixture
def turtle(listen: Listen) -> Listener:
    return listen("/turtle1/cmd_vel")


def test_a_halted_stage_of_real_robots_has_not_obeyed_a_stop_until_it_continues(
    turtle: Listener, alone: Mapping[str, str]
) -> None:
    patient = {**alone, **with_limits(protocol__limits__HANG_LIMIT=LIMIT)}
    with dancing(patient, turtle, standby=False) as (_, stage, press):  # which would kill it
        halt(stage)
        assert press() == (202, "the real robots")
        os.kill(stage, signal.SIGCONT)
        confirmed(press)
        turtle.wait(still)


def test_without_stop_sockets_as_on_windows_it_has_not_obeyed_until_it_continues_either(
    turtle: Listener, alone: Mapping[str, str]
) -> None:
    patient = with_limits(protocol__limits__HANG_LIMIT=LIMIT, safety__stop_socket__SUPPORTED=False)
    with dancing({**alone, **patient}, turtle, standby=False) as (_, stage, press):
        halt(stage)
        assert press() == (202, "")
        os.kill(stage, signal.SIGCONT)
        while press() == (202, ""):
            pass
        turtle.wait(still)


def test_the_stop_of_a_halted_stage_is_confirmed_once_another_one_has_stopped_its_robots(
    turtle: Listener, alone: Mapping[str, str]
) -> None:
    with dancing(alone, turtle) as (server, stage, press):
        halt(stage)
        confirmed(press)  # at once, if the other one is quick
        server.wait_for_line("a new one is stopping the robots")
        turtle.wait(still)


def test_a_stop_while_the_session_is_halted_stops_robots_and_no_save_from_before_it_moves_them(
    turtle: Listener, alone: Mapping[str, str]
) -> None:
    known = 3.0  # seconds after which the session repeats the stop, and people count as knowing of it
    limits = with_limits(safety__stops__KNOWN=known, safety__stops__BEHIND=0.01)
    with dancing({**alone, **limits}, turtle) as (server, _, press):
        halt(server.pid)
        server.type(AFTER)
        server.client.save(server.uri)
        assert press() == (204, "")
        for _ in range(3):  # 0.05 s apart, so the session will learn of it late
            turtle.wait(still)
        continued = time.monotonic()
        os.kill(server.pid, signal.SIGCONT)
        server.client.wait("window/showMessage", lambda shown: shown["message"][0] in "▶■")  # about that save
        turtle.wait(lambda twist: twist["at"] > continued + known and still(twist))
        assert not any(twist["x"] == AFTER_SPEED for twist in turtle.heard)
