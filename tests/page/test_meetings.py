"""Meetings of the robots that play, in messages to pages, and the line at a takeover."""

from __future__ import annotations

import queue
from collections.abc import Iterator
from dataclasses import replace
from fractions import Fraction

import pytest

from improv_core.page.background import OwnThread
from improv_core.page.meetings import Meetings
from improv_core.program.analysis import analyze
from improv_core.program.compiler import score_of
from improv_core.protocol.page_messages import MeetingsMessage
from improv_core.score.meetings import check_room
from improv_core.score.score import Score
from improv_core.score.takeover import OutgoingScore, PendingTakeover, edited

LIMIT = 60.0
APART = "ada at 0 0\nbo at 3 0 facing 180\nada $ repeat (forward backward)\nbo $ rest\n"


class Heard:
    def __init__(self) -> None:
        self.messages: queue.Queue[MeetingsMessage] = queue.Queue()
        self.lines: queue.Queue[str] = queue.Queue()
        self.thread = OwnThread("meetings of a test")
        self.meetings = Meetings(self.messages.put, self.lines.put, self.thread.do)

    def message(self, score: Score, generation: int) -> MeetingsMessage:
        self.meetings.show(score, generation)
        return self.messages.get(timeout=LIMIT)


@pytest.fixture
def heard() -> Iterator[Heard]:
    heard = Heard()
    yield heard
    heard.thread.close()


def taken_over(before: str, after: str, beat: Fraction) -> Score:
    """Return the score that plays once a program is saved at a beat while another one plays."""
    old, new = score_of(analyze(before)), score_of(analyze(after))
    kept = {name: 2 if name in changed(before, after) else 1 for name in new.parts}
    numbered = replace(old, parts={name: replace(part, editions=(1,)) for name, part in old.parts.items()})
    parts = {name: replace(part, editions=(kept[name],)) for name, part in new.parts.items()}
    swap = PendingTakeover(replace(new, parts=parts), 2, "now", 4, 0.0, None)
    return edited(swap, beat, OutgoingScore(numbered, 0, False, {}))


def changed(before: str, after: str) -> set[str]:
    return {line.split()[0] for line in set(after.splitlines()) - set(before.splitlines())}


def test_pages_get_meetings_and_hits(heard: Heard) -> None:
    score = score_of(analyze("room 20 4\n" + APART.replace("rest", "forward")))
    message = heard.message(score, 7)
    assert {key: message[key] for key in ("type", "generation", "from", "to", "all", "assumes")} == {
        "type": "meetings",
        "generation": 7,
        "from": 0.0,
        "to": 3.0,
        "all": True,
        "assumes": False,
    }
    (meeting,) = message["meetings"]
    assert meeting["robots"] == ["ada", "bo"]
    assert meeting["beat"] == pytest.approx(0.6003, abs=1e-3)
    assert meeting["more"] == 2
    assert [pose[0] for pose in meeting["poses"]] == pytest.approx([1.2, 1.8], abs=2e-3)
    assert message["hits"] == []
    assert heard.lines.empty()


SENSING = "room 4 4\nada at -1.5 -1\nada $ until near repeat forward 1m\nbo at -1 1.5\nbo $ rest\n"


@pytest.mark.slow("starts a process")
def test_senses_decide_as_in_the_simulator(heard: Heard) -> None:
    wall = score_of(analyze(SENSING))
    assert check_room(wall, 0).hits  # if no sense held
    message = heard.message(wall, 1)
    assert (message["hits"], message["meetings"], message["assumes"]) == ([], [], False)
    met = score_of(analyze(SENSING.replace("bo $ rest", "bo $ repeat 3 strafeleft 1m")))
    heard.meetings.show(wall, 2)
    message = heard.message(met, 3)
    assert message["generation"] == 3
    assert message["hits"][0]["robot"] == "bo"


def test_a_save_that_brings_robots_together_has_a_warning(heard: Heard) -> None:
    after = APART.replace("bo $ rest", "bo $ forward forward")
    message = heard.message(taken_over(APART, after, Fraction(21, 2)), 2)
    assert message["from"] == 10.5
    assert message["meetings"][0]["beat"] == pytest.approx(10.85, abs=1e-2)
    assert heard.lines.get(timeout=LIMIT) == "ada and bo will meet in 0.4 s: change what they play, or stop them"


def test_a_save_marks_nothing_that_a_robot_senses_in_time(heard: Heard) -> None:
    after = SENSING.replace("bo $ rest", "bo $ repeat 3 strafeleft 1m")
    message = heard.message(taken_over(SENSING, after, Fraction(1)), 2)
    assert ([each["robot"] for each in message["hits"]], message["assumes"]) == (["bo"], True)


def test_a_save_that_brings_nobody_together_has_no_warning(heard: Heard) -> None:
    message = heard.message(taken_over(APART, APART.replace("bo $ rest", "bo $ left"), Fraction(10)), 2)
    assert message["meetings"] == []
    heard.message(score_of(analyze(APART)), 3)
    assert heard.lines.empty()


def test_only_the_latest_score_is_checked(heard: Heard) -> None:
    scores = [
        score_of(analyze(f"ada bo $ repeat {number} (forward choose (left right))")) for number in (400, 401, 402)
    ]
    for generation, score in enumerate(scores):
        heard.meetings.show(score, generation)
    generations = [heard.messages.get(timeout=LIMIT)["generation"]]
    while generations[-1] != 2:
        generations.append(heard.messages.get(timeout=LIMIT)["generation"])
    assert generations in ([2], [0, 2], [0, 1, 2])
