"""The job of a stage that moves real robots through an output."""

from __future__ import annotations

from collections.abc import Callable
from typing import cast

from improv_core.ipc.channel import OutputChannel
from improv_core.protocol.commands import COMMANDS, Conduct, PageRequest
from improv_core.protocol.messages import VERSION, FromStage, Ready
from improv_core.protocol.output import Sink
from improv_core.stage.loop import OpenedOutput, run
from improv_core.stage.process import Hear, Job, SystemClock, Tell, perform, report_sent


def play(open_sink: Callable[[OutputChannel], Sink], name: str, *, reports: bool) -> int:
    """Play what standard input requests until it ends, as the stage of this `name`. If it `reports`, it tells the
    parent each velocity that it sends. Returns exit code 1 after a failure, 2 if the output can't be used."""

    def begin(put: Tell, hear: Hear) -> Job:
        def ask(command: PageRequest) -> None:
            if COMMANDS[command["type"]].at_once:
                hear(cast(Conduct, command))  # now, even if the parent hangs, or gets nothing before we are ready
            put({"type": "request", "command": command})

        def tell_both(message: FromStage) -> None:
            # A speed that was set before the first score is no news: the parent would take it for the end of a score.
            if message["type"] != "transport" or message["generation"]:
                sink.show(message)
                put(message)

        sink = open_sink(OutputChannel(hear, ask, lambda line: tell_both({"type": "warning", "message": line})))
        ready: Ready = {"type": "ready", "protocol": VERSION, "sink": sink.description, "real": True}
        opened = OpenedOutput(sink, tell_both, sink.announce)
        if reports:
            report_sent(sink, put)
        return Job(lambda inbox, parent: run(opened, inbox, SystemClock(), parent), ready)

    return perform(begin, name=name)
