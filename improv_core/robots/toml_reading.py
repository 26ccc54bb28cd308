"""Reads the values of a TOML text. Invalid values are reported at their positions and then ignored."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass
from typing import Any

from improv_core.diagnostics import Diagnostic, Fix, likely, replace
from improv_core.robots.schema import find, known
from improv_core.robots.toml_positions import Keys
from improv_core.robots.toml_text import TomlText
from improv_core.text import Span

Range = tuple[str, float, float]
"""The unit, the minimum, and the maximum of a number."""


@dataclass(frozen=True, slots=True)
class TomlReading:
    """Reads values by their keys, according to the schema. The public methods never raise; they add to `diagnostics`.

    An error about a missing key, or about tables that don't fit together, is reported only if the `whole` text could be
    read.
    """

    toml: TomlText
    diagnostics: list[Diagnostic]

    def values(self, keys: Keys, table: Mapping[str, Any]) -> dict[str, Any]:
        """Read the valid numbers, flags, and words with choices in a table: all that only the schema decides."""
        found = {name: self._value((*keys, name), table) for name in table}
        return {name: value for name, value in found.items() if value is not None}

    def _value(self, keys: Keys, table: Mapping[str, Any]) -> float | bool | str | None:
        key, value = find(keys), table[str(keys[-1])]
        if not key or key.type == "number":
            return self.number(keys, value) if key else None
        if key.type == "integer":
            return self.integer(keys, value)
        if key.type == "boolean" and not isinstance(value, bool):
            self.at_value(keys, f"write `{keys[-1]}` as `true` or `false`")
        elif key.type == "boolean":
            return bool(value)
        return self.one_of(keys, table) if key.choices else None

    def number(self, keys: Keys, value: Any, allowed: Range | None = None) -> float | None:
        """Read a number in the range that is `allowed`, by default the schema's."""
        unit, least, most = allowed or _range(keys)
        if isinstance(value, int | float) and not isinstance(value, bool) and least <= value <= most:
            return float(value)
        what = "this" if isinstance(keys[-1], int) else f"`{keys[-1]}`"
        self.at_value(keys, f"write {what} in {unit}, from {least} to {most}")
        return None

    def integer(self, keys: Keys, value: Any) -> int | None:
        _, least, most = _range(keys)
        if type(value) is int and least <= value <= most:
            return value
        self.at_value(keys, f"write `{keys[-1]}` as a whole number from {least} to {most}")
        return None

    def one_of(
        self, keys: Keys, table: Mapping[str, Any], among: Collection[str] = (), whole: bool = False
    ) -> str | None:
        """Read one of these words, by default one of the schema's choices."""
        word = self.text(keys, table)
        words = among or known(keys).choices
        if word is None or word in words:
            return word
        message, near = _unknown(word, words)
        self.at_value(keys, message, near and f'"{near}"', whole)
        return None

    def text(self, keys: Keys, table: Mapping[str, Any]) -> str | None:
        value = table.get(str(keys[-1]))
        if value is None or isinstance(value, str):
            return value
        self.at_value(keys, f"write `{keys[-1]}` as text, in quotes")
        return None

    def table(self, keys: Keys, value: Any) -> dict[str, Any]:
        """Read the entries of a table that the schema has, or all of them if people choose the names."""
        if not isinstance(value, dict):
            self.at_value(keys, f"write `{keys[-1]}` as a section: `[{'.'.join(map(str, keys))}]`")
            return {}
        names = known(keys).keys
        unknown = [name for name in value if names and name not in names]
        for name in unknown:
            self.unknown_key((*keys, name), names)
        return {name: inner for name, inner in value.items() if name not in unknown}

    def unknown_key(self, keys: Keys, names: Collection[str]) -> None:
        """Report a key that is none of these names."""
        self.at_key(keys, *_unknown(str(keys[-1]), names))

    def at_key(self, keys: Keys, message: str, fixed: str = "", whole: bool = False) -> None:
        """Report a key; `fixed` is the likely correction."""
        if not (whole and self.toml.diagnostics):
            self._report(self.toml.positions.nearest(keys).key, message, fixed)

    def at_value(self, keys: Keys, message: str, fixed: str = "", whole: bool = False) -> None:
        """Report a value; `fixed` is the likely correction."""
        if not (whole and self.toml.diagnostics):
            self._report(self.toml.positions.nearest(keys).value, message, fixed)

    def warn_value(self, keys: Keys, message: str) -> None:
        """Warn of a value without which everything can play."""
        span = self.toml.positions.nearest(keys).value
        self.diagnostics.append(Diagnostic("robots", span, message, warns=True))

    def _report(self, span: Span, message: str, fixed: str) -> None:
        fixes: tuple[Fix, ...] = replace(f"Change to {fixed}", span, fixed) if fixed else ()
        self.diagnostics.append(Diagnostic("robots", span, message, fixes))


def _range(keys: Keys) -> Range:
    key = known(keys)
    return key.unit, key.least, key.most


def _unknown(word: str, known: Collection[str]) -> tuple[str, str]:
    """Return the error about an unknown word, and the word that was probably meant, or an empty one."""
    near = likely(word, known)
    hint = f"did you mean `{near}`?" if near else f"write one of {listed(known)}"
    return f"`{word}` is not valid here: {hint}", near or ""


def listed(words: Collection[str]) -> str:
    return ", ".join(f"`{word}`" for word in words)
