"""All stages as one. The stages are fakes that the tests speak for, but for the last test."""

from __future__ import annotations

import asyncio
import tempfile
from collections.abc import Awaitable, Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Any

import pytest

from improv_core.playback.playback import BEHIND, News, Playback, RunningStage
from improv_core.playback.stage_process import Heard, StageError
from improv_core.playback.start import Options, SinkName
from improv_core.playback.stop_socket import IDLE, stop_all
from improv_core.playback.stops import Stops
from improv_core.program.analysis import analyze
from improv_core.program.compiler import score_of
from improv_core.score.score import Safety, Score
from improv_core.stage.protocol import (
    Answer,
    Conduct,
    Decided,
    Editing,
    FromStage,
    Load,
    Moment,
    Ready,
    Sensed,
    Source,
    State,
    ToStage,
    TransportMessage,
    Written,
)

LIMIT = 60.0
ENDLESS = score_of(analyze("r $ repeat forward\n"))


Hear = Callable[[RunningStage, Heard, int], None]


@pytest.fixture(autouse=True)
def _runtime(monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    """A folder of sockets with a short name, in which nothing else plays."""
    with tempfile.TemporaryDirectory(dir="/tmp") as folder:
        monkeypatch.setenv("XDG_RUNTIME_DIR", folder)
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
        self,
        state: State,
        beat: float = 0.0,
        monotonic: float = 500.0,
        waits_for: Sequence[str] = (),
        begins: Mapping[str, float] | None = None,
    ) -> None:
        """Say where it is in what it was given to play last."""
        transport: TransportMessage = {
            "type": "transport",
            "generation": self.loads[-1]["generation"],
            "restarted": 1 if begins else self.loads[-1]["generation"],
            "state": state,
            "backend": "fake",
            "tempo": 120.0,
            "speed": 1.0,
            "beats": None,
            "beat": beat,
            "performed": beat / 2,
            "muted": [],
            "soloed": [],
            "monotonic": monotonic,
            "wall": 0.0,
        }
        if waits_for:
            transport["waits_for"] = waits_for
        if begins:
            transport["begins"] = begins
        self.say(transport)

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
        """Have a program played. Its generation."""
        return await self.playback.play(ENDLESS, "dance.improv", self.stops.count)

    async def play(self) -> tuple[Fake, Fake]:
        """Begin: the stage that leads, and its twin, which play."""
        assert await self.begin()
        leader, twin = self.latest("ros"), self.latest("simulator")
        leader.tell("playing")
        return leader, twin

    @property
    def lines(self) -> list[str]:
        return [each["message"] for each in self.news if each["type"] in ("warning", "error", "gone")]


def check(performs: Callable[[Show], Awaitable[None]], backend: str = "both") -> None:
    async def run() -> None:
        show = Show(backend)
        try:
            await performs(show)
        finally:
            await show.playback.close()
            assert not any(stage.alive for stage in show.stages)

    asyncio.run(run())


def test_the_twin_begins_at_the_beat_0_of_the_stage_that_leads() -> None:
    async def performs(show: Show) -> None:
        assert await show.begin() == 1
        leader, twin = show.latest("ros"), show.latest("simulator")
        leader.tell("waiting")
        assert (leader.kinds, twin.kinds) == (["load"], [])
        leader.tell("playing", beat=3.0, monotonic=500.0)  # three beats at 120 a minute since beat 0
        entry = {"beat": 3.0, "monotonic": 500.0}
        assert twin.loads == [{**leader.loads[0], "entry": entry}]
        leader.tell("playing", beat=4.0, monotonic=500.5)
        assert len(twin.loads) == 1

    check(performs)


def test_the_twin_stops_where_the_stage_that_leads_stops_by_itself() -> None:
    async def performs(show: Show) -> None:
        leader, twin = await show.play()
        leader.tell("stopped")
        assert twin.kinds == ["load", "hush"]

    check(performs)


