"""A stage's standard input and output: lines of JSON that become arrivals, and messages that become lines."""

from __future__ import annotations

import json
import queue
import sys

from improv_core.score.score import from_json
from improv_core.stage.inbox import Inbox
from improv_core.stage.loop import Arrival, End, Play, Reading, Unreadable, one_line
from improv_core.stage.protocol import FromStage, ProtocolError, read_to_stage
from improv_core.stage.setpoints import setpoints

LONG = 10_000
"""Bytes from which on a line counts as one that takes time to read."""


def read_arrivals(inbox: Inbox) -> None:
    """Put in what each line of standard input says; its end, also in the middle of a line, ends the stage."""
    # A file of our own: at its end Python waits for the lock of its own, which a thread that reads never lets go.
    for line in open(0, "rb", closefd=False):  # noqa: SIM115
        if not line.endswith(b"\n"):
            break
        if len(line) > LONG:
            inbox.put(Reading())
        inbox.put(arrival(line))
    inbox.put(End())


def arrival(line: bytes) -> Arrival:
    """What a line says.

    Scores are read and tried here, on the thread that reads lines, so that what plays goes on meanwhile.
    """
    try:
        message = read_to_stage(line)
    except ProtocolError as error:
        return Unreadable(str(error))
    if message["type"] != "load":
        return message
    try:
        score = from_json(message["score"])
        score.seconds(score.beats)
        for part in score.parts.values():
            next(setpoints(part, score.tempo), None)
        return Play(message, score)
    except Exception as error:  # whatever is wrong with it, robots must not go on as if nothing had been asked for
        return Unreadable(f"this program can't be played: {one_line(error)}", is_score=True)


def write_messages(outbox: queue.SimpleQueue[FromStage | None]) -> None:
    """Write each message as a line, until None. On a thread of its own: a full pipe must not hold up the player."""
    while (message := outbox.get()) is not None:
        try:
            sys.stdout.write(json.dumps(message) + "\n")
            sys.stdout.flush()
        except OSError:  # the parent is gone; the end of standard input says so too
            return
