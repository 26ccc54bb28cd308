"""Find the declaration in `improv.toml` of the body part or the pose at the cursor."""

from __future__ import annotations

from collections.abc import Sequence

from improv_core.ide.body_words import takes
from improv_core.ide.phrases import poses_at
from improv_core.ide.references import names_used, performers
from improv_core.program.analysis import Analysis
from improv_core.robots.config import Robots
from improv_core.robots.toml_positions import Keys
from improv_core.robots.toml_text import read_toml
from improv_core.text import Span


def declarations(analysis: Analysis, offset: int, robots: Robots) -> Sequence[Span]:
    """Return the spans in `improv.toml` that declare it, those of robots that perform the statement first."""
    asked = _asked(analysis, offset)
    if not asked:
        return ()
    profiles = {profile.name for profile in performers(analysis, asked[0])}
    entries = read_toml(robots.text).positions.entries
    found = [(keys[1] not in profiles, entry.key) for keys, entry in entries.items() if _is(keys, asked[1])]
    return [span for _, span in sorted(found)]


_ANY = ""
"""Matches any name."""


def _asked(analysis: Analysis, offset: int) -> tuple[int, Keys] | None:
    """Return the statement at the cursor, and the keys of the body part or pose that the cursor touches."""
    placed = analysis.statement_at(offset)
    if not placed:
        return None
    place = offset - placed.start
    for span in poses_at(placed):
        if span.holds(place):
            pose = placed.statement.text[span.start : span.end]
            return placed.index, ("profiles", _ANY, "body", _ANY, "poses", pose)
    for name in names_used(placed):
        if name.span.holds(place) and takes(analysis, name.text, placed.index) is not None:
            return placed.index, ("profiles", _ANY, "body", name.text)
    return None


def _is(keys: Keys, asked: Keys) -> bool:
    return len(keys) == len(asked) and all(one in (_ANY, key) for one, key in zip(asked, keys, strict=True))
