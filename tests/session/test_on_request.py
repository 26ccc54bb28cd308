"""The acts that follow from people's requests, as tables: request → acts."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import pytest

from improv_core.ipc.stage_process import StageError
from improv_core.program.analysis import analyze
from improv_core.program.compiler import score_of
from improv_core.protocol.commands import Editing
from improv_core.protocol.messages import ProgramMessage, State
from improv_core.score.score import Safety
from improv_core.session.acts import Announce, Now
from improv_core.session.on_request import ProblemFields, on_request, program_message
from improv_core.session.state import Output
from tests.session.story import DANCE, NOW, READY, Story, at, play, tell

GUARDED = replace(DANCE, safety=Safety(stop="/e_stop"))
REFUSED = "✗ the emergency stop on /e_stop is on: release it, then save again"
STILL_ON = (
    "✗ the emergency stop on /e_stop is still on, although improv.toml no longer names it: release it "
    "(`ros2 topic pub --once /e_stop std_msgs/msg/Bool '{data: false}'`) or restart Improv, then save again"
)
FORM: Any = {"type": "arrange", "shape": "line", "distance": 1.0, "facing": "in"}
PLACE: Any = {"type": "place", "start_poses": {}}


def changing(change: Any) -> Any:
    return {"type": "editing", "page": 1, "ask": {"type": "change", "number": 0, "change": change}}


@pytest.mark.parametrize("asker", ["ros", "simulator"])
@pytest.mark.parametrize(
    ("request_", "follows"),
    [
        ({"type": "seek", "beat": 2.0}, ["ros: seek", "simulator: seek"]),
        ({"type": "speed", "factor": 0.5}, ["ros: speed", "simulator: speed"]),
        ({"type": "silence", "muted": ["r"], "soloed": []}, ["ros: silence", "simulator: silence"]),
        ({"type": "resume"}, ["ros: resume", "simulator: resume"]),
        ({"type": "cue"}, ["ros: cue"]),  # the twin gets what robots sensed
        ({"type": "restart"}, ["ros: score 2"]),
        ({"type": "stop"}, []),  # stages have obeyed it as it arrived
        ({"type": "pause"}, []),
        (changing(PLACE), ["editing"]),
        (changing(FORM), ["editing"]),
        ({"type": "page_opened"}, ["page_opened"]),
    ],
)
def test_a_page_request_reaches_all_stages_for_the_same_time(asker: Output, request_: Any, follows: Any) -> None:
    story = Story.playing()
    assert story((asker, {"type": "request", "command": request_})) == follows
    for message in (*story.sent("ros"), *story.sent("simulator")):
        assert message == {**request_, "at": NOW}


def test_playing_again_is_not_armed() -> None:
    story = Story()
    story(play(arming={}))
    story({"type": "restart"})
    assert story.score.play.arming is None


def test_messages_that_move_robots_carry_the_count_of_stops_at_the_request() -> None:
    story = Story.playing()
    story({"type": "resume"}, stops=3)
    assert [act.unless for act in story.acts] == [3, 3]  # type: ignore[union-attr]
    story({"type": "restart"}, stops=4)
    assert (story.score.asked, story.score.play.stops, story.score.play.when) == (True, 4, "restart")
    write: Editing = {"type": "editing", "page": 1, "ask": {"type": "write", "number": 1, "text": "", "revision": ""}}
    story(write, stops=5)
    assert story.acts == [Announce(write, stops=5)]


def test_a_score_counts_as_played_once_it_has_been_sent() -> None:
    """A stop on another thread may keep it back."""
    state = Story().state
    then, _ = on_request(state, play(), Now())
    assert (then.generation, then.is_on, then.played) == (0, False, None)
    story = Story()
    story(play())
    assert (story.state.generation, story.state.is_on, story.state.played) == (1, True, story.score.play)


def test_before_anything_has_been_played_there_is_nothing_to_seek_or_restart() -> None:
    tell(Story(), [
        ({"type": "seek", "beat": 2.0}, ["nothing has been played yet: save a program before you seek"]),
        ({"type": "restart"}, []),
        ({"type": "cue"}, ["ros: cue"]),
    ])  # fmt: skip


def test_a_restart_plays_the_same_score_with_the_same_senses() -> None:
    story = Story()
    story(play(senses=[], when="bar", beats_per_bar=3))
    first = story.score.play
    story({"type": "restart"})
    again = story.score.play
    assert again == replace(first, generation=2, when="restart", beats_per_bar=4)


def test_the_state_knows_muted_and_soloed_robots() -> None:
    story = Story()
    assert story.state.silenced == (frozenset(), frozenset())
    story({"type": "silence", "muted": ["r"], "soloed": ["s", "t"]})
    assert story.state.silenced == ({"r"}, {"s", "t"})  # type: ignore[comparison-overlap]


def test_the_simulator_leads_for_a_score_that_is_only_simulated() -> None:
    story = Story.playing()
    tell(story, [
        (play(simulated=True), ["ros: stop", "simulator: score 2"]),  # real robots stop until the next score
        (("simulator", at("playing", 2, 1.0)), ["transport"]),
        (("ros", at("stopped", 1)), ["transport (the other)"]),
    ])  # fmt: skip
    assert (story.state.is_on, story.state.status, story.state.is_real) == (True, "simulator", False)
    tell(story, [
        ({"type": "speed", "factor": 2.0}, ["simulator: speed", "ros: speed"]),  # for its next score
        ({"type": "seek", "beat": 2.0}, ["simulator: seek"]),
        ({"type": "resume"}, ["simulator: resume"]),  # only the stage that paused resumes
        ({"type": "restart"}, ["simulator: score 3"]),
        (play(simulated=True), ["simulator: score 4"]),
        (play(), ["simulator: stop", "ros: score 5"]),
        (("ros", at("playing", 5)), ["simulator: score 5 from beat 0", "transport"]),
    ])  # fmt: skip


def joining(before: str, line: str, *, stopped: int = 0, state: State = "playing", **how: Any) -> Mapping[str, str]:
    """Return the lengths of each robot's scenes once a program has joined another one that plays."""
    story = Story()
    story(play(score_of(analyze(before))))
    story((story.state.leader or "ros", at(state, 1)))
    story(play(score_of(analyze(line)), joins=True, **how), stopped=stopped)
    return {
        name: " ".join(f"{each.duration}" for each in part.scenes)
        for name, part in story.score.play.score.parts.items()
    }