@pytest.mark.parametrize("asker", ["ros", "simulator"])
def test_what_is_asked_for_at_a_page_reaches_all_stages_at_one_time(asker: SinkName) -> None:
    async def performs(show: Show) -> None:
        leader, twin = await show.play()
        requests: list[Conduct] = [
            {"type": "pause"},
            {"type": "seek", "beat": 2.0},
            {"type": "speed", "factor": 0.5},
            {"type": "silence", "muted": ["r"], "soloed": []},
            {"type": "hush"},
        ]
        for request in requests:
            show.latest(asker).say({"type": "request", "command": request})
            assert leader.sent[-1] == twin.sent[-1]
            assert leader.sent[-1] == {**request, "at": leader.sent[-1].get("at")}
        assert show.playback.muted == {"r"}

    check(performs)


def test_a_page_can_play_again_and_have_starts_written_and_is_known_to_be_watched() -> None:
    async def performs(show: Show) -> None:
        leader, twin = await show.play()
        twin.say({"type": "request", "command": {"type": "restart"}})
        assert [load["generation"] for load in leader.loads] == [1, 2]
        twin.say({"type": "request", "command": {"type": "place", "start_poses": {}}})
        assert show.news[-1] == {"type": "place", "start_poses": {}}
        twin.say({"type": "request", "command": {"type": "watched"}})
        assert show.playback.watched.is_set()

    check(performs)


@pytest.mark.parametrize(("command", "sent"), [({"type": "restart"}, "load"), ({"type": "resume"}, "resume")])
def test_what_a_page_asked_for_before_a_stop_does_not_move_robots_after_it(command: Any, sent: str) -> None:
    async def performs(show: Show) -> None:
        leader, twin = await show.play()
        asked = show.stops.arrive(command)  # on the thread that reads
        twin.say({"type": "request", "command": {"type": "hush"}})
        twin.hear({"type": "request", "command": command}, asked)  # on the event loop
        assert leader.kinds == ["load", "hush"]
        twin.say({"type": "request", "command": command})
        assert leader.kinds == ["load", "hush", sent]

    check(performs)


def test_a_stop_from_another_terminal() -> None:
    async def performs(show: Show) -> None:
        show.held = {"ros", "simulator"}
        beginning = asyncio.ensure_future(show.begin())
        await asyncio.sleep(0)  # it is on its way
        assert await asyncio.to_thread(list, stop_all()) == ["stopped dance.improv before it began"]
        show.released.set()
        assert await beginning is None
        assert await asyncio.to_thread(list, stop_all()) == [IDLE]
        leader, twin = await show.play()
        assert await asyncio.to_thread(list, stop_all()) == [
            "stopped dance.improv on ros, with the simulator alongside"
        ]
        assert leader.kinds[-1] == twin.kinds[-1] == "hush"
        leader.tell("stopped")
        assert await asyncio.to_thread(list, stop_all()) == [IDLE]
        assert show.lines == ["stopped by `improv stop`"] * 2
        await show.playback.close()
        assert list(stop_all()) == []

    check(performs)


def test_there_is_no_beat_to_seek_before_anything_has_been_played() -> None:
    async def performs(show: Show) -> None:
        await show.playback.open()
        show.latest("simulator").say({"type": "request", "command": {"type": "seek", "beat": 2.0}})
        assert [stage.kinds for stage in show.stages] == [[], []]
        assert show.lines == ["nothing has been played yet: save a program before you seek"]

    check(performs)


def test_while_an_emergency_stop_is_on_a_score_that_names_it_is_refused() -> None:
    async def performs(show: Show) -> None:
        leader, twin = await show.play()
        guarded = replace(ENDLESS, safety=Safety(stop="/e_stop"))
        leader.tell("stopped", waits_for=["/e_stop"])
        assert twin.kinds[-1] == "hush"
        assert await show.playback.play(guarded, "dance.improv", show.stops.count) is None
        assert show.lines == ["✗ the emergency stop on /e_stop is on: release it, then save again"]
        assert len(leader.loads) == 1
        leader.tell("stopped")
        assert await show.playback.play(guarded, "dance.improv", show.stops.count)

    check(performs)


