"""Stages on several machines that play as one, as stories: messages → acts, in words."""

from __future__ import annotations

import json
import math
from dataclasses import replace
from typing import Any, NamedTuple

import pytest

from improv_core.program.analysis import analyze
from improv_core.program.compiler import score_of
from improv_core.protocol.messages import Pressed, State, ToStage
from improv_core.protocol.play_again import NOT_READY, STOPPED
from improv_core.score.equality import same
from improv_core.score.score import Host, Score
from improv_core.score.score_json import from_json
from improv_core.session import on_hosts as hosts
from improv_core.session.acts import Act, Announce, Loaded, Now, Send, SendScore, Start, StateAndActs
from improv_core.session.loads import Loads
from improv_core.session.on_hosts import in_time
from improv_core.session.on_report import on_clock, on_report, on_time
from improv_core.session.on_request import on_request, tell_pressed
from improv_core.session.state import HERE, SessionState, StageKey
from improv_core.session.together import EDGE, SPARE, beat_at
from tests.session.story import READY, at, play, unpacked

PI, PAD = "pi@pi.local", "pad"
HOSTS = {"p": Host(PI, patience=3.0), "q": Host(PI), "o": Host(PAD)}
NOW = 1000.0


def on_hosts(text: str) -> Score:
    """Return a score whose robots p, q, and o have other hosts."""
    score = score_of(analyze(text))
    parts = {name: replace(part, host=HOSTS.get(name)) for name, part in score.parts.items()}
    return replace(score, parts=parts)


class SendTo(NamedTuple):
    """A message to the stage of a host."""

    host: str
    message: ToStage


class Say(NamedTuple):
    """A message of all stages, which act as one."""

    message: Any


class StartHost(NamedTuple):
    """The stage of a host is to be started again."""

    host: str


View = SendTo | Say | StartHost
PAGE = StageKey(HERE, "page")
FAULT = {"response": "tell", "over": False}


class Story:
    """Stages on hosts, from when all have started, and a page; `acts` are those that followed from the latest event."""

    def __init__(self, *hosts: str) -> None:
        self.now = NOW
        self.acts: list[View] = []
        self.loads = Loads()
        self.pressed: Pressed = {"type": "pressed", "topics": [], "count": 0}
        self.stopped = 0
        self.state = replace(SessionState().opening(dict.fromkeys(hosts or (HERE, PI, PAD), SPARE)), leader="ros")
        self.reports(PAGE, READY["page"])
        for host in self.state.robots:
            assert self.starts(host) == []

    def told(self, kind: str, **fields: Any) -> list[str]:
        """Return the acts that follow if somebody asks for something, or a clock is heard."""
        message: Any = {"type": kind, **fields}
        if kind == "anchor":
            return self.follows(on_clock(self.state, message, self.times()))
        if kind == "pressed":
            return self.follows((self.state, tell_pressed(self.state, message)))
        self.stopped += kind == "stop"
        return self.follows(on_request(self.state, message, self.times()))

    def said(self, host: str, kind: str, /, **fields: Any) -> list[str]:
        """Return the acts that follow if the stage of a host sends a message."""
        message: Any = {"type": kind, **(FAULT if kind == "fault" else {}), **fields}
        return self.reports(StageKey(host, "ros"), message)

    def starts(self, host: str) -> list[str]:
        """Return the acts that follow if the stage of a host starts."""
        self.loads.forget([StageKey(host, "ros")])
        return self.reports(StageKey(host, "ros"), READY["ros"])

    def reports(self, stage: StageKey, message: Any) -> list[str]:
        return self.follows(on_report(self.state, stage, message, self.times()))

    def is_at(self, host: str, state: State, beat: float = 0.0, **known: Any) -> list[str]:
        """Return the acts that follow if the stage of a host is in a state now, at 120 beats per minute."""
        message: Any = {**at(state, self.state.generation, beat, self.now), **known}
        return self.said(host, message.pop("type"), **message)

    def waits(self) -> list[str]:
        """Return the acts that follow at the next time that the stages wait for."""
        self.now = hosts.due(self.state, self.times())
        return self.wakes()

    def wakes(self) -> list[str]:
        """Return the acts that follow now because of the time."""
        return self.follows(on_time(self.state, self.times()))

    def plays(self, program: str | Score = "a p q o $ repeat forward\n", stops: int = 0, **how: Any) -> list[str]:
        """Return the acts that follow if somebody plays a program, and people know of some presses."""
        score = on_hosts(program) if isinstance(program, str) else program
        return self.follows(on_request(self.state, play(score, **how), replace(self.times(), known=stops)))

    def follows(self, decided: StateAndActs) -> list[str]:
        """Return the acts that follow from a decision. Scores to send are sent."""
        self.state, acts = decided
        self.acts = [seen for act in acts for seen in self._seen(act)]
        for act in acts:
            if isinstance(act, SendScore) and act.asked:
                loaded: Loaded = {"type": "loaded", "play": act.play}
                self.state, _ = on_report(self.state, act.to[0], loaded, self.times())
        return self.words

    def _seen(self, act: Act) -> list[View]:
        """Return an act as people and the stages of robots see it."""
        match act:
            case Send(to, message) if to.output == "ros":
                return [SendTo(to.host, message)]
            case SendScore(to):
                return [SendTo(key.host, load) for key, load in self.loads.of(self.state, act).items()]
            case Announce(news):
                return [Say(news)]
            case Start(stage):
                return [StartHost(stage.host)]
        return []

    def times(self) -> Now:
        return Now(self.now, self.now, stopped=self.stopped, pressed=self.pressed)

    @property
    def words(self) -> list[str]:
        return [in_words(act) for act in self.acts]

    def sent(self, host: str) -> list[Any]:
        return [act.message for act in self.acts if isinstance(act, SendTo) and act.host == host]

    @classmethod
    def playing(cls, *hosts: str) -> Story:
        """All have begun at NOW."""
        story = cls(*hosts)
        story.plays()
        for host in story.state.alive:
            story.said(host, "armed", generation=1, armed=True, begins=None)
        for host in story.state.alive:
            story.is_at(host, "playing")
        return story


