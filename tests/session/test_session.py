"""Stages are started, sent messages, and ended. They are fakes that the tests control, except in one test. Decisions
are tested in test_on_request.py and test_on_report.py."""

from __future__ import annotations

import asyncio
import tempfile
import time
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from improv_core.ipc.stage_process import StageError
from improv_core.program.analysis import analyze
from improv_core.program.compiler import score_of
from improv_core.protocol.commands import Editing, Stop
from improv_core.protocol.messages import Pressed
from improv_core.safety import stop_socket
from improv_core.safety.stop_socket import IDLE, StopSocket, stop_all
from improv_core.score.score import OutsideClock, Safety, Score
from improv_core.session.session import LOST, Playback
from improv_core.session.start import Options
from improv_core.session.state import HERE, Output, PlayScore, StageKey
from tests.session.fakes import LIMIT, Fake, Fakes, performed
from tests.session.story import DANCE, unpacked

OPEN = score_of(analyze("r $ until cue (repeat forward)\n"))


@pytest.fixture(autouse=True)
def _runtime(monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    """A folder of sockets with a short name, in which nothing else plays."""
    with tempfile.TemporaryDirectory(dir="/tmp") as folder:
        monkeypatch.setenv("XDG_RUNTIME_DIR", folder)
        for name in ("RUNTIME", "SHARED"):
            monkeypatch.setattr(stop_socket, name, Path(folder))
        yield


@pytest.mark.parametrize(("command", "sent"), [({"type": "restart"}, "load"), ({"type": "resume"}, "resume")])
@performed
async def test_a_page_request_made_before_a_stop_does_not_move_robots_after_it(
    fakes: Fakes, command: Any, sent: str
) -> None:
    leader, twin = await fakes.play()
    asked = fakes.stops.arrive(command)  # on the thread that reads
    twin.say({"type": "request", "command": {"type": "stop"}})
    twin.hear({"type": "request", "command": command}, asked)  # on the event loop
    assert leader.kinds == ["load", "stop"]
    twin.say({"type": "request", "command": command})
    assert leader.kinds == ["load", "stop", sent]


@performed
async def test_the_leading_stage_gets_news_of_the_clock_that_its_score_follows(fakes: Fakes) -> None:
    follows = PlayScore(replace(DANCE, clock=OutsideClock("midi", "IAC")), "dance.improv", 0)
    await fakes.playback.play(follows)
    await fakes.playback.play(follows)
    (clock,) = fakes.clocks
    assert (clock.clock, clock.tempo) == (OutsideClock("midi", "IAC"), float(DANCE.tempo))
    leader, twin = fakes.latest("ros"), fakes.latest("simulator")
    clock.say({"type": "anchor", "at": 1.0, "beat": 2.0, "tempo": 100.0, "period": 0.02, "jumps": 0})
    clock.say({"type": "warning", "message": "the cable is gone"})
    assert (leader.kinds, twin.kinds) == (["load", "load", "anchor"], [])
    assert fakes.lines == ["the cable is gone"]
    await fakes.begin()
    assert not clock.alive
    await fakes.playback.play(follows)
    fakes.clocks[-1].say({"type": "clock_gone", "message": "it crashed"})
    assert fakes.lines[-1] == "the clock is lost: it crashed"
    await fakes.playback.play(follows)
    assert len(fakes.clocks) == 3, "a save starts it again"
    await fakes.playback.close()
    assert not fakes.clocks[-1].alive


@performed
async def test_improv_stop_says_which_program_it_stopped(fakes: Fakes) -> None:
    reached = StopSocket(fakes.playback.stop)
    fakes.held = {"ros", "simulator"}
    beginning = asyncio.ensure_future(fakes.begin())
    await asyncio.sleep(0)  # it is on its way
    assert await asyncio.to_thread(list, stop_all()) == ["stopped dance.improv before it began"]
    fakes.released.set()
    assert await beginning is None
    assert await asyncio.to_thread(list, stop_all()) == [IDLE]
    leader, twin = await fakes.play()
    stopped = "stopped dance.improv on ros, with the simulator alongside"
    assert await asyncio.to_thread(list, stop_all()) == [f"{stopped}: 1 robot was moving"]
    assert leader.kinds[-1] == twin.kinds[-1] == "stop"
    leader.tell("paused")
    assert await asyncio.to_thread(list, stop_all()) == [stopped]
    leader.tell("stopped")
    assert await asyncio.to_thread(list, stop_all()) == [IDLE]
    leader.moves, leader.sent[:] = True, []  # a stage whose robots move although nothing plays, for whatever reason
    assert await asyncio.to_thread(list, stop_all()) == [f"{stopped}: 1 robot was moving"]
    assert leader.kinds == ["stop"]
    assert fakes.lines == ["stopped by `improv stop`"] * 4
    await fakes.playback.close()
    reached.close()
    assert list(stop_all()) == []


@performed
async def test_real_robots_play_only_if_improv_stop_reaches_them(fakes: Fakes) -> None:
    fakes.stops.unreachable = "there is no folder"
    with pytest.raises(StageError, match=r"^real robots need `improv stop`: there is no folder$"):
        await fakes.play()
    fakes.playback = Playback(Options("sim"), lambda message, leads: None, fakes.stops, fakes._start)
    await fakes.playback.open()
    await fakes.playback.close()


GUARDED = replace(DANCE, safety=Safety(stop="/e_stop"))
REFUSED = "✗ the emergency stop on /e_stop is on: release it, then save again"
ON: Pressed = {"type": "pressed", "topics": ["/e_stop"], "count": 1}
OFF: Pressed = {"type": "pressed", "topics": [], "count": 1}


@performed
async def test_an_emergency_stop_is_kept_when_its_stage_dies_and_when_another_playback_begins(fakes: Fakes) -> None:
    leader, _ = await fakes.play()
    leader.say(ON)
    leader.die()
    await fakes.until(lambda: len(fakes.stages) == 3)
    revived = fakes.latest("ros")
    await fakes.until(lambda: "load" in revived.kinds)
    assert revived.sent[0] == ON  # so that it hears the release
    assert "stops" not in revived.loads[0]  # it only stops the robots
    revived.tell("stopped")
    assert await fakes.playback.play(PlayScore(GUARDED, "dance.improv", fakes.stops.count)) is None
    other = Playback(Options("ros"), lambda message, leads: fakes.news.append(message), fakes.stops, fakes._start)
    assert await other.play(PlayScore(GUARDED, "dance.improv", fakes.stops.count)) is None
    assert fakes.lines[-2:] == [REFUSED] * 2
    assert fakes.latest("ros").sent[0] == ON
    fakes.latest("ros").say(OFF)
    assert await other.play(PlayScore(GUARDED, "dance.improv", fakes.stops.count))
    await other.close()


@performed
async def test_a_score_carries_the_number_of_emergency_stops_known_at_its_request(
    fakes: Fakes,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr("improv_core.session.session.KNOWN", 0.0)
    leader, _ = await fakes.play()
    assert leader.loads[-1]["stops"] == 0
    before = fakes.stops.count
    leader.say(ON)
    leader.say(OFF)
    assert await fakes.begin()  # it arrived together with the press, which nobody can have known yet
    assert leader.loads[-1]["stops"] == 0
    await fakes.until(lambda: fakes.stops.known)
    assert await fakes.playback.play(PlayScore(DANCE, "dance.improv", before)) is None
    assert await fakes.begin()
    assert leader.loads[-1]["stops"] == 1


@performed
async def test_a_dead_leading_stage_is_replaced_by_one_that_stops_the_robots_first(fakes: Fakes) -> None:
    leader, twin = await fakes.play()
    leader.die()
    assert twin.kinds == ["load", "stop"]
    assert fakes.lines == ["the stage exited unexpectedly: a new one is stopping the robots; play again"]
    await fakes.until(lambda: fakes.latest("ros") is not leader and fakes.latest("ros").sent)
    new = fakes.latest("ros")
    (standing,) = new.loads
    assert standing["score"]["parts"].keys() == {"r"}
    assert standing["score"]["movements"] == []
    new.tell("ended")
    assert await fakes.begin()
    assert new.loads[-1]["score"] != standing["score"]


@performed
async def test_a_new_stage_stops_the_robots_of_one_that_is_killed_in_the_end(fakes: Fakes) -> None:
    leader, _ = await fakes.play()
    leader.hangs = True
    closing = asyncio.ensure_future(fakes.playback.close())
    await fakes.until(lambda: fakes.latest("ros") is not leader and fakes.latest("ros").sent)
    new = fakes.latest("ros")
    (standing,) = new.loads
    assert standing["score"]["movements"] == []
    assert not closing.done()
    new.tell("ended")
    await asyncio.wait_for(closing, LIMIT)
    assert not new.alive
    assert fakes.lines == [f"{LOST}: a new one is stopping the robots; play again"]


@performed
async def test_an_end_stops_robots_before_the_new_stage_of_their_page_has_started(fakes: Fakes) -> None:
    leader, twin = await fakes.play()
    fakes.held = {"simulator"}
    twin.die()
    closing = asyncio.ensure_future(fakes.playback.close())
    await fakes.until(lambda: leader.kinds == ["load", "stop"])
    fakes.released.set()
    await asyncio.wait_for(closing, LIMIT)


@performed
async def test_a_stop_that_stages_have_obeyed_first_still_names_the_dance(fakes: Fakes) -> None:
    leader, _ = await fakes.play()
    asked = time.monotonic()
    leader.tell("stopped")
    assert (
        fakes.playback.stop({"type": "stop", "direct": "first", "at": asked})
        == "stopped dance.improv on ros, with the simulator alongside"
    )
    first: Stop = {"type": "stop", "direct": "first", "at": asked}
    assert fakes.playback.stop(first) == "stopped dance.improv on ros, with the simulator alongside"
    assert fakes.playback.stop({"type": "stop", "direct": "second", "at": time.monotonic()}) == IDLE
    await fakes.playback.close()


@performed
async def test_closing_names_the_robots_that_no_stage_could_stop(fakes: Fakes) -> None:
    leader, _ = await fakes.play()
    leader.hangs = True
    fakes.fails.add("ros")
    await asyncio.wait_for(fakes.playback.close(), LIMIT)
    (unreached,) = [each for each in fakes.news if each["type"] == "unreached"]
    assert unreached["robots"] == ["r"]
    assert unreached["message"] == "r may still be moving: no stage could stop them"


@performed
async def test_a_stop_names_no_robots_as_stopped_that_nothing_has_stopped_yet(fakes: Fakes) -> None:
    leader, _ = await fakes.play()
    failed = "dance.improv: robots may still be moving, since their stage has failed: look at them"
    leader.die()
    assert fakes.playback.stop({"type": "stop"}) == failed
    await fakes.until(lambda: fakes.latest("ros") is not leader and fakes.latest("ros").sent)
    assert fakes.playback.stop({"type": "stop"}) == failed
    fakes.latest("ros").tell("ended")
    assert fakes.playback.stop({"type": "stop"}) == IDLE


@pytest.mark.parametrize("ends", [False, True])
@performed
async def test_a_play_that_was_stopped_while_stages_started_never_begins(fakes: Fakes, ends: bool) -> None:
    fakes.held = {"ros", "simulator"}
    playing = asyncio.ensure_future(fakes.begin())
    await asyncio.sleep(0)  # it is on its way
    if ends:
        closing = asyncio.ensure_future(fakes.playback.close())
        await asyncio.sleep(0)
        fakes.released.set()
        await closing
    else:
        fakes.stops.stop()
        fakes.released.set()
    assert await playing is None
    assert not any(stage.loads for stage in fakes.stages)
    assert await fakes.begin() == 1


@pytest.mark.parametrize("failing", ["ros", "simulator"])
@performed
async def test_if_one_stage_cannot_start_none_is_left_open(fakes: Fakes, failing: Output) -> None:
    fakes.fails = {failing}
    with pytest.raises(StageError, match=f"no {failing} here"):
        await fakes.begin()
    (other,) = fakes.stages
    assert not other.alive
    assert fakes.playback.state.status == "nothing"
    fakes.fails.clear()
    assert await fakes.begin()


@performed
async def test_giving_up_while_stages_start_leaves_none_open(fakes: Fakes) -> None:
    fakes.held = {"simulator"}
    opening = asyncio.ensure_future(fakes.playback.open())
    await fakes.until(lambda: len(fakes.stages) == 1)  # the other is not there yet
    opening.cancel()
    with pytest.raises(asyncio.CancelledError):
        await opening
    assert not any(stage.alive for stage in fakes.stages)


@performed
async def test_only_a_parent_that_edits_lets_a_page_edit_and_a_stop_comes_first(fakes: Fakes) -> None:
    write: Editing = {
        "type": "editing",
        "page": 1,
        "ask": {"type": "write", "number": 1, "text": "ada $ left\n", "revision": ""},
    }
    _, twin = await fakes.play()
    news = len(fakes.news)
    twin.say({"type": "request", "command": write})
    assert (fakes.edits, len(fakes.news), twin.kinds) == ([], news, ["load"])
    await fakes.playback.close()
    fakes.playback = Playback(Options("both"), lambda message, leads: None, fakes.stops, fakes._start, fakes.edit)
    _, twin = await fakes.play()
    asked = fakes.stops.arrive(write)  # on the thread that reads
    twin.say({"type": "request", "command": {"type": "stop"}})
    twin.hear({"type": "request", "command": write}, asked)  # on the event loop
    assert fakes.edits == [(write, asked)]
    assert await fakes.playback.play(PlayScore(DANCE, "dance.improv", asked)) is None  # it was stopped before it began


@performed
async def test_the_twin_gets_a_change_once_it_reaches_that_beat(fakes: Fakes) -> None:
    await fakes.playback.play(PlayScore(OPEN, "dance", 0))
    leader, twin = fakes.latest("ros"), fakes.latest("simulator")
    leader.tell("playing")
    fakes.playback.ask({"type": "seek", "beat": 4.0})
    assert (leader.kinds[-1], twin.kinds[-1]) == ("seek", "load")
    await fakes.until(lambda: twin.kinds[-1] == "seek")


@performed
async def test_pages_show_the_errors_that_keep_a_program_from_playing(fakes: Fakes) -> None:
    await fakes.playback.open()
    fakes.playback.present("dance.improv", "/dances", [("dance.improv", 1, 5, "forwrd", "it is not defined")])
    problem = {"file": "dance.improv", "line": 1, "column": 5, "word": "forwrd", "message": "it is not defined"}
    message = {"type": "program", "name": "dance.improv", "folder": "/dances", "problems": [problem], "count": 1}
    assert unpacked(fakes.latest("simulator").sent[-1]) == message
    fakes.playback.present("dance.improv", "/dances")
    assert unpacked(fakes.latest("simulator").sent[-1]) == {**message, "problems": [], "count": 0}


@performed
async def test_a_dance_on_other_stages_has_a_new_number_and_the_same_speed(fakes: Fakes) -> None:
    await fakes.play()
    fakes.playback.ask({"type": "silence", "muted": ["r"], "soloed": []})
    other = Playback(Options("sim"), lambda message, leads: None, fakes.stops, fakes._start)
    other.keep_as(fakes.playback)
    other.ask({"type": "speed", "factor": 2.0})
    assert await other.play(PlayScore(DANCE, "dance.improv", fakes.stops.count)) == 2
    assert fakes.latest("simulator").kinds == ["silence", "speed", "load"]
    assert other.state.page == fakes.playback.state.page
    await other.close()


SAVED = analyze("anna $ repeat forward\nbert $ repeat left\n")


def edited(bert: str) -> Score:
    """The program with another line for bert."""
    at = SAVED.text.index("repeat left")
    return score_of(SAVED.edited(at, len(SAVED.text) - 1, bert))


def load_of(stage: Fake) -> tuple[int, bool, bool]:
    """Return the generation of a stage's latest score, whether it was whole, and whether anna was only named."""
    load = stage.loads[-1]
    return load["generation"], load["score"]["known"] == 0, load["score"]["parts"]["anna"] is None


@performed
async def test_a_save_sends_each_stage_only_the_parts_it_lacks(fakes: Fakes) -> None:
    assert await fakes.playback.play(PlayScore(score_of(SAVED), "dance", fakes.stops.count))
    leader, twin = fakes.latest("ros"), fakes.latest("simulator")
    leader.tell("playing")
    await fakes.playback.play(PlayScore(edited("right"), "dance", fakes.stops.count, "bar", 3))
    await fakes.playback.play(PlayScore(edited("repeat right"), "dance", fakes.stops.count, "bar", 3))
    assert (load_of(leader), load_of(twin)) == ((3, False, True), (1, True, False))
    assert leader.loads[-1]["beats_per_bar"] == 3
    assert [{"stops", "asleep"} & load.keys() for load in (leader.loads[0], twin.loads[0])] == [
        {"stops", "asleep"},
        set(),
    ]
    leader.tell("playing", beat=6.0, begins={"bert": 6.0})
    assert load_of(twin) == (3, False, True)
    assert (twin.loads[-1]["when"], twin.loads[-1]["entry"]) == (
        "now",
        {"beat": 6.0, "monotonic": 500.0, "begins": {"bert": 6.0}},
    )
    bert = twin.loads[-1]["score"]["parts"]["bert"]
    assert len(twin.loads[-1]["score"]["movements"]) < 6
    assert bert["editions"] not in [twin.loads[0]["score"]["parts"][robot]["editions"] for robot in ("anna", "bert")]


@pytest.mark.parametrize("publish", [False, True])
@performed
async def test_a_stage_of_robots_gets_the_text_only_if_it_publishes_the_dance(fakes: Fakes, publish: bool) -> None:
    score = replace(score_of(SAVED), publish=publish)
    assert await fakes.playback.play(PlayScore(score, "dance", fakes.stops.count))
    leader, twin = fakes.latest("ros"), fakes.latest("simulator")
    leader.tell("playing")
    (real,), (shown,) = leader.loads, twin.loads
    known = [(load["score"]["text"], len(load["score"]["offsets"])) for load in (real, shown)]
    assert known == [(SAVED.text, 2) if publish else ("", 0), (SAVED.text, 2)]


@performed
async def test_the_score_after_one_held_back_by_a_stop_is_sent_whole(fakes: Fakes) -> None:
    assert await fakes.playback.play(PlayScore(score_of(SAVED), "dance", fakes.stops.count))
    asked = fakes.stops.count
    fakes.stops.stop()
    assert await fakes.playback.play(PlayScore(edited("right"), "dance", asked, "beat")) is None
    assert await fakes.playback.play(PlayScore(edited("right"), "dance", fakes.stops.count, "beat")) == 2
    assert load_of(fakes.latest("ros")) == (2, True, False)


@performed
async def test_a_new_stage_is_sent_the_whole_score(fakes: Fakes) -> None:
    assert await fakes.playback.play(PlayScore(score_of(SAVED), "dance", fakes.stops.count))
    leader = fakes.latest("ros")
    leader.die()
    await fakes.until(lambda: fakes.latest("ros") is not leader and fakes.latest("ros").loads)
    fakes.latest("ros").tell("ended")
    await fakes.until(lambda: fakes.playback._stages[StageKey(HERE, "ros")] is fakes.latest("ros"))
    assert await fakes.playback.play(PlayScore(edited("right"), "dance", fakes.stops.count, "beat")) == 2
    load = fakes.latest("ros").loads[-1]["score"]
    assert max(load["parts"]["anna"]["scenes"]) < load["known"] + len(load["movements"])
