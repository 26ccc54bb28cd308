"""Make foreign text safe to show: names, keys, values, paths, and the messages that quote them.

Text leaves Improv in few places: the terminal, the editor's messages, diagnostics, and hovers. The code there calls
these functions, so messages may quote anything.
"""

from __future__ import annotations

import re

LONGEST_LINE = 10_000
"""The most characters of a line that is shown; a path and a message fit."""
LONGEST_MESSAGE = 1_000
LONGEST_WORD = 200
"""The most characters of one word in a long message; the URL of the page fits."""
_LONG_WORD = re.compile(rf"\S{{{LONGEST_WORD + 1},}}")


def printable(text: str) -> str:
    r"""Return the text with everything invisible written as an escape, such as `\x1b` or `\u202e`, and without the
    middle of a long one.

    Escapes everything that `str.isprintable` rejects: control characters, line separators, formatting characters (so
    that the direction of text stays visible), lone surrogates, and all spaces except the usual one.
    """
    text = _cut(text, LONGEST_LINE)
    return text if text.isprintable() else "".join(map(_visible, text))


def message(text: str) -> str:
    """Return a message in one printable line. Long words are cut first, because they are quotes."""
    if len(text) <= LONGEST_WORD:  # true of most, and most are made again at each key
        return text if text.isprintable() else printable(text)
    return printable(_cut(_LONG_WORD.sub(lambda word: _cut(word[0], LONGEST_WORD), text), LONGEST_MESSAGE))


def one_line(error: BaseException) -> str:
    """Return an exception as one printable line of text."""
    return message(" ".join(str(error).split()) or type(error).__name__)


def message_without_links(text: str) -> str:
    """Return a message with Markdown's links taken apart: editors make links of messages, even ones that run
    commands."""
    return without_links(message(text))


def without_links(text: str) -> str:
    """Do the same with a text that is a message already."""
    return text.replace("](", "] (")


def _cut(text: str, longest: int) -> str:
    if len(text) <= longest:
        return text
    half = (longest - 1) // 2
    return f"{text[:half]}…{text[-half:]}"


def _visible(char: str) -> str:
    return char if char.isprintable() else char.encode("unicode_escape").decode("ascii")
