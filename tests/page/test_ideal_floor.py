"""The page of real robots without a simulator: its floor, and its process but for its pipes."""

from __future__ import annotations

import asyncio
import queue
import threading
from typing import Any
from unittest.mock import Mock, call

import aiohttp
import pytest

from improv_core.ipc.arrivals import Arrival, End, Lost, UrgentQueue
from improv_core.page import __main__ as main
from improv_core.page.__main__ import SIGNALED, open_alone, options_in
from improv_core.page.ideal_floor import IdealFloor
from improv_core.program.analysis import analyze
from improv_core.program.compiler import score_of
from improv_core.protocol.messages import FromStage, Play, When
from improv_core.safety.heartbeat import Parent
from tests.page.conftest import LIMIT, TOKEN, transport
from tests.player.test_player import Stage, score


class PageOpened(Stage):
    """A player, and a floor that gets all its messages."""

    def __init__(self, program: str) -> None:
        super().__init__()
        self.floor = IdealFloor(lambda: self.now)
        self._shown = 0
        self.load(program)

    def load(self, program: str, when: When = "restart") -> None:
        made, generation = score(program), len(self.told) + 1
        self.floor.add_score(made, generation)
        self.perform(made, generation, when)

    def places(self) -> dict[str, tuple[float, float]]:
        for message in self.told[self._shown :]:
            if message["type"] == "transport":
                self.floor.take(message)
            elif message["type"] == "sensed":
                self.floor.sense(message)
        self._shown = len(self.told)
        poses = self.floor.snapshot().poses
        return {robot: (round(pose.x, 6), round(pose.y, 6)) for robot, pose in poses.items()}


def test_robots_are_where_their_score_has_them() -> None:
    stage = PageOpened("r $ repeat forward\ns at 0 2\ns $ until cue (repeat forward) rest\n")
    assert stage.places() == {"r": (0, 0), "s": (0, 2)}
    stage.run(1.5)
    assert stage.places() == {"r": (3, 0), "s": (3, 2)}
    stage.ask("cue")
    stage.run(0.5)
    assert stage.places() == {"r": (4, 0), "s": (3, 2)}
    stage.load("r $ repeat backward\n", "now")
    stage.run(0.5)
    assert stage.places() == {"r": (3, 0)}
    assert stage.floor.snapshot().at == 2.5


def test_a_silent_robot_stays_where_it_was() -> None:
    stage = PageOpened("r at 0 0\ns at 0 0\nr s $ repeat forward\n")
    stage.run(1)
    stage.places()
    stage.ask("silence", muted=["r"], soloed=[])
    stage.places()
    stage.run(1)
    assert stage.places() == {"r": (2, 0), "s": (4, 0)}


def test_nothing_is_on_the_floor_before_the_first_score() -> None:
    assert IdealFloor().snapshot().poses == {}


@pytest.mark.parametrize(("problem", "told"), [("", [call({"type": "stopped"})]), (SIGNALED, [])])
def test_pages_of_real_robots_are_told_that_they_stopped_only_if_the_session_has_ended(
    problem: str, told: list[object], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(main, "PageServer", viewer := Mock())
    inbox: UrgentQueue[Arrival] = UrgentQueue()
    job = open_alone(options_in([]), lambda message: None, inbox.put, TOKEN)
    inbox.put(End(problem))
    assert job.run(inbox, Parent()) == bool(problem)
    assert viewer.return_value.publish.call_args_list == told


def test_a_page_without_a_simulator_shows_scores_and_answers_pings() -> None:
    said: queue.SimpleQueue[FromStage] = queue.SimpleQueue()
    inbox: UrgentQueue[Arrival] = UrgentQueue()
    job = open_alone(options_in(["--port", "0"]), said.put, inbox.put, TOKEN)
    codes: list[int] = []
    thread = threading.Thread(target=lambda: codes.append(job.run(inbox, Parent())))
    thread.start()
    dance = score_of(analyze("r $ forward left\n"))
    inbox.put(Play({"type": "load", "generation": 1, "score": {}, "when": "restart", "backend": "ROS 2"}, dance))
    job.hand_to_pages(transport(1, "paused", beat=0.5))
    inbox.put(Lost(2))
    inbox.put({"type": "ping", "number": 3})
    assert said.get(timeout=LIMIT) == {"type": "lacks", "generation": 2}
    assert said.get(timeout=LIMIT) == {"type": "pong", "number": 3}

    async def first(*kinds: str) -> dict[str, Any]:
        page = job.ready["page"]
        found: dict[str, Any] = {}
        async with (
            aiohttp.ClientSession() as session,
            session.ws_connect(f"{page}live?token={TOKEN}&page=p", origin=page.rstrip("/")) as socket,
        ):
            while found.keys() != {*kinds}:
                message = await socket.receive_json(timeout=LIMIT)
                found |= {message["type"]: message} if message["type"] in kinds else {}
            inbox.put(End())
            while (await socket.receive_json(timeout=LIMIT))["type"] != "stopped":
                pass
        return found

    found = asyncio.run(first("score", "transport", "poses"))
    thread.join(LIMIT)
    assert codes == [0]
    assert found["score"]["text"] == "r $ forward left\n"
    assert found["poses"]["poses"] == [[1.0, 0.0, 0.0, 0.0]]
