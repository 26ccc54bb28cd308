"""OSC messages about a dance, and their times. Pure functions; times are monotonic, in seconds."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import NamedTuple

from improv_core.music.osc_wire import Argument
from improv_core.preview.forecast import WordBegins
from improv_core.protocol.commands import is_muted
from improv_core.protocol.messages import Sensed, State, TransportMessage
from improv_core.protocol.transport import beat_at
from improv_core.score.senses import CUE, RobotSense

SAME = 1e-3
"""Beats by which a transport may differ from the prediction of the previous one without counting as a jump."""
ROUNDING = 1e-9
"""Beats by which rounding may make a due beat seem later."""
SILENT = -1
"""The value of a sense that is silent."""


class OscDue(NamedTuple):
    """A message, and the time at which it is due."""

    at: float
    address: str
    arguments: Sequence[Argument]


@dataclass(frozen=True, slots=True)
class Voice:
    """The facts sent so far: the state, the next whole beat, each robot's word, and the senses. `begun` is the beat up
    to which words have been sent."""

    transport: TransportMessage | None = None
    beat: int = 0
    words: Mapping[str, str] = field(default_factory=dict)
    senses: Mapping[RobotSense, bool | None] = field(default_factory=dict)
    begun: float = -math.inf

    @property
    def state(self) -> State | None:
        return self.transport["state"] if self.transport else None

    def after(self, transport: TransportMessage) -> tuple[Voice, list[OscDue]]:
        """Return the voice after a report of the position, and the messages that are due at once."""
        before = self.transport
        told = (
            []
            if self.state == transport["state"]
            else [OscDue(transport["monotonic"], "/improv/state", [transport["state"]])]
        )
        begin = math.ceil(transport["beat"] - SAME)
        continues = (
            before is not None
            and before["state"] == transport["state"] == "playing"
            and before["restarted"] == transport["restarted"]
            and abs(beat_at(before, transport["monotonic"]) - transport["beat"]) < SAME
        )
        words = self.words if transport["state"] == "playing" and self.state == "playing" else {}
        return Voice(transport, max(begin, self.beat) if continues else begin, words, self.senses), told

    def sensed(self, message: Sensed, wall: float, now: float) -> tuple[Voice, list[OscDue]]:
        """Return the voice after a report of a sense, and the messages that are due at once. `wall` is the Unix time
        now."""
        what, value = RobotSense(message["robot"], message["sense"]), message["value"]
        is_cue = what.sense == CUE and value  # it holds for an instant, so each is another one
        if not is_cue and what in self.senses and self.senses[what] == value:
            return self, []
        arguments: list[Argument] = [what.sense, what.robot, SILENT if value is None else int(value)]
        told = OscDue(now + message["wall"] / 1e9 - wall, "/improv/sense", arguments)
        return replace(self, senses={**self.senses, what: value}), [told]

    def next(self, begins: Iterable[WordBegins]) -> float:
        """The next time at which a message is due, given the beats at which words begin; infinite if none is."""
        if not self.transport or self.state != "playing":
            return math.inf
        whole = self.beat if self._has_beat(self.beat) else math.inf
        words = min((each.beat for each in begins if each.beat > self.begun), default=math.inf)
        return _time(self.transport, min(whole, words))

    def due(self, begins: Iterable[WordBegins], now: float) -> tuple[Voice, list[OscDue]]:
        """Return the messages that are due by now, in order, and the voice after them. Beats that are long past are
        left out."""
        transport = self.transport
        if not transport or self.state != "playing":
            return self, []
        reached = beat_at(transport, now) + ROUNDING
        first, last = max(self.beat, math.floor(reached)), math.floor(reached)
        told = [each for beat in range(first, last + 1) if self._has_beat(beat) for each in self._at_beat(beat)]
        words = dict(self.words)
        for beat, robot, word in sorted(each for each in begins if self.begun < each.beat <= reached):
            if word != words.get(robot):
                words[robot] = word
                if word and not is_muted(robot, transport["muted"], transport["soloed"]):
                    told.append(OscDue(_time(transport, beat), "/improv/word", [robot, word]))
        voice = replace(self, beat=max(self.beat, last + 1), words=words, begun=reached)
        return voice, sorted(told, key=lambda each: each.at)

    def _has_beat(self, beat: int) -> bool:
        """Return whether the score reaches a beat."""
        assert self.transport
        beats = self.transport["beats"]
        return beats is None or beat < beats

    def _at_beat(self, beat: int) -> list[OscDue]:
        """The messages at the beginning of a beat."""
        assert self.transport
        at, length = _time(self.transport, beat), self.transport.get("bar")
        bar = [OscDue(at, "/improv/bar", [beat // length])] if length and beat % length == 0 else []
        return [*bar, OscDue(at, "/improv/beat", [beat])]


def _time(transport: TransportMessage, beat: float) -> float:
    """The time at which a beat is due. Beats before this report of the position are due at its time."""
    passed = max(beat - transport["beat"], 0.0)
    return transport["monotonic"] + passed * 60 / transport["tempo"]
