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
from collections.abc import Callable, Mapping
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any

if __name__ == "__main__":
    # Python puts the folder it runs first on the path, where our modules would hide others of the same name;
    # the package goes last, so that it hides none of ROS's.
    here = Path(__file__).resolve().parent
    sys.path[:] = [entry for entry in sys.path if not entry or Path(entry).resolve() != here]
    sys.path.append(str(here.parent.parent))

from improv_core.score.motion import Twist
from improv_core.score.score import Score, from_json
from improv_core.stage.player import Player
from improv_core.stage.sinks import Sink

VERSION = 1
"""The protocol's version: docs/protocol.md."""

SILENCE_LIMIT = 0.5
"""Seconds without a ping after which the parent counts as hung: nobody could stop the real robots any more."""
READING_LIMIT = 10.0
"""The same while a score is read, and the pings behind it are not. The parent too has as much patience."""

LONG = 10_000
"""Bytes of a line from which on it counts as one that takes time to read."""

EARLY = 0.0004
"""Seconds before a command that a stage with real robots wakes up, to be awake when it is due: the system wakes it
0.2 ms late. It costs about 1 % of a core while something plays."""
SWITCH_INTERVAL = 0.0005
"""Seconds that a thread of ours may work while the player waits: a long score takes its reader a hundred times that."""

Message = Mapping[str, Any]
Tell = Callable[[dict[str, Any]], None]


def main() -> int:
    """Play what standard input asks for until it ends. Exit code 1 after a failure, 2 if the sink can't be had."""
    options = _options()
    sys.setswitchinterval(SWITCH_INTERVAL)
    inbox: queue.SimpleQueue[Message] = queue.SimpleQueue()
    outbox: queue.SimpleQueue[dict[str, Any] | None] = queue.SimpleQueue()
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, lambda *_: inbox.put({"type": "end"}))
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
        "--takes-start-poses", action="store_true", help="start poses dragged on the page can be written"
    )
    parser.add_argument("--report-sent", action="store_true", help="tell of every velocity that is sent")
    return parser.parse_args()


@dataclass(frozen=True, slots=True)
class _Opened:
    """A sink, what to say once it is ready, where everything said goes, and who is shown what is to be played."""

    sink: Sink
    ready: dict[str, Any]
    tell: Tell
    show: Callable[[Score, int], None] = lambda score, generation: None


def _open(options: argparse.Namespace, put: Tell) -> _Opened:
    ready = {"type": "ready", "protocol": VERSION, "live": options.sink == "ros"}
    if options.sink == "ros":
        from improv_core.stage.sinks.ros import Ros

        ros = Ros(options.discovery)
        return _Opened(ros, {**ready, "sink": ros.description}, put)

    from improv_core.stage.sinks.simulator import Simulator
    from improv_core.stage.viewer.server import Viewer

    simulator = Simulator()
    try:
        viewer = Viewer(
            options.port,
            simulator.snapshot,
            lambda command: put({"type": "request", "command": command}),
            takes_start_poses=options.takes_start_poses,
            # Not an argument: those can be read by every user of the machine.
            token=os.environ.get("IMPROV_PAGE_TOKEN"),
        )
    except OSError as error:
        if error.errno not in (errno.EADDRINUSE, errno.EACCES):
            raise
        raise OSError(f"the page's port {options.port} is taken: choose another, or 0 for any free one") from error

    def tell(message: dict[str, Any]) -> None:
        viewer.publish(message)
        put(message)

    return _Opened(simulator, {**ready, "sink": simulator.name, "page": viewer.url}, tell, viewer.show)


def _report_sent(sink: Sink, put: Tell) -> None:
    """Have a sink tell of everything it sends, also by itself; the time is taken just before."""
    send = sink.send

    def send_and_tell(robot: str, twist: Twist, at: float) -> None:
        wall = time.time_ns()
        send(robot, twist, at)
        put({"type": "sent", "robot": robot, "twist": [twist.x, twist.y, twist.z, twist.yaw], "wall": wall})

    sink.send = send_and_tell  # type: ignore[method-assign]


def _play(opened: _Opened, inbox: queue.SimpleQueue[Message]) -> int:
    sink, tell = opened.sink, opened.tell
    player = Player(sink, tell, time.time)
    last: dict[str, Any] = {"type": "stopped"}
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
            if message["type"] == "end":
                return 0
            reading = message["type"] == "reading"
            if sink.live and (message["type"] == "ping" or silent_from < math.inf):
                silent_from = time.monotonic() + (READING_LIMIT if reading else SILENCE_LIMIT)
            if not reading:
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


def _obey(player: Player, message: Message, opened: _Opened) -> None:
    kind, now = message["type"], time.monotonic()
    try:
        # All stages do a thing as of the time it was asked for; what has been sent since can't be taken back.
        at = max(min(float(message.get("at", now)), now), player.reached)
        obey = _asked_for(message, opened)
    except (KeyError, TypeError, ValueError) as error:
        opened.tell({"type": "error", "message": f"the stage can't make sense of {kind!r}: {_one_line(error)}"})
        return
    if obey:
        obey(player, at)  # what goes wrong from here on ends the stage, which stops the robots
    else:
        opened.tell({"type": "error", "message": f"the stage does not know the message {kind!r}"})


def _asked_for(message: Message, opened: _Opened) -> Callable[[Player, float], None] | None:
    """What a message asks for. Raises KeyError, TypeError or ValueError where it makes no sense."""
    match message["type"]:
        case "load":
            score, generation = message["score"], int(message["generation"])
            backend, when, zero = str(message["backend"]), str(message["when"]), message.get("zero")
            zero = None if zero is None else float(zero)

            def load(player: Player, at: float) -> None:
                player.backend = backend
                opened.show(score, generation)
                player.load(score, generation, when, at, zero)

            return load
        case "hush":
            return lambda player, at: player.hush(time.monotonic())
        case "pause":
            return Player.pause
        case "resume":
            return Player.resume
        case "seek":
            beat = float(message["beat"])
            return lambda player, at: player.seek(beat, at)
        case "speed":
            factor = float(message["factor"])
            return lambda player, at: player.set_speed(factor, at)
        case "silence":
            muted, soloed = frozenset(message["muted"]), frozenset(message["soloed"])
            return lambda player, at: player.set_silent(muted, soloed, at)
        case "ping":
            return lambda player, at: opened.tell({"type": "pong", "number": message.get("number")})
    return None


def _read(inbox: queue.SimpleQueue[Message]) -> None:
    """Every line of standard input is a message; its end, also in the middle of a line, ends the stage."""
    # A file of our own: at its end Python waits for the lock of its own, which a thread that reads never lets go.
    for line in open(0, "rb", closefd=False):  # noqa: SIM115
        if not line.endswith(b"\n"):
            break
        if len(line) > LONG:
            inbox.put({"type": "reading"})
        inbox.put(_message(line))
    inbox.put({"type": "end"})


def _message(line: bytes) -> Message:
    """What a line says. A score is read here, on the thread that reads lines, so that what plays goes on meanwhile."""
    try:
        message = json.loads(line)
    except ValueError:
        return {"type": "no JSON"}
    if not isinstance(message, dict) or "type" not in message:
        return {"type": "no message"}
    if message["type"] != "load":
        return message
    try:
        return {**message, "score": from_json(message["score"])}
    except (KeyError, TypeError, ValueError):
        return {"type": "no score"}


def _write(outbox: queue.SimpleQueue[dict[str, Any] | None]) -> None:
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
