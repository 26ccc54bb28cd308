"""Reads the values of a TOML text. Invalid values are reported where they are and then ignored."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass
from difflib import get_close_matches
from typing import Any

from improv_core.diagnostics import Diagnostic
from improv_core.robots.toml_text import Entry, Keys
from improv_core.text import Span

Range = tuple[str, float, float]
"""The unit, the minimum, and the maximum of a number."""


@dataclass(frozen=True, slots=True)
class TomlReading:
    """Reads values by their keys. The public methods never raise; they add to `diagnostics`."""

    entries: Mapping[Keys, Entry]
    diagnostics: list[Diagnostic]

    def flag(self, keys: Keys, table: Mapping[str, Any]) -> bool:
        value = table.get(str(keys[-1]), False)
        if isinstance(value, bool):
            return value
        self.at_value(keys, f"write `{keys[-1]}` as `true` or `false`")
        return False

    def number(self, keys: Keys, value: Any, allowed: Range) -> float | None:
        unit, least, most = allowed
        if isinstance(value, int | float) and not isinstance(value, bool) and least <= value <= most:
            return float(value)
        what = "this" if isinstance(keys[-1], int) else f"`{keys[-1]}`"
        self.at_value(keys, f"write {what} in {unit}, from {least} to {most}")
        return None

    def numbers(self, keys: Keys, table: Mapping[str, Any], ranges: Mapping[str, Range]) -> dict[str, float]:
        """The valid numbers in a table."""
        names = [name for name in table if name in ranges]
        found = {name: self.number((*keys, name), table[name], ranges[name]) for name in names}
        return {name: number for name, number in found.items() if number is not None}

    def one_of(self, keys: Keys, table: Mapping[str, Any], known: Collection[str]) -> str | None:
        word = self.text(keys, table)
        if word is None or word in known:
            return word
        self.at_value(keys, _unknown(word, known))
        return None

    def text(self, keys: Keys, table: Mapping[str, Any]) -> str | None:
        value = table.get(str(keys[-1]))
        if value is None or isinstance(value, str):
            return value
        self.at_value(keys, f"write `{keys[-1]}` as text, in quotes")
        return None

    def table(self, keys: Keys, value: Any, known: Collection[str] = ()) -> dict[str, Any]:
        """The entries of a table with `known` keys, or all of them if `known` is empty."""
        if not isinstance(value, dict):
            self.at_value(keys, f"write `{keys[-1]}` as a section: `[{'.'.join(map(str, keys))}]`")
            return {}
        unknown = [key for key in value if known and key not in known]
        for key in unknown:
            self.at_key((*keys, key), _unknown(key, known))
        return {key: inner for key, inner in value.items() if key not in unknown}

    def at_key(self, keys: Keys, message: str) -> None:
        self._report(self.entries[keys].key, message)

    def at_value(self, keys: Keys, message: str) -> None:
        self._report(self.entries[keys].value, message)

    def _report(self, span: Span, message: str) -> None:
        self.diagnostics.append(Diagnostic("robots", span, message))


def _unknown(word: str, known: Collection[str]) -> str:
    near = get_close_matches(word, known, n=1) or get_close_matches(word.lower(), known, n=1)
    hint = f"did you mean `{near[0]}`?" if near else f"write one of {listed(known)}"
    return f"`{word}` is not valid here: {hint}"


def listed(words: Collection[str]) -> str:
    return ", ".join(f"`{word}`" for word in words)
