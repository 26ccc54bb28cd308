"""Messages of our own, for editors that highlight what is playing (docs/protocol.md); sent only on request."""

from __future__ import annotations

import time
from typing import Any

from improv_core.ide.moments import SoFar, playing
from improv_core.program.analysis import Analysis
from improv_core.stage.protocol import TransportMessage
from improv_core.text import Span
from improv_ls.documents import Document
from improv_ls.positions import Encoding, to_position

EVALUATED = "improv/evaluated"
TRANSPORT = "improv/transport"


def moments(document: Document, played: Analysis, encoding: Encoding, start: float, so_far: SoFar) -> dict[str, Any]:
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
        for robot, stretch in playing(played, document.analysis, start, so_far).items()
    }
    ranges = [[value for offset in span for value in _position(document, offset, encoding)] for span in indices]
    return {"uri": document.uri, "version": document.version, "from": start, "ranges": ranges, "robots": robots}


def transport(message: TransportMessage, uri: str | None, page: str | None) -> dict[str, Any]:
    """A stage's transport message as of now."""
    beat = beat_of(message)
    return {
        "generation": message["generation"],
        "state": message["state"],
        "backend": message["backend"],
        "tempo": message["tempo"],
        "speed": message["speed"],
        "beats": message["beats"],
        "muted": message["muted"],
        "soloed": message["soloed"],
        "beat": beat if message["beats"] is None else min(beat, message["beats"]),
        "wall": time.time(),
        "uri": uri,
        "page": page,
    }


def beat_of(message: TransportMessage) -> float:
    """The beat that a stage's transport message means now."""
    passed = time.monotonic() - message["monotonic"] if message["state"] == "playing" else 0.0
    return message["beat"] + passed * message["tempo"] / 60


def _position(document: Document, offset: int, encoding: Encoding) -> tuple[int, int]:
    position = to_position(document.lines, offset, encoding)
    return position.line, position.character
