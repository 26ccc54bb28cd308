"""Has the client ask again for inlay hints while a dance plays, because they show the beat of each line."""

from __future__ import annotations

import asyncio
import time
from collections.abc import Awaitable, Callable, Sequence
from typing import TYPE_CHECKING

from improv_core.protocol.messages import TransportMessage
from improv_core.protocol.transport import beat_at
from improv_ls.editor import Editor

if TYPE_CHECKING:
    from improv_core.ide.inlay_hint import Hint

SHORTEST = 0.5
"""Seconds between two requests to ask again, at least."""
AFTER = 0.005
"""Seconds to wait after a beat begins, so that it surely has begun."""


class Hinting:
    """Follows the dance that plays. `hints` computes the hints at a beat."""

    def __init__(self, editor: Editor, hints: Callable[[float], Awaitable[Sequence[Hint]]]) -> None:
        self._editor = editor
        self._hints = hints
        self._shown: Sequence[Hint] = ()
        self._task: asyncio.Task[None] | None = None

    def follow(self, transport: TransportMessage) -> None:
        """Note that the playback has changed."""
        self.stop()
        if self._editor.can("workspace.inlay_hint.refresh_support"):
            self._task = asyncio.create_task(self._refresh(transport))

    def stop(self) -> None:
        if self._task:
            self._task.cancel()
            self._task = None

    def clear(self) -> None:
        """Note that nothing plays anymore, which no message reports."""
        self.stop()
        if self._shown:
            self._shown = ()
            self._editor.refresh("inlay_hint")

    async def _refresh(self, transport: TransportMessage) -> None:
        """Refresh the hints with each beat, or each long enough part of a beat, if they change."""
        period = 60 / transport["tempo"]
        step = period / max(period // SHORTEST, 1) if period >= SHORTEST else SHORTEST
        while True:
            wanted = self._editor.hints_playing
            now = await self._hints(beat_at(transport, time.monotonic())) if wanted else ()
            if now != self._shown:
                self._shown = now
                self._editor.refresh("inlay_hint")
            if transport["state"] != "playing":
                return
            zero = transport["monotonic"] - transport["beat"] * period
            await asyncio.sleep(step - (time.monotonic() - zero) % step + AFTER)
