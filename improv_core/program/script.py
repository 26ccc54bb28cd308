"""Read a script of robots' senses: for `improv compile --senses`."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from typing import Any

from improv_core.score.movement import ENDLESS, Duration, Exact, near
from improv_core.score.performance import SenseSpan

LATEST = 10**9
"""The last beat that a script may name."""
_KEYS = frozenset({"sense", "robot", "from", "to"})


class ScriptError(Exception):
    """An error in a script, described in one line."""


def read_script(text: str) -> list[SenseSpan]:
    """Read the script in a JSON text: a list of `{"sense": "near", "robot": "anna", "from": 2.3, "to": 4.1}`, in beats.

    Without `robot`, a sense holds for all robots, and without `to`, forever. Beats count to a millionth. Raises
    ScriptError.
    """
    try:
        entries = json.loads(text)
    except (ValueError, RecursionError) as error:
        raise ScriptError(f"this is not JSON: {error}") from None
    if not isinstance(entries, list):
        raise ScriptError('write a list, such as [{"sense": "near", "from": 2.3, "to": 4.1}]')
    return [_sensing(number, entry) for number, entry in enumerate(entries, 1)]


def _sensing(number: int, entry: object) -> SenseSpan:
    if not isinstance(entry, dict) or not {"sense", "from"} <= entry.keys() <= _KEYS:
        raise ScriptError(f"entry {number}: write `sense`, `from`, and perhaps `to` and `robot`, and nothing else")
    for key in ("sense", "robot"):
        if not isinstance(entry.get(key, ""), str):
            raise ScriptError(f"entry {number}: write `{key}` in quotes")
    start = _beat(number, entry, "from")
    end: Duration = _beat(number, entry, "to") if "to" in entry else ENDLESS
    if end < start:
        raise ScriptError(f"entry {number}: `to` is before `from`: swap them")
    return SenseSpan(entry["sense"], entry.get("robot"), start, end)


def _beat(number: int, entry: Mapping[str, Any], key: str) -> Exact:
    beat = entry[key]
    if type(beat) not in (int, float) or not math.isfinite(beat) or not 0 <= beat <= LATEST:
        raise ScriptError(f"entry {number}: write `{key}` as a number of beats from 0 to {LATEST:,}")
    return near(beat)
