"""The worst kinds of foreign text, and the characters that must never reach people."""

from __future__ import annotations

import unicodedata

from hypothesis import strategies as st

EXPLOITS = {
    "title": "\x1b]0;owned\x07",
    "clipboard": "\x1b]52;c;cm0gLXJmIC8=\x07",
    "clear": "\x1b[2J\x1b[H",
    "one byte": "\x9b2J\x9d0;owned\x9c",
    "bidi": "\u202ereversed\u2066isolated\u2069",
    "zero width": "ro\u200bbot\u200d\ufeff\u2060",
    "lines": "one\ntwo\rthree\u2028four\u2029five\x85six",
    "delete": "hidden\x7f\x08\x08",
    "tags": "\U000e0041\U000e007f",
    "link": "[free](command:workbench.action.quit)",
    "image": "![x](https://example.com/x.png)",
    "code": "`` ` ``` [x](command:y)",
    "long": "a" * 5_000,
}
FOREIGN = st.sampled_from(sorted(EXPLOITS.values())) | st.text(
    st.characters(codec="utf-8", exclude_characters="\0")
    | st.sampled_from('\x1b\x9b\u202e\u2066\u200b\u2028\x7f\n\t`[]()!<>"\\'),
    max_size=30,
)
_STEERS = {"Cc", "Cf", "Cs", "Zl", "Zp"}


def steering(text: str, allowed: str = "\n") -> set[str]:
    """Return the characters of a text that steer a terminal or hide from people."""
    return {char for char in text if unicodedata.category(char) in _STEERS} - set(allowed)
