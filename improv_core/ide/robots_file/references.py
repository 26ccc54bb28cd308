"""Find the robot, profile, body part, or pose at the cursor in `improv.toml`, and all its names in the file."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import chain

from improv_core.diagnostics import Edit
from improv_core.ide.rename import RefusalError
from improv_core.robots.schema import find
from improv_core.robots.toml_positions import Keys
from improv_core.robots.toml_text import read_toml
from improv_core.score.profiles import BUILT_IN
from improv_core.text import Span


@dataclass(frozen=True, slots=True)
class FileSymbol:
    """A named thing, and the span of the name. `section` is "robots", "profiles", "body", or "poses".

    Body parts and poses of all profiles that have one name are the same, as in programs.
    """

    section: str
    name: str
    span: Span


def symbol_at(text: str, offset: int) -> FileSymbol | None:
    """Return the symbol that the cursor touches, including at its end."""
    positions = read_toml(text).positions
    for keys, spans in positions.named.items():
        for span in spans:
            if span.holds(offset) and (symbol := section(keys)):
                return FileSymbol(*symbol, span)
    return next((symbol for symbol in _uses(text) if symbol.span.holds(offset)), None)


def declarations(text: str, symbol: FileSymbol) -> list[Span]:
    """Return the spans that name the section of a robot or a profile, or the table of a body part or a pose."""
    named = read_toml(text).positions.named
    same = (spans for keys, spans in named.items() if section(keys) == (symbol.section, symbol.name))
    return sorted(chain.from_iterable(same))


def uses(text: str, symbol: FileSymbol) -> list[Span]:
    """Return the values in the file that name a profile or a body part, without their quotes."""
    return [each.span for each in _uses(text) if (each.section, each.name) == (symbol.section, symbol.name)]


def rename_profile(text: str, symbol: FileSymbol, new: str) -> list[Edit]:
    """Return the edits that give a profile a new name. Raises RefusalError."""
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


def section(keys: Keys) -> tuple[str, str] | None:
    """Return the section and the name of the symbol that the last of these keys names; None if it is a word of ours."""
    if len(keys) == 2 and keys[0] in ("robots", "profiles"):
        return str(keys[0]), str(keys[1])
    inside = keys[0] == "profiles" and len(keys) in (4, 6) and keys[2] == "body" and str(keys[len(keys) - 2])
    return (inside, str(keys[-1])) if inside in ("body", "poses") else None


def _uses(text: str) -> Iterator[FileSymbol]:
    """Yield every value that names a profile or a body part."""
    for keys, entry in read_toml(text).positions.entries.items():
        written = text[slice(*entry.value)]
        if len(written) < 3 or written[0] not in "\"'":
            continue
        span = Span(entry.value.start + 1, entry.value.end - 1)
        if len(keys) == 3 and entry.value != entry.key and (key := find(keys)) and key.profile:
            yield FileSymbol("profiles", written[1:-1], span)
        is_mirror = len(keys) == 5 and keys[4] == "mirror" and entry.value != entry.key
        is_part = is_mirror or (len(keys) == 6 and keys[4] == "parts")
        if is_part and (inside := section(keys[:4])) and inside[0] == "body":
            yield FileSymbol("body", written[1:-1], span)
