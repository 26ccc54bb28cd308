"""Performances by a clock that jumps from one command to the next: as fast as they can be computed."""

from __future__ import annotations

import json
import signal
import time
from collections.abc import Callable
from dataclasses import asdict
from pathlib import Path
from typing import Any

import click

from improv_core.commands.terminal import WRONG_PROGRAM, tell_diagnostics
from improv_core.program.compiler import score_of
from improv_core.program.files import ReadError, analyze_file
from improv_core.program.report import outcome, summary
from improv_core.score.movement import ENDLESS
from improv_core.score.score import Score
from improv_core.stage.player import Player
from improv_core.stage.sinks import Sink


def perform(
    score: Score,
    sink: Sink,
    seconds: float | None = None,
    tell: Callable[[dict[str, Any]], None] = lambda message: None,
) -> None:
    """Have a player send a score, or its first seconds, to a sink, and tell what it says (docs/protocol.md)."""
    player = Player(sink, tell, lambda: 0.0)
    now = 0.0
    player.load(score, 1, "restart", now)
    while (deadline := player.deadline(now)) is not None:
        now = max(now, deadline)
        if seconds is not None and now >= seconds and player.state == "playing":
            now = seconds
            player.hush(now)
        else:
            player.advance(now)


def rehearse(path: Path, seconds: float | None, *, report: bool) -> int:
    """Play a program in the simulator without a page, faster than real time; the exit code. Raises ReadError."""
    from improv_core.stage.sinks.simulator import Simulator

    analysis = analyze_file(path)
    tell_diagnostics(path, analysis)
    if not analysis.ok:
        return WRONG_PROGRAM
    score = score_of(analysis)
    if score.beats == ENDLESS and seconds is None:
        raise ReadError("this program never ends: say how much of it to play, as in `--for 60` (seconds)")
    last: dict[str, Any] = {}

    def tell(message: dict[str, Any]) -> None:
        if message["type"] == "transport":
            last.update(message)
        else:
            click.echo(f"improv: {message['message']}", err=True)

    # Ctrl-C ends it at once, also where a shell has had that ignored: there is nothing to put in order, and pymunk
    # would swallow a KeyboardInterrupt raised while it calls us.
    signal.signal(signal.SIGINT, signal.SIG_DFL)
    began = time.perf_counter()
    simulator = Simulator(period=None)
    perform(score, simulator, seconds, tell)
    ended = outcome({**last, "poses": {robot: asdict(pose) for robot, pose in simulator.poses().items()}})
    if report:
        click.echo(json.dumps(ended))
    else:
        took = time.perf_counter() - began
        click.echo(f"{summary(analysis)}: {ended['seconds']:.1f} s, played in {took:.2f} s")
    return 0
