"""The names of the outputs that are installed as packages. Standard library only."""

from __future__ import annotations

from functools import lru_cache

GROUP = "improv.outputs"
"""The group of their entry points."""


@lru_cache(maxsize=1)
def outputs_installed() -> frozenset[str]:
    """Return the names of installed outputs, without importing any of them; none if Improv itself isn't installed."""
    from importlib.metadata import entry_points

    return frozenset(each.name for each in entry_points(group=GROUP))
