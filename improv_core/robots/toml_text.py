"""A TOML text: its data, or why it is not valid, and the positions of its keys and values."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property, lru_cache
from typing import Any

import tomllib

from improv_core.diagnostics import Diagnostic
from improv_core.robots.toml_errors import unreadable
from improv_core.robots.toml_positions import Keys, Positions, find_positions
from improv_core.robots.toml_statements import read_statements


@dataclass(frozen=True)
class TomlText:
    """The data of a text, and its positions.

    If the text is not valid TOML, there is no data, but there are the positions that can be found. `readable` is the
    data of its valid statements, in which other errors can be found, and `broken` has the tables that may have more
    data.
    """

    text: str
    data: Mapping[str, Any] = field(default_factory=dict)
    diagnostics: tuple[Diagnostic, ...] = ()
    readable: Mapping[str, Any] = field(default_factory=dict)
    broken: frozenset[Keys] = frozenset()

    def is_whole(self, keys: Keys) -> bool:
        """True if all of a table could be read. If not, a missing key proves nothing."""
        return not any(keys[: len(each)] == each[: len(keys)] for each in self.broken)

    @cached_property
    def positions(self) -> Positions:
        """Positions, found when they are first needed: a program whose file has no errors needs none."""
        return find_positions(self.text)


@lru_cache(maxsize=4)
def read_toml(text: str) -> TomlText:
    """Read a text. Never raises; invalid TOML gives a `syntax` diagnostic at its position."""
    text = re.sub("^\ufeff", " ", text)  # a byte order mark; the space keeps the offsets
    try:
        data = tomllib.loads(text)
    except (ValueError, RecursionError) as error:
        found = read_statements(text)
        diagnostics = tuple(found.diagnostics) or (unreadable(text, str(error)),)
        return TomlText(text, {}, diagnostics, found.data, frozenset(found.broken))
    return TomlText(text, data, readable=data)
