"""Requests in OSC messages: `(address, arguments) -> request`, and limits for them. Pure functions."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace

from improv_core.music.osc_wire import Argument
from improv_core.plain import message as in_plain_text
from improv_core.protocol import play_again
from improv_core.protocol.commands import PageRequest
from improv_core.protocol.fields import FASTEST, LAST_BEAT, SLOWEST
from improv_core.protocol.messages import FromStage
from improv_core.score.score import Score
from improv_core.score.senses import OscName

STOPS = "/improv/stop", "/improv/pause"
"""The addresses that always count, even in a flood."""
URGENT = tuple(address.encode() + b"\0" for address in STOPS)
"""The bytes that a datagram with one of these addresses contains."""
AHEAD = 2.0
"""Seconds that a message may wait until its time. A later time comes from a wrong clock."""
MAX_HELD = 1_000
"""The most messages that may wait for their time."""


@dataclass(frozen=True, slots=True)
class Situation:
    """The known state of the dance. `tempo` is in beats per minute at speed 1, and `senses` are those that robots read
    from OSC messages: names and robots."""

    heard: play_again.Heard = field(default_factory=play_again.Heard)
    tempo: float = 60.0
    senses: frozenset[tuple[str, str]] = frozenset()

    def after(self, message: FromStage) -> Situation:
        """Return the situation after another message of the stage that leads."""
        known = replace(self, heard=self.heard.after(message))
        if message["type"] == "transport":
            return replace(known, tempo=message["tempo"] / message["speed"] / message.get("pace", 1.0))
        return known

    def playing(self, score: Score) -> Situation:
        """Return the situation once this score plays."""
        found = [(source, part.robot) for part in score.parts.values() for source in part.senses.values()]
        return replace(self, senses=frozenset((each.osc, robot) for each, robot in found if isinstance(each, OscName)))


class UnclearError(Exception):
    """A message asks for nothing that can be done. The text is one line with the reason."""


def request(address: str, arguments: Sequence[Argument], known: Situation) -> PageRequest | None:
    """Return the request of a message; None if there is nothing to do. Raises UnclearError.

    A button that sends 0 on release requests something only when it is pressed.
    """
    if address not in _ASKS:
        raise UnclearError(f"there is no {_shown(address)}")
    return _ASKS[address](arguments, known)


def waits(asked: PageRequest) -> bool:
    """Return whether a request waits until its time. Only senses wait, because they can't start anything that somebody
    has stopped meanwhile."""
    return asked["type"] in ("cue", "osc_sense")


def _pause(arguments: Sequence[Argument], known: Situation) -> PageRequest | None:
    return {"type": "pause"} if known.heard.state in ("playing", "waiting") and _pressed(arguments) else None


def _play(arguments: Sequence[Argument], known: Situation) -> PageRequest | None:
    if not _pressed(arguments):
        return None
    reply = play_again.play(known.heard, "osc")
    if not reply.succeeds:
        raise UnclearError(f"/improv/play: {reply.line}")
    return reply.request


def _seek(arguments: Sequence[Argument], known: Situation) -> PageRequest:
    beat = _number(arguments)
    if beat is None or not 0 <= beat <= LAST_BEAT:
        raise UnclearError("/improv/seek takes a beat, counted from 0")
    return {"type": "seek", "beat": beat}


def _tempo(arguments: Sequence[Argument], known: Situation) -> PageRequest:
    tempo = _number(arguments)
    least, most = known.tempo * SLOWEST, known.tempo * FASTEST
    if tempo is None or not least <= tempo <= most:
        raise UnclearError(f"/improv/tempo takes beats per minute, here from {least:g} to {most:g}")
    return {"type": "speed", "factor": min(max(tempo / known.tempo, SLOWEST), FASTEST)}


def _sense(arguments: Sequence[Argument], known: Situation) -> PageRequest:
    if len(arguments) == 3:
        name, robot, value = arguments
        if isinstance(name, str) and isinstance(robot, str) and isinstance(value, int | float) and value in (0, 1):
            if (name, robot) not in known.senses:
                raise UnclearError(f"{_shown(robot)} plays nothing that reads the OSC sense {_shown(name)}")
            return {"type": "osc_sense", "name": name, "robot": robot, "value": bool(value)}
    raise UnclearError("/improv/sense takes the name of a sense, a robot, and 0 or 1")


_ASKS: Mapping[str, Callable[[Sequence[Argument], Situation], PageRequest | None]] = {
    "/improv/stop": lambda arguments, known: {"type": "stop", "by": "osc"},
    "/improv/pause": _pause,
    "/improv/play": _play,
    "/improv/cue": lambda arguments, known: {"type": "cue"} if _pressed(arguments) else None,
    "/improv/seek": _seek,
    "/improv/tempo": _tempo,
    "/improv/sense": _sense,
}


def _pressed(arguments: Sequence[Argument]) -> bool:
    """Return whether a button is pressed rather than released."""
    return not arguments or arguments[0] != 0


def _number(arguments: Sequence[Argument]) -> float | None:
    (value,) = arguments if len(arguments) == 1 else (None,)
    if isinstance(value, bool) or not isinstance(value, int | float) or not math.isfinite(value):
        return None
    return float(value)


def _shown(address: str) -> str:
    return in_plain_text(address[:60])