def test_a_line_replaces_the_parts_of_its_robots_and_all_others_keep_dancing() -> None:
    both = "r $ repeat up\ns $ up\n"
    assert joining(both, "s $ left left") == {"r": "inf", "s": "2"}
    assert joining(both, "s $ left left", state="paused") == {"r": "inf", "s": "2"}
    assert joining(both, "t $ left") == {"r": "inf", "s": "1", "t": "1"}
    assert joining("r $ up\n---\nr s $ up up\n", "---\nr $ left") == {"r": "1 1", "s": "0 2"}


def test_after_a_stop_a_line_starts_no_other_robot() -> None:
    assert joining("r $ repeat up", "s $ left", stopped=1) == {"s": "1"}
    for state in ("stopped", "ended"):
        assert joining("r $ repeat up", "s $ left", state=state) == {"s": "1"}
    resumed = Story.playing()
    resumed({"type": "resume"}, stops=1, stopped=1)
    resumed(play(score_of(analyze("s $ left")), joins=True), stopped=1)
    assert [*resumed.score.play.score.parts] == ["r", "s"]


def test_ghosts_and_real_robots_never_dance_together_and_all_have_one_tempo() -> None:
    with pytest.raises(StageError, match="a ghost can't join real robots: play only that"):
        joining("r $ repeat up", "ghost $ left", simulated=True)
    story = Story.playing()
    story(play(simulated=True))
    story(("simulator", at("playing", 2)))
    story(play(score_of(analyze("s $ left")), joins=True))
    assert [*story.score.play.score.parts] == ["s"]
    with pytest.raises(StageError, match="what dances plays at beat 60: play the whole program"):
        joining("r $ repeat up", "beat 90\ns $ left")


