"""The words that move robots are the same in the language, in the score's messages, and in the movements of robots."""

from __future__ import annotations

from improv_core.preview.window import about
from improv_core.program.analysis import analyze
from improv_core.program.compiler import score_of
from improv_core.score.primitives import PRIMITIVES
from improv_core.score.walk import walk
from improv_core.syntax.vocabulary import of_kind
from improv_core.syntax.word import Kind


def test_every_primitive_of_the_language_moves_as_the_table_says() -> None:
    assert list(PRIMITIVES) == of_kind(Kind.PRIMITIVE)
    for word, velocity in PRIMITIVES.items():
        movement = analyze(f"ada $ {word}").robots["ada"]
        assert [moment.velocity for moment in walk(movement)] == [velocity]


def test_the_page_gets_the_words_with_the_score() -> None:
    words = about(score_of(analyze("ada $ halfright")), 1, takes_start_poses=False)["words"]
    assert words.keys() == PRIMITIVES.keys()
    assert words["halfright"] == [0.0, 0.0, 0.0, -0.5]
