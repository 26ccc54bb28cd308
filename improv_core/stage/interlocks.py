"""What has to change before real robots may move: an emergency stop, a deadman button, robots that are waited for."""

from __future__ import annotations

from collections.abc import Collection

from improv_core.score.score import Safety
from improv_core.stage.sensing import Sensing

GAMEPAD = "the gamepad at the page"
"""What an edge is about that comes from the page: a deadman button that is held there."""


def waits_for(safety: Safety, sensing: Sensing, away: Collection[str]) -> list[str]:
    """What real robots wait for, by these rules. `away` are robots that have stopped listening."""
    if stop := stop_of(safety, sensing):
        return [stop]
    held = safety.deadman is None or sensing.latest(str(safety.deadman)) or sensing.latest(GAMEPAD)
    return [
        *([] if held else [str(safety.deadman)]),
        *(sorted(away) if safety.rejoin == "pause" else []),
    ]


def stop_of(safety: Safety, sensing: Sensing) -> str | None:
    """The topic of the emergency stop, if it is on."""
    stop = safety.stop
    return stop if stop and sensing.latest(stop) else None
