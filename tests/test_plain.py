"""Foreign text is shown literally, and steers nothing."""

from __future__ import annotations

import pytest
from hypothesis import given

from improv_core.diagnostics import Diagnostic, Fix, Related
from improv_core.plain import LONGEST_LINE, LONGEST_MESSAGE, message, message_without_links, printable
from improv_core.text import Span
from tests.untrusted import EXPLOITS, FOREIGN, steering


@pytest.mark.parametrize(
    ("text", "shown"),
    [
        ("größe ▶ ∞ 🐢 «x»", "größe ▶ ∞ 🐢 «x»"),
        ("\x1b[2J", r"\x1b[2J"),
        ("\x9b", r"\x9b"),
        ("\u202e\u2066", r"\u202e\u2066"),
        ("a\u200bb\ufeff", r"a\u200bb\ufeff"),
        ("a\nb\r\u2028", r"a\nb\r\u2028"),
        ("\U000e0041", r"\U000e0041"),
        ("\udc9b", r"\udc9b"),
    ],
)
def test_invisible_characters_become_escapes(text: str, shown: str) -> None:
    assert printable(text) == message(text) == shown


@pytest.mark.parametrize("name", EXPLOITS)
def test_nothing_of_a_diagnostic_steers(name: str) -> None:
    text, span = EXPLOITS[name], Span(0, 0)
    found = Diagnostic("robots", span, text, (Fix(text, ()),), (Related(span, text),)).shifted(1)
    for shown in (found.message, found.fixes[0].title, found.related[0].message):
        assert steering(shown, "") == set()
        assert len(shown) <= LONGEST_MESSAGE


@given(FOREIGN)
def test_nothing_steers(text: str) -> None:
    assert steering(printable(text), "") == set()
    assert "](" not in message_without_links(text)


def test_a_long_word_loses_its_middle_and_a_message_keeps_its_end() -> None:
    shown = message(f"`{'a' * 10_000}` is not known: did you mean `forward`?")
    assert shown.endswith("a` is not known: did you mean `forward`?")
    assert len(shown) < 250
    assert len(message("a " * 10_000)) <= LONGEST_MESSAGE
    assert len(printable("a" * 100_000)) <= LONGEST_LINE
