"""Publishes the forecast for rviz, Foxglove, and monitors: paths, markers, the position, diagnostics, and messages.

It is a process of its own, because publishing a path takes longer than commands can wait. The stage starts it with its
own interpreter, as `python …/improv_core/stage publisher`. Standard library only (rclpy imported lazily).
"""

from __future__ import annotations

import gc
import os
import select
import sys
import time
from collections.abc import Callable
from typing import TYPE_CHECKING

from improv_core.preview.forecast import Forecast
from improv_core.protocol.helper_messages import FromPublisher, Health, ToPublisher
from improv_core.protocol.json_lines import Lines, own_output
from improv_core.score.score_json import RowsRead, from_json

if TYPE_CHECKING:
    from improv_core.outputs.ros.publisher.topics import Publications

NICENESS = 10
"""The process's niceness. If all processors are busy, it comes last."""
MARKER_PERIOD = 0.1
"""Seconds between two markers of a robot that moves."""
PERIOD = 1.0
"""Seconds between two paths of a robot, or messages about what stands. REP 107 has diagnostics once a second."""


def main() -> int:
    """Publish the stage's messages from standard input, until that ends. On failure, report the error."""
    lines: Lines[ToPublisher] = Lines()
    say: Callable[[FromPublisher], None] = own_output()
    os.nice(NICENESS)
    try:
        from improv_core.outputs.ros.publisher.topics import Publications

        publications = Publications(sys.argv[1], sys.argv[2:])
        gc.freeze()
        _publish(publications, lines)
    except Exception as error:  # whatever rclpy raises
        say({"type": "error", "message": f"{type(error).__name__}: {error}"})
        return 1
    publications.close()
    return 0


def _publish(publications: Publications, lines: Lines[ToPublisher]) -> None:
    forecast, read = Forecast(), RowsRead()
    health: Health = {"type": "health", "late": 0.0, "missing": {}, "clipped": []}
    due = 0.0  # when everything is published again
    while not lines.ended:
        select.select([0], [], [], MARKER_PERIOD)
        for message in lines.read():
            if message["type"] == "plays":
                forecast.add_score(from_json(message["score"], read), message["generation"])
            elif message["type"] == "transport" or message["type"] == "sensed":
                forecast.take(message)
                due = 0.0
            elif message["type"] == "measured":
                forecast.take(message)
            elif message["type"] == "health":
                health = message
            elif message["type"] == "fault":
                forecast.note_fault(message)
                if message["line"]:
                    publications.log("error" if message["response"] == "stop" else "warning", message["line"])
            else:
                publications.log(message["type"], message["message"])
        now = time.monotonic()
        publications.spin()
        if now >= due:
            due = now + PERIOD
            forecast.compute(now)
            publications.publish(forecast, health, now)
            health = {**health, "late": 0.0}
        elif forecast.is_moving:
            publications.publish_markers(forecast, now)
