"""Keeps up with what a stage says, so that what plays can be replayed beside it. Standard library only."""

from __future__ import annotations

from improv_core.protocol.messages import Sensed, TransportMessage, beat_at
from improv_core.score.movement import near
from improv_core.score.replay import Replay
from improv_core.score.score import Score

JUMP = 0.01
"""Seconds by which the position may differ from what is expected before that counts as a jump."""


def followed(replay: Replay | None, score: Score, before: TransportMessage | None, message: TransportMessage) -> Replay:
    """The replay of a score, of which a message is about, after one about `before`. The score knows when its parts
    began. What senses have decided stays, unless playback has jumped."""
    goes_on = before is not None and before["restarted"] == message["restarted"] and not _jumps(before, message)
    if replay and goes_on and replay.score is score:
        return replay
    return Replay(score, near(message["beat"]), replay if goes_on else None)


def note(replay: Replay, message: Sensed) -> None:
    """Note in a replay what a robot senses."""
    replay.sense(message["robot"], message["sense"], message["value"], near(message["beat"]))


def _jumps(before: TransportMessage, message: TransportMessage) -> bool:
    """Whether the position in a message is not where the message before it leads."""
    expected = beat_at(before, message["monotonic"])
    return abs(message["beat"] - expected) > JUMP * message["tempo"] / 60
