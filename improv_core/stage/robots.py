"""The job of the stage that moves real robots over ROS 2 (rclpy, imported lazily)."""

from __future__ import annotations

from collections.abc import Sequence
from typing import cast

from improv_core.outputs.ros.output import RosSink
from improv_core.outputs.ros.standby.client import Standby
from improv_core.protocol.commands import COMMANDS, Conduct, PageRequest
from improv_core.protocol.messages import VERSION, FromStage, Ready
from improv_core.stage.loop import OpenedOutput, run
from improv_core.stage.process import Hear, Job, SystemClock, Tell, perform, report_sent


def play(standby: Standby, node: str | None, arguments: Sequence[str], *, reports: bool) -> int:
    """Play what standard input requests until it ends, with ROS's `arguments`. If it `reports`, it tells the parent
    each velocity that it sends. Returns exit code 1 after a failure, 2 if ROS 2 can't be used."""

    def begin(put: Tell, hear: Hear) -> Job:
        def ask(command: PageRequest) -> None:
            if COMMANDS[command["type"]].at_once:
                hear(cast(Conduct, command))  # now, even if the parent hangs, or gets nothing before we are ready
            put({"type": "request", "command": command})

        ros = RosSink(standby, hear, ask, node, arguments, lambda line: tell_both({"type": "warning", "message": line}))

        def tell_both(message: FromStage) -> None:
            # A speed that was set before the first score is no news: the parent would take it for the end of a score.
            if message["type"] != "transport" or message["generation"]:
                ros.show(message)
                put(message)

        ready: Ready = {"type": "ready", "protocol": VERSION, "sink": ros.description, "real": True}
        opened = OpenedOutput(ros, tell_both, ros.announce, guard=ros.guard, pending_zeros=ros.pending_zeros)
        if reports:
            report_sent(ros, put)
        return Job(lambda inbox, parent: run(opened, inbox, SystemClock(), parent), ready)

    return perform(begin)
