"""The player's decisions, as tables: a run, an event, the facts → the next run, and the acts."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from fractions import Fraction
from itertools import product
from typing import Any, get_args

import pytest

from improv_core.player import events
from improv_core.player.acts import (
    Act,
    Begin,
    CheckLater,
    CheckNow,
    CheckSoon,
    CreatePublishers,
    Dismiss,
    DriveBack,
    Drop,
    ForgetEdges,
    Listen,
    Place,
    Prepare,
    PrepareRestart,
    Report,
    ReportSenses,
    Resend,
    Rest,
    SendUntil,
    StartMeasuring,
    Still,
    Tell,
    TellFaults,
    Then,
    Zero,
)
from improv_core.player.agenda import NEVER, Due, Rank, next_decision, next_edges, performed
from improv_core.player.decide import _RULES, SEEN, decide, trouble
from improv_core.player.events import Event, Facts, Internal
from improv_core.player.run import Mode, Run, Silenced
from improv_core.player.start_gate import Gate, is_ready, message
from improv_core.player.start_rules import WAITS, robots_to_home
from improv_core.protocol.messages import When
from improv_core.protocol.play_again import NOT_READY
from improv_core.protocol.robot_messages import FaultMessage, RobotInstant
from improv_core.safety.fault_monitor import RobotNews
from improv_core.safety.fault_rules import FaultBegan, FaultOver, Worst
from improv_core.safety.interlocks import GAMEPAD, OLDER, EmergencyStops
from improv_core.safety.preflight import Standing
from improv_core.safety.separation import Near
from improv_core.score.faults import FaultRules, Response
from improv_core.score.motion import STILL, Pose
from improv_core.score.movement import Duration
from improv_core.score.peer_clock import Anchor
from improv_core.score.score import Deadman, Safety, Score
from improv_core.score.takeover import PendingTakeover, Takeover
from improv_core.score.transport import Switch, Transport
from improv_core.score.world import World
from tests.player.plays import to_play
from tests.player.test_player import score

ZERO = 1000.0
"""Beat 0 on the clock. A beat takes a second, so beat 3 is at 1003."""
STOP, DEADMAN = "/e_stop", Deadman("/joy", 4)
BUTTON = str(DEADMAN)
DANCE = score("beat 60\na b $ repeat 8 forward")
OTHER = score("beat 60\na b $ repeat 8 left")
SCENES = score("beat 60\na $ forward forward\n---\na $ left left")
GUARDED = replace(DANCE, safety=Safety(stop=STOP, deadman=DEADMAN))
TOGETHER = replace(DANCE, safety=Safety(rejoin="pause"))
NOTHING = Score(Fraction(60), {name: replace(part, scenes=()) for name, part in DANCE.parts.items()})
PRESSED = EmergencyStops(frozenset({STOP}), 1)
MODES: Sequence[Mode] = get_args(Mode)


def run(mode: Mode, beat: float = 0, dance: Score = DANCE, **different: object) -> Run:
    """A run that has reached a beat, which was 3 s after beat 0 if it is at rest."""
    transport = Transport(ZERO, 0.0, 0 if mode == "playing" else Fraction(beat), dance.tempo)
    made = Run(mode, dance, dance, generation=1, restarted=1, transport=transport)
    return replace(made, **different)  # type: ignore[arg-type]


def at(beat: float, over: Duration = 8, **known: object) -> Facts:
    """Facts at this many seconds after beat 0."""
    return Facts(ZERO + beat, over=over, **known)  # type: ignore[arg-type]


def real(beat: float, **known: object) -> Facts:
    return replace(at(beat, **known), real=True)  # type: ignore[arg-type]


def resumed(beat: float, second: float) -> Transport:
    """A transport that plays from a beat on since this many seconds after beat 0."""
    return Transport(ZERO, second, Fraction(beat), Fraction(60))


def begins(dance: Score, beat: float, second: float) -> list[Act]:
    beat = int(beat) if beat == int(beat) else beat
    return [Begin(dance.parts, beat, second), Report(ZERO + second), ReportSenses(beat, second)]  # type: ignore[arg-type]


def found(before: Run, event: Event, facts: Facts) -> tuple[Run, list[Act]]:
    """Decide what follows from an event, and from the next look at a beat 0 that waits for nothing anymore."""
    then, done = decide(before, event, facts)
    if not then.is_due:
        return then, done
    after, more = decide(then, events.Awaited(), facts)
    return after, [*done, *more]


def names(done: Sequence[Act]) -> list[str]:
    return [type(each).__name__ for each in done]


def name_of(event: Event) -> str:
    return event["type"] if isinstance(event, dict) else type(event).__name__


def lines(done: Sequence[Act]) -> list[str]:
    told = [each.message for each in done if isinstance(each, Tell)]
    return [each["message"] for each in told if each["type"] == "warning" or each["type"] == "error"]


# Stop, pause, resume


@pytest.mark.parametrize("mode", MODES)
def test_a_stop_stops_everything(mode: Mode) -> None:
    swap = PendingTakeover(OTHER, 2, "beat", 4, 4.0, None)
    then, done = decide(run(mode, 3, next=swap), {"type": "stop"}, real(3))
    assert (then.mode, then.next, then.transport.origin) == ("stopped", None, 3)
    assert done == [Zero(), Report()]


def test_a_stop_lets_a_stage_that_only_has_to_stop_robots_keep_waiting() -> None:
    before = run("waiting", dance=NOTHING)
    assert decide(before, {"type": "stop"}, real(3)) == (before, [])


@pytest.mark.parametrize("mode", MODES)
def test_a_pause_stops_what_plays_and_keeps_the_save_that_waits(mode: Mode) -> None:
    swap = PendingTakeover(OTHER, 2, "beat", 4, 4.0, None)
    then, done = decide(run(mode, 3, next=swap, continues=True), {"type": "pause"}, at(3))
    plays = mode == "playing"
    assert (then.mode, then.next, then.continues) == ("paused" if plays else mode, swap, False)
    assert done == ([Zero(), Report()] if plays else [])


@pytest.mark.parametrize("mode", MODES)
def test_only_a_pause_can_be_resumed(mode: Mode) -> None:
    before = run(mode, 3)
    then, done = decide(before, {"type": "resume"}, at(10))
    if mode == "paused":
        assert then == replace(before, mode="playing", transport=resumed(3, 10))
        assert done == begins(DANCE, 3, 10)
    else:
        assert (then, done) == (before, [])


def test_a_save_that_waits_for_a_beat_waits_for_that_beat_after_a_pause_too() -> None:
    swap = PendingTakeover(OTHER, 2, "beat", 4, 4.0, None)
    then, _ = decide(run("paused", 3.25, next=swap), {"type": "resume"}, at(10))
    assert then.next == replace(swap, at=10.75)


@pytest.mark.parametrize(
    ("before", "moves"),
    [
        *((run(mode, 3), mode in ("waiting", "playing")) for mode in MODES),
        (run("paused", 3, continues=True), True),
        (run("stopped", 3, continues=True), False),
        (run("paused", 3, next=PendingTakeover(OTHER, 2, "now", 4, 3.0, None)), False),
        (run("ended", 8, next=PendingTakeover(OTHER, 2, "now", 4, 9.0, None)), True),
    ],
)
def test_robots_may_move_unless_a_person_has_to_play_first(before: Run, moves: bool) -> None:
    assert before.may_move == moves


# Conditions of real robots

HOLD = f"paused: to let robots move, hold {BUTTON}"
ON = "✗ the emergency stop on /e_stop is on: release it, then save again"


@pytest.mark.parametrize(
    ("before", "facts", "then", "done", "said"),
    [
        (run("playing", dance=GUARDED), real(3, held={BUTTON}), "playing", [], []),
        (run("playing", dance=GUARDED), real(3, held={GAMEPAD}), "playing", [], []),
        (run("playing", dance=GUARDED), at(3), "playing", [], []),  # the simulator needs no button
        (run("playing", dance=GUARDED), real(3), "paused", ["Zero", "Report", "CheckLater", "Tell"], [HOLD]),
        (run("paused", 3, GUARDED, continues=True), real(9), "paused", [], []),
        (
            run("paused", 3, GUARDED, continues=True),
            real(9, held={BUTTON}),
            "playing",
            ["Begin", "Report", "ReportSenses"],
            [],
        ),
        (run("paused", 3, GUARDED), real(9, held={BUTTON}), "paused", [], []),  # somebody has paused
        (
            run("playing", dance=TOGETHER),
            real(3, away={"b"}),
            "paused",
            ["Zero", "Report", "CheckLater", "Tell"],
            ["paused until b listens again"],
        ),
        (run("playing"), real(3, away={"b"}), "playing", [], []),
        (run("playing", dance=GUARDED, stops=PRESSED), real(3), "stopped", ["Zero", "Report", "Tell"], [ON]),
    ],
)
def test_robots_pause_and_continue_as_their_conditions_change(
    before: Run, facts: Facts, then: Mode, done: Sequence[str], said: Sequence[str]
) -> None:
    after, what = decide(before, events.Changed(), facts)
    assert (after.mode, names(what), lines(what)) == (then, done, said)
    if then == "paused" and before.mode == "playing":
        assert after.continues
        assert after.transport.origin == 3


def test_resuming_without_the_deadman_button_waits_for_it() -> None:
    then, done = decide(run("paused", 3, GUARDED), {"type": "resume"}, real(9))
    assert (then.mode, then.continues, then.transport.origin) == ("paused", True, 3)
    assert done == [Zero(), Report(), CheckLater(), Tell({"type": "warning", "message": HOLD})]


@pytest.mark.parametrize(
    ("before", "pressed", "then", "stops", "done"),
    [
        (run("playing"), True, "stopped", PRESSED, ["Tell", "Zero", "Report", "Tell"]),
        (run("waiting"), True, "stopped", PRESSED, ["Tell", "Zero", "Report", "Tell"]),
        (run("stopped", stops=PRESSED), True, "stopped", PRESSED, []),
        (run("stopped", stops=PRESSED), False, "stopped", EmergencyStops(frozenset(), 1), ["Tell", "Report", "Tell"]),
        (run("playing"), False, "playing", EmergencyStops(), []),
    ],
)
def test_an_emergency_stop(before: Run, pressed: bool, then: Mode, stops: EmergencyStops, done: Sequence[str]) -> None:
    after, what = decide(before, events.EmergencyStop(STOP, pressed), real(3))
    assert (after.mode, after.stops, names(what)) == (then, stops, done)


@pytest.mark.parametrize(
    ("mode", "is_real", "late", "overloaded", "reason"),
    [
        ("playing", True, 0.5, False, None),
        ("playing", True, 0.6, False, events.Stalled(0.6)),
        ("playing", True, 0.0, True, events.Overloaded()),
        ("playing", False, 60.0, True, None),  # the simulator catches up
        ("stopped", True, 60.0, True, None),
        ("paused", True, 60.0, True, None),
    ],
)
def test_real_robots_stop_if_late_or_overloaded(
    mode: Mode, is_real: bool, late: float, overloaded: bool, reason: Event | None
) -> None:
    assert trouble(run(mode, 3), is_real, late, overloaded) == reason


def test_robots_stop_before_people_read_why() -> None:
    late, slow = (decide(run("playing"), event, real(3))[1] for event in (events.Stalled(1.23), events.Overloaded()))
    assert names(late) == names(slow) == ["Zero", "Report", "Tell"]
    assert lines(late) == ["the stage stalled for 1.2 s, so all robots were stopped: play again"]
    assert lines(slow) == ["this machine is too slow for 2 robots, so all were stopped: play fewer robots"]


@pytest.mark.parametrize("mode", MODES)
def test_real_robots_too_near_to_each_other_pause_until_somebody_resumes(mode: Mode) -> None:
    guarded = replace(DANCE, world=World(keep_apart=0.3))
    then, done = decide(run(mode, 3, dance=guarded), events.TooNear([Near(("a", "b"), 0.2)]), real(3))
    if mode != "playing":
        assert (then.mode, done) == (mode, [])
        return
    assert (then.mode, then.continues, then.too_near) == ("paused", False, ("a", "b"))
    assert names(done) == ["Zero", "Report", "Tell"]
    assert decide(then, events.Changed(), real(9))[0].mode == "paused"
    resumed_run, done = decide(then, {"type": "resume"}, real(9))
    assert (resumed_run.mode, resumed_run.too_near, names(done)) == ("playing", (), ["Begin", "Report", "ReportSenses"])


def test_robots_stand_while_one_that_must_be_seen_is_not() -> None:
    then, done = decide(run("playing"), events.Changed(), real(3, unseen=["b", "a"]))
    assert (then.mode, then.continues, names(done)) == ("paused", True, ["Zero", "Report", "CheckLater", "Tell"])
    assert lines(done) == ["paused: a pose of a didn't come for 0.2 s"]
    assert decide(then, {"type": "resume"}, real(4, unseen=["a"]))[0].mode == "paused"
    assert decide(then, events.Changed(), real(4))[0].mode == "playing"


# Saves


@pytest.mark.parametrize(
    ("dance", "stops", "knows", "facts", "line"),
    [
        (OTHER, PRESSED, 1, real(3), "✗ the emergency stop on /e_stop is still on"),
        (OTHER, EmergencyStops(frozenset(), 2), 1, real(3), OLDER),
        (OTHER, EmergencyStops(frozenset(), 2), 2, real(3), None),
        (OTHER, PRESSED, 1, at(3), None),
        (NOTHING, PRESSED, 1, real(3), None),  # it only stops robots
    ],
)
def test_a_save_is_refused_after_an_emergency_stop(
    dance: Score, stops: EmergencyStops, knows: int, facts: Facts, line: str | None
) -> None:
    before, load = run("stopped", stops=stops), to_play(dance, 2, "restart", stops=knows)
    then, done = decide(before, load, facts)
    assert then == before
    if line:
        assert names(done) == ["Tell", "Report"]
        assert lines(done)[0].startswith(line)
    else:
        assert done == [PrepareRestart(load), Then(events.Restarted(load))]


@pytest.mark.parametrize(
    ("mode", "when", "done"),
    [
        *((mode, "restart", ["PrepareRestart", "Then"]) for mode in MODES),
        *((mode, "beat", ["PrepareRestart", "Then"]) for mode in ("stopped", "waiting", "ended")),
        ("playing", "beat", ["CreatePublishers"]),
        ("paused", "beat", ["Drop", "SendUntil", "Prepare", "Then"]),
    ],
)
def test_a_save_takes_over_from_what_plays_or_restarts(mode: Mode, when: When, done: Sequence[str]) -> None:
    before = run(mode, 3)
    then, what = decide(before, to_play(OTHER, 2, when), at(3))
    assert names(what) == done
    assert then.score == before.score  # until the other score has been prepared, which may fail
    assert then.generation == 1


@pytest.mark.parametrize(("when", "second"), [("now", 2.5), ("beat", 3), ("bar", 4), ("end", 8)])
def test_a_save_takes_over_at_its_time(when: Switch, second: float) -> None:
    then, done = decide(run("playing"), to_play(OTHER, 2, when), at(2.5))
    assert then.next == PendingTakeover(OTHER, 2, when, 4, second, None)
    assert done == [CreatePublishers(OTHER)]


def test_another_stage_sets_the_time() -> None:
    entry: Takeover = {"beat": 5.0, "monotonic": ZERO + 5.25}
    then, _ = decide(run("playing"), to_play(OTHER, 2, "now", entry=entry), at(3))
    assert then.next == PendingTakeover(OTHER, 2, "now", 4, 5.25, entry)


def test_a_takeover_is_prepared_before_the_run_says_so() -> None:
    swap = PendingTakeover(OTHER, 2, "beat", 4, 3.0, None)
    before = run("playing", next=swap)
    then, done = decide(before, Due(3.0, Rank.TAKEOVER), at(3))
    assert then == replace(before, next=None)
    drop, send, prepare, last = done
    assert (drop, send) == (Drop({"a", "b"}), SendUntil(3.0))
    assert isinstance(prepare, Prepare)
    assert isinstance(last, Then)
    after, what = decide(then, last.event, at(3))
    assert (after.mode, after.generation, after.score.begins("a", 0)) == ("playing", 2, 3)
    assert names(what) == ["Dismiss", "Begin", "Report", "ReportSenses", "CheckSoon"]


def test_a_save_takes_over_from_a_score_without_robots() -> None:
    _, done = decide(run("paused", dance=Score(Fraction(60), {})), to_play(SCENES, 2, "beat"), at(3, over=0))
    assert names(done) == ["Drop", "SendUntil", "Prepare", "Then"]


def test_a_robot_whose_part_is_the_same_is_left_alone() -> None:
    numbered = {name: replace(part, editions=(7,)) for name, part in DANCE.parts.items()}
    dance = replace(DANCE, parts=numbered)
    edit = replace(dance, parts={**numbered, "b": replace(OTHER.parts["b"], editions=(8,))})
    before = run("playing", dance=dance, next=PendingTakeover(edit, 2, "beat", 4, 3.0, None))
    then, done = decide(before, Due(3.0, Rank.TAKEOVER), at(3))
    assert done[0] == Drop({"b"})
    last = done[-1]
    assert isinstance(last, Then)
    _, what = decide(then, last.event, at(3))
    assert what[:2] == [Dismiss({"b"}), Begin({"b"}, 3, 3.0)]


def test_a_score_that_needs_a_deadman_button_waits_for_it_as_it_takes_over() -> None:
    guarded = replace(OTHER, safety=Safety(deadman=DEADMAN))
    before = run("playing", next=PendingTakeover(guarded, 2, "beat", 4, 3.0, None))
    then, done = decide(before, Due(3.0, Rank.TAKEOVER), real(3))
    last = done[-1]
    assert isinstance(last, Then)
    after, what = decide(then, last.event, real(3))
    assert (after.mode, after.continues, after.generation) == ("paused", True, 2)
    assert names(what) == ["Dismiss", "Zero", "Report", "CheckLater", "Tell", "CheckSoon"]


def test_a_save_needs_nobody_in_a_place_while_robots_move() -> None:
    facts = real(3, places={"a": Standing(Pose(), Pose(1.0))})
    faster = replace(OTHER, tempo=Fraction(120))
    then, done = decide(
        run("playing", next=PendingTakeover(faster, 2, "beat", 4, 3.0, None)), Due(3.0, Rank.TAKEOVER), facts
    )
    last = done[-1]
    assert isinstance(last, Then)
    assert decide(then, last.event, facts)[0].mode == "playing"


# From the beginning to the end


def test_beat_0_comes_after_robots_are_checked() -> None:
    before, _ = decide(run("playing", 3), events.Restarted(to_play(OTHER)), at(3))
    then, done = decide(before, events.Listened((), False, ["a"]), at(3))
    assert (then.mode, then.is_due, done) == ("waiting", True, [])


def test_beat_0_waits_for_listeners() -> None:
    load = to_play(OTHER, 2, "restart")
    then, done = decide(run("playing", 3), events.Restarted(load), at(3))
    assert (then.mode, then.generation, then.restarted, then.score) == ("waiting", 2, 2, OTHER)
    assert done == [Listen(["a", "b"])]
    assert decide(then, events.Listened((), True, ["a", "b"]), at(3)) == (then, [Still(["a", "b"]), Report()])
    assert decide(then, events.Awaited(), at(4)) == (then, [Listen()])
    assert decide(then, events.Listened((), True, None), at(4)) == (then, [])
    due, what = decide(then, events.Listened((), False, None), at(5))
    assert (due.mode, due.is_due, what) == ("waiting", True, []), "that look may have taken long"
    after, what = decide(due, events.Awaited(), at(5.2))
    assert (after.mode, after.is_due, after.transport.zero) == ("playing", False, ZERO + 5.2)
    begun = Begin(OTHER.parts, 0, 0.0)
    assert what == [StartMeasuring(), begun, Report(ZERO + 5.2), ReportSenses(0, 0.0), CheckSoon(OTHER.parts)]


@pytest.mark.parametrize(("robots", "facts", "later"), [(10, real(5), 0), (110, real(5), 0.002), (110, at(5), 0)])
def test_beat_0_of_many_real_robots_comes_when_their_commands_are_ready(
    robots: int, facts: Facts, later: float
) -> None:
    dance = score("beat 60\n" + " ".join(f"r{number}" for number in range(robots)) + " $ forward\n")
    after, _ = decide(run("waiting", dance=dance, is_due=True), events.Awaited(), facts)
    assert after.transport.zero == pytest.approx(ZERO + 5 + later, abs=1e-9)


@pytest.mark.parametrize(
    ("event", "mode"), [({"type": "stop"}, "stopped"), (events.EmergencyStop(STOP, True), "stopped")]
)
def test_a_stop_just_before_beat_0_is_obeyed(event: Event, mode: Mode) -> None:
    then, done = decide(run("waiting", is_due=True), event, real(5))
    assert (then.mode, then.is_due, Zero() in done) == (mode, False, True)


def test_a_restart_just_before_beat_0_looks_for_its_own_robots() -> None:
    then, _ = decide(run("waiting", is_due=True), events.Restarted(to_play(OTHER, 2, "restart")), at(5))
    assert (then.mode, then.is_due) == ("waiting", False)


@pytest.mark.parametrize(
    ("heard", "without", "begins", "says"),
    [
        (events.Listened((), False, None, ["b"], True), True, True, False),
        (events.Listened((), True, None, ["b"]), False, False, False),
        (events.Listened((), False, None, ["b"], True), False, False, True),
        (events.Listened((), False, None, ["b"]), False, False, False),
        (events.Listened(["b"], False, None), False, True, False),
    ],
)
def test_only_start_without_begins_without_all_listeners(
    heard: events.Listened, without: bool, begins: bool, says: bool
) -> None:
    dance = replace(OTHER, safety=Safety(start_without=without))
    after, done = found(run("waiting", dance=dance), heard, at(5))
    assert after.mode == ("playing" if begins else "waiting")
    named: list[Act] = [CheckSoon(["b"]), Tell({"type": "warning", "message": WAITS})]
    assert (done == named) == says, "it is said once"


def test_a_score_that_only_stops_robots_does_not_wait_for_those_that_do_not_listen() -> None:
    before = run("waiting", dance=replace(NOTHING, safety=Safety(start_without=False)))
    after, _ = found(before, events.Listened((), False, None, ["b"], True), at(5))
    assert after.mode == "playing"


def test_a_robot_that_only_has_to_stop_does_so_while_others_keep_waiting() -> None:
    before = run("waiting", dance=NOTHING)
    assert decide(before, events.Listened({"a"}, True, None), at(4)) == (before, [Still(["a"])])


def test_the_next_scene_begins_for_all() -> None:
    then, done = decide(run("playing", dance=SCENES), Due(2.0, Rank.SCENE), at(2, over=2))
    assert (then.scene, then.score, then.mode) == (1, SCENES, "playing")
    assert done == [Dismiss(), Begin(SCENES.parts, 2, 2.0)]  # its beat was known, so it is not reported


@pytest.mark.parametrize("is_real", [True, False])
def test_a_score_ends(is_real: bool) -> None:
    then, done = decide(run("playing"), Due(8.0, Rank.END), at(8.001, real=is_real))
    assert (then.mode, then.transport.origin, then.transport.since) == ("ended", 8, 8.0)
    assert done == [Rest(), *([] if is_real else [CheckNow(DANCE.parts)]), Report()]


def test_a_robot_that_drives_back_stands_at_the_end() -> None:
    before = run("playing", dance=replace(DANCE, safety=Safety(rejoin="return")))
    _, done = decide(before, Due(8.0, Rank.END), real(8, standing=frozenset({"a"})))
    assert done == [Rest(), DriveBack("a", STILL), Report()]


def test_a_save_that_waits_for_an_end_unknown_in_advance_takes_over_there() -> None:
    swap = PendingTakeover(OTHER, 2, "end", 4, math.inf, None)
    then, done = decide(run("playing", next=swap), Due(8.0, Rank.END), at(8))
    assert (then.mode, then.next) == ("playing", None)
    assert names(done) == ["Drop", "SendUntil", "Prepare", "Then"]
    assert done[1] == SendUntil(8.0)


# Seek, speed, silence


@pytest.mark.parametrize("asked", [-1.0, 0.0, 2.5, 1e12, math.inf])
@pytest.mark.parametrize("mode", ["stopped", "paused", "ended", "playing"])
def test_a_seek_plays_on_there_or_is_a_pause_there(mode: Mode, asked: float) -> None:
    then, done = decide(run(mode, 3), {"type": "seek", "beat": asked}, at(3))
    beat = min(max(asked, 0), 8)
    assert then.transport.origin == beat
    assert (then.mode, names(done[3:])) == (
        ("playing", ["Begin", "Report", "ReportSenses"]) if mode == "playing" else ("paused", ["Report"])
    )
    assert names(done[:2]) == ["Dismiss", "ForgetEdges"]
    assert Place(then.transport.origin) in done


def test_a_seek_goes_to_the_scene_of_its_beat() -> None:
    then, done = decide(run("playing", dance=SCENES), {"type": "seek", "beat": 3.0}, at(1, over=2))
    assert then.scene == 1
    assert done == [Dismiss(), ForgetEdges(), Place(3), *begins(SCENES, 3, 1)]


def test_a_seek_that_takes_too_long_to_compute_changes_nothing() -> None:
    before = run("playing", 3, dance=score("r $ repeat choose (forward left)\n"))
    then, done = decide(before, {"type": "seek", "beat": 1e15}, at(3))
    assert then is before
    assert names(done) == ["Tell"]


def test_there_is_no_beat_to_seek_before_anything_is_loaded() -> None:
    assert decide(Run(), {"type": "seek", "beat": 4.0}, at(3)) == (Run(), [])


def test_a_seek_before_beat_0_does_not_skip_the_first_scene() -> None:
    before = run("waiting", dance=SCENES)
    assert decide(before, {"type": "seek", "beat": 3.0}, at(3)) == (before, [])


SILENT, HEARD = RobotNews("a", FaultBegan("silent", Worst())), RobotNews("a", FaultOver("silent", Worst()))


def with_response(response: Response) -> Score:
    return replace(DANCE, safety=Safety(faults=FaultRules({"silent": response})))


@pytest.mark.parametrize(
    ("mode", "response", "then", "stood", "done"),
    [
        ("playing", "tell", "playing", [], [TellFaults([SILENT])]),
        ("playing", "stand", "playing", ["a"], [Resend(["a"]), Report(), TellFaults([SILENT])]),
        ("playing", "stop", "stopped", [], [Zero(), Report(), TellFaults([SILENT])]),
        ("paused", "stand", "paused", ["a"], [Report(), TellFaults([SILENT])]),
        ("paused", "stop", "stopped", [], [Zero(), Report(), TellFaults([SILENT])]),
    ],
)
def test_a_fault_gets_its_response(
    mode: Mode, response: Response, then: Mode, stood: list[str], done: list[Act]
) -> None:
    after, todo = decide(run(mode, 3, with_response(response)), events.Faults([SILENT]), real(3))
    assert (after.mode, [*after.stood], todo) == (then, stood, done)


def test_a_fault_that_is_over_moves_nobody() -> None:
    stands = run("playing", dance=with_response("stand"), stood={"a": ZERO})
    assert decide(stands, events.Faults([HEARD]), real(3)) == (stands, [TellFaults([HEARD])])


def test_one_fault_that_stops_all_stops_them_first() -> None:
    rules = FaultRules({"silent": "stand", "late": "stop"})
    before = run("playing", dance=replace(DANCE, safety=Safety(faults=rules)))
    both = [SILENT, RobotNews("b", FaultBegan("late", Worst()))]
    after, todo = decide(before, events.Faults(both), real(3))
    assert (after.mode, names(todo)[0]) == ("stopped", "Zero")


@pytest.mark.parametrize(
    ("muted", "soloed", "beat", "stands"),
    [
        ([], [], 3, False),  # somebody unmutes it
        (["a"], [], 3, True),
        (["a", "b"], [], 3, True),
        (["a"], ["a"], 3, True),  # a solo of a muted robot is no unmuting
        ([], [], SEEN / 2, True),  # too early: the person can't know that it stands
    ],
)
def test_only_a_person_who_unmutes_a_robot_lets_it_move(
    muted: list[str], soloed: list[str], beat: float, stands: bool
) -> None:
    stood = run("playing", dance=with_response("stand"), stood={"a": ZERO})
    after, _ = decide(stood, {"type": "silence", "muted": muted, "soloed": soloed}, real(beat))
    assert after.stands("a", ()) == stands


@pytest.mark.parametrize(
    "event", [{"type": "pause"}, {"type": "stop"}, {"type": "seek", "beat": 1.0}, {"type": "speed", "factor": 2.0}]
)
def test_nothing_else_lets_a_robot_move(event: Event) -> None:
    stood = run("playing", dance=with_response("stand"), stood={"a": ZERO})
    assert decide(stood, event, real(3))[0].stands("a", ())
    stopped, _ = decide(stood, {"type": "stop"}, real(3))
    again = decide(stopped, events.Restarted(to_play(DANCE, 2, "restart")), real(4))
    assert again[0].stands("a", ())


def stands(robot: str) -> FaultMessage:
    """The report of a real robot that stands because of a fault."""
    when: RobotInstant = {"generation": 1, "robot": robot, "beat": 3.0, "performed": 3.0, "wall": 0}
    fault: FaultMessage = {
        **when, "type": "fault", "fault": "silent", "over": False, "response": "stand", "worst": {}, "message": "",
        "line": "",
    }  # fmt: skip
    return fault


def test_the_simulated_robot_stands_with_the_real_one() -> None:
    after, todo = decide(run("playing"), stands("a"), at(3))
    assert ([*after.stood], todo) == (["a"], [Resend(["a"]), Report()])
    assert decide(after, stands("a"), at(4)) == (after, [])
    assert decide(after, stands("nobody"), at(4)) == (after, [])


@pytest.mark.parametrize(("asked", "got"), [(0.0, "0.1"), (0.1, "0.1"), (3.7, "3.7"), (100.0, "4")])
def test_speed_has_limits(asked: float, got: str) -> None:
    then, done = decide(run("stopped"), {"type": "speed", "factor": asked}, at(3))
    assert (then.speed, then.tempo, then.transport.tempo) == (Fraction(got), 60 * Fraction(got), 60 * Fraction(got))
    assert done == [Report()]


def test_another_speed_plays_on_from_the_beat_that_is_reached() -> None:
    then, done = decide(run("playing"), {"type": "speed", "factor": 2.0}, at(3))
    assert then.transport == Transport(ZERO, 3.0, 3, Fraction(120))
    assert done == begins(DANCE, 3, 3)


@pytest.mark.parametrize(
    ("mode", "muted", "soloed", "standing", "resent"),
    [
        ("playing", {"a"}, (), (), ["a"]),
        ("playing", (), {"a"}, (), ["b"]),
        ("playing", {"a"}, (), {"a"}, []),  # it stands already
        ("playing", (), (), (), []),
        ("paused", {"a"}, (), (), []),
    ],
)
def test_a_silence_resends_only_the_robots_that_it_changes(
    mode: Mode, muted: set[str], soloed: set[str], standing: set[str], resent: Sequence[str]
) -> None:
    facts = at(3, standing=frozenset(standing))
    then, done = decide(run(mode, 3), {"type": "silence", "muted": [*muted], "soloed": [*soloed]}, facts)
    assert then.silenced == Silenced(frozenset(muted), frozenset(soloed))
    assert done == [*([Resend(resent)] if resent else []), Report()]


# Armed

ARMED = Gate(ready=True)
AT_5 = Gate(ZERO + 5)
"""The tests' wall clock is their monotonic clock."""
READY = events.Listened((), False, None)