def in_words(act: View) -> str:
    if isinstance(act, StartHost):
        return f"start {act.host} again"
    message: Any = unpacked(act.message)
    what = message["state"] if message["type"] == "transport" else message.get("message", message["type"])
    return f"say {what}" if isinstance(act, Say) else f"{act.host or 'here'}: {what}"


def test_each_stage_gets_the_score_and_which_robots_are_its() -> None:
    story = Story()
    assert story.plays(stops=0) == ["here: load", f"{PAD}: load", f"{PI}: load"]
    loads = {host: story.sent(host)[0] for host in (HERE, PI, PAD)}
    assert {host: load["here"] for host, load in loads.items()} == {HERE: HERE, PI: PI, PAD: PAD}
    assert {host: load.get("patience") for host, load in loads.items()} == {HERE: None, PI: 0.5, PAD: 0.5}
    assert all(load["arming"] == {} for load in loads.values()), "beat 0 waits until all are ready"


def test_a_host_is_as_patient_as_the_least_patient_of_its_robots() -> None:
    story = Story()
    story.plays("p $ forward\n")
    assert story.sent(PI)[0]["patience"] == 3.0


def test_a_pause_before_all_are_ready_means_that_nobody_begins() -> None:
    story = Story(HERE, PI)
    story.plays()
    story.told("pause")
    story.said(HERE, "armed", generation=1, armed=True, begins=None)
    assert story.said(PI, "armed", generation=1, armed=True, begins=None) == []
    assert (story.state.mode, story.told("resume")) == ("stopped", [])


def test_beat_0_is_at_one_instant_once_all_are_ready() -> None:
    story = Story()
    story.plays()
    story.said(PI, "link", host=PI, offset=0.0, error=0.0, round_trip=0.1, lag=0.2)
    assert story.said(HERE, "armed", generation=1, armed=True, begins=None) == []
    assert story.said(PI, "armed", generation=1, armed=True, begins=None) == []
    assert story.said(PAD, "armed", generation=1, armed=True, begins=None) == [
        "here: resume",
        f"{PAD}: resume",
        f"{PI}: resume",
    ]
    assert {act.message["at"] for act in story.acts} == {NOW + 0.2 + SPARE}  # type: ignore[union-attr, typeddict-item]


def test_an_armed_dance_begins_on_a_persons_request_or_at_its_time() -> None:
    for begins in (None, NOW + 60):
        story = Story(HERE, PI)
        story.plays(arming={} if begins is None else {"begins": begins})
        assert story.told("resume") == [f"say {NOT_READY}"]
        story.said(HERE, "armed", generation=1, armed=True, begins=None)
        assert story.said(PI, "armed", generation=1, armed=True, begins=None) == ["say armed"]
        assert (story.waits() if begins else story.told("resume")) == ["here: resume", f"{PI}: resume"]
        assert {act.message["at"] for act in story.acts} == {begins or NOW + SPARE}  # type: ignore[union-attr, typeddict-item]


COUNT = {"beats": 3, "period": 0.25}
"""A bar of three beats at 120 beats per minute, twice as fast."""


def counting(**arming: float) -> Story:
    """All are ready, and count a bar before beat 0."""
    story = Story(HERE, PI)
    story.told("speed", factor=2.0)
    story.plays(replace(on_hosts("beat 120\na p $ repeat forward\n"), count_in=True, bar=3), arming=arming)
    for host in (HERE, PI):
        story.said(host, "armed", generation=1, armed=True, begins=None)
    return story