def test_what_only_the_simulator_is_to_play_stops_real_robots_until_the_next_score() -> None:
    async def performs(show: Show) -> None:
        ros, simulator = await show.play()
        alone = await show.playback.play(ENDLESS, "dance.improv", show.stops.count, simulated=True)
        assert (ros.kinds[-1], simulator.loads[-1]["generation"]) == ("hush", alone)
        assert "entry" not in simulator.loads[-1]  # it leads
        simulator.tell("playing", 1.0)
        ros.tell("stopped")
        assert show.playback.is_on
        assert show.playback.status == "simulator"
        show.playback.conduct({"type": "speed", "factor": 2.0})
        assert ros.kinds[-1] == simulator.kinds[-1] == "speed"
        show.playback.resume(show.stops.count)
        assert ros.kinds[-1] == "speed"  # only what paused resumes

        both = await show.begin()
        assert simulator.kinds[-1] == "hush"
        assert ros.loads[-1]["generation"] == both
        ros.tell("playing", monotonic=700.0)
        assert simulator.loads[-1]["entry"]["monotonic"] == 700.0

    check(performs)


def test_a_stage_that_dies_while_the_simulator_plays_alone_is_replaced_by_one_that_stops_its_robots() -> None:
    async def performs(show: Show) -> None:
        ros, simulator = await show.play()
        ghost = score_of(analyze("ghost $ repeat forward\n"))
        await show.playback.play(ghost, "dance.improv", show.stops.count, simulated=True)
        simulator.tell("playing")
        ros.say({"type": "stopped", "message": "r can't be stopped"})
        ros.die()
        assert show.lines == ["the stage exited unexpectedly: a new one is stopping the robots"]
        await show.until(lambda: show.latest("ros") is not ros and show.latest("ros").sent)
        new = show.latest("ros")
        (standing,) = new.loads
        assert (standing["score"]["parts"].keys(), standing["score"]["movements"]) == ({"r"}, [])
        assert (show.playback.is_on, simulator.kinds[-1]) == (True, "load"), "the simulator plays on"
        new.tell("ended")
        await show.begin()
        assert (new.kinds, simulator.kinds[-1]) == (["load", "load"], "hush")

    check(performs)


def test_where_a_stage_that_idles_can_not_be_replaced_the_next_score_starts_all() -> None:
    async def performs(show: Show) -> None:
        ros, _ = await show.play()
        await show.playback.play(ENDLESS, "dance.improv", show.stops.count, simulated=True)
        show.fails = {"ros"}
        ros.die()
        assert show.lines == ["the stage exited unexpectedly: its robots were stopped"]
        await show.until(lambda: len(show.lines) > 1)
        assert show.lines[-1] == "no new stage could be started: no ros here"
        show.fails = set()
        await show.play()
        assert show.latest("ros").kinds == ["load"]

    check(performs)


def test_without_a_simulator_nothing_is_simulated() -> None:
    async def performs(show: Show) -> None:
        with pytest.raises(StageError, match="no robot is named, and there is no simulator"):
            await show.playback.play(ENDLESS, "dance.improv", show.stops.count, simulated=True)
        assert show.latest("ros").kinds == []

    check(performs, "ros")


def test_a_twin_pauses_while_what_leads_waits() -> None:
    async def performs(show: Show) -> None:
        leader, twin = await show.play()
        leader.tell("paused", monotonic=510.0, waits_for=["button 4 on /joy"])
        leader.tell("playing", monotonic=520.0)
        assert twin.sent[1:] == [{"type": "pause", "at": 510.0}, {"type": "resume", "at": 520.0}]
        leader.tell("paused")
        leader.tell("playing")
        assert len(twin.sent) == 3, "what somebody asks for, the twin is told when it is asked"

    check(performs)


def test_a_stage_that_led_and_died_is_replaced_by_one_that_stops_the_robots_first() -> None:
    async def performs(show: Show) -> None:
        leader, twin = await show.play()
        leader.die()
        assert twin.kinds == ["load", "hush"]
        assert show.lines == ["the stage exited unexpectedly: its robots were stopped; save to play again"]
        await show.until(lambda: show.latest("ros") is not leader and show.latest("ros").sent)
        new = show.latest("ros")
        (standing,) = new.loads
        assert standing["score"]["parts"].keys() == {"r"}
        assert standing["score"]["movements"] == []
        new.tell("ended")
        assert await show.begin()
        assert new.loads[-1]["score"] != standing["score"]

    check(performs)