def armed(gate: Gate, ready: bool = True, dance: Score = DANCE) -> Run:
    return run("waiting", dance=dance, gate=replace(gate, ready=ready))


def told(gate: Gate | None) -> Tell:
    return Tell(message(gate, 1))


def wall(second: float, places: Mapping[str, Standing] | None = None) -> Facts:
    return replace(at(second), wall=ZERO + second, places=places or {})


def test_a_restart_may_be_armed() -> None:
    load = to_play(OTHER, 2, "restart", arming={})
    then, _ = decide(run("playing", 3), events.Restarted(load), at(3))
    assert (then.mode, then.gate) == ("waiting", Gate())
    again, _ = decide(then, events.Restarted(to_play(OTHER, 2)), at(4))
    assert again.gate is None


@pytest.mark.parametrize(
    ("gate", "event", "second", "mode", "ready"),
    [
        (Gate(), events.Listened((), True, None), 4, "waiting", False),
        (Gate(), READY, 4, "waiting", True),
        (Gate(), {"type": "resume"}, 4, "waiting", False),  # too early: it begins only once all is ready
        (ARMED, READY, 1e9, "waiting", True),
        (Gate(-math.inf, True), READY, 4, "playing", False),
        (AT_5, READY, 4.9, "waiting", True),
        (AT_5, READY, 5, "playing", False),
        (replace(AT_5, ready=True), READY, 4.9, "waiting", True),
        (replace(AT_5, ready=True), READY, 5, "playing", False),
        (replace(AT_5, ready=True), {"type": "stop"}, 4, "stopped", False),
        (replace(AT_5, ready=True), {"type": "pause"}, 4, "stopped", False),
        (AT_5, {"type": "stop"}, 4, "stopped", False),
        (AT_5, {"type": "pause"}, 4, "stopped", False),
        (replace(AT_5, ready=True), events.EmergencyStop(STOP, True), 4, "stopped", False),
        (replace(AT_5, ready=True), {"type": "seek", "beat": 2.0}, 4, "waiting", True),
        (replace(AT_5, ready=True), events.Changed(), 4, "waiting", True),
    ],
)
def test_a_person_or_the_clock_begins_an_armed_score(
    gate: Gate, event: Event, second: float, mode: Mode, ready: bool
) -> None:
    before = run("waiting", gate=gate)
    then, done = found(before, event, wall(second))
    assert then.mode == mode
    assert is_ready(then.gate) == ready
    assert (told(then.gate) in done) == (gate.ready != ready), "people are told of each change, once"
    assert any(isinstance(each, Begin) for each in done) == (mode == "playing")
    if mode != "waiting":
        assert then.gate is None, "nothing begins later by itself"


