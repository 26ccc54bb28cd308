"""The structure of an `improv.toml`, even of a half-typed one: sections, outline, folding ranges, selection ranges."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass

from improv_core.ide.document_symbol import OutlineEntry
from improv_core.ide.folding_range import Fold, comment_folds, widest
from improv_core.ide.selection_range import nested
from improv_core.robots.toml_positions import KeyAndValue, Keys, comments, multi_line_strings
from improv_core.robots.toml_text import read_toml
from improv_core.text import LineIndex, Span

Value = tuple[str, KeyAndValue]
"""A name as it is written below its header, and the spans of it and its value."""


@dataclass(frozen=True, slots=True)
class Section:
    """A header, and the values below it up to the next one. Above the first header, the header is empty."""

    keys: Keys
    header: Span
    values: Sequence[Value]

    @property
    def span(self) -> Span:
        """The span from the header to the last value."""
        return Span(self.header.start, self.values[-1][1].value.end if self.values else self.header.end)


def sections(text: str) -> list[Section]:
    """Return all sections, in the order of the text. Values inside of other values are not among theirs."""
    positions = read_toml(text).positions
    written = sorted(
        ((keys, entry) for keys, entry in positions.entries.items() if entry.value.start > entry.key.start),
        key=lambda each: each[1].key,
    )
    begins = [(Span(0, 0), ()), *positions.headers] if positions.headers else [(Span(0, 0), ())]
    found = []
    for (start, keys), end in zip(begins, [*(span.start for span, _ in begins[1:]), len(text)], strict=True):
        values = list(_values(written, keys, Span(start.start, end)))
        if start.end:
            found.append(Section(keys, Span(start.start, _line_end(text, start.start)), values))
        elif values:
            first = values[0][1].key.start
            found.append(Section(keys, Span(first, first), values))
    return found


def _values(written: Sequence[tuple[Keys, KeyAndValue]], table: Keys, within: Span) -> Iterator[Value]:
    end = within.start
    for keys, entry in written:
        if end <= entry.key.start and entry.value.end <= within.end and keys[: len(table)] == table:
            yield ".".join(map(str, keys[len(table) :])), entry
            end = entry.value.end


def _line_end(text: str, start: int) -> int:
    """Return the end of a line, without its comment and the space before it."""
    line = text[start:].partition("\n")[0]
    comment = next((span.start for span in comments(line)), len(line))
    return start + len(line[:comment].rstrip())


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


def folds(lines: LineIndex) -> list[Fold]:
    """Return all folds, at most one starting at each line, in the order of the text."""
    strings = [
        (lines.position(span.start).line, lines.position(span.end).line) for span in multi_line_strings(lines.text)
    ]
    outside = [
        fold
        for fold in comment_folds(lines)
        if not any(first < fold.first <= last or first < fold.last <= last for first, last in strings)
    ]
    return widest([*outside, *_code(lines)])


def _code(lines: LineIndex) -> Iterator[Fold]:
    """Fold sections and values. A line that starts with the closing bracket of a value stays visible."""
    for section in sections(lines.text):
        if section.header.start < section.header.end:
            yield Fold(lines.position(section.header.start).line, lines.position(section.span.end).line)
        for _, entry in section.values:
            first, last = (lines.position(place).line for place in (entry.key.start, entry.value.end))
            yield Fold(first, last - 1 if lines.line(last).lstrip(" \t")[:1] in ("]", "}") else last)


_WORD = re.compile(r"[\w-]+")


def selections(text: str, offset: int) -> list[Span]:
    """Return the spans around the cursor, from the innermost to the whole file, each larger than the previous one."""
    around = [*comments(text), *(Span(*word.span()) for word in _WORD.finditer(text))]
    for section in sections(text):
        around += [section.span, section.header]
    for entry in read_toml(text).positions.entries.values():
        around += [entry.key, entry.value, Span(entry.key.start, entry.value.end)]
        if text[entry.value.start : entry.value.start + 1] in ('"', "'", "[", "{"):
            around.append(Span(entry.value.start + 1, entry.value.end - 1))
    return nested(text, sorted((span for span in around if span.holds(offset)), key=lambda span: span.start - span.end))
