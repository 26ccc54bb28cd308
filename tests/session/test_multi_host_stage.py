"""Stages on several machines that look like one, faked."""

from __future__ import annotations

import asyncio
import threading
from collections.abc import Awaitable, Callable
from typing import Any

import pytest

from improv_core.ipc.stage_process import StageError
from improv_core.safety.stops import Stops
from improv_core.score.score_json import RowsWritten, to_json
from improv_core.session.group import multi_host_stage, rules
from improv_core.session.group.multi_host_stage import MultiHostStage
from improv_core.session.group.state import HERE
from improv_core.session.session import Playback
from improv_core.session.start import Options
from improv_core.session.state import PlayScore
from tests.session.fakes import LIMIT, Fake
from tests.session.story import DANCE, at
from tests.session.test_group import PI, on_hosts


class Members:
    """The stages of hosts, faked, and the messages of all together. Hosts that are `unreachable` fail to start, and the
    one that is `silent` starts once it `answers`."""

    def __init__(self, unreachable: set[str]) -> None:
        self.unreachable = unreachable
        self.problem = "ssh can't find {}"
        self.failed = 0
        self.silent: str | None = None
        self.answers = asyncio.Event()
        self.stages: dict[str, Fake] = {}
        self.heard: list[Any] = []
        self.news = asyncio.Event()

    async def start(self, host: str, hear: Any) -> Any:
        self.news.set()
        if host == self.silent:
            await self.answers.wait()
        if host in self.unreachable:
            self.failed += 1
            raise StageError(self.problem.format(host))
        self.stages[host] = Fake("ros", Options(), hear, Stops())
        return self.stages[host]

    def hear(self, stage: MultiHostStage, message: Any, stops: int) -> None:
        self.heard.append(message)
        self.news.set()

    async def until(self, fits: Callable[[], bool]) -> None:
        async def look() -> None:
            while not fits():
                await self.news.wait()
                self.news.clear()

        await asyncio.wait_for(look(), LIMIT)

    @property
    def lines(self) -> list[str]:
        return [each["message"] for each in self.heard if each["type"] == "warning"]


def performed(*unreachable: str) -> Callable[[Callable[..., Awaitable[None]]], Callable[..., None]]:
    """Give a test the stage here and one on a host, of which these are unreachable, and close them afterwards."""

    async def perform(test: Callable[..., Awaitable[None]]) -> None:
        members = Members({*unreachable})
        all_ = await MultiHostStage.start([HERE, PI], members.start, members.hear)
        await test(members, all_)
        await all_.close()
        assert not any(stage.alive for stage in members.stages.values())

    return lambda test: lambda: asyncio.run(perform(test))