@pytest.mark.parametrize(
    ("before", "known", "deaf", "brought"),
    [
        (run("waiting"), {}, (), ["a", "b"]),
        (run("playing"), {}, (), []),
        (run("stopped"), {}, (), []),
        (run("waiting", dance=GUARDED), {}, (), []),  # nobody holds the button
        (run("waiting", dance=GUARDED), {"held": {BUTTON}}, (), ["a", "b"]),
        (run("waiting", dance=GUARDED, stops=PRESSED), {"held": {BUTTON}}, (), []),
        (run("waiting", silenced=Silenced(frozenset({"a"}))), {}, (), ["b"]),
        (run("waiting", stood={"a": 1.0}), {}, (), ["b"]),
        (run("waiting"), {"standing": frozenset({"b"})}, (), ["a"]),
        (run("waiting"), {}, ("a",), ["b"]),
        (run("waiting", dance=replace(DANCE, safety=Safety(start_without=False))), {}, ("a",), []),
        (run("waiting", dance=TOGETHER), {"away": frozenset({"a"})}, (), []),
    ],
)
def test_joints_are_brought_to_their_starts_only_if_their_robots_may_move(
    before: Run, known: Mapping[str, Any], deaf: Sequence[str], brought: Sequence[str]
) -> None:
    facts = Facts(ZERO, real=True, **known)
    assert robots_to_home(before, facts, False, deaf) == brought
    assert robots_to_home(before, facts, True, deaf) == []


