"""Decides about people's requests: `(state, request, now) -> (state, acts)`, without side effects. Standard library
only."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

from improv_core.ipc.stage_process import StageError
from improv_core.protocol.commands import COMMANDS, PageRequest, Resume, Watched
from improv_core.protocol.editing import Answer, ProgramSource
from improv_core.protocol.messages import Pressed, ProgramMessage, refused_by
from improv_core.protocol.page_messages import for_pages
from improv_core.score.transport import BEATS_PER_BAR
from improv_core.session.acts import Act, Announce, Send, SendScore
from improv_core.session.state import Change, PlayScore, SessionState

StageRequest = Change | Resume | ProgramMessage | ProgramSource | Answer
"""The requests to all stages: a change, to resume after a pause, or to show something on pages."""
Decided = tuple[SessionState, list[Act]]


@dataclass(frozen=True, slots=True)
class Now:
    """Further facts for a decision: the monotonic time, the count of stops at the request, and the emergency stops that
    are on."""

    at: float = 0.0
    stops: int = 0
    pressed: Pressed = field(default_factory=lambda: Pressed(type="pressed", topics=[], count=0))


def asked(state: SessionState, request: PlayScore | StageRequest | PageRequest | Watched, now: Now) -> Decided:
    """Return the state after a request, and the acts that follow. Raises StageError if nothing can play it.

    A request goes to all stages from here, so they never disagree. A stop has already been obeyed when it arrived.
    """
    if isinstance(request, PlayScore):
        return _play(state, request, now)
    if request["type"] == "program" or request["type"] == "source" or request["type"] == "answer":
        return _inform(state, request)
    if request["type"] == "watched":
        return state, [Announce(request)]
    if request["type"] == "editing":
        return state, [Announce(request, stops=now.stops)]
    if request["type"] == "restart":
        again = state.played and replace(
            state.played,
            when="restart",
            beats_per_bar=BEATS_PER_BAR,
            stops=now.stops,
            arming=None,
            by=request.get("by"),
        )
        return _send_score(state, again) if again and state.leader else (state, [])
    if request["type"] == "resume":
        resume = request.copy()
        resume["at"] = now.at
        twin = None if state.armed else state.twin  # the twin begins with the leader
        return state, [Send(name, resume, unless=now.stops) for name in (state.leader, twin) if name]
    if request["type"] == "stop" and "mark" in request:
        return _await_obeyed(state, request["mark"])
    if request["type"] == "stop" or request["type"] == "pause":
        return state, []
    return _change(state, request, now)


def _await_obeyed(state: SessionState, mark: str) -> Decided:
    """Inform pages about the stages that have yet to obey a stop, unless that is the simulator, which confirms it
    itself."""
    if not state.real:
        return state, []
    return replace(state, unobeyed=state.unobeyed | {mark}), obeyed(state, mark, ["the real robots"])


def obeyed(state: SessionState, mark: str, waits_for: Sequence[str] = ()) -> list[Act]:
    """Inform pages that all stages have obeyed a stop, except those that it waits for."""
    message = for_pages({"type": "obeyed", "mark": mark, "waits_for": waits_for})
    return [Send(name, message) for name, ready in state.stages.items() if "page" in ready]


def _play(state: SessionState, play: PlayScore, now: Now) -> Decided:
    first, on = state.idle or state.leader, now.pressed["topics"]
    assert first
    if on and state.stages[first]["real"] and not play.simulated:
        line = refused_by(on, play.score.safety.stop)
        # Another stage may have received the press: this one has to receive the release.
        return state, [Send(first, now.pressed), Announce({"type": "error", "message": line})]
    state, acts = _let_lead(state, play.simulated)
    state, more = _send_score(state, play)
    return state, [*acts, *more]


def _let_lead(state: SessionState, simulated: bool) -> Decided:
    """Have the simulator play alone, while the stage of real robots stops them and waits, or both play again."""
    assert state.leader
    # Whichever led: simulated robots, too, must not keep dancing while real ones get ready.
    stop: list[Act] = [Send(state.leader, {"type": "stop"})]
    if simulated and state.twin:
        return replace(state, leader=state.twin, idle_score=state.played.score if state.played else None), stop
    if simulated and state.is_real:
        raise StageError("no robot is named, and there is no simulator: set improv.backend to auto, sim, or both")
    if not simulated and state.idle:
        return replace(state, leader=state.idle), stop
    return state, []


def _send_score(state: SessionState, play: PlayScore) -> Decided:
    assert state.leader
    generation = state.generation + 1
    editions, score = state.editions.number(play.score, generation)
    play = replace(play, score=score, generation=generation)
    return replace(state, editions=editions), [SendScore(state.leader, play, asked=True)]


def _change(state: SessionState, change: Change, now: Now) -> Decided:
    """Send a change to all stages, effective at the same time."""
    row, change = COMMANDS[change["type"]], change.copy()
    change.pop("at", None)  # a kept change has no time
    if row.kept:
        state = state.keeping(change)
    elif change["type"] == "seek" and not state.played:
        line = "nothing has been played yet: save a program before you seek"
        return state, [Announce({"type": "warning", "message": line})]
    timed, later = change.copy(), change.copy()
    timed["at"], later["at"] = now.at, now.at + state.behind
    acts = [Send(state.leader, timed)] if state.leader else []
    if state.idle and row.kept:
        acts.append(Send(state.idle, timed))  # the change holds for the next score of that stage
    if state.twin and not row.as_sensed:
        acts.append(Send(state.twin, later, state.behind))
    return state, [*acts]


def _inform(state: SessionState, message: ProgramMessage | ProgramSource | Answer) -> Decided:
    """Send a message to pages, and to those that are opened later unless it is an answer."""
    if message["type"] != "answer":
        state = state.keeping(message)
    for_all = message["type"] == "program"
    return state, [Send(name, for_pages(message)) for name, ready in state.stages.items() if for_all or "page" in ready]
