"""Follows MIDI clock and reports its position (docs/protocol.md).

It is a process of its own, started by the parent: its library may hang or crash, and robots must not. It ends when its
standard input ends. `python …/improv_core/stage midi PORT`; mido is imported lazily.
"""

from __future__ import annotations

import queue
import sys
import time
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any

from improv_core.music.midi_time import MidiTime, heard
from improv_core.plain import message as in_plain_text
from improv_core.plain import one_line
from improv_core.protocol.clock_messages import AnchorMessage
from improv_core.protocol.json_lines import Lines, own_output
from improv_core.score.peer_clock import Anchor

if TYPE_CHECKING:  # a process that only hears a clock needs no score, and little memory
    from improv_core.protocol.helper_messages import FromClock

LOOK = 2.0
"""Seconds between two searches for inputs: they come and go with their cables."""
PATIENCE = 0.1
"""Seconds to wait for a message before checking whether to end."""
LACKS = 'MIDI clock needs two more packages: pip install "improv-ls[midi]"'


def main() -> int:
    """Report the clock's position until standard input ends. Exit code 1 if this machine has no MIDI."""
    lines: Lines[Any] = Lines()
    tell: Callable[[FromClock], None] = own_output()
    try:
        import mido

        mido.get_input_names()
    except ImportError:
        tell({"type": "error", "message": LACKS})
        return 1
    except Exception as error:  # whatever the system's library raises
        tell({"type": "error", "message": f"this machine has no MIDI: {one_line(error)}"})
        return 1
    listening = _Listening(mido, sys.argv[1] if len(sys.argv) > 1 else "", tell)
    looked, known = -LOOK, MidiTime()
    while not lines.ended:
        if (now := time.monotonic()) - looked >= LOOK:
            looked = now
            listening.look()
        for kind, position, at in listening.heard():
            known, anchor = heard(known, kind, position, at)
            if anchor:
                tell(to_message(anchor))
        for _ in lines.read():
            pass  # the parent only ever closes the pipe
    listening.close()
    return 0


def to_message(anchor: Anchor) -> AnchorMessage:
    """Convert an anchor to a message for stages."""
    return {
        "type": "anchor",
        "at": anchor.at,
        "beat": anchor.phase,
        "tempo": anchor.rate * 60,
        "period": anchor.period,
        "jumps": anchor.jumps,
    }


def chosen(names: Sequence[str], wanted: str) -> str | None:
    """The first input whose name begins with `wanted`; None if there is none."""
    return next((name for name in names if name.startswith(wanted)), None)


class _Listening:
    """Listens on an input while there is one."""

    def __init__(self, mido: Any, wanted: str, tell: Callable[[FromClock], None]) -> None:
        self._mido, self._wanted, self._tell = mido, wanted, tell
        self._port: Any = None
        self._inbox: queue.SimpleQueue[tuple[str, int, float]] = queue.SimpleQueue()
        self._latest_line = ""

    def look(self) -> None:
        """Open the input, or notice that it is gone."""
        try:
            names = self._mido.get_input_names()
            if self._port and self._port.name not in names:
                self._say(f"the MIDI input {self._port.name} is gone: connect it again")
                self.close()
            if not self._port and (name := chosen(names, self._wanted)) is not None:
                self._port = self._mido.open_input(name, callback=self._take)
                self._latest_line = ""
            elif not self._port:
                which = f"MIDI input whose name begins with {self._wanted}" if self._wanted else "MIDI input"
                others = f"there are {', '.join(names)}" if names else "connect one"
                self._say(f"there is no {which}: {others}")
        except Exception as error:  # whatever the system's library raises
            self._say(f"MIDI can't be heard: {one_line(error)}")

    def heard(self) -> list[tuple[str, int, float]]:
        """The messages that have arrived: their kinds, song positions, and times of arrival."""
        try:
            came = [self._inbox.get(timeout=PATIENCE)]
            while not self._inbox.empty():
                came.append(self._inbox.get())
        except queue.Empty:
            return []
        return came

    def close(self) -> None:
        port, self._port = self._port, None
        if port:
            port.close()

    def _take(self, message: Any) -> None:
        """Queue a message. A thread of the library calls this, and it must not wait."""
        self._inbox.put((message.type, getattr(message, "pos", 0), time.monotonic()))

    def _say(self, line: str) -> None:
        if line != self._latest_line:
            self._latest_line = line
            self._tell({"type": "warning", "message": in_plain_text(line)})