@pytest.mark.parametrize("asked", ["stop", "pause"])
def test_a_stop_names_other_nodes_that_can_move_a_robot(asked: str) -> None:
    facts = real(3, other_publishers={"b": ["/improv_2", "/teleop"], "gone": ["/teleop"]})
    _, done = decide(run("playing"), {"type": asked}, facts)  # type: ignore[arg-type]
    assert names(done) == ["Zero", "Report", "Tell"]
    line = "b may still be moving: stop /improv_2, /teleop, which can move it, too"
    assert done[-1] == Tell({"type": "unreached", "generation": 1, "robots": ["b"], "message": line})


@pytest.mark.parametrize(("real", "mode"), [(True, "stopped"), (False, "waiting")])
def test_a_pause_before_beat_0_stops_real_robots_whose_joints_may_be_moving(real: bool, mode: Mode) -> None:
    then, done = decide(run("waiting"), {"type": "pause"}, Facts(ZERO, real=real))
    assert then.mode == mode
    assert (Zero() in done) == real


def test_robots_stand_while_it_is_armed() -> None:
    heard = events.Listened((), False, ["a"])
    then, done = decide(run("waiting", gate=Gate()), heard, wall(4))
    assert done == [Still(["a"]), Report(), told(ARMED)]
    assert decide(then, READY, wall(5)) == (then, [])


