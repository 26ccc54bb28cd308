"""The stage's process: JSON lines in, velocities out. Whatever ends it, every robot is told to stop first.

Started as `python …/improv_core/stage`, perhaps by ROS's interpreter, where our package is not installed.
"""

from __future__ import annotations

import argparse
import errno
import gc
import json
import math
import os
import queue
import signal
import sys
import threading
import time
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

if __name__ == "__main__":
    # Python puts the folder it runs first on the path, where our modules would hide others of the same name;
    # the package goes last, so that it hides none of ROS's.
    here = Path(__file__).resolve().parent
    sys.path[:] = [entry for entry in sys.path if not entry or Path(entry).resolve() != here]
    sys.path.append(str(here.parent.parent))

from improv_core.score.motion import Twist
from improv_core.score.score import Score, from_json
from improv_core.stage.player import Player
from improv_core.stage.protocol import (
    LOADING_LIMIT,
    SILENCE_LIMIT,
    VERSION,
    FromStage,
    Load,
    ProtocolError,
    Ready,
    Stopped,
    ToStage,
    read_to_stage,
)
from improv_core.stage.sinks import Sink

LONG = 10_000
"""Bytes of a line from which on it counts as one that takes time to read."""

EARLY = 0.0004
"""Seconds before a command that a stage with real robots wakes up, to be awake when it is due: the system wakes it
0.2 ms late. It costs about 1 % of a core while something plays."""
SWITCH_INTERVAL = 0.0005
"""Seconds that a thread of ours may work while the player waits: a long score takes its reader a hundred times that."""

Tell = Callable[[FromStage], None]


@dataclass(frozen=True, slots=True)
class Play:
    """A `load` message whose score has been read."""

    load: Load
    score: Score


@dataclass(frozen=True, slots=True)
class Unreadable:
    """A line that is no message, or a score that can't be played: why, and whether it was a score."""

    problem: str
    was_score: bool = False


@dataclass(frozen=True, slots=True)
class Reading:
    """A long line has arrived. Until it has been read, pings behind it wait."""


@dataclass(frozen=True, slots=True)
class End:
    """Standard input has ended, or a signal asks the stage to end."""


Arrival = ToStage | Play | Unreadable | Reading | End
Inbox = queue.SimpleQueue[Arrival]


def main() -> int:
    """Play what standard input asks for until it ends. Exit code 1 after a failure, 2 if the sink can't be had."""
    options = _options()
    sys.setswitchinterval(SWITCH_INTERVAL)
    inbox: Inbox = queue.SimpleQueue()
    outbox: queue.SimpleQueue[FromStage | None] = queue.SimpleQueue()
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, lambda *_: inbox.put(End()))
    writer = threading.Thread(target=_write, args=(outbox,), daemon=True)
    writer.start()
    try:
        opened = _open(options, outbox.put)
    except Exception as error:  # whatever a sink's libraries raise, the one line that says so must get out
        outbox.put({"type": "error", "message": _one_line(error)})
        code = 2
    else:
        if options.report_sent:
            _report_sent(opened.sink, outbox.put)
        threading.Thread(target=_read, args=(inbox,), daemon=True).start()
        # Collections of garbage over all that has been imported would make commands late.
        gc.freeze()
        gc.set_threshold(50_000, 20, 100)
        opened.tell(opened.ready)
        code = _play(opened, inbox)
    outbox.put(None)
    writer.join(timeout=1)  # a parent that no longer reads must not keep us alive
    return code


def _options() -> argparse.Namespace:
    parser = argparse.ArgumentParser(prog="improv stage")
    parser.add_argument("--sink", choices=["simulator", "ros"], required=True)
    parser.add_argument("--port", type=int, default=0, help="the page's port; 0 for any free one")
    parser.add_argument("--discovery", help="ROS_AUTOMATIC_DISCOVERY_RANGE, where the environment does not say")
    parser.add_argument(
        "--takes-starts", action="store_true", help="starts that were dragged on the page can be written"
    )
    parser.add_argument("--report-sent", action="store_true", help="tell of every velocity that is sent")
    return parser.parse_args()


@dataclass(frozen=True, slots=True)
class _Opened:
    """A sink, what to say once it is ready, where everything said goes, and who is shown what is to be played."""

    sink: Sink
    ready: Ready
    tell: Tell
    show: Callable[[Score, int], None] = lambda score, generation: None


def _open(options: argparse.Namespace, put: Tell) -> _Opened:
    if options.sink == "ros":
        from improv_core.stage.sinks.ros import Ros

        ros = Ros(options.discovery)
        ready: Ready = {"type": "ready", "protocol": VERSION, "sink": ros.description, "live": True}
        return _Opened(ros, ready, put)

    from improv_core.stage.sinks.simulator import Simulator
    from improv_core.stage.viewer.server import Viewer

    simulator = Simulator()
    try:
        viewer = Viewer(
            options.port,
            simulator.snapshot,
            lambda command: put({"type": "request", "command": command}),
            takes_starts=options.takes_starts,
            # Not an argument: those can be read by every user of the machine.
            token=os.environ.get("IMPROV_PAGE_TOKEN"),
        )
    except OSError as error:
        if error.errno not in (errno.EADDRINUSE, errno.EACCES):
            raise
        raise OSError(f"the page's port {options.port} is taken: choose another, or 0 for any free one") from error

    def tell(message: FromStage) -> None:
        if message["type"] == "transport" or message["type"] == "stopped":
            viewer.publish(message)
        put(message)

    ready = {"type": "ready", "protocol": VERSION, "sink": simulator.name, "live": False, "page": viewer.url}
    return _Opened(simulator, ready, tell, viewer.show)