def test_robots_of_all_scores_that_may_play_are_stopped_on_all_their_topics() -> None:
    """What was saved may wait for the end of what plays, without its robots or on other topics."""

    async def performs(show: Show) -> None:
        leader, _ = await show.play()
        (robot,) = ENDLESS.parts.values()
        moved, added = replace(robot, topic="/elsewhere"), replace(robot, robot="s", topic="/s/cmd_vel")
        later = replace(ENDLESS, parts={"r": moved, "s": added})
        assert await show.playback.play(later, "dance.improv", show.stops.count, "end")
        leader.die()
        await show.until(lambda: show.latest("ros") is not leader and show.latest("ros").sent)
        parts = show.latest("ros").loads[0]["score"]["parts"]
        assert {part["topic"] for part in parts.values()} == {robot.topic, "/elsewhere", "/s/cmd_vel"}

    check(performs)


def test_a_new_stage_that_dies_before_the_robots_stand_is_not_replaced() -> None:
    async def performs(show: Show) -> None:
        leader, _ = await show.play()
        leader.die()
        await show.until(lambda: show.latest("ros") is not leader and show.latest("ros").sent)
        show.latest("ros").die()
        assert show.lines[-1] == "the stage exited unexpectedly: robots may still be moving; save to play again"
        assert len(show.stages) == 3

    check(performs)


def test_a_new_stage_that_dies_once_the_robots_stand_is_not_replaced_until_somebody_plays() -> None:
    """What ends each stage would otherwise have stages start forever."""

    async def performs(show: Show) -> None:
        leader, _ = await show.play()
        leader.die()
        await show.until(lambda: show.latest("ros") is not leader and show.latest("ros").sent)
        show.latest("ros").tell("ended")
        show.latest("ros").die()
        assert show.lines[-1] == "the stage exited unexpectedly; save to play again"
        assert len(show.stages) == 3
        await show.play()
        assert len(show.stages) == 5

    check(performs)


def test_who_plays_again_while_robots_are_being_stopped_need_not_wait_for_that_to_close() -> None:
    async def performs(show: Show) -> None:
        leader, _ = await show.play()
        leader.die()
        await show.until(lambda: show.latest("ros") is not leader and show.latest("ros").sent)
        assert await show.begin()
        await asyncio.wait_for(show.playback.close(), 4.0)  # half of HALT_LIMIT

    check(performs)


def test_a_twin_that_died_is_replaced_and_what_leads_plays_on() -> None:
    async def performs(show: Show) -> None:
        leader, twin = await show.play()
        page = show.playback.page
        twin.die()
        assert show.lines == ["the stage exited unexpectedly: a new one will show the next dance"]
        await show.until(lambda: show.latest("simulator") is not twin)
        assert leader.kinds == ["load"]
        await show.until(lambda: show.playback.page == page)
        new = show.latest("simulator")
        assert new.sent == []
        await show.play()
        assert len(new.loads) == 1

    check(performs)


@pytest.mark.parametrize("ends", [False, True])
def test_nothing_plays_that_was_stopped_while_the_stages_started(ends: bool) -> None:
    async def performs(show: Show) -> None:
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

    check(performs)


@pytest.mark.parametrize("failing", ["ros", "simulator"])
def test_where_one_stage_can_not_start_none_is_left_open(failing: SinkName) -> None:
    async def performs(show: Show) -> None:
        show.fails = {failing}
        with pytest.raises(StageError, match=f"no {failing} here"):
            await show.begin()
        (other,) = show.stages
        assert not other.alive
        assert show.playback.status == "nothing"
        show.fails.clear()
        assert await show.begin()

    check(performs)


def test_who_gives_up_while_the_stages_start_leaves_none_open() -> None:
    async def performs(show: Show) -> None:
        show.held = {"simulator"}
        opening = asyncio.ensure_future(show.playback.open())
        await show.until(lambda: len(show.stages) == 1)  # the other is not there yet
        opening.cancel()
        with pytest.raises(asyncio.CancelledError):
            await opening
        assert not any(stage.alive for stage in show.stages)

    check(performs)


def test_a_stage_that_can_not_be_replaced_is_said_and_the_next_play_tries_again() -> None:
    async def performs(show: Show) -> None:
        leader, _ = await show.play()
        show.fails = {"ros"}
        leader.die()
        await show.until(lambda: len(show.lines) == 2)
        assert show.lines[-1] == "no new stage could be started: no ros here"
        show.fails.clear()
        assert await show.begin()
        assert len(show.latest("ros").loads) == 1

    check(performs)


