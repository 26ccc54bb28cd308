"""The answer to `improv stop`. Standard library only."""

from __future__ import annotations

from collections.abc import Sequence

from improv_core.safety.stop_socket import IDLE
from improv_core.session.state import SessionState


def stop_line(state: SessionState, begins: Sequence[str], moving: int, was_on: bool) -> str:
    """Return the line about what was stopped: the program that played, or the one that `begins`, and how many real
    robots were `moving`, as far as that is known."""
    lost = state.real is not None and not state.obeys
    names = [state.played.name] if state.played and (was_on or moving or lost) else begins
    if not names:
        return IDLE
    if lost:
        return f"{names[0]}: robots may still be moving, since their stage has failed: look at them"
    if not (was_on or moving):
        return f"stopped {names[0]} before it began"
    stopped = f"stopped {names[0]} on {state.status}"
    if not moving:  # how many moved when somebody asked is not known
        return stopped
    return f"{stopped}: {'1 robot was' if moving == 1 else f'{moving} robots were'} moving"
