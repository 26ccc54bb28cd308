"""Lines in a terminal, above a last line that changes in place: the beat, and the keys."""

from __future__ import annotations

import asyncio
import os
import select
import sys
import threading
import time
from collections.abc import Callable
from contextlib import suppress

import click

from improv_core.commands.begin_time import countdown
from improv_core.commands.ros_arguments import is_launched
from improv_core.plain import printable
from improv_core.protocol.messages import CountJson, TransportMessage
from improv_core.session.shown_beats import each_beat


class Screen:
    """Output of a performance; a `quiet` one prints only complaints. Calls `lost` if it can't be written. If it
    `rings`, the terminal's bell rings with each beat that is counted before beat 0."""

    def __init__(self, quiet: bool, lost: Callable[[], object], *, rings: bool = False) -> None:
        self._quiet = quiet
        self._lost = lost
        self._rings = rings
        self._counter: asyncio.Task[None] | None = None
        self._beat = ""
        self._left = ""  # the time until it begins
        self._hint = ""
        self._shown = False  # true while the cursor is behind the last line

    @property
    def is_live(self) -> bool:
        """True while there is a last line: in a terminal that can move its cursor, and not in a log."""
        moves = sys.stdout.isatty() and os.environ.get("TERM") != "dumb"
        return moves and not (self._quiet or is_launched())

    def watch(self) -> None:
        """Notice from now on if whoever reads our lines ends, even while there is nothing to print: of a pipe, a
        socket, or what looks like a terminal. Call it in the event loop."""
        loop = asyncio.get_running_loop()
        if not hasattr(select, "poll"):  # on Windows
            return
        ends = select.poll()
        for number in (1, 2):
            with suppress(OSError):  # it is closed
                os.fstat(number)
                ends.register(number, 0)  # the end is always reported

        def wait() -> None:
            ends.poll()
            with suppress(RuntimeError):  # the loop is closed
                loop.call_soon_threadsafe(self._lost)

        threading.Thread(target=wait, daemon=True).start()

    def say(self, line: str) -> None:
        """Print a line, unless this is a quiet performance."""
        if not self._quiet:
            self._print(line)

    def complain(self, line: str) -> None:
        """Print a line to stderr."""
        self._print(line, err=True)

    def hint(self, hint: str) -> None:
        """Show this in the last line from now on."""
        if self.is_live:
            self._hint = hint
            self._renew()

    def count(self, transport: TransportMessage) -> None:
        """Show the beat in the last line while something plays. A beat that was shown before stays in its place."""
        self._stop_counter()
        if transport["state"] == "playing" and self.is_live:
            self._counter = asyncio.create_task(self._count(transport))

    def count_down(self, begins: float, count: CountJson | None = None) -> None:
        """Show in the last line the time until this Unix time, and count the last beats before it."""
        self._stop_counter()
        if self.is_live:
            self._counter = asyncio.create_task(self._count_down(begins, count))

    def close(self) -> None:
        """End the last line."""
        self._hint = ""
        self._stop_counter()
        self._clear()

    def _print(self, line: str, *, err: bool = False) -> None:
        self._renew(f"{printable(line)}\n", err=err)

    async def _count(self, transport: TransportMessage) -> None:
        async for beat in each_beat(transport):
            self._beat = beat
            self._renew()

    async def _count_down(self, begins: float, count: CountJson | None) -> None:
        counted = count["beats"] * count["period"] if count else 0.0
        while (left := begins - time.time()) > counted:
            self._left = f"begins in {countdown(left)}"
            self._renew()
            await asyncio.sleep(min(left % 1 or 1.0, left - counted))
        if count:
            await self._count_in(begins, count)

    async def _count_in(self, begins: float, count: CountJson) -> None:
        """Show the number of each beat before this Unix time, from 1 on."""
        for left in range(count["beats"], 0, -1):
            await asyncio.sleep(begins - left * count["period"] - time.time())
            self._left = f"count-in {count['beats'] - left + 1}/{count['beats']}"
            self._renew("\a" if self._rings else "")

    def _stop_counter(self) -> None:
        if self._counter:
            self._counter.cancel()
            self._counter = None
        self._left = ""
        beat, self._beat = self._beat, ""
        if self._shown and beat:
            self._renew(f"{beat}\n")

    def _renew(self, above: str = "", *, err: bool = False) -> None:
        """Show the last line again, below other output."""
        self._clear()
        if above:
            self._write(above, err=err)
        if shown := " · ".join(part for part in (self._beat, self._left, self._hint) if part):
            self._shown = True
            self._write(f"\r{shown} ")

    def _clear(self) -> None:
        """Replace the last line with an empty one, for another line to come."""
        if self._shown:
            self._shown = False
            self._write("\r\x1b[K")

    def _write(self, text: str, *, err: bool = False) -> None:
        try:
            click.echo(text, nl=False, err=err)
        except OSError:
            self._lost()
