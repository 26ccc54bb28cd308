"""The sections of an `improv.toml` and their values, even in a file that is half typed."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from improv_core.robots.toml_positions import KeyAndValue, Keys, comments
from improv_core.robots.toml_text import read_toml
from improv_core.text import Span

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