def test_a_person_begins_at_once() -> None:
    asked, done = decide(armed(AT_5), {"type": "resume"}, wall(3))
    assert done == [Listen()], "which waits for nothing"
    then, done = found(asked, READY, wall(3))
    assert (then.mode, then.transport.zero) == ("playing", ZERO + 3)
    assert not lines(done)


def test_a_resume_that_is_too_early_is_refused() -> None:
    before = armed(Gate(), ready=False)
    assert decide(before, {"type": "resume"}, wall(3)) == (before, [Tell({"type": "warning", "message": NOT_READY})])


@pytest.mark.parametrize(
    ("second", "says"),
    [(5.01, []), (5.5, ["begins 0.50 s late: the stage still waited for robots, or the clock was set"])],
)
def test_a_late_beginning_is_reported(second: float, says: list[str]) -> None:
    then, done = found(run("waiting", gate=AT_5), READY, wall(second))
    assert (then.mode, lines(done)) == ("playing", says)


def test_robots_have_to_be_in_their_places_before_it_is_armed_and_when_it_begins() -> None:
    wrong = {"a": Standing(Pose(), Pose(1.0))}
    for gate, second in ((Gate(), 4), (AT_5, 4), (replace(AT_5, ready=True), 5)):
        then, done = found(run("waiting", gate=gate), READY, replace(wall(second, places=wrong), real=True))
        assert (then.mode, then.gate, then.misplaced) == ("paused", None, wrong)
        assert "doesn't begin" in lines(done)[0]
    then, _ = found(armed(AT_5), READY, replace(wall(4, places=wrong), real=True))
    assert then.mode == "waiting", "somebody who walks among them disarms nothing"
    then, _ = found(run("waiting", dance=NOTHING), READY, replace(wall(4, places=wrong), real=True))
    assert then.mode == "playing", "who only has to stop needs no place"