def test_all_begin_to_count_at_one_instant_and_the_lead_reports_the_end() -> None:
    story = counting()
    assert [act.message.get("count") for act in story.acts] == [None], "nobody counts yet"  # type: ignore[union-attr]
    assert story.told("resume") == ["here: resume", f"{PI}: resume"]
    assert {act.message["at"] for act in story.acts} == {NOW + SPARE}  # type: ignore[union-attr, typeddict-item]
    for host, words in ((PI, []), (HERE, ["say armed"])):
        assert story.said(host, "armed", generation=1, armed=True, begins=NOW + 0.78, count=COUNT) == words
    assert story.told("resume") == [], "nobody can shorten it"
    for host, words in ((PI, []), (HERE, ["say armed"])):
        assert story.said(host, "armed", generation=1, armed=False, begins=None) == words
    assert story.is_at(HERE, "playing") == ["say playing"]


def test_the_last_bar_before_a_time_is_counted_by_all() -> None:
    story = counting(begins=NOW + 60)
    (armed,) = (act.message for act in story.acts if isinstance(act, Say))
    assert (armed["begins"], armed["count"]) == (NOW + 60, COUNT)
    assert story.waits() == ["here: resume", f"{PI}: resume"]
    instants = {act.message["at"] for act in story.acts}  # type: ignore[union-attr, typeddict-item]
    assert instants == {NOW + 60 - COUNT["beats"] * COUNT["period"]}


def test_a_stop_ends_a_count_everywhere_and_is_reported() -> None:
    story = counting()
    story.told("resume")
    story.said(HERE, "armed", generation=1, armed=True, begins=NOW + 0.78, count=COUNT)
    story.told("stop")
    assert story.said(HERE, "armed", generation=1, armed=False, begins=None) == ["say armed"]
    assert story.is_at(HERE, "stopped") == ["say stopped"]
    assert story.state.mode == "stopped"


def test_only_the_lead_reports_the_position() -> None:
    story = Story.playing()
    assert story.is_at(PI, "playing", 2.0) == []
    assert story.is_at(HERE, "playing", 2.0) == ["say playing"]
    only = Story.playing(PI, PAD)
    assert only.is_at(PAD, "playing", 2.0) == ["say playing"]


@pytest.mark.parametrize(
    "asked",
    [{"kind": "seek", "beat": 8.0}, {"kind": "speed", "factor": 0.5}, {"kind": "silence", "muted": [], "soloed": []}],
)
def test_requests_take_effect_everywhere_at_the_same_instant(asked: Any) -> None:
    story = Story.playing()
    story.now += 10.1
    asked = {**asked, "at": story.now}
    kind = asked["kind"]
    assert story.told(**asked) == [f"here: {kind}", f"{PAD}: {kind}", f"{PI}: {kind}"]
    assert {act.message["at"] for act in story.acts} == {story.now + SPARE}  # type: ignore[union-attr, typeddict-item]


def test_a_score_takes_over_after_all_have_it_and_not_at_the_edge_of_a_beat() -> None:
    for second, later in ((10.1, 0.0), (10.5 - SPARE, 2 * EDGE)):
        story = Story.playing()
        story.now = NOW + second
        assert story.plays("a $ repeat left\n", when="beat") == ["here: load", f"{PAD}: load", f"{PI}: load"]
        instant = story.now + SPARE + later
        assert [act.message["at"] for act in story.acts] == [pytest.approx(instant)] * 3  # type: ignore[union-attr, typeddict-item]


def test_nothing_resumes_after_the_end() -> None:
    story = Story.playing()
    assert story.is_at(HERE, "ended", 20.0) == ["say ended"]
    assert story.told("resume") == []


def test_reports_about_an_earlier_score_count_only_if_they_are_stops() -> None:
    story = Story.playing()
    story.plays(when="end")
    assert story.is_at(HERE, "playing", 3.0, generation=1) == ["say playing"]
    assert story.is_at(PI, "paused", 3.0, generation=1) == []
    assert story.is_at(PI, "stopped", 3.0, generation=1) == ["here: stop", f"{PAD}: stop", "say stopped"]
    story.plays()
    assert story.is_at(PI, "stopped", 3.0, generation=1) == [], "all are getting ready for another dance"


def test_a_pause_ends_for_all_at_the_same_instant_and_beat() -> None:
    story = Story.playing()
    pause: Any = {"type": "pause"}
    assert in_time(story.state, pause, Now(NOW + 1.1))["at"] == NOW + 1.1 + SPARE
    assert story.told("pause") == []
    story.is_at(HERE, "paused", 2.26)
    story.is_at(PI, "paused", 2.26)
    story.is_at(PAD, "paused", 2.5)  # it got that late
    assert story.told("resume") == ["here: resume", f"{PAD}: seek", f"{PAD}: resume", f"{PI}: resume"]
    assert story.sent(PAD)[0] == {"type": "seek", "beat": 2.26, "at": story.now + SPARE}


