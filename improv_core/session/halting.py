"""Decides how new stages stop the robots of dead ones, and the answer to `improv stop`. Standard library only."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import replace

from improv_core.protocol.messages import TransportMessage
from improv_core.safety.stop_socket import IDLE
from improv_core.score.score import Part, Score
from improv_core.score.takeover import Takeover
from improv_core.session.acts import Act, Now, SendScore
from improv_core.session.state import NOTHING, PlayScore, SessionState, StageKey
from improv_core.session.together import beat_at, entry_at


def halt(state: SessionState, key: StageKey) -> SendScore:
    """Have a stage stop the robots of all scores that may play on it, even if it has yet to find them."""
    idles = key.output == state.idle
    robots = state.on_robots.score
    scores = [robots] if idles and robots.parts else [*state.editions.sent.values()] or [NOTHING.score]
    return SendScore([key], PlayScore(_standing(scores), "", 0, generation=state.generation))


def has_halted(state: SessionState, key: StageKey, transport: TransportMessage) -> bool:
    """Return whether a stage reports that it has stopped a dead one's robots: before its score, it had none to stop."""
    stands = transport["state"] in ("stopped", "ended") and transport["generation"] == state.generation
    return key in state.stages and state.stages[key].died_moving and stands


def stood(state: SessionState, now: Now) -> Takeover | None:
    """Return where the score was when the last stage that played it died, by the reports of all. None if it had yet to
    begin, if somebody has stopped it, or if an emergency stop is on."""
    play = state.played
    if not play or play.stopped != now.stopped or now.pressed["topics"]:
        return None
    goes_on = play.when not in ("restart", "end")  # otherwise, places in the score before it mean nothing
    reports = [stage.transport for key, stage in state.stages.items() if key.output == state.leader]
    seen = [each for each in reports if each and (goes_on or each["generation"] == play.generation)]
    seen = [each for each in seen if each["state"] in ("playing", "paused")]
    latest = max(seen, key=lambda each: each["monotonic"], default=None)
    return entry_at(latest, beat_at(latest, now.at), now.at) if latest else None


def stand(state: SessionState, key: StageKey, now: Now) -> list[Act]:
    """Send a stage that has stopped the robots of a dead one the score from which people may have them resume."""
    if not state.stood or not state.played or key.output != state.leader:
        return []
    play = replace(state.played, when="restart", by=None)
    return [SendScore([key], play, stops={key: now.known}, whole=True, stood=state.stood)]


def stop_line(state: SessionState, begins: Sequence[str], moving: int, was_on: bool) -> str:
    """Return the line about what was stopped: the program that played, or the one that `begins`, and how many real
    robots were `moving`, as far as that is known."""
    lost = state.real is not None and not state.obeys
    names = [state.played.name] if state.played and (was_on or moving or lost) else begins
    if not names:
        return IDLE
    if lost:
        return f"{names[0]}: robots may still be moving, since their stage has failed: look at them"
    if not (was_on or moving):
        return f"stopped {names[0]} before it began"
    stopped = f"stopped {names[0]} on {state.status}"
    if not moving:  # how many moved when somebody asked is not known
        return stopped
    return f"{stopped}: {'1 robot was' if moving == 1 else f'{moving} robots were'} moving"


def _standing(scores: Collection[Score]) -> Score:
    """Return a score with the robots of these scores, any of which may play, and with nothing to play, so that they are
    only sent zeros.

    A robot may have another topic in each score. Then it counts as several.
    """
    robots = {part.topic: part for score in scores for part in score.moving().parts.values()}
    parts: dict[str, Part] = {}
    for topic, part in robots.items():
        name = topic if part.robot in parts else part.robot
        parts[name] = replace(part, robot=name, scenes=(), reset=None)
    latest = [*scores][-1]
    return Score(latest.tempo, parts, world=latest.world)
