"""A stage's standard input and output: lines of JSON that become arrivals, and messages that become lines."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import cast

from improv_core.ipc.arrivals import Arrival, DirectStop, End, First, Lost, Unreadable, UrgentQueue
from improv_core.plain import one_line
from improv_core.player.setpoint_queue import setpoints
from improv_core.protocol.commands import Stop
from improv_core.protocol.decoding import LONG, ProtocolError, read_as
from improv_core.protocol.limits import LONGEST_LINE
from improv_core.protocol.messages import DIRECT, FromStage, Play, ToStage, after, read_first
from improv_core.protocol.page_messages import ForPages
from improv_core.safety.heartbeat import Parent
from improv_core.score.score_json import LackingError, RowsRead, from_json

TOO_LONG = Unreadable(f"this program can't be played: it is longer than {LONGEST_LINE // 1_000_000} MB", is_score=True)


def read_arrivals(
    inbox: UrgentQueue[Arrival], parent: Parent | None, hand_to_pages: Callable[[ForPages], None]
) -> None:
    """Put the arrivals from standard input into the inbox, and note that the `parent` lives, unless it proves that on a
    channel of its own. Messages for pages go to these instead. The end of the input, even in the middle of a line, ends
    the stage, and so does any exception here: a stage that no longer reads could not be stopped."""
    problem, read = "", RowsRead()
    try:
        # Not sys.stdin: when Python ends, it waits for the lock of that file, which a reading thread never releases.
        with open(0, "rb", closefd=False) as stream:
            while (line := stream.readline(LONGEST_LINE)).endswith(b"\n") or len(line) == LONGEST_LINE:
                if not line.endswith(b"\n"):
                    while (rest := stream.readline(LONGEST_LINE)) and not rest.endswith(b"\n"):
                        pass
                    inbox.put(TOO_LONG)
                    continue
                if parent and len(line) > LONG:
                    parent.reading(time.monotonic())
                said = arrival(line, read)
                if parent:
                    parent.speaks(time.monotonic(), pings=isinstance(said, dict) and said["type"] == "ping")
                if isinstance(said, dict) and said["type"] == "page":
                    hand_to_pages(cast(ForPages, said["message"]))
                else:
                    inbox.put(said)
    except BaseException as error:
        problem = f"the stage can't read its input: {one_line(error)}"
    finally:
        inbox.put(End(problem))


def read_stops(pipe: int, inbox: UrgentQueue[Arrival], parent: Parent, tell: Callable[[FromStage], None]) -> None:
    """Put the stops, pauses, and pings from their own channel into the inbox, ahead of all that waits, and note that
    the parent lives. The end of the channel ends the stage at once, even if standard input has yet to bring a long
    score.

    On a host, a stop that somebody else has sent straight to the stage comes there, too: `tell` confirms it.
    """
    problem = ""
    try:
        with open(pipe, "rb", closefd=False) as stream:
            for line in stream:
                message, number = read_first(line)
                if message["type"] == "stop" and number == DIRECT:
                    inbox.put_first(direct(message, tell))
                    continue
                parent.speaks(time.monotonic(), pings=message["type"] == "ping")
                inbox.put_first(First(message, number))
    except BaseException as error:
        problem = f"the stage can't read stops: {one_line(error)}"
    finally:
        inbox.put_first(End(problem))


def direct(stop: Stop, tell: Callable[[FromStage], None]) -> DirectStop:
    """Return the arrival of a stop that has come straight to a stage on a host, and that `tell` confirms."""
    name = stop.get("direct", "")
    own: Stop = {"type": "stop", "direct": name}
    if "by" in stop:
        own["by"] = stop["by"]
    return DirectStop(own, lambda: tell({"type": "obeyed", "direct": name}))


def arrival(line: bytes, read: RowsRead) -> Arrival:
    """Return the arrival in a line. `read` has the movements of earlier lines.

    Scores are read and tried here, on the thread that reads lines, so that playback continues meanwhile.
    """
    try:
        message: ToStage = read_as(line, ToStage)
    except ProtocolError as error:
        return Unreadable(str(error))
    if message["type"] != "load":
        return message
    try:
        before = read.parts
        score = from_json(message["score"], read)
        score.seconds(score.beats)
        for robot, part in score.parts.items():
            if before.get(robot) is not part:
                for scene in part.scenes:
                    next(setpoints(part.profile, scene, score.tempo), None)
        return Play(message, score)
    except LackingError:
        return Lost(message["generation"], after(message))
    except Exception as error:  # whatever it is, robots must not keep moving as if nothing had been requested
        return Unreadable(f"this program can't be played: {one_line(error)}", is_score=True)


Outbox = UrgentQueue[FromStage | None]
"""Messages to the parent, and None after the last one. Any thread may put messages in; one gets them."""


def put(outbox: Outbox, message: FromStage) -> None:
    """Send the parent a message. Answers to pings overtake all others: a parent that is slow to read the velocities of
    a thousand robots must not consider their stage hung."""
    (outbox.put_first if message["type"] == "pong" else outbox.put)(message)


def write_messages(outbox: Outbox, say: Callable[[FromStage], None]) -> None:
    """Write each message, until None. This has its own thread, so that a full pipe can't delay the player."""
    while (message := outbox.get()) is not None:
        say(message)
