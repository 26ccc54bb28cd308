"""What follows from what people ask for: `(show, request, now) -> (show, acts)`. Nothing here does anything.

Standard library only.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

from improv_core.ipc.stage_process import StageError
from improv_core.protocol.commands import COMMANDS, Anyway, PageRequest, Resume, Watched
from improv_core.protocol.editing import Answer, ProgramSource
from improv_core.protocol.messages import Obeyed, Pressed, ProgramMessage, refused_by
from improv_core.score.transport import BEATS_PER_BAR
from improv_core.session.acts import Act, Announce, PassOn, Send, SendScore
from improv_core.session.state import Change, PlayScore, Show

Wish = Change | Resume | Anyway | ProgramMessage | ProgramSource | Answer
"""What may be asked of all stages: a change, to resume after a pause, or to show something on pages."""
Decided = tuple[Show, list[Act]]


@dataclass(frozen=True, slots=True)
class Now:
    """What a decision may also depend on: the monotonic time, the count of stops when this was asked for, and the
    emergency stops that are on."""

    at: float = 0.0
    stops: int = 0
    pressed: Pressed = field(default_factory=lambda: Pressed(type="pressed", topics=[], count=0))


def asked(show: Show, request: PlayScore | Wish | PageRequest | Watched, now: Now) -> Decided:
    """What is known after a request, and what to do about it. Raises StageError if nothing can play it.

    A request goes to all stages from here, so they never disagree. A stop has been obeyed already, when it arrived.
    """
    if isinstance(request, PlayScore):
        return _play(show, request, now)
    if request["type"] == "program" or request["type"] == "source" or request["type"] == "answer":
        return _inform(show, request)
    if (
        request["type"] == "place"
        or request["type"] == "form"
        or request["type"] == "tune"
        or request["type"] == "watched"
    ):
        return show, [Announce(request)]
    if request["type"] == "editing":
        return show, [PassOn(request, now.stops)]
    if request["type"] == "restart":
        again = show.played and replace(
            show.played,
            when="restart",
            beats_per_bar=BEATS_PER_BAR,
            stops=now.stops,
            arming=None,
            by=request.get("by"),
        )
        return _send_score(show, again) if again and show.leader else (show, [])
    if request["type"] == "resume" or request["type"] == "anyway":
        resume = request.copy()
        resume["at"] = now.at
        twin = None if show.armed else show.twin  # it begins with the leader
        return show, [Send(name, resume, unless=now.stops) for name in (show.leader, twin) if name]
    if request["type"] == "stop" and "mark" in request:
        return _await_obeyed(show, request["mark"])
    if request["type"] == "stop" or request["type"] == "pause":
        return show, []
    return _change(show, request, now)


def _await_obeyed(show: Show, mark: str) -> Decided:
    """Let pages know who has to obey a stop, unless that is the simulator, which confirms it itself."""
    if not show.real:
        return show, []
    return replace(show, unobeyed=show.unobeyed | {mark}), obeyed(show, mark, ["the real robots"])


def obeyed(show: Show, mark: str, waits_for: Sequence[str] = ()) -> list[Act]:
    """Let pages know that a stop was obeyed, except by those that it waits for."""
    message: Obeyed = {"type": "obeyed", "mark": mark, "waits_for": waits_for}
    return [Send(name, message) for name, ready in show.stages.items() if "page" in ready]


def _play(show: Show, play: PlayScore, now: Now) -> Decided:
    first, on = show.idle or show.leader, now.pressed["topics"]
    assert first
    if on and show.stages[first]["real"] and not play.simulated:
        line = refused_by(on, play.score.safety.stop)
        # Another stage may have heard it: this one has to hear its release.
        return show, [Send(first, now.pressed), Announce({"type": "error", "message": line})]
    show, acts = _let_lead(show, play.simulated)
    show, more = _send_score(show, play)
    return show, [*acts, *more]


def _let_lead(show: Show, simulated: bool) -> Decided:
    """Have the simulator play alone, while the stage of real robots stops them and waits, or both play again."""
    assert show.leader
    # Simulated robots must not keep dancing either, while real ones are waited for.
    stop: list[Act] = [Send(show.leader, {"type": "stop"})]
    if simulated and show.twin:
        return replace(show, leader=show.twin, idle_score=show.played.score if show.played else None), stop
    if simulated and show.is_real:
        raise StageError("no robot is named, and there is no simulator: set improv.backend to auto, sim, or both")
    if not simulated and show.idle:
        return replace(show, leader=show.idle), stop
    return show, []


def _send_score(show: Show, play: PlayScore) -> Decided:
    assert show.leader
    generation = show.generation + 1
    editions, score = show.editions.number(play.score, generation)
    play = replace(play, score=score, generation=generation)
    return replace(show, editions=editions), [SendScore(show.leader, play, asked=True)]


def _change(show: Show, change: Change, now: Now) -> Decided:
    """Send it to all stages, effective at the same time."""
    row, change = COMMANDS[change["type"]], change.copy()
    change.pop("at", None)  # what is kept has no time
    if row.kept:
        show = show.keeping(change)
    elif change["type"] == "seek" and not show.played:
        line = "nothing has been played yet: save a program before you seek"
        return show, [Announce({"type": "warning", "message": line})]
    timed, later = change.copy(), change.copy()
    timed["at"], later["at"] = now.at, now.at + show.behind
    acts = [Send(show.leader, timed)] if show.leader else []
    if show.idle and row.kept:
        acts.append(Send(show.idle, timed))  # it holds for what it plays next
    if show.twin and not row.as_sensed:
        acts.append(Send(show.twin, later, show.behind))
    return show, [*acts]


def _inform(show: Show, message: ProgramMessage | ProgramSource | Answer) -> Decided:
    """Tell pages, and those that are opened later unless it is an answer."""
    if message["type"] != "answer":
        show = show.keeping(message)
    for_all = message["type"] == "program"
    return show, [Send(name, message) for name, ready in show.stages.items() if for_all or "page" in ready]