def test_all_resume_from_one_beat_after_a_stop_that_nobody_asked_for() -> None:
    story = Story.playing(HERE, PI)
    story.is_at(HERE, "stopped", 2.3, resumes={"scene": 2.0, "beat": 2.3})
    assert story.sent(PI) == [{"type": "stop", "unasked": True}]
    story.is_at(PI, "stopped", 2.4, resumes={"scene": 2.0, "beat": 2.4})
    assert story.state.mode == "stopped"
    assert story.told("resume", beat=2.0) == ["here: seek", "here: resume", f"{PI}: seek", f"{PI}: resume"]
    asked = [message for host in (HERE, PI) for message in story.sent(host)]
    assert {(each["type"], each["beat"], each["at"]) for each in asked} == {
        ("seek", 2.0, story.now + SPARE),
        ("resume", 2.0, story.now + SPARE),
    }


def test_a_stage_that_seeks_the_common_beat_has_not_paused_by_itself() -> None:
    story = Story.playing()
    story.told("pause")
    story.is_at(PI, "paused", 2.26)
    story.told("resume")
    assert story.is_at(PAD, "paused", 2.5) == [], "it says only now that it was paused"
    story.now += SPARE + 0.1  # its machine is busy
    assert story.is_at(PAD, "paused", 2.26) == []
    assert story.is_at(PAD, "playing", 2.26) == []
    story.now += 1
    assert story.is_at(PAD, "paused", 4.26) == ["here: pause", f"{PI}: pause", "say paused"]


def test_the_others_get_the_leads_position_before_clocks_drift_apart() -> None:
    story = Story.playing()
    assert story.waits() == [f"{PAD}: bend", f"{PI}: bend"]
    assert story.sent(PI) == [
        {"type": "bend", "at": story.now, "beat": pytest.approx(2 * (story.now - NOW)), "pace": 1.0}
    ]


def test_a_stage_that_stops_by_itself_stops_all() -> None:
    story = Story.playing()
    assert story.is_at(PI, "stopped", 3.0) == ["here: stop", f"{PAD}: stop", "say stopped"]
    assert story.is_at(HERE, "stopped", 3.1) == ["say stopped"]


def test_a_stage_that_pauses_by_itself_pauses_all_until_it_continues() -> None:
    story = Story.playing()
    held = {"waits_for": ["button 4 on /joy"]}
    assert story.is_at(PI, "paused", 3.0, **held) == ["here: pause", f"{PAD}: pause", "say paused"]
    story.is_at(HERE, "paused", 3.1)
    story.is_at(PAD, "paused", 3.1)
    story.now += 5
    assert story.is_at(PI, "playing", 3.0) == [
        "here: seek",
        "here: resume",
        f"{PAD}: seek",
        f"{PAD}: resume",
        "say playing",
    ]
    assert story.sent(HERE)[0]["beat"] == pytest.approx(3.0 + 2 * SPARE)


def test_of_two_stages_that_pause_by_themselves_each_waits_for_the_other() -> None:
    story = Story.playing(HERE, PI)
    held = {"waits_for": ["button 4 on /joy"]}
    story.now += 1
    for host in (HERE, PI):
        story.is_at(host, "paused", 2.0, **held)
    story.now += 1
    assert story.is_at(HERE, "playing", 2.0) == ["here: pause"]
    story.is_at(HERE, "paused", 2.1)
    assert story.is_at(PI, "playing", 2.0) == ["here: seek", "here: resume", "say playing"]


def seen(*robots: str, at: float = NOW) -> dict[str, Any]:
    return {robot: {"at": at, "pose": {"x": 0.0, "y": 0.0, "z": 0.0, "heading": 0.0}} for robot in robots}


def test_stages_get_the_poses_of_other_stages_robots() -> None:
    story = Story.playing()
    assert story.said(PI, "seen", robots=seen("p", "q", "a")) == ["here: seen", f"{PAD}: seen"]
    assert story.sent(HERE)[0]["robots"] == seen("p", "q"), "it may speak only of its own"


