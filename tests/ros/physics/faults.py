"""Faults of robots and their times. This module never reads a clock."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

KINDS = {
    "swap": "ROBOT,ROBOT: the camera mistakes each for the other",
    "jump": "ROBOT=METERS: the camera sees it this far to its left",
    "lost": "ROBOT or ROBOT=SHARE: the camera misses this share of its poses (default: 1, all of them)",
    "late": "ROBOT=SECONDS: its poses come this much later",
    "lift": "ROBOT: somebody holds it above the floor, its wheels spin",
    "stuck": "ROBOT: its motors are blocked",
    "gone": "ROBOT: its node ends, and is back at the end",
    "cut": "ROBOT: no packet comes or goes (needs root, and --apart ROBOT)",
}


@dataclass(frozen=True, slots=True)
class Fault:
    """A kind of fault of these robots, from one time to another, in seconds."""

    kind: str
    robots: tuple[str, ...]
    amount: float
    start: float
    end: float


def parsed(text: str, robots: Sequence[str]) -> Fault:
    """Parse a fault such as `KIND:ROBOT[,ROBOT][=AMOUNT][@START[-END]]`. Raise ValueError for any other text."""
    what, _, when = text.partition("@")
    kind, _, who = what.partition(":")
    names, _, amount = who.partition("=")
    affected = tuple(names.split(","))
    if kind not in KINDS or not set(affected) <= set(robots) or len(affected) != (2 if kind == "swap" else 1):
        raise ValueError(f"{text!r} is no fault of these robots: write KIND:ROBOT[=AMOUNT][@START[-END]]")
    start, _, end = when.partition("-")
    return Fault(kind, affected, float(amount or 1), float(start or 0), float(end or math.inf))
