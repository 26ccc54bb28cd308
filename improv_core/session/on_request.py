"""Decides about people's requests: `(state, request, now) -> (state, acts)`, without side effects. Standard library
only."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

from improv_core.ipc.stage_process import StageError
from improv_core.protocol.commands import COMMANDS, PageOpened, PageRequest, Resume, Stop
from improv_core.protocol.editing import Answer, Draft, ProgramSource
from improv_core.protocol.messages import Pressed, Problem, ProgramMessage
from improv_core.protocol.page_messages import for_pages
from improv_core.protocol.play_again import STOPPED
from improv_core.safety.interlocks import refused_by
from improv_core.score.takeover import amid
from improv_core.score.transport import BEATS_PER_BAR
from improv_core.session import on_hosts
from improv_core.session.acts import Act, Announce, Now, Send, SendScore, StateAndActs, send, warning
from improv_core.session.state import HERE, Change, PlayScore, SessionState, StageKey

StageRequest = Change | Resume | ProgramMessage | ProgramSource | Draft | Answer
"""The requests to all stages: a change, to resume after a pause, or to show something on pages."""
ProblemFields = tuple[str, int, int, str, str]
"""The values of the fields of a `Problem`."""
MAX_ERRORS = 20
"""The most errors that pages list."""
Request = PlayScore | StageRequest | PageRequest | PageOpened


def on_request(state: SessionState, request: Request, now: Now) -> StateAndActs:
    """Return the state after a request, and the acts that follow. Raises StageError if nothing can play it.

    A request goes to all stages from here, so they never disagree. Stages have been sent stops and pauses already.
    """
    if isinstance(request, PlayScore):
        return _play(state, request, now)
    match request["type"]:
        case "program" | "source" | "draft" | "answer":
            return _inform(state, request)
        case "page_opened":
            return state, [Announce(request)]
        case "editing":
            return state, [Announce(request, stops=now.stops)]
        case "restart":
            if not state.played or not state.leader:
                return state, []
            by = request.get("by")
            again = replace(
                state.played, when="restart", beats_per_bar=BEATS_PER_BAR, stops=now.stops, arming=None, by=by
            )
            return send_score(state, again, now)
        case "resume":
            return _resume(state, request, now)
        case "stop":
            return _stop(state, now)
        case "pause":
            return on_hosts.pause(state), []
        case _:
            return _change(state, request, now)


def program_message(
    name: str, folder: str, errors: Sequence[ProblemFields], names: Mapping[str, str] | None = None
) -> ProgramMessage:
    """Return the program to play, and the errors that keep it from being played, for pages."""
    problems: list[Problem] = [
        {"file": file, "line": line, "column": column, "word": word, "message": message}
        for file, line, column, word, message in errors[:MAX_ERRORS]
    ]
    shown: ProgramMessage = {
        "type": "program",
        "name": name,
        "folder": folder,
        "problems": problems,
        "count": len(errors),
    }
    return {**shown, "names": names} if names else shown


def tell_pressed(state: SessionState, pressed: Pressed) -> list[Act]:
    """Send all stages of real robots the emergency stops that are on."""
    return [send(host, on_hosts.pressed_of(state, host, pressed)) for host in state.alive]


def _stop(state: SessionState, now: Now) -> StateAndActs:
    return on_hosts.stop(replace(state, stood=None, pending=None), now)


def _resume(state: SessionState, message: Resume, now: Now) -> StateAndActs:
    if now.overtaken:
        return state, []
    state = replace(state, played=state.played and replace(state.played, stopped=now.stopped))  # it dances again
    twin = None if state.armed else state.twin  # the twin begins with the leader
    timed = message.copy()
    timed["at"] = now.at
    acts: list[Act] = []
    for output in (state.leader, twin):
        if output == "ros" and state.is_spread:
            state, acts = on_hosts.resume(state, timed, now)
        elif output:
            acts.append(Send(StageKey(HERE, output), timed))
    return state, [replace(act, unless=now.stops) if isinstance(act, Send) else act for act in acts]


def _play(state: SessionState, play: PlayScore, now: Now) -> StateAndActs:
    first, on = state.idle or state.leader, now.pressed["topics"]
    if on and first == "ros" and not play.simulated:
        line = refused_by(on, play.score.safety.stop)
        # Another stage may have received the press: this one has to receive the release.
        return state, [*tell_pressed(state, now.pressed), Announce({"type": "error", "message": line})]
    play = _joined(state, play, now)
    state, acts = _let_lead(state, play.simulated, now)
    state, more = send_score(state, play, now)
    return state, [*acts, *more]


def _joined(state: SessionState, play: PlayScore, now: Now) -> PlayScore:
    """Return a request that joins the dance with the dancing robots added; unchanged after a stop. Raises
    StageError."""
    before = state.played
    if not (play.joins and before and state.is_on and before.stopped == now.stopped):
        return play
    if state.real and play.simulated != before.simulated:
        if play.simulated:
            raise StageError("no robot plays that, and a ghost can't join real robots: play only that")
        return play  # real robots can't join a ghost
    if play.score.tempo != before.score.tempo:
        raise StageError(
            f"what dances plays at beat {float(before.score.tempo):g}: play the whole program to change that"
        )
    return replace(play, score=amid(play.score, before.score), simulated=play.simulated or before.simulated)


def _let_lead(state: SessionState, simulated: bool, now: Now) -> StateAndActs:
    """Have the simulator play alone, while the stage of real robots stops them and waits, or both play again."""
    # Whichever led: simulated robots, too, must not keep dancing while real ones get ready.
    stop: Stop = {"type": "stop"}
    if simulated and state.twin:
        state, acts = _stop(replace(state, leader=state.twin), now)
        return state, [*(send(host, stop) for host in state.robots), *acts]
    if simulated and state.is_real:
        raise StageError("no robot is named, and there is no simulator: set improv.backend to auto, sim, or both")
    if not simulated and state.idle:
        return replace(state, leader=state.idle), [Send(StageKey(HERE, "simulator"), stop)]
    return state, []


def send_score(state: SessionState, play: PlayScore, now: Now) -> StateAndActs:
    """Send the leading stages a score. One that has died gets it once it has been replaced, unless an automation asks:
    after such a stop, only a person may."""
    leader = state.leader
    assert leader
    if state.is_gone(leader):
        return (state, [warning(STOPPED)]) if play.by else (replace(state, pending=play), [])
    generation = state.generation + 1
    editions, score = state.editions.number(play.score, generation)
    play = replace(play, score=score, generation=generation, joins=False, stopped=now.stopped)
    state = replace(state, editions=editions)
    if state.is_real and state.is_spread:
        return state, on_hosts.play(state, play, now)
    key = StageKey(HERE, leader)
    return state, [SendScore([key], play, stops={key: now.known}, asked=True)]


def _change(state: SessionState, change: Change, now: Now) -> StateAndActs:
    """Send a change to all stages, effective at the same time."""
    row, change = COMMANDS[change["type"]], change.copy()
    change.pop("at", None)  # a kept change has no time
    if row.kept:
        state = state.keeping(change)
    elif change["type"] == "seek" and not state.played:
        return state, [warning("nothing has been played yet: save a program before you seek")]
    timed, later = change.copy(), change.copy()
    timed["at"], later["at"] = now.at, now.at + state.behind
    acts: list[Act] = []
    if state.is_real or (state.idle and row.kept):  # it holds for the next score of idle robots
        state, acts = on_hosts.change(state, timed, now)
    if state.leader == "simulator":
        acts = [Send(StageKey(HERE, "simulator"), timed), *acts]
    if state.twin and not row.as_sensed:
        acts.append(Send(StageKey(HERE, state.twin), later, state.behind))
    return state, acts


def _inform(state: SessionState, message: ProgramMessage | ProgramSource | Draft | Answer) -> StateAndActs:
    """Send a message to pages, and the program also to those of stages that start later."""
    if message["type"] == "program" and state.kept.get("program") == message:
        return state, []  # most saves change neither its name nor its errors
    if message["type"] == "program" or message["type"] == "source":
        state = state.keeping(message)
    to = [key for key in state.stages if key.host == HERE] if message["type"] == "program" else state.pages
    return state, [Send(key, for_pages(message)) for key in to]
