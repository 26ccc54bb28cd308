"""The outline of an `improv.toml`: its sections and their keys."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

from improv_core.ide.document_symbol import OutlineEntry
from improv_core.ide.robots_file.sections import Value, sections
from improv_core.text import Span

LONGEST = 40
"""The most characters of a value that are shown. Longer ones are cut."""
_KINDS = {"robots": "robot", "profiles": "profile"}


def outline(text: str) -> list[OutlineEntry]:
    """Return the outline entries of a file, in the order of the text. Keys above all sections come alone."""
    found: list[OutlineEntry] = []
    for section in sections(text):
        keys = tuple(_key(text, value) for value in section.values)
        if not section.header.end - section.header.start:
            found += keys
            continue
        kind = _KINDS.get(str(section.keys[0]), "section") if len(section.keys) == 2 else "section"
        name = ".".join(str(key) for key in section.keys if isinstance(key, str)) or "[ ]"
        found.append(OutlineEntry(name, kind, "", section.span, section.header, keys))
    return found


def flattened(entries: Iterable[OutlineEntry]) -> Iterator[OutlineEntry]:
    """Yield the sections, each followed by its keys, for editors that show no tree."""
    for entry in entries:
        yield entry
        yield from entry.parts


def _key(text: str, value: Value) -> OutlineEntry:
    name, entry = value
    written = " ".join(text[slice(*entry.value)].split())
    detail = written if len(written) <= LONGEST else f"{written[: LONGEST - 1]}…"
    return OutlineEntry(name, "key", detail, Span(entry.key.start, entry.value.end), entry.key)
