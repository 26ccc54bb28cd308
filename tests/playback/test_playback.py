"""Stages are started, told what has been decided, and ended. They are fakes that the tests speak for, but for one test.

What is decided is asked in test_asked.py and test_heard.py."""

from __future__ import annotations

import asyncio
import tempfile
from collections.abc import Awaitable, Callable, Iterator, Mapping
from dataclasses import replace
from inspect import signature
from pathlib import Path
from typing import Any

import pytest

from improv_core.playback import stop_socket
from improv_core.playback.acts import News
from improv_core.playback.playback import Playback, RunningStage
from improv_core.playback.show import PlayScore
from improv_core.playback.stage_process import Heard, StageError
from improv_core.playback.start import Options, SinkName
from improv_core.playback.stop_socket import IDLE, StopSocket, stop_all
from improv_core.playback.stops import Stops
from improv_core.program.analysis import analyze
from improv_core.program.compiler import score_of
from improv_core.score.score import Safety, Score
from improv_core.stage.commands import Conduct, Editing
from improv_core.stage.messages import (
    FromStage,
    Load,
    Pressed,
    Ready,
    State,
    ToStage,
)
from tests.playback.story import DANCE, at

LIMIT = 60.0
OPEN = score_of(analyze("r $ until cue (repeat forward)\n"))


Hear = Callable[[RunningStage, Heard, int], None]


