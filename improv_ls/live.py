"""Messages of our own, for editors that light up what plays (docs/protocol.md). Sent to those that ask for them."""

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
    """What plays from a beat on: ranges in the document as it is now, and by robot when each is lit."""
    places: dict[Span, int] = {}
    robots = {
        robot: {
            "moments": [
                [moment.start, moment.end, [places.setdefault(span, len(places)) for span in moment.spans]]
                for moment in stretch.moments
            ],
            "until": stretch.until,
        }
        for robot, stretch in playing(played, document.analysis, start).items()
    }
    ranges = [[value for offset in span for value in _position(document, offset, encoding)] for span in places]
    return {"uri": document.uri, "version": document.version, "ranges": ranges, "robots": robots}


def transport(message: Mapping[str, Any], uri: str | None, page: str | None) -> dict[str, Any]:
    """A stage's transport message as of now."""
    passed = (time.monotonic() - message["monotonic"]) * message["tempo"] / 60 if message["state"] == "playing" else 0.0
    beat = message["beat"] + passed
    told = ("generation", "state", "backend", "tempo", "speed", "beats", "muted", "soloed")
    return {
        **{name: message[name] for name in told},
        "beat": beat if message["beats"] is None else min(beat, message["beats"]),
        "wall": time.time(),
        "uri": uri,
        "page": page,
    }


def _position(document: Document, offset: int, encoding: Encoding) -> tuple[int, int]:
    position = to_position(document.lines, offset, encoding)
    return position.line, position.character