def test_who_stands_still_and_how_fast_the_others_are_is_told_to_every_new_stage() -> None:
    async def performs(show: Show) -> None:
        kept: list[ToStage] = [
            {"type": "silence", "muted": ["r"], "soloed": []},
            {"type": "speed", "factor": 2.0},
        ]
        old = Playback(Options(), lambda message, leads: None, Stops())
        old.silence(["r"], [])
        old.conduct({"type": "speed", "factor": 2.0})
        show.playback.keep_as(old)
        assert show.playback.muted == {"r"}
        leader, twin = await show.play()
        assert leader.sent[:2] == twin.sent[:2] == kept
        leader.die()
        await show.until(lambda: show.latest("ros") is not leader and show.latest("ros").loads)
        assert show.latest("ros").sent[:2] == kept

    check(performs)


def test_a_dance_on_other_stages_has_a_number_that_no_dance_had_before() -> None:
    async def performs(show: Show) -> None:
        await show.play()
        other = Playback(Options("sim"), lambda message, leads: None, show.stops, show._start)
        other.keep_as(show.playback)
        assert await other.play(ENDLESS, "dance.improv", show.stops.count) == 2
        await other.close()

    check(performs)


def test_only_a_parent_that_edits_obeys_a_page_that_does_and_a_stop_comes_first() -> None:
    write: Editing = {
        "type": "editing",
        "page": 1,
        "ask": {"type": "write", "number": 1, "text": "ada $ left\n", "revision": ""},
    }

    async def performs(show: Show) -> None:
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
        assert await show.playback.play(ENDLESS, "dance.improv", asked) is None  # it was stopped before it began

    check(performs)


def test_pages_are_told_what_they_may_edit_also_those_of_a_new_stage_and_one_is_answered() -> None:
    async def performs(show: Show) -> None:
        leader, twin = await show.play()
        source: Source = {"type": "source", "path": "/dance.improv", "text": "", "revision": "1"}
        written: Written = {"type": "written", "number": 1, "revision": "1", "problem": ""}
        answer: Answer = {"type": "answer", "page": 1, "answer": written}
        show.playback.tell_pages(source)
        show.playback.tell_pages(answer)
        assert (twin.sent[-2:], leader.kinds) == ([source, answer], ["load"])  # ROS 2 has no page
        twin.die()
        await show.until(lambda: show.latest("simulator") is not twin)
        assert source in show.latest("simulator").sent
        assert answer not in show.latest("simulator").sent

    check(performs)


def test_pages_are_told_what_keeps_a_program_from_being_played_also_those_of_a_new_stage() -> None:
    async def performs(show: Show) -> None:
        await show.play()
        show.playback.present("dance.improv", "/dances", [("dance.improv", 1, 5, "forwrd", "it is not defined")])
        problem = {
            "file": "dance.improv",
            "line": 1,
            "column": 5,
            "word": "forwrd",
            "message": "it is not defined",
        }
        message = {"type": "program", "name": "dance.improv", "folder": "/dances", "problems": [problem]}
        old = show.latest("simulator")
        assert old.sent[-1] == message
        old.die()
        await show.until(lambda: show.latest("simulator") is not old)
        assert message in show.latest("simulator").sent
        show.playback.present("dance.improv", "/dances")
        assert show.latest("simulator").sent[-1] == {**message, "problems": []}

    check(performs)


def test_one_stage_alone_has_no_twin() -> None:
    async def performs(show: Show) -> None:
        assert await show.begin()
        (stage,) = show.stages
        stage.tell("playing")
        assert stage.kinds == ["load"]
        assert show.playback.status == "simulator"

    check(performs, "sim")


def test_a_real_stage_plays_at_the_speed_that_was_kept() -> None:
    async def run() -> None:
        told: asyncio.Queue[News] = asyncio.Queue()
        playback = Playback(Options("sim"), lambda message, leads: told.put_nowait(message), Stops())
        playback.conduct({"type": "speed", "factor": 2.0})
        try:
            assert await playback.play(ENDLESS, "dance.improv", 0) == 1
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


