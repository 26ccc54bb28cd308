"""Selection ranges in an `improv.toml`: word, value, key and value, section, file."""

from __future__ import annotations

import re

from improv_core.ide.robots_file.sections import sections
from improv_core.robots.toml_positions import comments
from improv_core.robots.toml_text import read_toml
from improv_core.text import Span

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
    found = [Span(0, len(text))]
    for span in sorted((span for span in around if span.holds(offset)), key=lambda span: span.start - span.end):
        last = found[-1]
        if span != last and span.start < span.end and last.start <= span.start and span.end <= last.end:
            found.append(span)
    return found[::-1]
