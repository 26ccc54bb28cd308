"""A playback whose real robots have stages on several machines, faked."""

from __future__ import annotations

import asyncio
import threading
from collections.abc import Awaitable, Callable
from typing import Any

import pytest

from improv_core.ipc.stage_process import StageError
from improv_core.safety.stops import Stops
from improv_core.session import on_hosts as hosts
from improv_core.session import start as starting
from improv_core.session.acts import News
from improv_core.session.session import Playback
from improv_core.session.start import Options
from improv_core.session.state import HERE, Output, PlayScore
from tests.session.fakes import LIMIT, Fake
from tests.session.story import DANCE, at
from tests.session.test_group import PI, on_hosts

ON_PI = on_hosts("a p q $ forward\n")


class Members:
    """The stages of hosts, faked, and the messages of all together. Hosts that are `unreachable` fail to start, and the
    one that is `silent` starts once it `answers`."""

    def __init__(self, *unreachable: str, backend: str = "ros") -> None:
        self.unreachable = {*unreachable}
        self.problem = "ssh can't find {}"
        self.failed = 0
        self.silent: str | None = None
        self.answers = asyncio.Event()
        self.stages: dict[str, Fake] = {}
        self.heard: list[Any] = []
        self.news = asyncio.Event()
        self.playback = Playback(Options(backend), self.hear, Stops(), self.start)

    async def start(self, output: Output, options: Options, token: str, hear: Any, stops: Stops) -> Fake | None:
        self.news.set()
        host = options.host.name if options.host else HERE
        if host == self.silent:
            await self.answers.wait()
        if host in self.unreachable:
            self.failed += 1
            raise StageError(self.problem.format(host))
        self.stages[host] = Fake(output, options, hear, stops)
        return self.stages[host]

    def hear(self, message: News, leads: bool) -> None:
        self.heard.append(message)
        self.news.set()

    async def open(self) -> None:
        await self.playback.open(ON_PI.hosts)

    async def play(self) -> None:
        assert await self.playback.play(PlayScore(ON_PI, "dance.improv", self.playback.stops.count))

    async def until(self, fits: Callable[[], bool]) -> None:
        async def look() -> None:
            while not fits():
                await self.news.wait()
                self.news.clear()

        await asyncio.wait_for(look(), LIMIT)

    @property
    def lines(self) -> list[str]:
        return [each["message"] for each in self.heard if each["type"] == "warning"]


def performed(*unreachable: str) -> Callable[[Callable[[Members], Awaitable[None]]], Callable[[], None]]:
    """Give a test the stage here and one on a host, of which these are unreachable, and close them afterwards."""

    async def perform(test: Callable[[Members], Awaitable[None]]) -> None:
        members = Members(*unreachable)
        await members.open()
        await test(members)
        await members.playback.close()
        assert not any(stage.alive for stage in members.stages.values())

    return lambda test: lambda: asyncio.run(perform(test))


