"""A backend of mido whose only input is a named pipe: bytes written there arrive as on a cable. Its path is in
MIDI_CABLE, and the input is gone when the path is."""

from __future__ import annotations

import os
import threading
from pathlib import Path
from typing import Any

from mido.parser import Parser
from mido.ports import BaseInput

CABLE = Path(os.environ["MIDI_CABLE"])


def get_devices(**options: Any) -> list[dict[str, Any]]:
    return [{"name": "cable", "is_input": True, "is_output": False}] if CABLE.exists() else []


class Input(BaseInput):  # type: ignore[misc]
    """Like that of rtmidi, it has a thread that calls back."""

    _locking = False

    def _open(self, callback: Any, **options: Any) -> None:
        def read() -> None:
            parser = Parser()
            with CABLE.open("rb", buffering=0) as cable:
                while data := cable.read(64):
                    parser.feed(data)
                    for message in parser:
                        callback(message)

        threading.Thread(target=read, daemon=True).start()
