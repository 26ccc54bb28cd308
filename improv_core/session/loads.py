"""The messages by which stages get scores. Standard library only."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import replace
from typing import Any

from improv_core.protocol.limits import SILENCE_LIMIT
from improv_core.protocol.messages import Load
from improv_core.score.score import Score
from improv_core.score.score_json import RowsWritten, to_json
from improv_core.session.acts import SendScore
from improv_core.session.state import HERE, SessionState, StageKey


class Loads:
    """Makes the messages. Each has only what its stage lacks, unless the whole score is to be sent."""

    def __init__(self) -> None:
        self._written: dict[StageKey, RowsWritten] = {}  # the movements that each stage has

    def of(self, state: SessionState, act: SendScore) -> dict[StageKey, Load]:
        """Return the message for each stage that is to get a score."""
        # Stages that have the same movements share this, so for all of them, the score is written once.
        known = {id(written): written for key in act.to if (written := self._written.get(key))}
        written = known.popitem()[1].renewed() if len(known) == 1 and not act.whole else RowsWritten()
        self._written |= dict.fromkeys(act.to, written)
        together = state.is_spread and any(key.output == "ros" for key in act.to)
        # Together, stages follow a clock of music that only we hear: none may follow it by itself.
        score = to_json(replace(act.play.score, clock=None) if together else act.play.score, written)
        # A long program's text fills a pipe, and a stage of robots shows it to nobody unless it publishes the dance.
        unseen = score if act.play.score.publish else {**score, "text": "", "offsets": []}
        return {stage: _load(state, act, stage, unseen if stage.output == "ros" else score) for stage in act.to}

    def forget(self, stages: Iterable[StageKey]) -> None:
        """Have the next message to these stages be whole."""
        self._written |= {stage: RowsWritten() for stage in stages}


def _load(state: SessionState, act: SendScore, stage: StageKey, score: Mapping[str, Any]) -> Load:
    play = act.play
    load: Load = {
        "type": "load",
        "generation": play.generation,
        "score": score,
        "when": play.when,
        "backend": state.status,
        "beats_per_bar": play.beats_per_bar,
    }
    if act.entry:
        load["entry"] = act.entry
    if act.stood:
        load["stood"] = act.stood
    if act.at is not None:
        load["at"] = act.at
    if stage in act.stops:
        load["stops"] = act.stops[stage]
    if play.senses is not None:
        load["senses"] = play.senses
    if play.anyway:
        load["anyway"] = True
    if act.gathers:  # also keeps a stage from playing that has sought a beat after a stop
        load["when"], load["arming"] = "restart", {}
    elif play.arming is not None:
        load["arming"] = play.arming
    if play.by:
        load["by"] = play.by
    if stage.output == "ros" and state.is_spread:
        load["here"] = stage.host
        if stage.host != HERE:
            load["patience"] = _patience(play.score, stage.host)
    return load


def _patience(score: Score, host: str) -> float:
    """Return the seconds after which the stage of a host that hears nothing stops its robots."""
    hosts = [part.host for part in score.parts.values() if part.host and part.host.name == host]
    return min((each.patience for each in hosts), default=SILENCE_LIMIT)