@pytest.fixture(autouse=True)
def _short_limits(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(starting, "PAUSES", (0.0,))
    monkeypatch.setattr(hosts, "CONFIRM_LIMIT", 0.05)


@performed()
async def test_a_stop_reaches_all_stages_from_any_thread_while_the_event_loop_is_busy(members: Members) -> None:
    stopping = threading.Thread(target=members.playback.stops.stop)
    stopping.start()
    stopping.join()  # the event loop does nothing meanwhile
    assert [stage.kinds for stage in members.stages.values()] == [["stop"], ["stop"]]


@performed()
async def test_stages_are_one_backend_of_real_robots(members: Members) -> None:
    assert (members.playback.state.status, members.playback.state.is_real) == (f"ros; ros on {PI}", True)


@performed(PI)
async def test_each_reason_why_a_host_cannot_be_reached_is_reported_once(members: Members) -> None:
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
    async def test(members: Members) -> None:
        await members.play()
        for stage in members.stages.values():
            stage.say(at("playing", 1))
        members.playback.stops.stop()
        members.stages[HERE].say(at("stopped", 1))
        if closes:  # Ctrl-C stops first, and then closes
            await members.playback.close()
        await members.until(lambda: "unreached" in [each["type"] for each in members.heard])
        lines = [each["message"] for each in members.heard if each["type"] == "unreached"]
        assert lines == [f"p, q may still be moving: {PI} has not confirmed the stop"]

    test()


@pytest.mark.parametrize("then", ["it answers", "it fails", "it stays silent"])
def test_the_others_begin_without_a_host_that_does_not_answer(then: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(starting, "SLOW", 0.0)
    monkeypatch.setattr(starting, "LATEST", 0.0)

    async def perform() -> None:
        members = Members(*([PI] if then == "it fails" else []))
        members.silent = PI
        await members.play()
        assert [*members.stages] == [HERE]
        if then != "it stays silent":
            members.answers.set()
            await members.until(lambda: members.failed > 1 or (PI in members.stages and bool(members.stages[PI].loads)))
        assert members.lines == [
            f"{PI} has not answered for 0 s: the others wait for up to 0 s",
            f"{PI} has not answered for 0 s: the others begin, and it joins them",
            *([f"{PI} can't be reached: ssh can't find {PI} (Improv keeps trying)"] if then == "it fails" else []),
        ]
        await members.playback.close()
        assert not any(stage.alive for stage in members.stages.values())

    asyncio.run(perform())


@performed()
async def test_robots_move_if_the_stage_of_their_host_reports_it(members: Members) -> None:
    await members.play()
    members.stages[PI].say(at("playing", 1))
    line = f"stopped dance.improv on ros; ros on {PI}: 2 robots were moving"
    assert members.playback.stop({"type": "stop"}) == line, "whatever has become of the other"


@pytest.mark.parametrize("unreachable", [(HERE,), (HERE, PI)])
def test_nothing_starts_if_the_stage_here_fails(unreachable: tuple[str, ...]) -> None:
    with pytest.raises(StageError, match=r"ssh can't find $"):
        performed(*unreachable)(lambda members: asyncio.sleep(0))()


def test_nothing_starts_if_there_can_be_no_stage_at_all() -> None:
    async def none(*_: Any) -> None:
        return None

    playback = Playback(Options("ros"), lambda message, leads: None, Stops(), none)
    with pytest.raises(StageError, match="no stage could be started"):
        asyncio.run(playback.open(ON_PI.hosts))


@performed()
async def test_a_request_on_a_robot_is_obeyed_by_all(members: Members) -> None:
    members.stages[PI].say({"type": "request", "command": {"type": "pause"}})
    assert [stage.kinds for stage in members.stages.values()] == [["pause"], ["pause"]]


def test_a_score_with_other_hosts_starts_their_stages() -> None:
    opened: list[str] = []

    async def start(output: Output, options: Options, token: str, hear: Any, stops: Stops) -> Fake:
        if output == "ros":
            opened.append(options.host.name if options.host else HERE)
        return Fake(output, options, hear, stops)

    async def perform() -> None:
        playback = Playback(Options("both"), lambda message, leads: None, Stops(), start)
        for score in (DANCE, DANCE, on_hosts("a p $ forward\n"), DANCE):
            await playback.play(PlayScore(score, "dance.improv", playback.stops.count))
        await playback.play(PlayScore(on_hosts("o $ forward\n"), "dance.improv", playback.stops.count, simulated=True))
        await playback.close()

    asyncio.run(perform())
    assert opened == [HERE, HERE, PI], "stages that run already, or that nobody needs, are not started"


@performed()
async def test_a_resume_from_before_a_pause_changes_nothing(members: Members) -> None:
    await members.play()
    generation = members.playback.state.generation
    for stage in members.stages.values():
        stage.say({"type": "armed", "generation": generation, "armed": True, "begins": None})
    for stage in members.stages.values():
        stage.say(at("playing", generation))
    asked = members.playback.stops.count
    members.playback.stops.stop({"type": "pause"})
    for stage in members.stages.values():
        stage.say(at("paused", generation, 1.0))
    members.playback.ask({"type": "resume"}, asked)
    assert [stage.kinds[-1] for stage in members.stages.values()] == ["pause", "pause"]
    members.playback.ask({"type": "resume"}, members.playback.stops.count)
    assert [stage.kinds[-1] for stage in members.stages.values()] == ["resume", "resume"]