@pytest.fixture(autouse=True)
def _short_limits(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(multi_host_stage, "PAUSES", (0.0,))
    monkeypatch.setattr(rules, "CONFIRM_LIMIT", 0.05)


@performed()
async def test_a_stop_reaches_all_stages_from_any_thread_while_the_event_loop_is_busy(
    members: Members, all_: MultiHostStage
) -> None:
    stopping = threading.Thread(target=all_.send, args=({"type": "stop"},))
    stopping.start()
    stopping.join()  # the event loop does nothing meanwhile
    assert [stage.kinds for stage in members.stages.values()] == [["stop"], ["stop"]]


@performed()
async def test_stages_are_one_stage_of_real_robots(members: Members, all_: MultiHostStage) -> None:
    assert all_.ready == {"type": "ready", "protocol": 3, "sink": f"ros; ros on {PI}", "real": True}


@performed(PI)
async def test_each_reason_why_a_host_cannot_be_reached_is_reported_once(
    members: Members, all_: MultiHostStage
) -> None:
    await members.until(lambda: members.failed > 2)
    members.problem = "ssh refuses {}"
    seen = members.failed
    await members.until(lambda: members.failed > seen + 2)
    members.unreachable.clear()
    await members.until(lambda: PI in members.stages)
    assert members.lines == [
        f"{PI} can't be reached: {problem} {PI} (Improv keeps trying)" for problem in ("ssh can't find", "ssh refuses")
    ]


@pytest.mark.parametrize("closes", [False, True])
def test_robots_that_have_not_confirmed_a_stop_are_named_once(closes: bool) -> None:
    @performed()
    async def test(members: Members, all_: MultiHostStage) -> None:
        load(all_)
        for stage in members.stages.values():
            stage.say(at("playing", 1))
        all_.send({"type": "stop"})
        members.stages[HERE].say(at("stopped", 1))
        if closes:  # Ctrl-C stops first, and then closes
            await all_.close()
        await members.until(lambda: "unreached" in [each["type"] for each in members.heard])
        lines = [each["message"] for each in members.heard if each["type"] == "unreached"]
        assert lines == [f"p, q may still be moving: {PI} has not confirmed the stop"]

    test()


def load(all_: MultiHostStage) -> None:
    score = to_json(on_hosts("a p q o $ forward\n"), RowsWritten())
    all_.send({"type": "load", "generation": 1, "score": score, "when": "restart", "backend": "all"})


@pytest.mark.parametrize("then", ["it answers", "it fails", "it stays silent"])
def test_the_others_begin_without_a_host_that_does_not_answer(then: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(multi_host_stage, "SLOW", 0.0)
    monkeypatch.setattr(multi_host_stage, "LATEST", 0.0)

    async def perform() -> None:
        members = Members({PI} if then == "it fails" else set())
        members.silent = PI
        all_ = await MultiHostStage.start([HERE, PI], members.start, members.hear)
        load(all_)
        assert [*members.stages] == [HERE]
        if then != "it stays silent":
            members.answers.set()
            await members.until(lambda: members.failed > 1 or (PI in members.stages and bool(members.stages[PI].loads)))
        assert members.lines == [
            f"{PI} has not answered for 0 s: the others wait for up to 0 s",
            f"{PI} has not answered for 0 s: the others begin, and it joins them",
            *([f"{PI} can't be reached: ssh can't find {PI} (Improv keeps trying)"] if then == "it fails" else []),
        ]
        await all_.close()
        assert not any(stage.alive for stage in members.stages.values())

    asyncio.run(perform())


@performed()
async def test_robots_move_if_the_stage_of_their_host_reports_it(members: Members, all_: MultiHostStage) -> None:
    load(all_)
    members.stages[PI].say(at("playing", 1))
    assert all_.moving("apqo") == ["p", "q"], "whatever has become of the others"


@pytest.mark.parametrize("unreachable", [(HERE,), (HERE, PI)])
def test_nothing_starts_if_the_stage_here_fails(unreachable: tuple[str, ...]) -> None:
    with pytest.raises(StageError, match=r"ssh can't find $"):
        performed(*unreachable)(lambda members, all_: asyncio.sleep(0))()


def test_nothing_starts_if_there_can_be_no_stage_at_all() -> None:
    async def none(host: str, hear: Any) -> None:
        return None

    with pytest.raises(StageError, match="no stage could be started"):
        asyncio.run(MultiHostStage.start([HERE, PI], none, lambda *_: None))


@performed()
async def test_a_request_on_a_robot_is_passed_on(members: Members, all_: MultiHostStage) -> None:
    members.stages[PI].say({"type": "request", "command": {"type": "pause"}})
    assert members.heard == [{"type": "request", "command": {"type": "pause"}}]


def test_a_score_with_other_hosts_starts_their_stages() -> None:
    opened: list[list[str]] = []

    async def start(sink: Any, options: Options, token: str, hear: Any, stops: Stops) -> Any:
        if sink == "ros":
            opened.append([host.name for host in options.hosts])
        return Fake(sink, options, hear, stops)

    async def perform() -> None:
        playback = Playback(Options("both"), lambda message, leads: None, Stops(), start)
        for score in (DANCE, DANCE, on_hosts("a p $ forward\n"), DANCE):
            await playback.play(PlayScore(score, "dance.improv", playback.stops.count))
        await playback.play(PlayScore(on_hosts("o $ forward\n"), "dance.improv", playback.stops.count, simulated=True))
        await playback.close()

    asyncio.run(perform())
    assert opened == [[], [PI]], "stages that run already, or that nobody needs, are not started"
