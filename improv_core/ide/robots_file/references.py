"""Finds the robot or the profile at the cursor in `improv.toml`, and all names of the same one in the file."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from improv_core.diagnostics import Edit
from improv_core.ide.rename import RefusalError
from improv_core.robots.schema import find
from improv_core.robots.toml_text import read_toml
from improv_core.score.profiles import BUILT_IN
from improv_core.text import Span


@dataclass(frozen=True, slots=True)
class FileSymbol:
    """A robot or a profile, and its span. `section` is "robots" or "profiles"."""

    section: str
    name: str
    span: Span


def symbol_at(text: str, offset: int) -> FileSymbol | None:
    """The robot or profile that the cursor touches, including at its end."""
    positions = read_toml(text).positions
    for keys, spans in positions.named.items():
        if len(keys) == 2 and keys[0] in ("robots", "profiles"):
            for span in spans:
                if span.holds(offset):
                    return FileSymbol(str(keys[0]), str(keys[1]), span)
    return next((symbol for symbol in _uses(text) if symbol.span.holds(offset)), None)


def declarations(text: str, symbol: FileSymbol) -> list[Span]:
    """The spans that name the section of a robot or a profile."""
    return list(read_toml(text).positions.named.get((symbol.section, symbol.name), ()))


def uses(text: str, symbol: FileSymbol) -> list[Span]:
    """The values in the file that name a profile, without their quotes."""
    same = (each for each in _uses(text) if each.name == symbol.name)
    return [each.span for each in same] if symbol.section == "profiles" else []


def rename_profile(text: str, symbol: FileSymbol, new: str) -> list[Edit]:
    """The edits that give a profile a new name. Raises RefusalError."""
    toml = read_toml(text)
    if toml.diagnostics:
        raise RefusalError("improv.toml can't be read: fix it first")
    if symbol.name in BUILT_IN:
        raise RefusalError(f"`{symbol.name}` is built in and can't be renamed")
    if not new or not all(char.isascii() and (char.isalnum() or char in "_-") for char in new):
        raise RefusalError(f"`{new}` is not a valid profile name: use a to z, digits, `_`, and `-`")
    if new != symbol.name and (new in BUILT_IN or ("profiles", new) in toml.positions.named):
        raise RefusalError(f"`{new}` is already a profile: choose another name")
    spans = [*declarations(text, symbol), *uses(text, symbol)]
    return [Edit(span, new) for span in sorted(spans) if new != symbol.name]


def _uses(text: str) -> Iterator[FileSymbol]:
    """Every value that names a profile."""
    for keys, entry in read_toml(text).positions.entries.items():
        key = find(keys) if len(keys) == 3 else None
        written = text[slice(*entry.value)]
        if key and key.profile and entry.value != entry.key and len(written) > 2 and written[0] in "\"'":
            yield FileSymbol("profiles", written[1:-1], Span(entry.value.start + 1, entry.value.end - 1))
