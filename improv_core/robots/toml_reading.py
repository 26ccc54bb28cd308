"""Reads the values of a TOML text. Invalid values are reported at their positions and then ignored."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass
from typing import Any

from improv_core.diagnostics import Diagnostic, Fix, likely, replace
from improv_core.robots.schema import known
from improv_core.robots.schema_key import Key
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
        """Read the valid values in a table: all that only the schema decides, so no profiles and no chosen names."""
        found = {name: self.value((*keys, name), value) for name, value in table.items()}
        return {name: value for name, value in found.items() if value is not None}

    def value(self, keys: Keys, value: Any) -> Any:
        """Read a value as the schema describes it; None if it is wrong, or if more than the schema decides."""
        key = known(keys)
        if key.type == "number":
            return self.number(keys, value)
        if key.type == "integer":
            return self.integer(keys, value)
        if key.type == "boolean":
            if isinstance(value, bool):
                return value
            self._refuse(keys, "as `true` or `false`")
            return None
        if key.items:
            return self._list(keys, key, value)
        if key.keys:
            return self.entries(keys, value)
        return None if key.named or key.profile else self.text(keys, value)

    def number(self, keys: Keys, value: Any, allowed: Range | None = None) -> float | None:
        """Read a number in the range that is `allowed`, by default the schema's."""
        unit, least, most = allowed or _range(keys)
        if isinstance(value, int | float) and not isinstance(value, bool) and least <= value <= most:
            return float(value)
        self._refuse(keys, f"{f'in {unit},' if unit else 'as a number'} from {least} to {most}")
        return None

    def integer(self, keys: Keys, value: Any) -> int | None:
        _, least, most = _range(keys)
        if type(value) is int and least <= value <= most:
            return value
        self._refuse(keys, f"as a whole number from {least} to {most}")
        return None

    def text(self, keys: Keys, value: Any) -> str | None:
        """Read a text, if there is one, as the schema describes it."""
        key = known(keys)
        if key.choices or not isinstance(value, str):
            return self.one_of(keys, value, key.choices)
        if key.form and not key.form[0](value):
            self.at_value(keys, key.form[1])
            return None
        return value

    def one_of(self, keys: Keys, word: Any, words: Collection[str], whole: bool = False) -> str | None:
        """Read one of these words, if there is a word."""
        if word is not None and not isinstance(word, str):
            self._refuse(keys, "as text, in quotes")
        elif word is None or word in words:
            return word
        else:
            message, near = _unknown(word, words)
            self.at_value(keys, message, near and f'"{near}"', whole)
        return None

    def _list(self, keys: Keys, key: Key, value: Any) -> list[Any] | None:
        assert key.items
        if not isinstance(value, list) or len(value) < key.least or key.count not in (0, len(value)):
            unit = f" in {key.items.unit}" if key.items.unit else ""
            self._refuse_form(keys, key, f"{key.count} numbers{unit}" if key.count else "a list")
            return None
        found = [self.value((*keys, place), item) for place, item in enumerate(value)]
        right = [each for each in found if each is not None]
        return None if key.count and len(right) < key.count else right

    def entries(self, keys: Keys, value: Any) -> dict[str, Any] | None:
        """Read the values of the keys in a table that are in the schema; None if a required key is missing."""
        key = known(keys)
        if not isinstance(value, dict):
            self._refuse_form(keys, key, "a table")
            return None
        table = self.table(keys, value)
        if missing := next((name for name in key.required if name not in table), None):
            lacks = key.keys[missing]
            how = f", in {lacks.unit}" if lacks.unit else f": {listed(lacks.choices)}" if lacks.choices else ""
            self.at_value(keys, f"add `{missing}`{how}", whole=True)
            return None
        found = self.values(keys, table)
        return found if found.keys() >= {*key.required} else None

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

    def _refuse_form(self, keys: Keys, key: Key, usual: str) -> None:
        form = key.about if isinstance(keys[-1], int) else usual
        self._refuse(keys, f"as {form}, such as `{key.example}`")

    def _refuse(self, keys: Keys, how: str) -> None:
        """Report a value that has to be written in another way."""
        self.at_value(keys, f"write {'this' if isinstance(keys[-1], int) else f'`{keys[-1]}`'} {how}")

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
