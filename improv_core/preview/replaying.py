"""Keeps a replay of the dance up to date from a stage's messages. Standard library only."""

from __future__ import annotations

from improv_core.protocol.messages import Sensed, TransportMessage
from improv_core.protocol.transport import beat_at
from improv_core.score.movement import near
from improv_core.score.replay import Replay
from improv_core.score.score import Score

JUMP = 0.01
"""Seconds by which the position may differ from the expected one before that counts as a jump."""


def followed(replay: Replay | None, score: Score, before: TransportMessage | None, message: TransportMessage) -> Replay:
    """Return the replay of a score after a message about it; `before` is the previous message. The score knows the
    beats at which its parts began. Decisions of senses stay, unless playback has jumped."""
    continues = before is not None and before["restarted"] == message["restarted"] and not _jumps(before, message)
    if replay and continues and replay.score is score:
        return replay
    return Replay(score, near(message["beat"]), replay if continues else None)


def note(replay: Replay, message: Sensed) -> None:
    """Add a change of a robot's sense to a replay."""
    replay.sense(message["robot"], message["sense"], message["value"], near(message["beat"]))


def _jumps(before: TransportMessage, message: TransportMessage) -> bool:
    """Return whether the position in a message differs from the prediction of the message before it."""
    expected = beat_at(before, message["monotonic"])
    return abs(message["beat"] - expected) > JUMP * message["tempo"] / 60