def test_without_the_deadman_button_nothing_begins_by_itself() -> None:
    then, done = found(armed(AT_5, dance=GUARDED), READY, replace(wall(5), real=True))
    assert (then.mode, then.continues, then.gate) == ("paused", True, None)
    assert Zero() in done


def test_a_score_that_only_stops_robots_is_never_armed() -> None:
    then, _ = found(run("waiting", dance=NOTHING, gate=Gate()), READY, wall(4))
    assert then.mode == "playing"


# All rules

LOAD = to_play(replace(OTHER, safety=Safety(stop=STOP, deadman=DEADMAN)), 2, "now")
EVENTS: Sequence[Event] = [
    LOAD,
    to_play(LOAD.score, 2, "restart"),
    events.Restarted(LOAD),
    events.Awaited(),
    events.Listened((), False, None),
    events.Replaced(LOAD.score, 2, 3.0, 3, {"a", "b"}, (), False),
    {"type": "stop"},
    {"type": "pause"},
    {"type": "resume"},
    {"type": "seek", "beat": 2.0},
    {"type": "speed", "factor": 2.0},
    {"type": "silence", "muted": ["a"], "soloed": []},
    events.EmergencyStop(STOP, True),
    events.Changed(),
    Anchor(ZERO + 3, 3.0, 2.0, 0.1),
    {"type": "bend", "pace": 2.0, "beat": 3.0, "at": ZERO + 3},
    events.Stalled(1.0),
    events.Overloaded(),
    Due(8.0, Rank.END),
    Due(3.0, Rank.TAKEOVER),
]