def test_poses_within_a_moment_are_sent_together_and_the_latest_counts() -> None:
    story = Story.playing()
    begun = story.now
    story.said(PI, "seen", robots=seen("p"))
    assert story.said(PAD, "seen", robots=seen("o")) == []
    story.said(HERE, "seen", robots=seen("a"))
    story.said(HERE, "seen", robots=seen("a", at=NOW + 0.01))
    assert story.waits() == ["here: seen", f"{PAD}: seen", f"{PI}: seen"]
    assert story.now == begun + hosts.SEEN_PERIOD
    assert story.sent(PI)[0]["robots"] == {**seen("o"), **seen("a", at=NOW + 0.01)}
    story.now += hosts.SEEN_PERIOD
    assert story.said(PI, "seen", robots=seen("p")) == ["here: seen", f"{PAD}: seen"], (
        "at once if nobody was told lately"
    )


@pytest.mark.parametrize("late", [HERE, PI])
def test_a_stage_that_began_a_scene_at_another_beat_joins_the_one_that_leads(late: str) -> None:
    story = Story.playing(HERE, PI)
    begins = {HERE: 3.0, PI: 3.0, late: 4.0}
    story.now += 1.5
    assert story.is_at(PI, "playing", 3.0, scene={"index": 1, "begins": begins[PI]}) == []
    story.now += 0.5
    joins = story.is_at(HERE, "playing", 4.0, scene={"index": 1, "begins": begins[HERE]})
    assert joins == ["say playing", f"{PI}: load"]
    assert story.sent(PI)[0]["entry"]["scene"] == {"index": 1, "begins": begins[HERE]}
    assert story.is_at(PI, "playing", 4.2, scene={"index": 1, "begins": begins[HERE]}) == [], "once is enough"


def test_two_stages_that_both_see_two_robots_too_near_to_each_other_are_one_pause() -> None:
    story = Story.playing()
    near = {"too_near": ["a", "p"]}
    story.now += 1
    assert story.is_at(PI, "paused", 2.0, **near) == ["here: pause", f"{PAD}: pause", "say paused"]
    line = "paused: a and p are 0.20 m apart"
    assert story.is_at(HERE, "paused", 2.02, **near) == ["say paused"]
    assert story.said(PI, "warning", message=line, **near) == [f"say {PI}: {line}"]
    assert story.said(HERE, "warning", message=line, **near) == [], "people know that"
    assert story.said(HERE, "warning", message="a is far") == ["say a is far"]
    story.is_at(HERE, "paused", 2.02, too_near=["a", "o"])
    assert story.said(HERE, "warning", message="paused: a and o are 0.10 m apart", too_near=["a", "o"]) != []
    story.is_at(HERE, "paused", 2.02, **near)
    story.is_at(PAD, "paused", 2.1)
    assert story.told("resume") == ["here: resume", f"{PAD}: seek", f"{PAD}: resume", f"{PI}: seek", f"{PI}: resume"]
    story.now += SPARE
    for host in story.state.alive:
        story.now += 0.02  # they are late to obey, and seek the beat while they are still paused
        assert story.is_at(host, "paused", 2.02, **near) == []
        story.is_at(host, "playing", 2.02)
    assert story.state.mode == "playing"
    story.now += 1
    assert story.is_at(PI, "paused", 4.0, **near)[0] == "here: pause", "what comes later is another pause"


def test_a_pause_that_is_reported_after_a_person_resumes_pauses_no_stage() -> None:
    story = Story.playing()
    near = {"too_near": ["a", "p"]}
    story.now += 1
    story.is_at(PI, "paused", 2.0, **near)
    story.is_at(HERE, "paused", 2.0)
    late = story.now
    story.now += 0.2
    story.told("resume")
    assert story.is_at(PAD, "paused", 2.0, **near, monotonic=late) == []
    assert story.state.mode == "playing"
    story.now += SPARE
    held = {"waits_for": ["button 4 on /joy"]}
    assert story.is_at(PAD, "paused", 2.0, **held)[-1] == "say paused", "it can't continue: a button must be held"


def test_a_robot_that_is_not_in_its_place_holds_all_back_until_people_play_again() -> None:
    story = Story(HERE, PI)
    story.plays()
    story.said(HERE, "armed", generation=1, armed=True, begins=None)
    assert story.is_at(PI, "paused") == ["say paused"]
    place: Any = {"place": {"x": 0, "y": 0, "heading": 0}, "pose": None, "line": "p is elsewhere"}
    story.said(PI, "misplaced", generation=1, waits=True, robots={"p": place})
    assert story.acts[0].message["robots"].keys() == {"p"}  # type: ignore[union-attr, typeddict-item]
    assert story.told("resume", anyway=True) == ["here: load", f"{PI}: load"]
    assert [act.message["anyway"] for act in story.acts] == [True, True]  # type: ignore[union-attr, typeddict-item]


def test_a_line_names_robots_that_have_not_confirmed_a_stop() -> None:
    story = Story.playing()
    story.told("stop")
    story.is_at(HERE, "stopped", 1.0)
    story.is_at(PAD, "stopped", 1.0)
    assert story.waits() == [f"say p, q may still be moving: {PI} has not confirmed the stop"]
    assert story.is_at(PI, "stopped", 1.0) == []


