"""Performances whose clock jumps from one setpoint to the next: as fast as they can be computed."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

from improv_core.commands.exit_codes import CommandError
from improv_core.player.player import Player
from improv_core.protocol.messages import FromStage, Load, Play, Sensed
from improv_core.protocol.output import Sink
from improv_core.score.movement import ENDLESS
from improv_core.score.score import Score


def check_end(score: Score, seconds: float | None) -> None:
    """Raise CommandError if neither a score nor a number of seconds ends a performance."""
    if score.beats == ENDLESS and seconds is None:
        raise CommandError("this program never ends: limit it, for example with `--for 60` (seconds)")


def perform(
    score: Score,
    sink: Sink,
    seconds: float | None = None,
    tell: Callable[[FromStage], None] = lambda message: None,
    senses: Sequence[Sensed] | None = None,
) -> None:
    """Have a player send a score, or its first seconds, to a sink; `tell` gets its messages (docs/protocol.md).

    With `senses`, robots sense these and nothing else. The player follows no clock from outside and counts no bar,
    because nobody waits for a beat.
    """
    player = Player(sink, tell, lambda: 0.0)
    now = 0.0
    load: Load = {"type": "load", "generation": 1, "score": {}, "when": "restart", "backend": ""}
    if senses is not None:
        load["senses"] = senses
    player.take(Play(load, replace(score, clock=None, count_in=False)), now)
    while (deadline := player.deadline(now)) is not None:
        now = max(now, deadline)
        if seconds is not None and now >= seconds and player.run.mode == "playing":
            now = seconds
            player.take({"type": "stop"}, now)
        else:
            player.advance(now)
