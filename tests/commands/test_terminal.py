"""Messages of stages about real robots → the lines in a terminal, and the report at the end."""

from __future__ import annotations

import asyncio
import re
import time
from pathlib import Path
from typing import Any

import pytest

from improv_core.commands.screen import Screen
from improv_core.commands.terminal import TerminalSession
from improv_core.program.analysis import analyze
from improv_core.protocol.robot_messages import FaultMessage, WorstJson
from improv_core.robots.config import read_robots
from improv_core.safety import preflight
from improv_core.score.motion import Pose
from improv_core.session.start import Options
from tests.session.fakes import Fakes
from tests.session.story import at


def fault(robot: str, beat: float, line: str, *, over: bool = False, worst: WorstJson | None = None) -> FaultMessage:
    return {
        "type": "fault",
        "generation": 1,
        "robot": robot,
        "fault": "silent",
        "over": over,
        "response": "tell",
        "worst": worst or {},
        "message": f"about {robot}",
        "line": line,
        "beat": beat,
        "performed": beat,
        "wall": 0,
    }


@pytest.fixture
def session() -> TerminalSession:
    return TerminalSession(Options("sim"), quiet=True)


def test_each_line_about_faults_is_printed_once(session: TerminalSession, capsys: pytest.CaptureFixture[str]) -> None:
    for message in (fault("a", 1, "no poses of a and b"), fault("b", 1, ""), fault("c", 2, "no pose of c")):
        session._hear(message, True)
        session._hear(message, False)  # the simulator beside them repeats it
    assert capsys.readouterr().err == "improv: no poses of a and b\nimprov: no pose of c\n"


async def test_the_address_of_the_page_is_printed_again_if_stages_of_hosts_replace_its_server(
    capsys: pytest.CaptureFixture[str],
) -> None:
    fakes, session = Fakes(), TerminalSession(Options("both"))
    session.playback = fakes.playback
    await session.open(browser=False)
    for host in ("", 'host = "pi@pi.local"\n'):
        analysis = analyze("p $ forward\n", read_robots(f"[robots.p]\n{host}"))
        await session.play(analysis, Path("dance.improv"))
    await fakes.playback.close()
    printed = [line.partition(" ")[0] for line in capsys.readouterr().out.splitlines()]
    assert printed == ["watch", "▶", "watch", "▶"]


def test_a_key_resumes_after_a_stop_that_nobody_asked_for_and_the_session_stays(
    capsys: pytest.CaptureFixture[str],
) -> None:
    async def run(stays: bool) -> tuple[bool, list[str]]:
        fakes, session = Fakes(), TerminalSession(Options("both"))
        session.playback = fakes.playback
        session.stays = stays
        session.keyboard.show(hears=True)
        await session.open(browser=False)
        await session.play(analyze("r $ forward\n"), Path("dance.improv"))
        asked = list[Any]()
        fakes.playback.ask = lambda request, stops=0: asked.append(request)  # type: ignore[method-assign]
        session._hear(at("stopped", 1, resumes={"scene": 2.0, "beat": 3.5}, beats=8.0), True)
        finished = session.finished.is_set()
        session.keyboard.resume("scene")
        session.keyboard.resume("beat")
        session._hear(at("playing", 1), True)
        session.keyboard.resume("beat")
        await fakes.playback.close()
        return finished, asked

    assert asyncio.run(run(stays=False)) == (True, [])
    assert "press r" not in capsys.readouterr().out
    resumed: list[Any] = [{"type": "resume", "beat": beat} for beat in (2.0, 3.5)]
    assert asyncio.run(run(stays=True)) == (False, resumed)
    line = "press r to resume from this scene (beat 3/8), or b from this beat (beat 4/8)"
    assert line in capsys.readouterr().out.splitlines()


