"""Follows an Ableton Link session and reports its position (docs/protocol.md).

It is a process of its own, started by the parent, because aalink is under the GPL: Improv neither contains nor links
it, and nobody gets it by default. It ends when its standard input ends. `python …/improv_core/stage link "" TEMPO`: the
tempo, in beats per minute, is that of the session as long as it has no other member. aalink is imported lazily.
"""

from __future__ import annotations

import asyncio
import sys
import time
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from improv_core.protocol.json_lines import Lines, own_output

if TYPE_CHECKING:  # a process that only hears a clock needs no score, and little memory
    from improv_core.protocol.helper_messages import FromClock

OFTEN = 0.1
"""Seconds between two anchors."""
LACKS = 'Ableton Link needs one more package, which is under the GPL: pip install "improv-ls[link]"'


def main() -> int:
    """Report the session's position until standard input ends. Exit code 1 without aalink."""
    lines: Lines[Any] = Lines()
    tell: Callable[[FromClock], None] = own_output()
    try:
        from aalink import Link
    except ImportError:
        tell({"type": "error", "message": LACKS})
        return 1
    asyncio.run(_listen(Link, lines, tell))
    return 0


async def _listen(make: Callable[[float], Any], lines: Lines[Any], tell: Callable[[FromClock], None]) -> None:
    """Join the session, and report its position while it has other members: alone, Improv would follow itself."""
    link = make(float(sys.argv[2]))
    link.enabled = True
    while not lines.ended:
        if link.num_peers:
            beat, at = link.beat, time.monotonic()
            tell({"type": "anchor", "at": at, "beat": beat, "tempo": link.tempo, "period": OFTEN, "jumps": 0})
        await asyncio.sleep(OFTEN)
        for _ in lines.read():
            pass  # the parent only ever closes the pipe
    link.enabled = False