def test_a_stop_that_all_confirm_is_no_news() -> None:
    story = Story.playing()
    story.told("stop")
    for host in story.state.alive:
        story.is_at(host, "stopped", 1.0)
    assert story.waits() == []


def test_a_host_that_comes_back_joins_at_the_beat() -> None:
    story = Story.playing()
    assert story.said(PI, "gone", message="it was rebooted") == [
        f"say {PI}: it was rebooted; the others continue, and it joins them again",
        f"start {PI} again",
    ]
    story.now += 20.1
    story.is_at(HERE, "playing", 40.2)
    story.starts(PI)
    assert story.words == [f"{PI}: load"]
    (load,) = story.sent(PI)
    assert load["entry"] == {"beat": pytest.approx(40.2 + 2 * SPARE), "monotonic": pytest.approx(story.now + SPARE)}
    assert (load["when"], "arming" in load, load["score"]["known"]) == ("restart", False, 0)


@pytest.mark.parametrize("sent", [False, True])
def test_a_host_that_comes_back_stops_its_robots_if_somebody_stops_before_it_has_joined(sent: bool) -> None:
    """They may still move as the stage before left them, and a score on its way is void."""
    story = Story.playing()
    story.said(PI, "gone", message="it was rebooted")
    if not sent:
        story.state = replace(story.state, settles=math.inf)
    story.starts(PI)
    assert story.words == [f"{PI}: load"] * sent
    assert story.told("stop") == [f"{PI}: load"]
    (load,) = story.sent(PI)
    assert (load["score"]["movements"], load["here"]) == ([], PI)
    assert not any(part["scenes"] for part in load["score"]["parts"].values())


def test_a_host_that_comes_back_during_a_pause_joins_when_the_others_continue() -> None:
    story = Story.playing()
    story.told("pause")
    story.is_at(HERE, "paused", 2.0)
    story.said(PI, "gone", message="it was rebooted")
    story.starts(PI)
    assert story.words == []
    story.told("resume")
    assert story.is_at(HERE, "playing", 2.0) == ["say playing", f"{PI}: load"]


def test_a_host_that_comes_back_while_robots_are_waited_for_gets_ready_with_the_others() -> None:
    story = Story(HERE, PI)
    story.plays()
    story.said(PI, "gone", message="it was rebooted")
    assert story.said(PI, "armed", generation=1, armed=True, begins=None) == [], "what it said before is no news"
    story.starts(PI)
    assert (story.words, story.sent(PI)[0]["arming"]) == ([f"{PI}: load"], {})
    assert story.said(HERE, "armed", generation=1, armed=True, begins=None) == []
    assert story.said(PI, "armed", generation=1, armed=True, begins=None) == ["here: resume", f"{PI}: resume"]


def test_a_host_that_lacks_an_earlier_score_gets_the_whole_one_and_joins() -> None:
    story = Story.playing(HERE, PI)
    assert story.said(PI, "lacks", generation=1) == [f"{PI}: load"]
    assert story.sent(PI)[0]["score"]["known"] == 0


def test_a_dance_ends_if_all_remaining_stages_have_yet_to_join() -> None:
    story = Story.playing(HERE, PI)
    story.told("pause")
    story.is_at(HERE, "paused", 2.0)
    story.said(PI, "gone", message="it was rebooted")
    story.starts(PI)
    assert story.said(HERE, "gone", message="it was killed") == [
        "say the stage here: it was killed",
        "start  again",
        f"{PI}: load",
        "say stopped",
    ]


@pytest.mark.parametrize("first_is_back", [False, True])
@pytest.mark.parametrize("early", [False, True])
def test_people_may_have_all_resume_from_where_all_stages_died(first_is_back: bool, early: bool) -> None:
    """They may do so `early`, before the last of the new stages has stopped its robots: it joins the others."""
    story = Story.playing(HERE, PI)
    story.is_at(PI, "playing", 4.0)
    story.is_at(HERE, "playing" if first_is_back else "waiting", 4.0)  # it may die before it has reported more
    story.said(PI, "gone", message="no power")
    if first_is_back:
        story.state = replace(story.state, settles=math.inf)  # it has yet to join
        assert story.starts(PI) == []
        story.state = replace(story.state, settles=-math.inf)
    story.now += 0.5
    story.said(HERE, "gone", message="no power")
    assert story.starts(HERE) == ["here: load"]
    if not first_is_back:
        assert story.starts(PI) == [f"{PI}: load"]

    def stands(host: str) -> None:
        assert story.is_at(host, "stopped") == [f"{host or 'here'}: load"]
        (load,) = story.sent(host)
        assert (load["stood"]["beat"], load["when"], load["score"]["known"]) == (5.0, "restart", 0)

    stands(HERE)
    offer: dict[str, Any] = {"beat": 5.0, "resumes": {"scene": 0.0, "beat": 5.0}}
    assert story.is_at(HERE, "stopped", **offer) == ["say stopped"]
    assert story.state.resumes == offer["resumes"]
    if not early:
        stands(PI)
        story.is_at(PI, "stopped", **offer)
    assert story.told("resume", beat=5.0) == ["here: resume", *([] if early else [f"{PI}: resume"])]
    story.now += 1.0
    story.is_at(HERE, "playing", 5.0)
    assert ([load["entry"]["beat"] > 5.0 for load in story.sent(PI)], story.state.mode) == ([True] * early, "playing")
    assert story.is_at(PI, "playing", 5.0) == []
    assert [stage.died_moving for stage in story.state.robots.values()] == [False, False]