def test_a_save_sends_each_stage_only_what_it_lacks() -> None:
    async def performs(show: Show) -> None:
        assert await show.playback.play(score_of(SAVED), "dance", show.stops.count)
        leader, twin = show.latest("ros"), show.latest("simulator")
        leader.tell("playing")
        await show.playback.play(edited("right"), "dance", show.stops.count, "bar", 3)
        await show.playback.play(edited("repeat right"), "dance", show.stops.count, "bar", 3)
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
        assert bert["editions"] not in [
            twin.loads[0]["score"]["parts"][robot]["editions"] for robot in ("anna", "bert")
        ]

    check(performs)


@pytest.mark.parametrize("sink", ["ros", "simulator"])
def test_a_stage_that_lacks_something_is_sent_the_whole_score(sink: SinkName) -> None:
    async def performs(show: Show) -> None:
        assert await show.playback.play(score_of(SAVED), "dance", show.stops.count)
        leader, stage = show.latest("ros"), show.latest(sink)
        leader.tell("playing")
        await show.playback.play(edited("right"), "dance", show.stops.count, "beat")
        leader.tell("playing", beat=6.0, begins={"bert": 6.0})
        before = len(stage.loads)
        stage.say({"type": "lacks", "generation": 1})  # an old one, which nobody needs any more
        assert len(stage.loads) == before
        stage.say({"type": "lacks", "generation": 2})
        assert load_of(stage) == (2, True, False)
        assert stage.loads[-1].get("entry") == stage.loads[-2].get("entry")

    check(performs)


def test_after_a_score_that_a_stop_held_back_the_next_one_is_whole() -> None:
    async def performs(show: Show) -> None:
        assert await show.playback.play(score_of(SAVED), "dance", show.stops.count)
        asked = show.stops.count
        show.stops.stop()
        assert await show.playback.play(edited("right"), "dance", asked, "beat") is None
        assert await show.playback.play(edited("right"), "dance", show.stops.count, "beat") == 2
        assert load_of(show.latest("ros")) == (2, True, False)

    check(performs)


def test_a_new_stage_is_sent_the_whole_score() -> None:
    async def performs(show: Show) -> None:
        assert await show.playback.play(score_of(SAVED), "dance", show.stops.count)
        leader = show.latest("ros")
        leader.die()
        await show.until(lambda: show.latest("ros") is not leader and show.latest("ros").loads)
        show.latest("ros").tell("ended")
        await show.until(lambda: show.playback._leader is show.latest("ros"))
        assert await show.playback.play(edited("right"), "dance", show.stops.count, "beat") == 2
        load = show.latest("ros").loads[-1]["score"]
        assert max(load["parts"]["anna"]["scenes"]) < load["known"] + len(load["movements"])

    check(performs)


def test_the_twin_performs_what_the_leader_has_sensed_and_a_moment_later() -> None:
    open_score = score_of(analyze("r $ until cue (repeat forward)\n"))
    moment: Moment = {"generation": 1, "robot": "r", "beat": 2.5, "performed": 1.25, "wall": 0}
    sensed: Sensed = {"type": "sensed", "sense": "cue", "value": True, **moment}
    decided: Decided = {"type": "decided", "sources": [[0, 4, 9]], "held": True, **moment}

    async def performs(show: Show) -> None:
        await show.playback.play(open_score, "dance", 0)
        leader, twin = show.latest("ros"), show.latest("simulator")
        leader.tell("playing", monotonic=500.0)
        assert twin.loads[-1]["entry"] == {"beat": 0.0, "monotonic": 500.0 + BEHIND}
        show.playback.conduct({"type": "cue"})
        assert (leader.kinds[-1], twin.kinds[-1]) == ("cue", "load")
        leader.say(sensed)
        leader.say(decided)
        assert twin.sent[-2:] == [sensed, decided]
        told = len(show.news)
        twin.say(sensed)  # as it shows it on its page
        assert len(show.news) == told
        show.playback.conduct({"type": "seek", "beat": 4.0})
        assert (leader.kinds[-1], twin.kinds[-1]) == ("seek", "decided")
        await show.until(lambda: twin.kinds[-1] == "seek")
        (seek,) = (message for message in leader.sent if message["type"] == "seek")
        (later,) = (message for message in twin.sent if message["type"] == "seek")
        assert later["at"] == pytest.approx(seek["at"] + BEHIND)

    check(performs)
