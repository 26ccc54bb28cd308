"""Characters that other keyboards, word processors, and web pages write in place of ours, and their meanings.

Code that reads, explains, fixes, or formats them uses these tables. `usual` reads a character that can mean only one
thing as that thing. One that can mean several (`MEANT`) is an error with a fix.
"""

from __future__ import annotations

import re
import unicodedata
from collections.abc import Mapping
from functools import lru_cache
from types import MappingProxyType

HASHES = "#\uff03"
COMMENT = rf"[{HASHES}][^\r\n]*"
NAME = r"[^\W\d]\w*"
"""A name in a text that `usual` has returned with a `mark`: only `\\w` continues a name there."""

FULL_WIDTH = {chr(code + 0xFEE0): chr(code) for code in range(ord("!"), ord("~") + 1) if not chr(code).isalpha()}
SPACES = "\u00a0\u1680\u2000\u2001\u2002\u2003\u2004\u2005\u2006\u2007\u2008\u2009\u200a\u202f\u205f\u3000"
"""Unicode's spaces (its category Zs) except the usual one."""
ACCEPTED: Mapping[str, str] = MappingProxyType(
    {**FULL_WIDTH, **dict.fromkeys(SPACES, " "), "\u2212": "-", "\u00d7": "*", "\u00f7": "/", "\u2044": "/"}
)
"""Characters that are read as one of ours, unless they continue a name."""

BOM = "\ufeff"
JOINERS = "\u200c\u200d"
"""Joiners belong to a name between two of its characters, and comparisons ignore them: Persian and Hindi need them."""
UNSEEN = JOINERS + "\u00ad\u061c\u180e\u200b\u200e\u200f\u2060\u2061\u2062\u2063\u2064"
"""Invisible characters: ignored between words, an error within one. Those that change the direction of text are an
error everywhere, because they can make a program look like another one."""

DASHES = "-\u2010\u2011\u2012\u2013\u2014\u2015\u2212\u2500\u2e3a\u2e3b\ufe58\ufe63"
DECIMAL_COMMAS = ",\u066b"
DEGREES = "\u00ba\u02da"
LINE_ENDS = "\u2028\u2029"
SEPARATORS = ",;\u060c\u061b\u3001"
"""Characters that people write between items of a list."""
MEANT: Mapping[str, str] = MappingProxyType(
    {
        **dict.fromkeys("\u2768\u2985\ufe59", "("),
        **dict.fromkeys("\u2769\u2986\ufe5a", ")"),
        **dict.fromkeys("\u27e6\u301a", "["),
        **dict.fromkeys("\u27e7\u301b", "]"),
        **dict.fromkeys("\u2217\u22c5\u2715\u2a2f", "*"),
        "\u2215": "/",
        **dict.fromkeys("\u00a6\u2016\u2223\u2225\u2502\u2503\u2758", "||"),
        "\ufe69": "$",
        "\ufe66": "=",
    }
)
"""Stray characters that a fix replaces with ours."""
OPENERS = "{\u00ab\u2039\u3008\u300a\u300c\u3010\u3014\u276a\u27e8"
CLOSERS = "}\u00bb\u203a\u3009\u300b\u300d\u3011\u3015\u276b\u27e9"
"""Brackets that may be round or square."""

_WORDS = {
    ",": "a comma",
    ";": "a semicolon",
    ":": "a colon",
    ".": "a point",
    "%": "a percent sign",
    "&": "an ampersand",
    "|": "a single bar",
    "'": "an apostrophe",
    '"': "a quotation mark",
    "`": "a backtick",
    "{": "a curly bracket",
    "}": "a curly bracket",
    "\u00ba": "an ordinal indicator",
    "\u02da": "a ring",
    "\u00ad": "a soft hyphen",
    "\u2028": "a line separator",
    "\u2029": "a paragraph separator",
}
_INVISIBLE = ("Cc", "Cf", "Cn", "Co", "Cs", "Zl", "Zp")
_TRICKY = re.compile(rf"[^\x00-\x7f\w]|[{chr(0xFF10)}-{chr(0xFF19)}]")
_RELEVANT = re.compile(rf"{COMMENT}|\w+|[{UNSEEN}]+|[^\x00-\x7f]")
_ALWAYS_A_NAME = re.compile(NAME)
_MARK = "_"


def usual(text: str, mark: str = "") -> str:
    """Replace characters that stand for ours in a statement. Offsets and comments stay.

    A `mark` also replaces each character of a name that `\\w` doesn't match, such as an accent.
    """
    if text.isascii() or not _TRICKY.search(text):
        return text
    named = -1  # the end of a name that the next character may continue

    def written(match: re.Match[str]) -> str:
        nonlocal named
        found, (start, end) = match[0], match.span()
        first = found[0]
        if first in HASHES:
            return "#" + found[1:]
        if first == "_" or first.isalnum():
            digits = 0
            while start != named and digits < len(found) and found[digits].isdecimal():
                digits += 1
            if digits < len(found):
                named = end
            return "".join([ACCEPTED.get(each, each) for each in found[:digits]]) + found[digits:]
        if first in UNSEEN:
            after = text[end : end + 1]
            if start == named and continues_name(after) and all(each in JOINERS for each in found):
                named = end
                return mark * len(found) or found
            is_within = start > 0 and _is_within(text[start - 1]) and _is_within(after)
            return found if is_within else " " * len(found)
        if start == named and continues_name(found):
            named = end
            return mark or found
        if ACCEPTED.get(found) == "_":
            named = end
        return ACCEPTED.get(found, found)

    return _RELEVANT.sub(written, text)


def shape(text: str) -> str:
    """Return a statement in which only `\\w` continues a name. Offsets stay."""
    return text if text.isascii() else usual(text, _MARK)


def is_name(text: str) -> bool:
    """Return whether a text is one name."""
    return _ALWAYS_A_NAME.fullmatch(shape(text)) is not None


def spelled(name: str) -> str:
    """Return a name in the form in which names are compared: without joiners, and composed.

    Names of letters and digits alone were always allowed, so they stay as they are and differ from each other: the ohm
    sign is no omega.
    """
    if name.isascii():
        return name
    plain = usual(name).translate(_WITHOUT_JOINERS)
    return plain if _ALWAYS_A_NAME.fullmatch(plain) else unicodedata.normalize("NFC", plain)


_WITHOUT_JOINERS = {ord(each): None for each in JOINERS}


def in_words(char: str) -> str:
    """Describe a character in words, with its code unless it is a usual one: `an en dash, U+2013`."""
    code = f"U+{ord(char):04X}"
    words = _WORDS.get(char)
    if not words:
        called = unicodedata.name(char, "").lower()
        is_unseen = unicodedata.category(char) in _INVISIBLE or char in UNSEEN or not called
        words = "a character that can't be seen" if is_unseen else f"{'an' if called[0] in 'aeio' else 'a'} {called}"
    return words if char.isascii() and char.isprintable() else f"{words}, {code}"


@lru_cache(maxsize=10_000)
def continues_name(char: str) -> bool:
    """Return whether a character can continue a name: `\\w`, or Unicode's XID_Continue."""
    return char != "" and (f"a{char}".isidentifier() or char.isalnum())


def _is_within(char: str) -> bool:
    return char == "." or continues_name(char)
