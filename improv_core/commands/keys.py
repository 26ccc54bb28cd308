"""Keys with which a person controls a performance in the terminal, and the lines that name them."""

from __future__ import annotations

import asyncio
import contextlib
import os
import sys
import time
import webbrowser
from collections.abc import Callable, Iterator, Mapping
from datetime import datetime
from typing import Literal

from improv_core.commands.begin_time import in_words
from improv_core.commands.screen import Screen
from improv_core.page.browser import has_browser
from improv_core.protocol.messages import Armed, TransportMessage
from improv_core.protocol.robot_messages import Resumes
from improv_core.protocol.transport import counted
from improv_core.session.session import Playback

HINT = "o or Enter opens the page again, Ctrl-C ends"
"""Last line of the terminal while it reads keys: an address works only once."""
HINT_RESUMES = "r resumes from this scene, b from this beat, Ctrl-C ends"
"""Last line of the terminal after a stop that nobody asked for."""
HINT_ARMED = "Space or Enter begins, Ctrl-C ends"
"""Last line of the terminal while a program is armed."""


class Keyboard:
    """The functions of keys, and the last line of the `screen`, which names those that do something now."""

    def __init__(self, playback: Callable[[], Playback], screen: Screen) -> None:
        self._playback = playback
        self._screen = screen
        self.hears = False
        """True if the terminal hears keys."""
        self._opening: set[asyncio.Task[None]] = set()
        self.resumes: Resumes | None = None
        """The beats from which a key has robots continue."""

    def functions(self) -> Mapping[str, Callable[[], None]]:
        """Return the function of each key."""
        return {
            "c": lambda: self._playback().ask({"type": "cue"}),
            " ": self._begin,
            **dict.fromkeys("rR", lambda: self.resume("scene")),
            **dict.fromkeys("bB", lambda: self.resume("beat")),
            **dict.fromkeys("\r\n", lambda: (self._begin if self._playback().state.armed else self._open_again)()),
            **dict.fromkeys("oO", self._open_again),
        }

    def show(self, hears: bool) -> None:
        """Show how to open the page, if the terminal `hears` keys."""
        self.hears = hears
        if hears and self._usual:
            self._screen.hint(HINT)

    @property
    def _usual(self) -> str:
        return HINT if self._playback().state.page else ""

    def _begin(self) -> None:
        """Begin the armed program."""
        playback = self._playback()
        if playback.state.armed:
            playback.ask({"type": "resume"}, playback.stops.count)

    def resume(self, place: Literal["scene", "beat"]) -> None:
        """Continue after a stop that nobody asked for: from the scene that played, or from the beat."""
        if self.resumes:
            playback = self._playback()
            playback.ask({"type": "resume", "beat": self.resumes[place]}, playback.stops.count)

    def _open_again(self) -> None:
        """Open the page with a new ticket, in a browser; if there is none, print the address."""

        async def open_again() -> None:
            if not await self.open_page():
                self._screen.say(f"watch it at {self._playback().link()}")

        if self._playback().state.page:
            task = asyncio.create_task(open_again())
            self._opening.add(task)
            task.add_done_callback(self._opening.discard)

    async def open_page(self) -> bool:
        """Show the page in a browser. Return whether there are both."""
        link = self._playback().link(own=True)
        return link is not None and has_browser() and await asyncio.to_thread(webbrowser.open, link)

    def take_armed(self, message: Armed) -> None:
        """Print that everything is ready, and how to begin."""
        state = self._playback().state
        if self.hears:
            self._screen.hint(HINT_ARMED if message["armed"] else self._usual)
        if not message["armed"]:
            return
        begins, count = message["begins"], message.get("count")
        if begins and count and begins - time.time() <= count["beats"] * count["period"]:
            self._screen.count_down(begins, count)
            return
        ways = [
            *(["Space or Enter"] if self.hears else []),
            *(["Play on the page"] if state.page else []),
            *(["the service ~/play"] if state.is_real else []),
        ]
        at = ""
        if begins:
            at = f"at {in_words(datetime.fromtimestamp(begins), datetime.now())}, or "
            self._screen.count_down(begins, count)
        self._screen.say(f"armed: all is ready, and begins {at}with {', or '.join(ways)}")

    def offer(self, transport: TransportMessage, *, stays: bool) -> None:
        """Print from where keys have robots continue, after a stop that nobody asked for, if the performance `stays`
        then."""
        offered, self.resumes = self.resumes, transport.get("resumes") if stays and self.hears else None
        if self.resumes and self.resumes != offered:
            scene, beat = (counted(transport, self.resumes[place]) for place in ("scene", "beat"))
            self._screen.say(f"press r to resume from this scene ({scene}), or b from this beat ({beat})")
        if bool(self.resumes) != bool(offered):
            self._screen.hint(HINT_RESUMES if self.resumes else self._usual)


@contextlib.contextmanager
def pressed(keys: Mapping[str, Callable[[], None]]) -> Iterator[bool]:
    """Call a key's function when somebody presses it, without Enter. Only in a terminal, and not in the background.

    Yield whether it does that.
    """
    if os.name == "nt" or not (sys.stdin and sys.stdin.isatty()) or not _in_front(sys.stdin.fileno()):
        yield False
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
        yield True
    finally:
        loop.remove_reader(terminal)
        with contextlib.suppress(termios.error):  # the terminal is gone
            termios.tcsetattr(terminal, termios.TCSANOW, before)


def _in_front(terminal: int) -> bool:
    """Return whether a terminal's input is for this process: not in the background, nor in a session without the
    terminal."""
    try:
        return os.tcgetpgrp(terminal) == os.getpgrp()
    except OSError:  # the terminal of another session, for example after `setsid`
        return False