@pytest.mark.parametrize("why", ["people stop", "an emergency stop"])
def test_nobody_is_offered_to_resume_if_somebody_stopped_before_all_stages_died(why: str) -> None:
    story = Story.playing(HERE, PI)
    if why == "people stop":
        story.told("stop")
    else:
        story.pressed = {"type": "pressed", "topics": ["/stop"], "count": 1}
    for host in (PI, HERE):
        story.said(host, "gone", message="no power")
    story.starts(HERE)
    assert story.is_at(HERE, "stopped") == []


def test_a_host_whose_link_was_silent_joins_again_unless_people_have_stopped() -> None:
    story = Story.playing()
    line = f"say {PI} heard nothing from here for 3 s, so its robots stopped"
    assert story.said(PI, "deserted", seconds=3.0) == [f"{line}; they join the others again", f"{PI}: load"]
    story = Story.playing()
    story.told("stop")
    assert story.said(PI, "deserted", seconds=3.0) == [f"{line}: play again"]


def test_the_only_host_whose_link_was_silent_stops_the_dance() -> None:
    story = Story.playing(PI)
    story.said(PI, "deserted", seconds=3.0)
    assert story.is_at(PI, "stopped", 3.0) == ["say stopped"]
    assert story.state.mode == "stopped"


def test_another_stage_leads_if_the_one_that_did_is_gone() -> None:
    story = Story.playing()
    story.said(HERE, "gone", message="it was killed")
    assert story.words[-2:] == ["start  again", "say playing"]
    assert story.is_at(PAD, "paused", 2.0, waits_for=["button 4 on /joy"])[-1] == "say paused"


def test_without_any_stage_all_is_over() -> None:
    story = Story.playing(PI)
    assert story.said(PI, "gone", message="the link is gone") == [
        f"start {PI} again",
        "say the link is gone: a new one is stopping the robots; play again",
    ]


def test_a_stage_speaks_only_of_its_own_robots() -> None:
    story = Story.playing()
    assert story.said(PI, "fault", robot="p") == ["say fault"]
    assert story.said(PI, "fault", robot="a") == []
    assert story.said(PI, "measured", robots={"a": 1}) == []
    story.said(PI, "measured", robots={"a": 1, "p": 2})
    assert story.acts[0].message["robots"] == {"p": 2}  # type: ignore[union-attr, typeddict-item]
    story.said(PI, "vitals", robots={"a": 1, "p": 2})
    story.said(HERE, "vitals", robots={"a": 3, "p": 4})
    assert story.acts[0].message["robots"] == {"a": 3, "p": 2}  # type: ignore[union-attr, typeddict-item]


def test_the_others_get_the_senses_of_a_robot() -> None:
    story = Story.playing()
    assert story.said(PI, "sensed", robot="p") == ["say sensed", "here: sensed", f"{PAD}: sensed"]
    assert story.said(HERE, "sensed", robot="p") == []


def test_a_save_builds_on_what_the_stages_have_and_a_newcomer_gets_it_whole() -> None:
    story = Story.playing()
    story.plays("a p $ repeat left\no $ repeat forward\n", when="now")
    assert story.sent(HERE)[0]["score"]["known"] > 0
    story.said(PI, "lacks", generation=2)
    story.now += 1
    story.is_at(HERE, "playing", 2.0)
    read = from_json(json.loads(json.dumps(story.sent(PI)[0]))["score"])
    saved = on_hosts("a p $ repeat left\no $ repeat forward\n")
    assert all(same(part.scenes[0], saved.parts[name].scenes[0]) for name, part in read.parts.items())


