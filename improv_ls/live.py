"""Messages of our own, for editors that highlight what is playing (docs/protocol.md); sent only on request."""

from __future__ import annotations

import time
from collections.abc import Mapping
from typing import Any

from improv_core.ide.moments import playing
from improv_core.program.analysis import Analysis
from improv_core.text import Span
from improv_ls.documents import Document
from improv_ls.positions import Encoding, to_position

EVALUATED = "improv/evaluated"
TRANSPORT = "improv/transport"
MOMENTS = "improv/moments"


def moments(document: Document, played: Analysis, encoding: Encoding, start: float = 0.0) -> dict[str, Any]:
    """What plays from a beat on: ranges in the document as it is now, and for each robot when each of them plays."""
    indices: dict[Span, int] = {}
    robots = {
        robot: {
            "moments": [
                [moment.start, moment.end, [indices.setdefault(span, len(indices)) for span in moment.spans]]
                for moment in stretch.moments
            ],
            "until": stretch.until,
        }
        for robot, stretch in playing(played, document.analysis, start).items()
    }
    ranges = [[value for offset in span for value in _position(document, offset, encoding)] for span in indices]
    return {"uri": document.uri, "version": document.version, "ranges": ranges, "robots": robots}


def transport(message: Mapping[str, Any], uri: str | None, page: str | None) -> dict[str, Any]:
    """A stage's transport message as of now."""
    beat = message["beat"]
    if message["state"] == "playing":
        beat += (time.monotonic() - message["monotonic"]) * message["tempo"] / 60
    copied = ("generation", "state", "backend", "tempo", "speed", "beats", "muted", "soloed")
    return {
        **{name: message[name] for name in copied},
        "beat": beat if message["beats"] is None else min(beat, message["beats"]),
        "wall": time.time(),
        "uri": uri,
        "page": page,
    }


def _position(document: Document, offset: int, encoding: Encoding) -> tuple[int, int]:
    position = to_position(document.lines, offset, encoding)
    return position.line, position.character
