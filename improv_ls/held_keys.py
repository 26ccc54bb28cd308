"""Keys of senses that a command holds, as if somebody pressed them on the page."""

from __future__ import annotations

import asyncio
from collections.abc import Callable

from improv_core.protocol.commands import KeySense
from improv_core.protocol.limits import DEADMAN_LIMIT
from improv_core.score.senses import Key
from improv_ls.editor import Editor
from improv_ls.playing import Playing

PERIOD = DEADMAN_LIMIT / 3
"""Seconds between two messages that a key is held: without them, the key counts as released."""


class HeldKeys:
    """The keys that are held. `conduct` sends the stages a message."""

    def __init__(self, editor: Editor, playing: Playing, conduct: Callable[[KeySense], None]) -> None:
        self._editor = editor
        self._playing = playing
        self._conduct = conduct
        self._held: dict[str, asyncio.Task[None]] = {}

    def toggle(self, key: str) -> None:
        """Hold the key of a sense until this is called again or the dance stops."""
        latest = self._playing.latest
        if key in self._held:
            self._held.pop(key).cancel()
            self._conduct({"type": "key", "key": key, "held": False})
            self._editor.say(f"{key} is released")
        elif self._playing.state != "playing" or not latest:
            self._editor.warn("improv.key: nothing plays; save a program first")
        elif key not in (
            keys := {each.key for each in latest.document.analysis.config.senses.values() if isinstance(each, Key)}
        ):
            known = f"one of {', '.join(sorted(keys))}" if keys else "but no sense in improv.toml has a key"
            self._editor.warn(f"improv.key: expected the key of a sense, {known}")
        else:
            self._held[key] = asyncio.create_task(self._hold(key))
            self._editor.say(f"{key} is held; the same command releases it")

    def release(self) -> None:
        """Release all keys. The stages need no message, because the dance has ended."""
        while self._held:
            self._held.popitem()[1].cancel()

    async def _hold(self, key: str) -> None:
        while True:
            self._conduct({"type": "key", "key": key, "held": True})
            await asyncio.sleep(PERIOD)
