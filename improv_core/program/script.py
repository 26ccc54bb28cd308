"""Read a script of robots' senses: for `improv compile --senses`."""

from __future__ import annotations

import json
from typing import Annotated, TypedDict

from improv_core.score.json_types import Between, NotRequired, fits, hints_of
from improv_core.score.movement import ENDLESS, near
from improv_core.score.performance import SenseSpan

LATEST = 10**9
"""The last beat that a script may name."""
_Beat = Annotated[float, Between(0, LATEST)]
_Entry = TypedDict("_Entry", {"sense": str, "robot": NotRequired[str], "from": _Beat, "to": NotRequired[_Beat]})
_EXAMPLE = '{"sense": "near", "robot": "anna", "from": 2.3, "to": 4.1}'


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
        raise ScriptError(f"write a list, such as [{_EXAMPLE}]")
    return [_sensing(number, entry) for number, entry in enumerate(entries, 1)]


def _sensing(number: int, entry: _Entry) -> SenseSpan:
    if not fits(entry, _Entry) or not entry.keys() <= hints_of(_Entry).keys():
        form = f"`sense`, `from`, and perhaps `to` and `robot`, and nothing else, such as {_EXAMPLE}"
        raise ScriptError(f"entry {number}: write {form}, with beats from 0 to {LATEST:,}")
    start, end = near(entry["from"]), near(entry["to"]) if "to" in entry else ENDLESS
    if end < start:
        raise ScriptError(f"entry {number}: `to` is before `from`: swap them")
    return SenseSpan(entry["sense"], entry.get("robot"), start, end)
