"""The acts that follow from stages' messages, starts, and ends, as tables: event → acts."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import pytest

from improv_core.program.analysis import analyze
from improv_core.program.compiler import score_of
from improv_core.protocol.messages import Armed, Decided, Obeyed, Pressed, Sensed
from improv_core.protocol.play_again import STOPPED
from improv_core.score.score import OutsideClock
from improv_core.session.on_report import BEHIND
from improv_core.session.state import Output
from tests.session.story import DANCE, FAILED, GONE, READY, Event, From, Story, at, play, tell

SENSED: Sensed = {"type": "sensed", "sense": "cue", "value": True, "generation": 1, "robot": "r", "beat": 2.5,
                  "performed": 1.25, "wall": 0}  # fmt: skip
DECIDED: Decided = {"type": "decided", "sources": [[0, 4, 9]], "held": True, "generation": 1, "robot": "r", "beat": 2.5,
                    "performed": 1.25, "wall": 0}  # fmt: skip
ARMED: Armed = {"type": "armed", "generation": 1, "armed": True, "begins": None}
DISARMED: Armed = {"type": "armed", "generation": 1, "armed": False, "begins": None}
OBEYED: Obeyed = {"type": "obeyed", "direct": "p 1"}
OPEN = score_of(analyze("r $ until cue (repeat forward)\n"))
MUSIC = replace(DANCE, clock=OutsideClock("midi"))
GHOST = score_of(analyze("ghost $ repeat forward\n"))
OFFER: dict[str, Any] = {"resumes": {"scene": 0.0, "beat": 5.0}}
BUTTON: dict[str, Any] = {"waits_for": ["button 4 on /joy"]}

STOPPING = "it exited: a new one is stopping the robots; play again"
ROS: From = "ros", READY["ros"]
SIMULATOR: From = "simulator", READY["simulator"]
STORIES: dict[str, Sequence[tuple[Event, list[str]]]] = {
    "the stage of real robots crashes": [
        (play(), ["ros: score 1"]),
        (("ros", at("waiting", 1)), ["transport"]),
        (("ros", at("playing", 1, 3.0)), ["simulator: score 1 from beat 3", "transport"]),
        (("ros", at("playing", 1, 4.0, monotonic=999.5)), ["transport"]),
        (("simulator", at("playing", 1)), ["transport (the other)"]),
        (("ros", GONE), ["simulator: stop", "start ros", STOPPING]),
        (("ros", at("stopped", 0)), ["transport (the other)"]),  # the new one is starting
        (ROS, ["ros: score 1 stop"]),
        (("ros", at("playing", 1)), ["transport"]),  # the twin does not show how robots stop
        (("ros", at("ended", 1)), ["transport", "ros: score 1 stands at beat 5"]),
        (("ros", at("stopped", 1, 5.0, **OFFER)), ["simulator: stop", "simulator: why_still", "transport"]),
        ({"type": "resume", "beat": 5.0}, ["ros: resume", "simulator: resume"]),
        (play(), ["ros: score 2"]),
        (("ros", at("playing", 2)), ["simulator: score 2 from beat 0", "simulator: why_still", "transport"]),
    ],
    "somebody stops robots before their new stage has": [
        (play(), ["ros: score 1"]),
        (("ros", at("playing", 1)), ["simulator: score 1 from beat 0", "transport"]),
        (("ros", GONE), ["simulator: stop", "start ros", STOPPING]),
        ({"type": "restart"}, []),
        ({"type": "stop"}, []),
        (ROS, ["ros: score 1 stop"]),
        (("ros", at("ended", 1)), ["transport"]),
    ],
    "somebody plays again before the new stage has started, and an automation can't": [
        (play(), ["ros: score 1"]),
        (("ros", at("playing", 1)), ["simulator: score 1 from beat 0", "transport"]),
        (("ros", GONE), ["simulator: stop", "start ros", STOPPING]),
        ({"type": "restart", "by": "osc"}, [STOPPED]),
        ({"type": "restart"}, []),
        (ROS, ["ros: score 1 stop", "ros: score 2"]),
        (("ros", at("playing", 2)), ["simulator: score 2 from beat 0", "transport"]),
    ],
    "the simulator bends with the leading stage, which follows a clock": [
        (play(), ["ros: score 1"]),
        (("ros", at("playing", 1, pace=1.5)), ["simulator: score 1 from beat 0", "simulator: bend", "transport"]),
        (("ros", at("playing", 1, 1.0, pace=1.6)), ["simulator: bend", "transport"]),
        (("simulator", at("playing", 1, 1.0, pace=1.6)), ["transport (the other)"]),
        (
            ("ros", at("paused", 1, 0.9, pace=1.6, waits_for=["/clock"])),
            ["simulator: pause", "simulator: seek", "simulator: why_still", "transport"],
        ),
        (
            ("ros", at("playing", 1, 0.9, pace=1.0)),
            ["simulator: resume", "simulator: bend", "simulator: why_still", "transport"],
        ),
    ],
    "a score follows the clock of music, and later ones don't": [
        (play(MUSIC), ["ros: score 1", "listen to midi"]),
        (play(MUSIC), ["ros: score 2"]),
        (play(), ["ros: score 3", "listen to no clock"]),
    ],
    "the stage of real robots crashes before it begins again": [
        (play(), ["ros: score 1"]),
        (("ros", at("playing", 1, 7.0)), ["simulator: score 1 from beat 7", "transport"]),
        ({"type": "restart"}, ["ros: score 2"]),
        (("ros", GONE), ["simulator: stop", "start ros", STOPPING]),
        (ROS, ["ros: score 2 stop"]),
        (("ros", at("ended", 2)), ["transport"]),  # the place was in the dance before
    ],
    "the stage of real robots crashes before it obeys a stop": [
        (play(), ["ros: score 1"]),
        (("ros", at("playing", 1)), ["simulator: score 1 from beat 0", "transport"]),
        ({"type": "stop"}, []),
        (("ros", GONE), ["simulator: stop", "start ros", STOPPING]),
        (ROS, ["ros: score 1 stop"]),
        (("ros", at("ended", 1)), ["transport"]),
    ],
    "a new stage dies, too, while robots may be moving": [
        (play(), ["ros: score 1"]),
        (("ros", GONE), ["simulator: stop", "start ros", STOPPING]),
        (ROS, ["ros: score 1 stop"]),
        (("ros", GONE), ["simulator: stop", "it exited: robots may still be moving; play again"]),
    ],
    "a new stage dies once robots stand": [
        (play(), ["ros: score 1"]),
        (("ros", GONE), ["simulator: stop", "start ros", STOPPING]),
        (ROS, ["ros: score 1 stop"]),
        (("ros", at("playing", 1)), ["transport"]),
        (("ros", at("ended", 1)), ["transport"]),
        (("ros", GONE), ["simulator: stop", "it exited; play again"]),  # or stages would start forever
    ],
    "a new stage that has played again dies": [
        (play(), ["ros: score 1"]),
        (("ros", GONE), ["simulator: stop", "start ros", STOPPING]),
        (ROS, ["ros: score 1 stop"]),
        (play(), ["ros: score 2"]),
        (("ros", GONE), ["simulator: stop", "start ros", STOPPING]),
    ],
    "a stage crashes before anything has been played": [
        (("ros", GONE), ["simulator: stop", "start ros", STOPPING]),
        (ROS, []),
        (play(), ["ros: score 1"]),
    ],
    "a stage crashes while it waits": [
        (play(), ["ros: score 1"]),
        (("ros", at("playing", 1)), ["simulator: score 1 from beat 0", "transport"]),
        (("ros", at("paused", 1, **BUTTON)), ["simulator: pause", "simulator: why_still", "transport"]),
        (("ros", GONE), ["simulator: stop", "start ros", STOPPING]),
        (ROS, ["ros: score 1 stop"]),
        (("ros", at("playing", 1)), ["simulator: why_still", "transport"]),
    ],
    "a stage cannot be replaced": [
        (play(), ["ros: score 1"]),
        (("ros", GONE), ["simulator: stop", "start ros", STOPPING]),
        (("ros", FAILED), ["no new stage could be started: no ROS"]),
        ({"type": "restart"}, []),
        (("simulator", at("stopped", 1)), ["transport (the other)"]),
    ],
    "the parent sends a stop that could not go straight to stages, and pages wait for those of real robots": [
        (play(), ["ros: score 1"]),
        (("simulator", OBEYED), []),
        (("ros", OBEYED), ["simulator: obeyed"]),
        (("ros", at("playing", 1)), ["simulator: score 1 from beat 0", "transport"]),
        (("ros", GONE), ["simulator: stop", "start ros", STOPPING]),
        (("simulator", {**OBEYED, "direct": "p 2"}), []),
        (ROS, ["ros: score 1 stop"]),
        (("ros", {**OBEYED, "direct": "p 2"}), []),
        (("ros", at("ended", 1)), ["transport", "ros: score 1 stands at beat 1000"]),
        (("ros", {**OBEYED, "direct": "p 3"}), ["simulator: obeyed"]),
    ],
    "the twin crashes": [
        (play(), ["ros: score 1"]),
        (("ros", at("playing", 1)), ["simulator: score 1 from beat 0", "transport"]),
        (("simulator", GONE), ["start simulator", "it exited: a new one will show what plays next (the other)"]),
        (SIMULATOR, []),
        (("ros", at("playing", 1, 8.0)), ["transport"]),
        (("simulator", {"type": "lacks", "generation": 1}), []),
        (play(), ["ros: score 2"]),
        (("ros", at("playing", 2)), ["simulator: score 2 from beat 0", "transport"]),
    ],
    "the twin cannot be replaced": [
        (play(), ["ros: score 1"]),
        (("simulator", GONE), ["start simulator", "it exited: a new one will show what plays next (the other)"]),
        (("simulator", FAILED), ["no new stage could be started: no ROS (the other)"]),
        (play(), ["ros: score 2"]),
        (("ros", at("playing", 2)), ["transport"]),
    ],
    "the stage of real robots crashes while the simulator plays alone": [
        (play(), ["ros: score 1"]),
        (play(GHOST, simulated=True), ["ros: stop", "simulator: score 2"]),
        (("ros", {"type": "stopped"}), ["stopped (the other)"]),
        (("ros", GONE), ["start ros", "it exited: a new one is stopping the robots (the other)"]),
        (("simulator", at("playing", 2)), ["transport"]),
        (("simulator", {"type": "lacks", "generation": 2}), ["simulator: score 2 whole"]),
        (ROS, ["ros: score 2 stop"]),
        (("ros", {"type": "lacks", "generation": 2}), []),
        (("ros", at("ended", 2)), ["transport (the other)"]),
        (play(), ["simulator: stop", "ros: score 3"]),
    ],
    "a score takes over at the next bar": [
        (play(), ["ros: score 1"]),
        (("ros", at("playing", 1)), ["simulator: score 1 from beat 0", "transport"]),
        (play(when="bar"), ["ros: score 2"]),
        (("ros", at("playing", 1, 2.0)), ["transport"]),
        (("simulator", {"type": "lacks", "generation": 2}), []),
        (("ros", at("playing", 2, 4.0)), ["simulator: score 2 from beat 4", "transport"]),
    ],
    "a score is armed, and a person begins": [
        (play(arming={}), ["ros: score 1"]),
        (("ros", at("waiting", 1)), ["transport"]),
        (("ros", ARMED), ["simulator: armed", "armed"]),
        (("simulator", ARMED), ["armed (the other)"]),
        ({"type": "resume"}, ["ros: resume"]),  # the twin begins with the leader
        (("ros", at("playing", 1)), ["simulator: score 1 from beat 0", "transport"]),
        (("ros", DISARMED), ["simulator: armed", "armed"]),
        ({"type": "resume"}, ["ros: resume", "simulator: resume"]),
    ],
    "a stage crashes while a score is armed": [
        (play(arming={}), ["ros: score 1"]),
        (("ros", ARMED), ["simulator: armed", "armed"]),
        (("ros", GONE), ["simulator: stop", "simulator: armed", "start ros", STOPPING]),
        (ROS, ["ros: score 1 stop"]),
    ],
    "the leading stage stops, waits, and continues by itself": [
        (play(), ["ros: score 1"]),
        (("ros", at("playing", 1)), ["simulator: score 1 from beat 0", "transport"]),
        (("ros", at("paused", 1, **BUTTON)), ["simulator: pause", "simulator: why_still", "transport"]),
        (("ros", at("ended", 1, **BUTTON)), ["simulator: why_still", "transport"]),
        (("ros", at("playing", 1)), ["simulator: resume", "transport"]),
        (("ros", at("paused", 1)), ["transport"]),  # the twin got the request when the leader did
        (("ros", at("playing", 1)), ["transport"]),
        (("ros", at("stopped", 1)), ["simulator: stop", "transport"]),
    ],
}


@pytest.mark.parametrize("story", STORIES.values(), ids=STORIES)
def test_a_session_with_real_robots_and_the_simulator(story: Sequence[tuple[Event, list[str]]]) -> None:
    tell(Story(), story)


def test_one_stage_alone_has_no_twin() -> None:
    story = Story("simulator")
    tell(story, [
        (play(), ["simulator: score 1"]),
        (("simulator", at("playing", 1)), ["transport"]),
        (("simulator", GONE), ["start simulator", STOPPING]),
        (SIMULATOR, ["simulator: score 1 stop"]),
    ])  # fmt: skip
    assert story.state.status == "simulator"


@pytest.mark.parametrize(
    ("heard", "is_open", "is_on", "still", "status"),
    [
        ([], True, True, True, "ROS 2, with the simulator alongside"),
        ([("ros", at("stopped", 1))], True, False, True, "ROS 2, with the simulator alongside"),
        ([("simulator", at("stopped", 1))], True, True, True, "ROS 2, with the simulator alongside"),
        ([("ros", GONE)], False, False, True, "ROS 2, with the simulator alongside"),
        ([("ros", GONE), ROS], True, False, False, "ROS 2, with the simulator alongside"),
        ([("ros", GONE), ROS, ("ros", at("stopped", 0))], True, False, False, "ROS 2, with the simulator alongside"),
        ([("ros", GONE), ROS, ("ros", at("playing", 1))], True, True, False, "ROS 2, with the simulator alongside"),
        (
            [("ros", GONE), ROS, ("simulator", at("stopped", 1))],
            True,
            False,
            False,
            "ROS 2, with the simulator alongside",
        ),
        ([("ros", GONE), ROS, ("ros", at("ended", 1))], True, False, True, "ROS 2, with the simulator alongside"),
        ([("ros", GONE), ROS, ("ros", GONE)], False, False, True, "ROS 2, with the simulator alongside"),
        ([("ros", GONE), ("ros", FAILED)], False, False, True, "nothing"),
        ([("simulator", GONE)], False, True, True, "ROS 2, with the simulator alongside"),
        ([("simulator", GONE), ("simulator", FAILED)], True, True, True, "ROS 2"),
    ],
)
def test_the_state_follows_the_stages(heard: Any, is_open: bool, is_on: bool, still: bool, status: str) -> None:
    """Unless it `is_open`, the next play starts all stages. While robots don't stand `still`, a close waits for
    them."""
    story = Story.playing()
    for event in heard:
        story(event)
    state = story.state
    assert (state.is_open, state.is_on, state.still, state.status) == (is_open, is_on, still, status)


def test_if_an_idle_stage_cannot_be_replaced_the_next_play_starts_all() -> None:
    story = Story.playing()
    story(play(simulated=True))
    story(("ros", GONE))
    assert story(("ros", FAILED)) == ["no new stage could be started: no ROS (the other)"]
    assert not story.state.is_open


def test_the_twin_enters_where_the_leading_stage_did() -> None:
    story = Story()
    story(play())
    story(("ros", at("playing", 1, 3.0, 500.0)))
    assert (story.score.play.when, story.score.entry) == ("restart", {"beat": 3.0, "monotonic": 500.0})
    story(play(when="bar"))
    scene = {"index": 1, "begins": 4.0}
    story(("ros", at("playing", 2, 6.0, 501.0, restarted=1, begins={"r": 6.0}, scene=scene)))
    entry = {"beat": 6.0, "monotonic": 501.0, "begins": {"r": 6.0}, "scene": scene}
    assert (story.score.play.when, story.score.entry) == ("now", entry)


def test_the_twin_pauses_and_resumes_when_the_leading_stage_did() -> None:
    story = Story.playing()
    story(("ros", at("paused", 1, monotonic=510.0, **BUTTON)))
    assert story.sent("simulator")[0] == {"type": "pause", "at": 510.0}
    story(("ros", at("playing", 1, monotonic=520.0)))
    assert story.sent("simulator")[0] == {"type": "resume", "at": 520.0}


@pytest.mark.parametrize(
    ("why", "line"),
    [
        ({"too_near": ["ada", "bo"]}, "Too near to each other: ada, bo. Make room, then press Play."),
        ({"waits_for": ["a pose of ada"]}, "Waiting for a pose of ada."),
    ],
)
def test_pages_show_why_real_robots_stand_until_they_play(why: dict[str, Any], line: str) -> None:
    story = Story.playing()
    story(("ros", at("paused", 1, **why)))
    assert story.sent("simulator")[1:] == [{"type": "why_still", "line": line}]
    story(("ros", at("paused", 1, **why)))
    assert story.sent("simulator")[1:] == []
    story(("ros", at("playing", 1)))
    assert story.sent("simulator")[1:] == [{"type": "why_still", "line": ""}]


def test_pages_offer_to_resume_after_a_stop_that_nobody_asked_for_until_another_stop() -> None:
    story, resumes = Story.playing(), {"scene": 2.0, "beat": 3.5}
    line = "Robots were stopped, although nobody asked for that."
    story(("ros", at("stopped", 1, resumes=resumes)))
    assert story.sent("simulator")[-1] == {"type": "why_still", "line": line, "resumes": resumes}
    story(("ros", at("stopped", 1)))
    assert story.sent("simulator")[-1] == {"type": "why_still", "line": ""}


def test_pages_name_robots_that_may_still_be_moving_until_something_plays() -> None:
    story = Story.playing()
    story(("ros", at("stopped", 1)))
    story(("ros", {"type": "unreached", "generation": 1, "robots": ["ada"], "message": "look at ada"}))
    assert story.sent("simulator") == [{"type": "why_still", "line": "look at ada"}]
    story(("ros", at("stopped", 1)))
    assert story.sent("simulator") == [{"type": "stop"}]
    story(play())
    story(("ros", at("waiting", 2)))
    assert story.sent("simulator") == [{"type": "why_still", "line": ""}]


def test_the_twin_plays_decisions_of_senses_a_moment_later() -> None:
    story = Story()
    story(play(OPEN))
    story(("ros", at("playing", 1)))
    assert story.score.entry == {"beat": 0.0, "monotonic": 500.0 + BEHIND, "behind": BEHIND}
    tell(story, [
        (("ros", SENSED), ["simulator: sensed", "sensed"]),
        (("simulator", SENSED), []),  # as it shows it on its page
        (("ros", DECIDED), ["simulator: decided", "decided"]),
        (("simulator", DECIDED), []),
        ({"type": "cue"}, ["ros: cue"]),  # the twin gets what robots sensed
        ({"type": "seek", "beat": 4.0}, ["ros: seek", "simulator: seek 0.1 s later"]),
    ])  # fmt: skip
    (seek, later) = (act.message for act in story.acts)  # type: ignore[union-attr]
    assert later["at"] == seek["at"] + BEHIND  # type: ignore[typeddict-item]
    story(play())
    story(("ros", at("playing", 2)))
    assert story({"type": "seek", "beat": 4.0}) == ["ros: seek", "simulator: seek"]


def test_real_poses_are_shown_on_the_page() -> None:
    joints = {"type": "joints", "generation": 1, "robot": "a", "positions": {}, "beat": 0, "performed": 0, "wall": 0}
    assert Story.playing()(("ros", joints)) == ["simulator: joints", "joints"]  # type: ignore[arg-type]
    story, measured = Story.playing(), {"type": "measured", "generation": 1, "robots": {}}
    assert story(("ros", measured)) == ["simulator: measured", "measured"]  # type: ignore[arg-type]
    assert story(("simulator", measured)) == ["measured (the other)"]  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("name", "known", "muted"),
    [
        ("ros", {}, {"r", "s"}),
        ("ros", {"response": "tell"}, {"s"}),
        ("ros", {"over": True}, {"s"}),
        ("simulator", {}, {"s"}),  # it follows, so its report counts for nobody
    ],
)
def test_a_robot_that_stands_because_of_a_fault_is_known_as_muted_and_can_be_unmuted(
    name: Output, known: Any, muted: set[str]
) -> None:
    story = Story.playing()
    story({"type": "silence", "muted": ["s"], "soloed": ["t"]})
    fault: Any = {"type": "fault", "robot": "r", "response": "stand", "over": False, "message": "gone", **known}
    assert story((name, fault)) == (["simulator: fault", "gone"] if name == "ros" else ["gone (the other)"])
    assert story.state.silenced == (frozenset(muted), frozenset("t"))
    story({"type": "silence", "muted": [], "soloed": []})
    assert story.state.silenced == (frozenset(), frozenset())


def test_a_stage_that_starts_in_place_of_a_dead_one_has_a_robot_with_a_fault_stand() -> None:
    story = Story.playing()
    fault: Any = {"type": "fault", "robot": "r", "response": "stand", "over": False, "message": "gone"}
    story(("ros", fault))
    story(("ros", GONE))
    story(("ros", READY["ros"]))
    assert {"type": "silence", "muted": ["r"], "soloed": []} in story.sent("ros")


@pytest.mark.parametrize(
    ("name", "generation", "follows"),
    [("ros", 1, []), ("ros", 2, ["ros: score 2 whole"]), ("simulator", 2, ["simulator: score 2 whole from beat 6"])],
)
def test_a_stage_that_lacks_something_is_sent_the_whole_score(
    name: Output, generation: int, follows: list[str]
) -> None:
    story = Story.playing()
    story(play(when="beat"))
    story(("ros", at("playing", 2, 6.0)))
    assert story((name, {"type": "lacks", "generation": generation})) == follows
    assert story.state.entered, "the leading stage plays on"


def test_robots_of_all_scores_that_may_play_are_stopped_on_all_their_topics() -> None:
    """A saved score may wait for the end of the current one, without its robots or on other topics."""
    (robot,) = DANCE.parts.values()
    moved, added = replace(robot, topic="/elsewhere"), replace(robot, robot="s", topic="/s/cmd_vel", reset="/reset")
    story = Story.playing()
    story(play(replace(DANCE, parts={"r": moved, "s": added}), when="end"))
    story(("ros", GONE))
    story(ROS)
    parts = story.score.play.score.parts
    assert {part.topic for part in parts.values()} == {robot.topic, "/elsewhere", "/s/cmd_vel"}
    assert not any(part.scenes or part.reset for part in parts.values())
    assert [part.robot for part in parts.values()] == [*parts]


def test_robots_of_a_score_that_no_longer_plays_are_not_stopped() -> None:
    story = Story.playing()
    story(play(GHOST, when="bar"))
    story(("ros", at("playing", 2, 4.0)))
    story(("ros", GONE))
    story(ROS)
    assert story.score.play.score.parts.keys() == {"ghost"}


def test_only_the_robots_of_an_idle_stage_are_stopped_when_it_dies() -> None:
    story = Story.playing()
    story(play(GHOST, simulated=True))
    story(("ros", GONE))
    story(ROS)
    assert story.score.play.score.parts.keys() == {"r"}
    assert story.state.is_on, "the simulator plays on"


ON: Pressed = {"type": "pressed", "topics": ["/e_stop"], "count": 1}


def test_a_new_stage_of_real_robots_gets_the_emergency_stops_that_are_on() -> None:
    story = Story.playing()
    story.pressed = ON
    story(("ros", GONE))
    assert story(ROS) == ["ros: pressed", "ros: score 1 stop"]
    assert not story.score.asked, "robots are stopped in any case"
    story(("simulator", GONE))
    assert story(SIMULATOR) == []


@pytest.mark.parametrize("name", ["ros", "simulator"])
def test_a_new_stage_gets_the_kept_messages(name: Output) -> None:
    story = Story.playing()
    kept: list[Any] = [
        {"type": "silence", "muted": ["r"], "soloed": []},
        {"type": "speed", "factor": 2.0},
        {"type": "program", "name": "dance.improv", "folder": "/", "problems": [], "count": 0},
        {"type": "source", "path": "/dance.improv", "text": "", "revision": "1"},
    ]
    answer: Any = {"type": "answer", "page": 1, "answer": {}}
    for each in (*kept, {"type": "cue"}, {"type": "seek", "beat": 1.0}, answer):
        story(each)
    story((name, GONE))
    story((name, READY[name]))
    assert story.sent(name) == kept


def test_a_page_without_a_simulator_is_sent_what_the_leading_stage_plays_and_reports() -> None:
    fault: Any = {"type": "fault", "robot": "r", "response": "stand", "over": False, "message": "gone"}
    story = Story("ros", "page")
    tell(story, [
        (play(), ["ros: score 1", "page: score 1"]),
        (("ros", at("waiting", 1)), ["page: transport", "transport"]),
        (("ros", ARMED), ["page: armed", "armed"]),
        (("ros", at("playing", 1)), ["page: transport", "transport"]),
        (("ros", SENSED), ["page: sensed", "sensed"]),
        (("ros", fault), ["page: fault", "gone"]),
        (("page", {"type": "request", "command": {"type": "resume"}}), ["ros: resume"]),
        (("page", {"type": "lacks", "generation": 1}), ["page: score 1 whole"]),
        (("page", GONE), ["start page", "it exited: a new one will show what plays next (the other)"]),
        (("page", READY["page"]), ["page: silence"]),
        (("ros", GONE), ["page: armed", "start ros", STOPPING]),
        (ROS, ["ros: silence", "ros: score 1 stop"]),
    ])  # fmt: skip
    assert story.state.status == "ROS 2"
