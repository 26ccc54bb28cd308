"""The stage's process: JSON lines in, velocities out. Whatever ends it, every robot is told to stop first.

Started as `python …/improv_core/stage`, perhaps by ROS's interpreter, where our package is not installed.
"""

from __future__ import annotations

import argparse
import json
import os
import queue
import signal
import sys
import threading
import time
from collections.abc import Callable, Mapping
from contextlib import suppress
from pathlib import Path
from typing import Any

if __name__ == "__main__":
    # Python puts the folder it runs first on the path, where our modules would hide others of the same name;
    # the package goes last, so that it hides none of ROS's.
    here = Path(__file__).resolve().parent
    sys.path[:] = [entry for entry in sys.path if not entry or Path(entry).resolve() != here]
    sys.path.append(str(here.parent.parent))

from improv_core.score import from_json
from improv_core.stage.player import Player
from improv_core.stage.sinks import Sink

VERSION = 1
"""The protocol's version: docs/protocol.md."""

Message = Mapping[str, Any]
Tell = Callable[[dict[str, Any]], None]


def main() -> int:
    """Play what standard input asks for until it ends. Exit code 1 after a failure, 2 if the sink can't be had."""
    options = _options()
    inbox: queue.SimpleQueue[Message] = queue.SimpleQueue()
    outbox: queue.SimpleQueue[dict[str, Any] | None] = queue.SimpleQueue()
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, lambda *_: inbox.put({"type": "end"}))
    writer = threading.Thread(target=_write, args=(outbox,), daemon=True)
    writer.start()
    try:
        sink, ready, tell = _open(options, outbox.put)
    except Exception as error:  # whatever a sink's libraries raise, the one line that says so must get out
        outbox.put({"type": "error", "message": _one_line(error)})
        code = 2
    else:
        threading.Thread(target=_read, args=(inbox,), daemon=True).start()
        tell(ready)
        code = _play(sink, inbox, tell)
    outbox.put(None)
    writer.join(timeout=1)  # a parent that no longer reads must not keep us alive
    return code


def _options() -> argparse.Namespace:
    parser = argparse.ArgumentParser(prog="improv stage")
    parser.add_argument("--sink", choices=["simulator", "ros"], required=True)
    parser.add_argument("--port", type=int, default=0, help="the page's port; 0 for any free one")
    parser.add_argument("--discovery", help="ROS_AUTOMATIC_DISCOVERY_RANGE, where the environment does not say")
    return parser.parse_args()


def _open(options: argparse.Namespace, put: Tell) -> tuple[Sink, dict[str, Any], Tell]:
    """The sink, what to say once it is ready, and where everything said goes."""
    ready = {"type": "ready", "protocol": VERSION}
    if options.sink == "ros":
        from improv_core.stage.sinks.ros import Ros

        ros = Ros(options.discovery)
        return ros, {**ready, "sink": ros.description}, put

    from improv_core.stage.sinks.simulator import Simulator
    from improv_core.stage.viewer.server import Viewer

    simulator = Simulator()
    try:
        viewer = Viewer(
            options.port,
            simulator.snapshot,
            lambda command: put({"type": "request", "command": command}),
            os.environ.get("IMPROV_PAGE_TOKEN"),  # not an argument: those can be read by every user of the machine
        )
    except OSError as error:
        raise OSError(f"the page's port {options.port} is taken: choose another, or 0 for any free one") from error

    def tell(message: dict[str, Any]) -> None:
        viewer.publish(message)
        put(message)

    return simulator, {**ready, "sink": simulator.name, "page": viewer.url}, tell


def _play(sink: Sink, inbox: queue.SimpleQueue[Message], tell: Tell) -> int:
    player = Player(sink, tell, time.time)
    try:
        while True:
            now = time.monotonic()
            deadline = player.deadline(now)
            try:
                message = inbox.get(timeout=None if deadline is None else max(deadline - now, 0))
            except queue.Empty:
                player.advance(time.monotonic())
                continue
            if message["type"] == "end":
                return 0
            _obey(player, message, tell)
    except Exception as error:
        tell({"type": "error", "message": f"the stage stopped: {_one_line(error)}"})
        return 1
    finally:
        _stop(player)
        tell({"type": "stopped"})
        sink.close()


def _stop(player: Player) -> None:
    """Send every robot its last zeros, as far as the sink still can."""
    with suppress(Exception):
        if player.state == "playing":  # else they stand already, and belong to whoever moves them next
            player.hush(time.monotonic())
        while (deadline := player.deadline(now := time.monotonic())) is not None:
            time.sleep(max(deadline - now, 0))
            player.advance(time.monotonic())


def _obey(player: Player, message: Message, tell: Tell) -> None:
    kind, now = message["type"], time.monotonic()
    if kind == "load":
        try:
            score = from_json(message["score"])
            generation, when, zero = int(message["generation"]), str(message["when"]), message.get("zero")
            player.backend = str(message["backend"])
        except (KeyError, TypeError, ValueError) as error:
            tell({"type": "error", "message": f"this is no score: {_one_line(error)}"})
            return
        player.load(score, generation, when, now, zero)
    elif kind == "hush":
        player.hush(now)
    elif kind == "ping":
        tell({"type": "pong"})
    else:
        tell({"type": "error", "message": f"the stage does not know the message {kind!r}"})


def _read(inbox: queue.SimpleQueue[Message]) -> None:
    """Every line of standard input is a message; its end, also in the middle of a line, ends the stage."""
    # A file of our own: at its end Python waits for the lock of its own, which a thread that reads never lets go.
    for line in open(0, "rb", closefd=False):  # noqa: SIM115
        if not line.endswith(b"\n"):
            break
        try:
            message = json.loads(line)
            inbox.put(message if isinstance(message, dict) and "type" in message else {"type": "no message"})
        except ValueError:
            inbox.put({"type": "no JSON"})
    inbox.put({"type": "end"})


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