def test_pages_get_the_name_and_the_errors_of_a_program_only_when_they_change() -> None:
    def program(*problems: ProblemFields) -> ProgramMessage:
        return program_message("d", "/", problems)

    problem = ("d", 1, 1, "x", "wrong")
    tell(Story(), [
        (program(), ["ros: program", "simulator: program"]),
        (program(), []),
        (program(problem), ["ros: program", "simulator: program"]),
        (program(), ["ros: program", "simulator: program"]),
    ])  # fmt: skip


def test_pages_get_the_program_while_the_stage_of_real_robots_starts() -> None:
    story = Story()
    story.state = story.state.closed()
    story(("simulator", READY["simulator"]))
    assert story({"type": "program", "name": "d", "folder": "/", "problems": [], "count": 0}) == ["simulator: program"]
    assert story({"type": "speed", "factor": 2.0}) == ["simulator: speed"]
    assert (story.state.is_open, story.state.status) == (False, "nothing")


def test_kept_changes_have_no_time() -> None:
    story = Story.playing()
    story({"type": "speed", "factor": 2.0, "at": 3.0})
    assert [*story.state.kept.values()] == [{"type": "speed", "factor": 2.0}]
    assert story.sent("ros") == [{"type": "speed", "factor": 2.0, "at": NOW}]


def test_without_a_simulator_nothing_is_simulated() -> None:
    story = Story("ros")
    with pytest.raises(StageError, match="no robot is named, and there is no simulator"):
        story(play(simulated=True))
    assert Story("simulator")(play(simulated=True)) == ["simulator: score 1"]


def test_real_robots_play_nothing_while_an_emergency_stop_is_on() -> None:
    story = Story.playing()
    story.pressed = {"type": "pressed", "topics": ["/e_stop"], "count": 1}
    tell(story, [
        (play(GUARDED), ["ros: pressed", REFUSED]),  # so that it receives the release
        (play(), ["ros: pressed", STILL_ON]),  # also if `stop` has been removed from improv.toml
        (play(simulated=True), ["ros: stop", "simulator: score 2"]),
        (play(GUARDED), ["ros: pressed", REFUSED]),
    ])  # fmt: skip
    assert story.state.leader == "simulator"
    story.pressed = {"type": "pressed", "topics": [], "count": 1}
    assert story(play(GUARDED)) == ["simulator: stop", "ros: score 3"]


def test_the_simulator_needs_no_emergency_stop() -> None:
    story = Story("simulator")
    story.pressed = {"type": "pressed", "topics": ["/e_stop"], "count": 1}
    assert story(play(GUARDED)) == ["simulator: score 1"]


def test_pages_get_the_source_and_ros_does_not() -> None:
    tell(Story(), [
        ({"type": "source", "path": "/d", "text": "", "revision": "1", "toml": ""}, ["simulator: source"]),
        ({"type": "answer", "page": 1, "answer": {"type": "write", "number": 1, "revision": "", "problem": ""}},
         ["simulator: answer"]),
        ({"type": "program", "name": "d", "folder": "/", "problems": [], "count": 0},
         ["ros: program", "simulator: program"]),
    ])  # fmt: skip


def test_peoples_settings_outlast_the_stages() -> None:
    story = Story.playing()
    story({"type": "speed", "factor": 2.0})
    state = story.state.closed()
    assert (state.is_open, state.is_on, state.status, state.page) == (False, False, "nothing", None)
    assert ({*state.kept}, state.generation, state.played) == ({"speed"}, 1, story.state.played)
    assert state.editions == story.state.editions
    story.state = state
    assert story(("simulator", READY["simulator"])) == ["simulator: speed"]
