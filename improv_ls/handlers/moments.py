"""improv/moments: docs/protocol.md."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from improv_core.stage.fields import LAST_BEAT
from improv_ls.session import Session


def moments(ls: Session, params: Any) -> Mapping[str, Any]:
    """What plays from a beat on; from the beginning if the params name no beat."""
    beat: Any = getattr(params, "beat", 0.0)
    known = isinstance(beat, int | float) and 0 <= beat <= LAST_BEAT
    return ls.performance.live.moments(float(beat) if known else 0.0)
