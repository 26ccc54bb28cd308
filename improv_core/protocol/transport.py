"""Facts that follow from a stage's reports of the playback position. Pure functions."""

from __future__ import annotations

import math
from collections.abc import Collection

from improv_core.protocol.commands import Stop
from improv_core.protocol.messages import TransportMessage


def beat_at(transport: TransportMessage, now: float) -> float:
    """Return the beat at a monotonic time, according to a stage's latest transport message."""
    passed = max(now - transport["monotonic"], 0.0) if transport["state"] == "playing" else 0.0
    beat = transport["beat"] + passed * transport["tempo"] / 60
    return beat if transport["beats"] is None else min(beat, transport["beats"])


def plays(transport: TransportMessage) -> bool:
    """Return whether a stage moves robots, or is about to once it has found them."""
    return transport["state"] in ("playing", "waiting")


def may_move(transport: TransportMessage) -> bool:
    """Return whether a stage moves robots, or may do so without another request, as its `Run.may_move` decides."""
    return plays(transport) or bool(transport.get("waits_for"))


def counted(transport: TransportMessage, beat: float) -> str:
    """Return a beat for people, who count from 1, and the number of beats: `beat 3/8`; in bars, `bar 2, beat 1`."""
    beats, passed = transport["beats"], math.floor(beat)
    whole = math.inf if beats is None else max(math.ceil(beats), 1)  # a beat that has only begun counts
    passed = int(min(passed, whole - 1))
    if "bar" in transport:
        bar, rest = divmod(passed, transport["bar"])
        return f"bar {bar + 1}, beat {rest + 1}"
    return f"beat {passed + 1}/{'∞' if beats is None else whole}"


def silenced(muted: Collection[str], soloed: Collection[str]) -> str:
    """Return which robots must not move, for people: `ada muted`, `only ada and bo may move`; empty if all may."""
    if soloed:
        return f"only {' and '.join(sorted(soloed))} may move"
    return f"{', '.join(sorted(muted))} muted" if muted else ""


def stop_of(transport: TransportMessage) -> Stop:
    """Return the stop for another stage when one has stopped, with all that counts for both: `unasked`, and `by`."""
    stop: Stop = {"type": "stop"}
    startable_by = transport.get("startable_by", ())
    if len(startable_by) == 1:
        stop["by"] = startable_by[0]
    if "resumes" in transport:
        stop["unasked"] = True
    return stop
