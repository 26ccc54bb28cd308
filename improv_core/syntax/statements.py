"""Split a text into statements, in one pass over the lines."""

from __future__ import annotations

import re
from collections.abc import Iterator

from improv_core.syntax.characters import COMMENT, HASHES, NAME, shape

_LINE = re.compile(rf"([^\r\n{HASHES}]*)({COMMENT})?(?:\r\n|\n|\r|$)")
# A line that looks like the start of a statement always is one, so a missing bracket never swallows the rest.
_PARAMETERS = rf"(?:[ \t]+{NAME}|[ \t]*\([ \t]*{NAME}[ \t]*\))*+"
_BEGINS = re.compile(rf"\s*(?:beat[ \t]+[-+.0-9]|-{{3}}|{NAME}{_PARAMETERS}[ \t]*=|{NAME}[^()\[\]$=|]*\$)")
_CONTINUES = re.compile(r"\|\||else\b")
_BRACKET = re.compile(r"[()\[\]]")
_SPACES = " \t\r\n\ufeff"


def split(text: str, begin: int = 0) -> Iterator[tuple[int, str]]:
    """Yield each statement's offset and text, without surrounding whitespace. Comments between statements belong to
    none.

    A statement ends with its line, unless a bracket is open or the next line of code begins with `||` or `else`.

    `begin` is the start of a line that does not continue a statement.
    """
    start, end, open_brackets = None, 0, 0
    for match in _LINE.finditer(text, begin):
        line = shape(match[1])
        code = line.strip(_SPACES)
        if code:
            if start is not None and not (_CONTINUES.match(code) if not open_brackets else not _BEGINS.match(line)):
                yield _trimmed(text, start, end)
                start, open_brackets = None, 0
            if start is None:
                start = match.start()
            for bracket in _BRACKET.finditer(code):
                if bracket[0] in "([":
                    open_brackets += 1
                elif open_brackets:
                    open_brackets -= 1
        if code or open_brackets:
            end = match.end()
    if start is not None:
        yield _trimmed(text, start, end)


def _trimmed(text: str, start: int, end: int) -> tuple[int, str]:
    shown = shape(text[start:end]).rstrip(_SPACES)
    first = len(shown) - len(shown.lstrip(_SPACES))
    return start + first, text[start + first : start + len(shown)]
