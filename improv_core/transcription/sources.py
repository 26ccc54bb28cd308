"""Recordings as they are read from files: where each robot was when. Standard library only."""

from __future__ import annotations

import re
from collections.abc import Collection, Mapping, Sequence
from typing import NamedTuple

from improv_core import LineError
from improv_core.transcription.track import TimedPlace

LARGEST = 1e6
"""The largest valid number in a file, in meters or seconds."""


class SourceError(LineError):
    """A recording can't be read; its text is one plain line."""


class Recording(NamedTuple):
    """The places of each robot in a file, and what was guessed about it, one plain line each.

    Some may be `drawn`: their times mean only how long a robot takes in all.
    """

    places: Mapping[str, Sequence[TimedPlace]]
    guesses: Sequence[str] = ()
    drawn: Collection[str] = ()


def robot_name(text: str, taken: Sequence[str] = ()) -> str:
    """Return a valid robot's name that is like this text and not taken."""
    name = re.sub(r"[^A-Za-z0-9]+", "_", text).strip("_")
    name = name if name[:1].isalpha() else f"robot{name}"
    number, wanted = 1, name
    while wanted in taken:
        number += 1
        wanted = f"{name}_{number}"
    return wanted
