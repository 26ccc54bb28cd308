"""The outputs that are installed as packages: their names and settings. Standard library only."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import lru_cache
from typing import NamedTuple

GROUP = "improv.outputs"
"""The group of their entry points."""
Value = bool | int | float | str
_KINDS: Mapping[type, str] = {
    bool: "as `true` or `false`",
    int: "as a whole number",
    float: "as a number",
    str: "as text, in quotes",
}


class Setting(NamedTuple):
    """A key that an output has in `[robots.NAME.settings]`: the sentence that describes it, its default, whose type is
    that of all its values, and their range, or the words among which people choose."""

    about: str
    default: Value
    least: float = float("-inf")
    most: float = float("inf")
    choices: Sequence[str] = ()

    def problem(self, value: object) -> str | None:
        """Return how to write a value that is not allowed."""
        if self.choices:
            return None if value in self.choices else f"as {' or '.join(f'`{each}`' for each in self.choices)}"
        kind = type(self.default)
        if kind is float and type(value) is int:
            value = float(value)
        if type(value) is not kind:
            return _KINDS[kind]
        if isinstance(value, int | float) and not self.least <= value <= self.most:
            return f"from {self.least:g} to {self.most:g}"
        return None


@lru_cache(maxsize=1)
def outputs_installed() -> frozenset[str]:
    """Return the names of installed outputs, without importing any of them; none if Improv itself isn't installed."""
    from importlib.metadata import entry_points

    return frozenset(each.name for each in entry_points(group=GROUP))


@lru_cache(maxsize=100)
def settings_of(output: str) -> Mapping[str, Setting] | None:
    """Return the settings of an output; None if it can't be imported. Only a file that sets some has it imported."""
    from importlib.metadata import entry_points

    for each in entry_points(group=GROUP, name=output):
        try:
            return dict(each.load().settings)
        except Exception:  # another package may do anything; its stage reports that it doesn't work
            return None
    return None