@pytest.fixture(autouse=True)
def _runtime(monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    """A folder of sockets with a short name, in which nothing else plays."""
    with tempfile.TemporaryDirectory(dir="/tmp") as folder:
        monkeypatch.setenv("XDG_RUNTIME_DIR", folder)
        for name in ("RUNTIME", "SHARED"):
            monkeypatch.setattr(stop_socket, name, Path(folder))
        yield


class Fake:
    """A stage that remembers what it is sent, and says what a test has it say."""

    def __init__(self, sink: SinkName, options: Options, hear: Hear, stops: Stops) -> None:
        self._hear = hear
        self._stops = stops
        self.sink = sink
        self.alive = True
        self.sent: list[ToStage] = []
        self.ready: Ready = {"type": "ready", "protocol": 1, "sink": sink, "real": sink == "ros"}
        if sink == "simulator":
            self.ready["page"] = f"http://127.0.0.1:{options.port or 8123}/"

    def send(self, message: ToStage) -> None:
        self.sent.append(message)

    async def close(self) -> None:
        self.alive = False

    def say(self, message: FromStage) -> None:
        self.hear(message, self._stops.arrive(message["command"]) if message["type"] == "request" else 0)

    def hear(self, message: FromStage, asked: int) -> None:
        self._hear(self, message, asked)

    def die(self) -> None:
        self.alive = False
        self._hear(self, {"type": "gone", "message": "the stage exited unexpectedly"}, 0)

    def tell(
        self, state: State, beat: float = 0.0, monotonic: float = 500.0, begins: Mapping[str, float] | None = None
    ) -> None:
        """Report where it is in the score that it was given last."""
        known = {"restarted": 1, "begins": begins} if begins else {}
        self.say(at(state, self.loads[-1]["generation"], beat, monotonic, **known))

    @property
    def loads(self) -> list[Load]:
        return [message for message in self.sent if message["type"] == "load"]

    @property
    def kinds(self) -> list[str]:
        return [message["type"] for message in self.sent]


class Show:
    """A playback on ROS 2 and the simulator, both faked, and what it tells its listener."""

    def __init__(self, backend: str = "both") -> None:
        self.stages: list[Fake] = []
        self.news: list[News] = []
        self.edits: list[tuple[Editing, int]] = []
        self.fails: set[str] = set()
        self.held: set[SinkName] = set()  # these stages only start
        self.released = asyncio.Event()  # once this is set
        self.stops = Stops()
        self.playback = Playback(
            Options(backend), lambda message, leads: self.news.append(message), self.stops, self._start
        )

    def edit(self, editing: Editing, asked: int) -> None:
        self.edits.append((editing, asked))

    async def _start(self, sink: SinkName, options: Options, token: str, hear: Hear, stops: Stops) -> Fake:
        if sink in self.held:
            await self.released.wait()
        if sink in self.fails:
            raise StageError(f"no {sink} here")
        self.stages.append(Fake(sink, options, hear, stops))
        return self.stages[-1]

    async def until(self, fits: Callable[[], Any]) -> None:
        """Let everything else go on until it fits."""

        async def look() -> None:
            while not fits():  # noqa: ASYNC110
                await asyncio.sleep(0)

        await asyncio.wait_for(look(), LIMIT)

    def latest(self, sink: SinkName) -> Fake:
        return next(stage for stage in reversed(self.stages) if stage.sink == sink)

    async def begin(self) -> int | None:
        """Have a program played; returns its generation."""
        return await self.playback.play(PlayScore(DANCE, "dance.improv", self.stops.count))

    async def play(self) -> tuple[Fake, Fake]:
        """Begin: the stage that leads, and its twin, which play."""
        assert await self.begin()
        leader, twin = self.latest("ros"), self.latest("simulator")
        leader.tell("playing")
        return leader, twin

    @property
    def lines(self) -> list[str]:
        return [each["message"] for each in self.news if each["type"] in ("warning", "error", "gone")]


def performed_on(backend: str) -> Callable[[Callable[..., Awaitable[None]]], Callable[..., None]]:
    """Give a test a show on a backend."""

    def decorated(test: Callable[..., Awaitable[None]]) -> Callable[..., None]:
        async def perform(**given: Any) -> None:
            show = Show(backend)
            try:
                await test(show, **given)
            finally:
                await show.playback.close()
                assert not any(stage.alive for stage in show.stages)

        def run(**given: Any) -> None:
            asyncio.run(perform(**given))

        asked = signature(test)
        others = [parameter for name, parameter in asked.parameters.items() if name != "show"]
        run.__name__, run.__doc__ = test.__name__, test.__doc__
        run.__signature__ = asked.replace(parameters=others)  # type: ignore[attr-defined]
        return run

    return decorated


@performed_on("both")
async def test_the_twin_begins_at_beat_0_of_the_leading_stage(show: Show) -> None:
    assert await show.begin() == 1
    leader, twin = show.latest("ros"), show.latest("simulator")
    leader.tell("waiting")
    assert (leader.kinds, twin.kinds) == (["load"], [])
    leader.tell("playing", beat=3.0, monotonic=500.0)  # three beats at 120 a minute since beat 0
    entry = {"beat": 3.0, "monotonic": 500.0}
    (load,) = leader.loads
    del load["stops"], load["asleep"]  # the simulator harms nobody
    assert twin.loads == [{**load, "entry": entry}]
    leader.tell("playing", beat=4.0, monotonic=500.5)
    assert len(twin.loads) == 1


@pytest.mark.parametrize(("command", "sent"), [({"type": "restart"}, "load"), ({"type": "resume"}, "resume")])
@performed_on("both")
async def test_a_page_request_made_before_a_stop_does_not_move_robots_after_it(
    show: Show, command: Any, sent: str
) -> None:
    leader, twin = await show.play()
    asked = show.stops.arrive(command)  # on the thread that reads
    twin.say({"type": "request", "command": {"type": "hush"}})
    twin.hear({"type": "request", "command": command}, asked)  # on the event loop
    assert leader.kinds == ["load", "hush"]
    twin.say({"type": "request", "command": command})
    assert leader.kinds == ["load", "hush", sent]


@performed_on("both")
async def test_a_stop_from_another_terminal(show: Show) -> None:
    reached = StopSocket(show.playback.stop)
    show.held = {"ros", "simulator"}
    beginning = asyncio.ensure_future(show.begin())
    await asyncio.sleep(0)  # it is on its way
    assert await asyncio.to_thread(list, stop_all()) == ["stopped dance.improv before it began"]
    show.released.set()
    assert await beginning is None
    assert await asyncio.to_thread(list, stop_all()) == [IDLE]
    leader, twin = await show.play()
    assert await asyncio.to_thread(list, stop_all()) == ["stopped dance.improv on ros, with the simulator alongside"]
    assert leader.kinds[-1] == twin.kinds[-1] == "hush"
    leader.tell("stopped")
    assert await asyncio.to_thread(list, stop_all()) == [IDLE]
    assert show.lines == ["stopped by `improv stop`"] * 2
    await show.playback.close()
    reached.close()
    assert list(stop_all()) == []


@performed_on("both")
async def test_real_robots_play_only_if_improv_stop_reaches_them(show: Show) -> None:
    show.stops.unreachable = "there is no folder"
    with pytest.raises(StageError, match=r"^real robots need `improv stop`: there is no folder$"):
        await show.play()
    show.playback = Playback(Options("sim"), lambda message, leads: None, show.stops, show._start)
    await show.playback.open()
    await show.playback.close()


GUARDED = replace(DANCE, safety=Safety(stop="/e_stop"))
REFUSED = "✗ the emergency stop on /e_stop is on: release it, then save again"
ON: Pressed = {"type": "pressed", "topics": ["/e_stop"], "count": 1}
OFF: Pressed = {"type": "pressed", "topics": [], "count": 1}


@performed_on("both")
async def test_an_emergency_stop_is_kept_when_its_stage_dies_and_when_another_playback_begins(show: Show) -> None:
    leader, _ = await show.play()
    leader.say(ON)
    leader.die()
    await show.until(lambda: len(show.stages) == 3)
    revived = show.latest("ros")
    await show.until(lambda: "load" in revived.kinds)
    assert revived.sent[0] == ON  # so that it hears the release
    assert "stops" not in revived.loads[0]  # it only stops the robots
    revived.tell("stopped")
    assert await show.playback.play(PlayScore(GUARDED, "dance.improv", show.stops.count)) is None
    other = Playback(Options("ros"), lambda message, leads: show.news.append(message), show.stops, show._start)
    assert await other.play(PlayScore(GUARDED, "dance.improv", show.stops.count)) is None
    assert show.lines[-2:] == [REFUSED] * 2
    assert show.latest("ros").sent[0] == ON
    show.latest("ros").say(OFF)
    assert await other.play(PlayScore(GUARDED, "dance.improv", show.stops.count))
    await other.close()


@performed_on("both")
async def test_a_score_says_how_many_emergency_stops_were_known_when_it_was_requested(
    show: Show,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr("improv_core.playback.playback.KNOWN", 0.0)
    leader, _ = await show.play()
    assert leader.loads[-1]["stops"] == 0
    before = show.stops.count
    leader.say(ON)
    leader.say(OFF)
    assert await show.begin()  # it arrived together with the press, so nobody can have known of that
    assert leader.loads[-1]["stops"] == 0
    await show.until(lambda: show.stops.known)
    assert await show.playback.play(PlayScore(DANCE, "dance.improv", before)) is None
    assert await show.begin()
    assert leader.loads[-1]["stops"] == 1


@performed_on("both")
async def test_a_dead_leading_stage_is_replaced_by_one_that_stops_the_robots_first(show: Show) -> None:
    leader, twin = await show.play()
    leader.die()
    assert twin.kinds == ["load", "hush"]
    assert show.lines == ["the stage exited unexpectedly: a new one is stopping the robots; save to play again"]
    await show.until(lambda: show.latest("ros") is not leader and show.latest("ros").sent)
    new = show.latest("ros")
    (standing,) = new.loads
    assert standing["score"]["parts"].keys() == {"r"}
    assert standing["score"]["movements"] == []
    new.tell("ended")
    assert await show.begin()
    assert new.loads[-1]["score"] != standing["score"]


@performed_on("both")
async def test_closing_after_playing_again_does_not_wait_for_robots_to_be_stopped(show: Show) -> None:
    leader, _ = await show.play()
    leader.die()
    await show.until(lambda: show.latest("ros") is not leader and show.latest("ros").sent)
    assert await show.begin()
    await asyncio.wait_for(show.playback.close(), 4.0)  # half of HALT_LIMIT


@performed_on("both")
async def test_a_dead_twin_is_replaced_and_the_leading_stage_keeps_playing(show: Show) -> None:
    leader, twin = await show.play()
    page = show.playback.show.page
    twin.die()
    assert show.lines == ["the stage exited unexpectedly: a new one will show the next dance"]
    await show.until(lambda: show.latest("simulator") is not twin)
    assert leader.kinds == ["load"]
    await show.until(lambda: show.playback.show.page == page)
    new = show.latest("simulator")
    await show.play()
    assert len(new.loads) == 1


@pytest.mark.parametrize("ends", [False, True])
@performed_on("both")
async def test_a_play_that_was_stopped_while_stages_started_never_begins(show: Show, ends: bool) -> None:
    show.held = {"ros", "simulator"}
    playing = asyncio.ensure_future(show.begin())
    await asyncio.sleep(0)  # it is on its way
    if ends:
        closing = asyncio.ensure_future(show.playback.close())
        await asyncio.sleep(0)
        show.released.set()
        await closing
    else:
        show.stops.stop()
        show.released.set()
    assert await playing is None
    assert not any(stage.loads for stage in show.stages)
    assert await show.begin() == 1


@pytest.mark.parametrize("failing", ["ros", "simulator"])
@performed_on("both")
async def test_if_one_stage_cannot_start_none_is_left_open(show: Show, failing: SinkName) -> None:
    show.fails = {failing}
    with pytest.raises(StageError, match=f"no {failing} here"):
        await show.begin()
    (other,) = show.stages
    assert not other.alive
    assert show.playback.show.status == "nothing"
    show.fails.clear()
    assert await show.begin()


@performed_on("both")
async def test_giving_up_while_stages_start_leaves_none_open(show: Show) -> None:
    show.held = {"simulator"}
    opening = asyncio.ensure_future(show.playback.open())
    await show.until(lambda: len(show.stages) == 1)  # the other is not there yet
    opening.cancel()
    with pytest.raises(asyncio.CancelledError):
        await opening
    assert not any(stage.alive for stage in show.stages)


@performed_on("both")
async def test_a_stage_that_cannot_be_replaced_is_reported_and_the_next_play_tries_again(show: Show) -> None:
    leader, _ = await show.play()
    show.fails = {"ros"}
    leader.die()
    await show.until(lambda: len(show.lines) == 2)
    assert show.lines[-1] == "no new stage could be started: no ros here"
    show.fails.clear()
    assert await show.begin()
    assert len(show.latest("ros").loads) == 1


@performed_on("both")
async def test_only_a_parent_that_edits_obeys_a_page_that_does_and_a_stop_comes_first(show: Show) -> None:
    write: Editing = {
        "type": "editing",
        "page": 1,
        "ask": {"type": "write", "number": 1, "text": "ada $ left\n", "revision": ""},
    }
    _, twin = await show.play()
    news = len(show.news)
    twin.say({"type": "request", "command": write})
    assert (show.edits, len(show.news), twin.kinds) == ([], news, ["load"])
    await show.playback.close()
    show.playback = Playback(Options("both"), lambda message, leads: None, show.stops, show._start, show.edit)
    _, twin = await show.play()
    asked = show.stops.arrive(write)  # on the thread that reads
    twin.say({"type": "request", "command": {"type": "hush"}})
    twin.hear({"type": "request", "command": write}, asked)  # on the event loop
    assert show.edits == [(write, asked)]
    assert await show.playback.play(PlayScore(DANCE, "dance.improv", asked)) is None  # it was stopped before it began


@performed_on("both")
async def test_what_a_page_requests_reaches_all_stages_for_the_same_time(show: Show) -> None:
    leader, twin = await show.play()
    requests: list[Conduct] = [{"type": "pause"}, {"type": "seek", "beat": 2.0}, {"type": "resume"}, {"type": "hush"}]
    for request in requests:
        twin.say({"type": "request", "command": request})
        assert leader.sent[-1] == twin.sent[-1]
        assert leader.sent[-1] == {**request, "at": leader.sent[-1].get("at")}


@performed_on("both")
async def test_what_real_robots_are_told_at_once_the_twin_is_told_when_it_is_there(show: Show) -> None:
    await show.playback.play(PlayScore(OPEN, "dance", 0))
    leader, twin = show.latest("ros"), show.latest("simulator")
    leader.tell("playing")
    show.playback.ask({"type": "seek", "beat": 4.0})
    assert (leader.kinds[-1], twin.kinds[-1]) == ("seek", "load")
    await show.until(lambda: twin.kinds[-1] == "seek")


@performed_on("both")
async def test_pages_show_what_keeps_a_program_from_playing(show: Show) -> None:
    await show.playback.open()
    show.playback.present("dance.improv", "/dances", [("dance.improv", 1, 5, "forwrd", "it is not defined")])
    problem = {"file": "dance.improv", "line": 1, "column": 5, "word": "forwrd", "message": "it is not defined"}
    message = {"type": "program", "name": "dance.improv", "folder": "/dances", "problems": [problem], "count": 1}
    assert show.latest("simulator").sent[-1] == message
    show.playback.present("dance.improv", "/dances")
    assert show.latest("simulator").sent[-1] == {**message, "problems": [], "count": 0}


@performed_on("both")
async def test_a_dance_on_other_stages_has_a_new_number_and_the_same_speed(show: Show) -> None:
    await show.play()
    show.playback.ask({"type": "silence", "muted": ["r"], "soloed": []})
    other = Playback(Options("sim"), lambda message, leads: None, show.stops, show._start)
    other.keep_as(show.playback)
    other.ask({"type": "speed", "factor": 2.0})
    assert await other.play(PlayScore(DANCE, "dance.improv", show.stops.count)) == 2
    assert show.latest("simulator").kinds == ["silence", "speed", "load"]
    assert other.show.page == show.playback.show.page
    await other.close()


@pytest.mark.slow("starts a stage")
def test_a_real_stage_plays_at_the_remembered_speed() -> None:
    async def run() -> None:
        told: asyncio.Queue[News] = asyncio.Queue()
        playback = Playback(Options("sim"), lambda message, leads: told.put_nowait(message), Stops())
        playback.ask({"type": "speed", "factor": 2.0})
        try:
            assert await playback.play(PlayScore(DANCE, "dance.improv", 0)) == 1
            while (message := await asyncio.wait_for(told.get(), LIMIT))["type"] != "transport" or (
                message["state"] != "playing"
            ):
                pass
            assert message["speed"] == 2
        finally:
            await playback.close()

    asyncio.run(run())


SAVED = analyze("anna $ repeat forward\nbert $ repeat left\n")


def edited(bert: str) -> Score:
    """The program with another line for bert."""
    at = SAVED.text.index("repeat left")
    return score_of(SAVED.edited(at, len(SAVED.text) - 1, bert))


def load_of(stage: Fake) -> tuple[int, bool, bool]:
    """The generation of the last score that a stage was sent, whether it was whole, and whether anna was only named."""
    load = stage.loads[-1]
    return load["generation"], load["score"]["known"] == 0, load["score"]["parts"]["anna"] is None


@performed_on("both")
async def test_a_save_sends_each_stage_only_what_it_lacks(show: Show) -> None:
    assert await show.playback.play(PlayScore(score_of(SAVED), "dance", show.stops.count))
    leader, twin = show.latest("ros"), show.latest("simulator")
    leader.tell("playing")
    await show.playback.play(PlayScore(edited("right"), "dance", show.stops.count, "bar", 3))
    await show.playback.play(PlayScore(edited("repeat right"), "dance", show.stops.count, "bar", 3))
    assert (load_of(leader), load_of(twin)) == ((3, False, True), (1, True, False))
    assert leader.loads[-1]["beats_per_bar"] == 3
    leader.tell("playing", beat=6.0, begins={"bert": 6.0})
    assert load_of(twin) == (3, False, True)
    assert (twin.loads[-1]["when"], twin.loads[-1]["entry"]) == (
        "now",
        {"beat": 6.0, "monotonic": 500.0, "begins": {"bert": 6.0}},
    )
    bert = twin.loads[-1]["score"]["parts"]["bert"]
    assert len(twin.loads[-1]["score"]["movements"]) < 6
    assert bert["editions"] not in [twin.loads[0]["score"]["parts"][robot]["editions"] for robot in ("anna", "bert")]


@pytest.mark.parametrize("sink", ["ros", "simulator"])
@performed_on("both")
async def test_a_stage_that_lacks_something_is_sent_the_whole_score(show: Show, sink: SinkName) -> None:
    assert await show.playback.play(PlayScore(score_of(SAVED), "dance", show.stops.count))
    leader, stage = show.latest("ros"), show.latest(sink)
    leader.tell("playing")
    await show.playback.play(PlayScore(edited("right"), "dance", show.stops.count, "beat"))
    leader.tell("playing", beat=6.0, begins={"bert": 6.0})
    before = len(stage.loads)
    stage.say({"type": "lacks", "generation": 1})  # an old one, which nobody needs anymore
    assert len(stage.loads) == before
    stage.say({"type": "lacks", "generation": 2})
    assert load_of(stage) == (2, True, False)
    assert stage.loads[-1].get("entry") == stage.loads[-2].get("entry")


@performed_on("both")
async def test_the_score_after_one_held_back_by_a_stop_is_sent_whole(show: Show) -> None:
    assert await show.playback.play(PlayScore(score_of(SAVED), "dance", show.stops.count))
    asked = show.stops.count
    show.stops.stop()
    assert await show.playback.play(PlayScore(edited("right"), "dance", asked, "beat")) is None
    assert await show.playback.play(PlayScore(edited("right"), "dance", show.stops.count, "beat")) == 2
    assert load_of(show.latest("ros")) == (2, True, False)


@performed_on("both")
async def test_a_new_stage_is_sent_the_whole_score(show: Show) -> None:
    assert await show.playback.play(PlayScore(score_of(SAVED), "dance", show.stops.count))
    leader = show.latest("ros")
    leader.die()
    await show.until(lambda: show.latest("ros") is not leader and show.latest("ros").loads)
    show.latest("ros").tell("ended")
    await show.until(lambda: show.playback._stages["ros"] is show.latest("ros"))
    assert await show.playback.play(PlayScore(edited("right"), "dance", show.stops.count, "beat")) == 2
    load = show.latest("ros").loads[-1]["score"]
    assert max(load["parts"]["anna"]["scenes"]) < load["known"] + len(load["movements"])