@pytest.mark.parametrize("stays", [True, False])
@pytest.mark.parametrize("replaced", [True, False])
async def test_a_terminal_that_stays_waits_for_the_stage_that_replaces_a_dead_one(stays: bool, replaced: bool) -> None:
    fakes, session = Fakes(), TerminalSession(Options("both"))
    fakes.playback._listen = session._hear
    session.playback, session.stays = fakes.playback, stays
    session.keyboard.show(hears=True)
    await session.open(browser=False)
    await session.play(analyze("r $ forward\n"), Path("dance.improv"))
    ros = fakes.stages[0]
    ros.tell("playing", 0.5, time.monotonic())
    fakes.fails = set() if replaced else {"ros"}
    ros.die()
    ended = session.finished.is_set()
    if replaced:
        await fakes.until(lambda: fakes.stages[2:])
        fakes.stages[-1].tell("ended")
    await asyncio.gather(*fakes.playback._replacing)
    if replaced:
        (stood,) = [load["stood"] for load in fakes.stages[-1].loads if "stood" in load]
        fakes.stages[-1].say(at("stopped", 1, stood["beat"], resumes={"scene": 0.0, "beat": stood["beat"]}))
    assert bool(session.keyboard.resumes) is (stays and replaced)
    await fakes.playback.close()
    lost = not (stays and replaced)
    assert (ended, session.finished.is_set(), session.broken.is_set()) == (not stays, lost, lost)


@pytest.mark.parametrize("stays", [True, False])
def test_robots_too_near_wait_for_a_key_or_end_the_session_if_nobody_can_resume(stays: bool) -> None:
    session = TerminalSession(Options("ros"), quiet=True)
    session.stays = stays
    session.keyboard.show(hears=True)
    session._hear(at("paused", 1, 3.5, too_near=["a", "b"], resumes={"scene": 2.0, "beat": 3.5}), True)
    assert (bool(session.keyboard.resumes), session.refused.is_set()) == (stays, not stays)


def test_after_an_interrupt_only_robots_that_may_still_move_are_named(
    session: TerminalSession, capsys: pytest.CaptureFixture[str]
) -> None:
    session.interrupted.set()
    session._hear(fault("a", 1, "no pose of a"), True)
    session._hear({"type": "unreached", "generation": 1, "robots": ["a"], "message": "look at a"}, True)
    assert capsys.readouterr().err == "improv: look at a\n"


@pytest.mark.parametrize("count", [3, 4, 12])
def test_all_robots_that_are_not_in_their_places_are_named(
    count: int, session: TerminalSession, capsys: pytest.CaptureFixture[str]
) -> None:
    """The line that it doesn't begin names a few."""
    found = {f"r{number}": preflight.Standing(Pose(), Pose(1)) for number in range(count)}
    session._hear(preflight.message(found, 1), True)
    expected = [f"improv: move r{number} 1.00 m toward 180°" for number in range(count)] if count > 3 else []
    assert capsys.readouterr().err.splitlines() == expected
    assert session.refused.is_set()


def test_the_report_has_an_entry_for_each_fault_of_each_robot(session: TerminalSession) -> None:
    """The size of a fault is known at its end. A fault that lasts has no end, and the same fault may come again."""
    for message in (
        fault("a", 1.5, "no poses of a and b", worst={"seconds": 1.0}),
        fault("b", 1.5, "", worst={"seconds": 1.1}),
        fault("a", 4.0, "poses of a come again", over=True, worst={"seconds": 3.5}),
        fault("a", 6.0, "no pose of a", worst={"seconds": 1.2}),
    ):
        session._hear(message, True)
    assert session.report()["faults"] == [
        entry("a", 1.5, 4.0, 3.5),
        entry("b", 1.5, None, 1.1),
        entry("a", 6.0, None, 1.2),
    ]


def test_the_report_names_robots_that_are_not_in_their_places(session: TerminalSession) -> None:
    session._hear(preflight.message({"a": preflight.Standing(Pose(), Pose(1))}, 1), True)
    session._hear(preflight.message({"b": preflight.Standing(Pose(), None)}, 1), False)  # the twin reports nothing new
    misplaced = session.report()["misplaced"]
    assert [*misplaced] == ["a"]
    assert misplaced["a"]["line"] == "move a 1.00 m toward 180°"
    session._hear(preflight.message(None, 1), True)
    assert "misplaced" not in session.report()


def entry(robot: str, begins: float, ends: float | None, seconds: float) -> dict[str, Any]:
    return {"robot": robot, "kind": "silent", "from": begins, "to": ends, "worst": {"seconds": seconds}}


async def test_the_terminal_counts_before_beat_0_and_rings_if_it_is_asked_to(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(Screen, "is_live", True)
    for rings in (False, True):
        screen = Screen(False, lambda: None, rings=rings)
        await screen._count_down(time.time() + 0.05, {"beats": 3, "period": 0.01})
        shown = capsys.readouterr().out
        assert re.findall(r"count-in \d/\d", shown) == ["count-in 1/3", "count-in 2/3", "count-in 3/3"]
        assert shown.count("\a") == 3 * rings