@pytest.mark.parametrize(
    "event", EVENTS, ids=lambda event: event["type"] if isinstance(event, dict) else type(event).__name__
)
def test_removed_robots_stop_and_nothing_begins_that_must_wait(event: Event) -> None:
    dance = replace(SCENES, safety=Safety(stop=STOP, deadman=DEADMAN))
    swap = PendingTakeover(OTHER, 2, "beat", 4, 3.0, None) if isinstance(event, Due) else None
    for mode, held, stops, knows in product(MODES, (False, True), (EmergencyStops(), PRESSED), (True, False)):
        before = run(mode, 3, GUARDED if isinstance(event, Due) else dance, stops=stops, next=swap)
        facts = real(3, held=frozenset({BUTTON} if held else ()))
        then, done = decide(before, event if knows else events.Changed(), facts)
        if before.mode == "playing" and then.mode in ("stopped", "paused"):
            assert Zero() in done
        if any(isinstance(each, Begin) for each in done):
            assert then.mode == "playing"
            goes_on = isinstance(event, Due)  # the next scene and the end begin nothing that did not play before
            assert goes_on or (held and not then.stops.on)
        else:
            assert then.mode != "playing" or before.mode == "playing"


def test_each_event_has_its_rule() -> None:
    assert _RULES.keys() == {*get_args(Internal)}


