"""The beats that people see while a score plays. Standard library only."""

from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator

from improv_core.protocol.messages import TransportMessage
from improv_core.protocol.transport import counted

AFTER = 0.02
"""Seconds after each beat until people see it: at the beat itself, the stage needs the processor."""


async def each_beat(transport: TransportMessage) -> AsyncIterator[str]:
    """Yield `beat 3/8` as each beat starts, beginning with the current one, forever."""
    # The event loop and the stage use the same clock: time.monotonic.
    loop, period = asyncio.get_running_loop(), 60 / transport["tempo"]
    zero = transport["monotonic"] - transport["beat"] * period
    while True:
        passed = max(int((loop.time() - zero) / period), 0)
        yield counted(transport, passed)
        await asyncio.sleep(zero + (passed + 1) * period + AFTER - loop.time())