def test_emergency_stops_are_counted_by_each_stage_and_known_together() -> None:
    story = Story.playing()
    story.said(PI, "pressed", topics=["/stop"], count=2)
    story.said(PAD, "pressed", topics=["/halt"], count=1)
    assert story.acts == [Say({"type": "pressed", "topics": ["/halt", "/stop"], "count": 3})]
    story.plays(stops=3)
    counts = {HERE: 0, PI: 2, PAD: 1}
    assert {host: story.sent(host)[0]["stops"] for host in counts} == counts
    story.told("pressed", topics=["/halt"], count=3)
    assert {host: story.sent(host)[0]["count"] for host in counts} == counts


def test_a_stage_that_reports_a_dance_that_nobody_has_played_prevents_no_stop() -> None:
    story = Story(HERE, PI)
    story.said(PI, "gone", message="no power")
    story.is_at(HERE, "paused")
    story.told("resume")
    story.starts(PI)
    assert story.told("stop") == [f"{PI}: load"]


def test_a_stage_in_place_of_a_dead_one_has_its_emergency_stops_and_counts_on() -> None:
    story = Story.playing()
    story.said(PI, "pressed", topics=["/stop"], count=2)
    story.said(PAD, "pressed", topics=["/halt"], count=1)
    story.pressed = {"type": "pressed", "topics": ["/halt", "/stop"], "count": 3}
    story.said(PI, "gone", message="no power")
    story.starts(PI)
    assert story.sent(PI)[0] == {"type": "pressed", "topics": ["/stop"], "count": 2}
    story.said(PAD, "gone", message="no power")
    story.said(HERE, "gone", message="no power")
    story.starts(HERE)
    assert "here: pressed" not in story.words, "it had none"


def test_messages_for_pages_go_to_the_stage_here_which_has_them() -> None:
    assert Story().told("program", text="") == ["here: program"]
    assert Story(PI).told("program", text="") == []


def test_stages_that_start_later_get_the_kept_messages() -> None:
    story = Story(HERE)
    story.told("silence", muted=["a"], soloed=[])
    story.state = story.state.opening({PI: SPARE})
    story.starts(PI)
    assert story.words == [f"{PI}: silence"]


def test_robots_that_nobody_moves_are_named() -> None:
    assert Story(PI).plays("a p $ forward\n")[0] == "say nobody moves a: no ROS 2 runs here, and they have no `host`"


def test_a_beat_may_be_sent_ahead() -> None:
    told = at("playing", 1, 4.0, NOW)
    assert (beat_at(told, NOW - 1), beat_at(told, NOW + 1)) == (2.0, 6.0)


def stopped(story: Story, by: list[str]) -> None:
    """Have all stop, and report which automations may have robots move."""
    story.told("stop")
    for host in story.state.alive:
        story.is_at(host, "stopped", 2.0, startable_by=by)


def test_only_a_person_continues_from_a_seek_since_a_stop() -> None:
    story = Story.playing(HERE, PI)
    stopped(story, [])
    assert story.told("seek", beat=5.0) == ["here: seek", f"{PI}: seek"]
    for host in (HERE, PI):
        story.is_at(host, "paused", 5.0, startable_by=[])
    assert story.told("resume", by="osc") == [f"say {STOPPED}"]
    assert story.told("resume") == ["here: resume", f"{PI}: resume"]
    assert story.state.mode == "playing"


def test_an_automation_plays_again_only_if_all_stages_let_it() -> None:
    story = Story.playing(HERE, PI)
    stopped(story, ["osc"])
    story.is_at(PI, "stopped", 2.0, startable_by=[])
    assert story.plays(by="osc") == [f"say {STOPPED}"]
    story.is_at(PI, "stopped", 2.0, startable_by=["osc"])
    assert story.plays(by="ros") == [f"say {STOPPED}"]
    assert story.plays(by="osc") == ["here: load", f"{PI}: load"]
    assert [load["by"] for host in (HERE, PI) for load in story.sent(host)] == ["osc", "osc"]
    assert story.said(PI, "gone", message="it broke")[1:] == [f"start {PI} again"]
    story.starts(PI)
    assert ["by" in load for load in story.sent(PI)] == [False]  # or a stage that is new would refuse it


def test_each_stage_gets_the_automation_that_continues() -> None:
    story = Story.playing(HERE, PI)
    story.told("pause")
    for host in (HERE, PI):
        story.is_at(host, "paused", 2.0)
    story.told("resume", by="ros")
    assert [message["by"] for host in (HERE, PI) for message in story.sent(host)] == ["ros", "ros"]


@pytest.mark.parametrize(("by", "stop"), [(["ros"], {"by": "ros"}), ([], {}), (None, {})])
def test_the_others_stop_by_whatever_stopped_one(by: list[str] | None, stop: dict[str, str]) -> None:
    story = Story.playing(HERE, PI)
    story.is_at(PI, "stopped", 2.0, **({} if by is None else {"startable_by": by}))
    assert story.sent(HERE) == [{"type": "stop", **stop}]