def _report_sent(sink: Sink, put: Tell) -> None:
    """Have a sink tell of everything it sends, also by itself; the time is taken just before."""
    send = sink.send

    def send_and_tell(robot: str, twist: Twist, at: float) -> None:
        wall = time.time_ns()
        send(robot, twist, at)
        put({"type": "sent", "robot": robot, "twist": [twist.x, twist.y, twist.z, twist.yaw], "wall": wall})

    sink.send = send_and_tell  # type: ignore[method-assign]


def _play(opened: _Opened, inbox: Inbox) -> int:
    sink, tell = opened.sink, opened.tell
    player = Player(sink, tell, time.time)
    last: Stopped = {"type": "stopped"}
    silent_from = math.inf  # when the parent, if it has pinged at all, counts as hung
    try:
        while True:
            now = time.monotonic()
            deadline = min(player.deadline(now) or math.inf, silent_from)
            early = EARLY if sink.live else 0.0
            try:
                message = inbox.get(timeout=max(deadline - early - now, 0) if deadline < math.inf else None)
            except queue.Empty:
                while (now := time.monotonic()) < deadline and early:
                    pass
                if now >= silent_from:
                    silent_from = math.inf
                    _stop_for_silence(player, tell, now)
                player.advance(now)
                continue
            if isinstance(message, End):
                return 0
            pinged = isinstance(message, dict) and message["type"] == "ping"
            if sink.live and (pinged or silent_from < math.inf):
                silent_from = time.monotonic() + (LOADING_LIMIT if isinstance(message, Reading) else SILENCE_LIMIT)
            if isinstance(message, Unreadable):
                tell({"type": "error", "message": message.problem})
                if message.was_score:
                    player.hush(time.monotonic())
            elif not isinstance(message, Reading):
                _obey(player, message, opened)
    except Exception as error:
        last["message"] = _one_line(error)
        return 1
    finally:
        _stop(player)
        tell({**last, **player.whereabouts()})
        sink.close()


def _stop(player: Player) -> None:
    """Send every robot its last zeros, as far as the sink still can."""
    with suppress(Exception):
        if player.state in ("playing", "waiting"):  # else they stand already, and belong to whoever moves them next
            player.hush(time.monotonic())
        while (deadline := player.deadline(now := time.monotonic())) is not None:
            time.sleep(max(deadline - now, 0))
            player.advance(time.monotonic())


def _stop_for_silence(player: Player, tell: Tell, now: float) -> None:
    if player.state in ("playing", "waiting"):
        player.hush(now)
        what = f"Improv was halted or hung for {SILENCE_LIMIT} s, so all robots were stopped: save to play again"
        tell({"type": "error", "message": what})


def _obey(player: Player, asked: ToStage | Play, opened: _Opened) -> None:
    """Do what a message asks for. What goes wrong ends the stage, which stops the robots; a score is only refused."""
    now = time.monotonic()
    message = asked.load if isinstance(asked, Play) else asked
    if message["type"] == "ping":
        opened.tell({"type": "pong", "number": message["number"]})
        return
    # All stages act as of the time of the request, but what has been sent since can't be taken back.
    at = max(min(message.get("at", now), now), player.reached)
    if isinstance(asked, Play):
        _load(player, asked, at, opened)
    elif message["type"] == "hush":
        player.hush(now)
    elif message["type"] == "pause":
        player.pause(at)
    elif message["type"] == "resume":
        player.resume(at)
    elif message["type"] == "seek":
        player.seek(message["beat"], at)
    elif message["type"] == "speed":
        player.set_speed(message["factor"], at)
    elif message["type"] == "silence":
        player.set_silent(message["muted"], message["soloed"], at)


def _load(player: Player, asked: Play, at: float, opened: _Opened) -> None:
    load, score = asked.load, asked.score
    try:
        player.backend = load["backend"]
        opened.show(score, load["generation"])
        player.load(score, load["generation"], load["when"], at, load.get("zero"))
    except Exception as error:
        opened.tell({"type": "error", "message": f"this program can't be played: {_one_line(error)}"})
        player.hush(time.monotonic())


def _read(inbox: Inbox) -> None:
    """Every line of standard input is a message; its end, also in the middle of a line, ends the stage."""
    # A file of our own: at its end Python waits for the lock of its own, which a thread that reads never lets go.
    for line in open(0, "rb", closefd=False):  # noqa: SIM115
        if not line.endswith(b"\n"):
            break
        if len(line) > LONG:
            inbox.put(Reading())
        inbox.put(_message(line))
    inbox.put(End())


def _message(line: bytes) -> Arrival:
    """What a line says. Scores are read here, on the thread that reads lines, so that what plays goes on meanwhile."""
    try:
        message = read_to_stage(line)
    except ProtocolError as error:
        return Unreadable(str(error))
    if message["type"] != "load":
        return message
    try:
        return Play(message, from_json(message["score"]))
    except Exception as error:  # whatever is wrong with it, robots must not go on as if nothing had been asked for
        return Unreadable(f"this program can't be played: {_one_line(error)}", was_score=True)


def _write(outbox: queue.SimpleQueue[FromStage | None]) -> None:
    """On a thread of its own: a full pipe must not hold up the player."""
    while (message := outbox.get()) is not None:
        try:
            sys.stdout.write(json.dumps(message) + "\n")
            sys.stdout.flush()
        except OSError:  # the parent is gone; the end of standard input says so too
            return


def _one_line(error: Exception) -> str:
    return " ".join(str(error).split()) or type(error).__name__


if __name__ == "__main__":
    sys.exit(main())