# The agenda


@pytest.mark.parametrize(
    ("before", "over", "due"),
    [
        (run("playing"), 8, Due(8.0, Rank.END)),
        (run("playing", dance=SCENES), 2, Due(2.0, Rank.SCENE)),
        (run("playing"), math.inf, NEVER),
        (run("playing", next=PendingTakeover(OTHER, 2, "beat", 4, 3.0, None)), 8, Due(3.0, Rank.TAKEOVER)),
        (run("playing", next=PendingTakeover(OTHER, 2, "end", 4, 8.0, None)), 8, Due(8.0, Rank.TAKEOVER)),
        (run("playing", dance=SCENES, next=PendingTakeover(OTHER, 2, "bar", 4, 2.0, None)), 2, Due(2.0, Rank.SCENE)),
        (run("ended", 8, next=PendingTakeover(OTHER, 2, "now", 4, 9.0, None)), 8, Due(9.0, Rank.TAKEOVER)),
        (run("paused", 3, next=PendingTakeover(OTHER, 2, "now", 4, 3.0, None)), 8, NEVER),
        *((run(mode, 3), 8, NEVER) for mode in MODES if mode != "playing"),
    ],
)
def test_the_earliest_decision_is_next(before: Run, over: Duration, due: Due) -> None:
    assert next_decision(before, over) == due


def test_what_is_due_at_one_instant_has_an_order() -> None:
    assert [*Rank] == [Rank.SCENE, Rank.TAKEOVER, Rank.EDGES, Rank.CHANGES, Rank.END, Rank.BEND, Rank.REPEATS]
    assert Due(2.0, Rank.END).last_before(Rank.CHANGES) == 2.0  # zeros that end a score come before it has ended
    assert Due(2.0, Rank.SCENE).last_before(Rank.CHANGES) < 2.0  # the next scene decides what is due then
    assert Due(2.0, Rank.TAKEOVER).last_before(Rank.CHANGES) < 2.0


def test_edges_that_were_announced_come_at_their_beats_while_it_plays() -> None:
    assert next_edges(run("playing"), 3) == Due(3.0, Rank.EDGES)
    assert next_edges(run("playing"), None).at == next_edges(run("paused", 2), 3).at == math.inf


def test_rounding_never_puts_the_present_before_what_is_due() -> None:
    zero = 1000.1
    late = replace(run("playing"), transport=Transport(zero, 0.0, 0, Fraction(60)))
    now = zero + 0.3
    assert late.transport.performed(now) < 0.3  # rounding loses this much
    assert performed(late, now, 0.3) == 0.3
