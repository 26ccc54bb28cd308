"""A playback whose real robots have stages on several machines, faked."""

from __future__ import annotations

import asyncio
import threading
import time
from dataclasses import replace
from typing import Any

import pytest

from improv_core.ipc.stage_process import StageError
from improv_core.safety.stage_stops import socket_of
from improv_core.safety.stops import Stops
from improv_core.score.score import Host
from improv_core.session import on_hosts as hosts
from improv_core.session import start as starting
from improv_core.session.session import Playback
from improv_core.session.start import Options
from improv_core.session.state import PlayScore
from improv_core.session.together import HANDED, SPARE, ahead
from tests.session.fakes import Fake, Fakes, performed
from tests.session.story import DANCE, at
from tests.session.test_group import PI, on_hosts

SCORE = on_hosts("a p q $ forward\n")


@pytest.fixture(autouse=True)
def _short_limits(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(starting, "PAUSES", (0.0,))
    monkeypatch.setattr(hosts, "CONFIRM_LIMIT", 0.05)


async def play(fakes: Fakes) -> tuple[Fake, Fake]:
    """Have the stage here, and the one on a host, get ready for beat 0."""
    assert await fakes.playback.play(PlayScore(SCORE, "dance.improv", fakes.stops.count))
    return fakes.latest("ros"), fakes.latest(PI)


async def begin(fakes: Fakes) -> tuple[Fake, Fake]:
    both = await play(fakes)
    for stage in both:
        stage.say({"type": "armed", "generation": 1, "armed": True, "begins": None})
    for stage in both:
        stage.say(at("playing", 1))
    return both


@performed
async def test_a_stop_reaches_all_stages_from_any_thread_while_the_event_loop_is_busy(fakes: Fakes) -> None:
    both = await play(fakes)
    stopping = threading.Thread(target=fakes.stops.stop)
    stopping.start()
    stopping.join()  # the event loop does nothing meanwhile
    assert [stage.kinds for stage in both] == [["load", "stop"]] * 2


@performed
async def test_stages_are_one_backend_of_real_robots(fakes: Fakes) -> None:
    await play(fakes)
    state = fakes.playback.state
    assert (state.status, state.is_real) == (f"ros; ros on {PI}, with the simulator alongside", True)


@pytest.mark.parametrize(("host", "lead"), [(Host("thymio", output=True), HANDED), (Host(PI), SPARE)])
@performed
async def test_commands_are_sent_as_far_ahead_as_the_farthest_stage_needs(
    fakes: Fakes, host: Host, lead: float
) -> None:
    parts = {robot: replace(part, host=part.host and host) for robot, part in SCORE.parts.items()}
    assert await fakes.playback.play(PlayScore(replace(SCORE, parts=parts), "dance.improv", fakes.stops.count))
    assert ahead(fakes.playback.state) == lead


@performed
async def test_each_reason_why_a_host_cannot_be_reached_is_reported_once(fakes: Fakes) -> None:
    fakes.fails.add(PI)
    await fakes.playback.open(SCORE.hosts)
    await fakes.until(lambda: fakes.failed > 2)
    fakes.problem = "ssh refuses {}"
    seen = fakes.failed
    await fakes.until(lambda: fakes.failed > seen + 2)
    fakes.fails.clear()
    await fakes.until(lambda: PI in [stage.name for stage in fakes.stages])
    assert fakes.lines == [
        f"{PI} can't be reached: {problem} (Improv keeps trying)" for problem in (f"no {PI} here", f"ssh refuses {PI}")
    ]


@pytest.mark.parametrize("closes", [False, True])
@performed
async def test_robots_that_have_not_confirmed_a_stop_are_named_once(fakes: Fakes, closes: bool) -> None:
    here, _ = await begin(fakes)
    fakes.stops.stop()
    here.say(at("stopped", 1))
    if closes:  # Ctrl-C stops first, and then closes
        await fakes.playback.close()
    await fakes.until(lambda: "unreached" in [each["type"] for each in fakes.news])
    lines = [each["message"] for each in fakes.news if each["type"] == "unreached"]
    assert lines == [f"p, q may still be moving: {PI} has not confirmed the stop"]


@pytest.mark.parametrize("then", ["it answers", "it fails", "it stays silent"])
@performed
async def test_the_others_begin_without_a_host_that_does_not_answer(fakes: Fakes, then: str) -> None:
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(starting, "SLOW", 0.0)
        patch.setattr(starting, "LATEST", 0.0)
        fakes.held.add(PI)
        fakes.fails |= {PI} if then == "it fails" else set()
        assert await fakes.playback.play(PlayScore(SCORE, "dance.improv", fakes.stops.count))
        assert {stage.name for stage in fakes.stages} == {"ros", "simulator"}
        if then != "it stays silent":
            fakes.released.set()
            await fakes.until(lambda: fakes.failed > 1 or (len(fakes.stages) == 3 and fakes.latest(PI).loads))
    assert fakes.lines == [
        f"{PI} has not answered for 0 s: the others wait for up to 0 s",
        f"{PI} has not answered for 0 s: the others begin, and it joins them",
        *([f"{PI} can't be reached: no {PI} here (Improv keeps trying)"] if then == "it fails" else []),
    ]


@performed
async def test_robots_move_if_the_stage_of_their_host_reports_it(fakes: Fakes) -> None:
    _, there = await play(fakes)
    there.say(at("playing", 1))
    line = f"stopped dance.improv on {fakes.playback.state.status}: 2 robots were moving"
    assert fakes.playback.stop({"type": "stop"}) == line, "whatever has become of the other"


@pytest.mark.parametrize("fails", [{"ros"}, {"ros", PI}])
@performed
async def test_nothing_starts_if_the_stage_here_fails(fakes: Fakes, fails: set[str]) -> None:
    fakes.fails = fails
    with pytest.raises(StageError, match="no ros here"):
        await fakes.playback.open(SCORE.hosts)


def test_nothing_starts_if_there_can_be_no_stage_at_all() -> None:
    async def none(*_: Any) -> None:
        return None

    playback = Playback(Options("ros"), lambda message, leads: None, Stops(), none)
    with pytest.raises(StageError, match="no stage could be started"):
        asyncio.run(playback.open(SCORE.hosts))


@performed
async def test_a_request_on_a_robot_is_obeyed_by_all(fakes: Fakes) -> None:
    both = await play(fakes)
    both[1].say({"type": "request", "command": {"type": "pause"}})
    assert [stage.kinds for stage in both] == [["load", "pause"]] * 2


@performed
async def test_a_score_with_other_hosts_starts_their_stages(fakes: Fakes) -> None:
    for score in (DANCE, DANCE, SCORE, DANCE):
        await fakes.playback.play(PlayScore(score, "dance.improv", fakes.stops.count))
    await fakes.playback.play(PlayScore(on_hosts("o $ forward\n"), "dance.improv", fakes.stops.count, simulated=True))
    opened = [stage.name for stage in fakes.stages if stage.name != "simulator"]
    assert opened == ["ros", "ros", PI], "stages that run already, or that nobody needs, are not started"


@performed
async def test_a_resume_from_before_a_pause_changes_nothing(fakes: Fakes) -> None:
    both = await begin(fakes)
    asked = fakes.stops.count
    fakes.stops.stop({"type": "pause"})
    for stage in both:
        stage.say(at("paused", 1, 1.0))
    for count, kind in ((asked, "pause"), (fakes.stops.count, "resume")):
        fakes.playback.ask({"type": "resume"}, count)
        assert [stage.kinds[-1] for stage in both] == [kind] * 2


@performed
async def test_a_stage_that_joins_learns_how_long_we_had_slept_when_somebody_asked(fakes: Fakes) -> None:
    """If the machine has slept since then, it moves nothing."""
    _, there = await begin(fakes)
    there.die()
    await fakes.until(lambda: fakes.latest(PI) is not there)
    fakes.latest("ros").say(at("playing", 1, 1.0, time.monotonic()))
    await fakes.until(lambda: fakes.latest(PI).loads)
    assert fakes.latest(PI).loads[0]["asleep"] == there.loads[0]["asleep"]


@performed
async def test_all_are_stopped_before_they_end(fakes: Fakes) -> None:
    both = await begin(fakes)
    await fakes.playback.close()
    assert [stage.kinds[-1] for stage in both] == ["stop", "stop"]


@pytest.mark.parametrize("moves", [False, True])
@performed
async def test_a_stage_that_died_counts_as_one_that_obeys_no_stop_only_if_it_moved_robots(
    fakes: Fakes, moves: bool
) -> None:
    _, there = await (begin if moves else play)(fakes)
    assert fakes.playback._show
    left = socket_of(fakes.playback._show, PI)
    left.touch()
    there.die()
    await fakes.until(lambda: fakes.latest(PI) is not there)
    assert left.exists() == moves
