"""Keys that are pressed in the terminal while something plays."""

from __future__ import annotations

import asyncio
import contextlib
import os
import sys
from collections.abc import Callable, Iterator, Mapping


@contextlib.contextmanager
def pressed(keys: Mapping[str, Callable[[], None]]) -> Iterator[None]:
    """Call what belongs to a key when it is pressed, without Enter. Only in a terminal, and not in the background."""
    if os.name == "nt" or not (sys.stdin and sys.stdin.isatty()) or os.tcgetpgrp(sys.stdin.fileno()) != os.getpgrp():
        yield
        return
    import termios
    import tty

    terminal, loop = sys.stdin.fileno(), asyncio.get_running_loop()
    before = termios.tcgetattr(terminal)

    def read() -> None:
        typed = os.read(terminal, 1024).decode(errors="replace")
        if not typed:  # the terminal is gone
            loop.remove_reader(terminal)
        for key in typed:
            if act := keys.get(key):
                act()

    tty.setcbreak(terminal, termios.TCSANOW)  # Ctrl-C still interrupts
    loop.add_reader(terminal, read)
    try:
        yield
    finally:
        loop.remove_reader(terminal)
        with contextlib.suppress(termios.error):  # it is gone
            termios.tcsetattr(terminal, termios.TCSANOW, before)
