"""Where one statement ends and the next begins, in one pass over the lines."""

from __future__ import annotations

import re
from collections.abc import Iterator

from improv_core.syntax.lexer import NAME

_LINE = re.compile(r"([^\r\n#]*)(#[^\r\n]*)?(?:\r\n|\n|\r|$)")
# A line that looks like the start of a statement always is one, so a missing bracket never swallows the rest.
_BEGINS = re.compile(rf"\s*(?:beat[ \t]+[-+.0-9]|{NAME}[ \t]*=|{NAME}[^()\[\]$=|]*\$)")
_BRACKET = re.compile(r"[()\[\]]")
_SPACES = " \t\r\n\ufeff"


def split(text: str, begin: int = 0) -> Iterator[tuple[int, str]]:
    """Each statement's offset and text, without surrounding whitespace. Comment lines belong to no statement.

    `begin` is the start of a line that does not continue a statement.
    """
    start, open_brackets = None, 0
    for match in _LINE.finditer(text, begin):
        line = match[1]
        code = line.strip(_SPACES)
        if start is not None and (not open_brackets or (code and _BEGINS.match(line))):
            yield _trimmed(text, start, match.start())
            start, open_brackets = None, 0
        if not code:
            continue
        if start is None:
            start = match.start()
        for bracket in _BRACKET.finditer(code):
            if bracket[0] in "([":
                open_brackets += 1
            elif open_brackets:
                open_brackets -= 1
    if start is not None:
        yield _trimmed(text, start, len(text))


def _trimmed(text: str, start: int, end: int) -> tuple[int, str]:
    piece = text[start:end].rstrip(_SPACES)
    body = piece.lstrip(_SPACES)
    return start + len(piece) - len(body), body
