"""Each word of the language, in all code that uses its row."""

from __future__ import annotations

import json
from fractions import Fraction
from itertools import islice

import pytest

from improv_core.diagnostics import Severity
from improv_core.ide.completion import complete, document
from improv_core.ide.hover import hover
from improv_core.ide.signature_help import signature
from improv_core.program.analysis import Analysis, analyze
from improv_core.program.compiler import score_of
from improv_core.score.equality import same
from improv_core.score.performance import Mover, perform
from improv_core.score.score_json import from_json, to_json
from improv_core.score.walk import walk
from improv_core.syntax.formatter import format_text
from improv_core.syntax.vocabulary import WORDS
from improv_core.syntax.word import Kind, Word

every_word = pytest.mark.parametrize("word", WORDS.values(), ids=lambda word: word.text)
words_that_take_movements = pytest.mark.parametrize(
    "word", [word for word in WORDS.values() if word.make], ids=lambda word: word.text
)
MAX_MOMENTS = 50


def program_with(word: Word) -> str:
    """Return a program of two robots that uses a word as its row describes it."""
    usage = word.usage.replace("movement", "(choose (forward left) right)")
    return f"{usage}\nr q $ forward\n" if word.kind is Kind.BEAT else f"r q $ {usage}\n"


def program_up_to(word: Word) -> tuple[Analysis, int]:
    """Return the same program up to the word, and the offset of the word."""
    program = program_with(word)
    typed = program[: program.index(word.text)]
    return analyze(typed), len(typed)


@every_word
def test_its_usage_is_a_correct_and_formatted_program(word: Word) -> None:
    program = program_with(word)
    assert format_text(program) == program
    assert [each.message for each in analyze(program).diagnostics if each.severity is Severity.ERROR] == []


@every_word
def test_its_movement_is_performed_alike_after_json(word: Word) -> None:
    score = score_of(analyze(program_with(word)))
    copy = from_json(json.loads(json.dumps(to_json(score))))
    for robot, part in score.parts.items():
        assert same(copy.parts[robot].movement, part.movement)
        walked = list(islice(walk(part.movement), MAX_MOMENTS))
        assert list(islice(walk(copy.parts[robot].movement), MAX_MOMENTS)) == walked
        performed = [moment for *_, moment in islice(perform([{Mover(robot): part.movement}], ()), MAX_MOMENTS)]
        assert walked
        assert [moment.velocity for moment in performed] == [moment.velocity for moment in walked]


@every_word
def test_it_is_offered_with_its_usage_and_documented(word: Word) -> None:
    analysis, offset = program_up_to(word)
    found = complete(analysis, offset)
    assert found
    (item,) = [each for each in found.items if each.label == word.text]
    documented = document(analysis, item, found.statement, pictures=False)
    assert item.detail == word.about
    assert documented
    assert word.about in documented.markdown
    assert all(argument.example in item.snippet for argument in word.arguments if word.make)


@words_that_take_movements
def test_its_signature_names_its_arguments_and_marks_the_one_being_typed(word: Word) -> None:
    program = program_with(word)
    place = program.index(word.text) + len(word.text) + 1
    for argument in word.arguments:
        shown = signature(analyze(program), place)
        assert shown
        assert shown.about == word.about
        assert shown.label[slice(*shown.parameters[shown.active])] == argument.name
        place = program.index(argument.example, place) + len(argument.example) + 1
    shown = signature(analyze(program), place)
    assert shown
    assert shown.label[slice(*shown.parameters[shown.active])] == "movement"


@every_word
def test_its_hover_describes_it(word: Word) -> None:
    program = program_with(word)
    found = hover(analyze(program), program.index(word.text))
    assert found
    if word.kind in (Kind.ELSE, Kind.NOT):  # their hovers describe the word that they belong to
        word = WORDS[found.word.partition(" ")[0]]
    elif word.kind is Kind.REFLECT:  # the hover of the plane says more
        word = WORDS[word.arguments[0].example]
    assert word.about in found.markdown


@pytest.mark.parametrize(
    ("word", "number"),
    [
        (word, number)
        for word in WORDS.values()
        for number in ("0", "1/3", "2")
        if word.make and word.arguments and word.arguments[0].rule(Fraction(number))
    ],
    ids=lambda each: each.text if isinstance(each, Word) else each,
)
def test_a_number_out_of_its_limits_is_reported(word: Word, number: str) -> None:
    program = program_with(word).replace(f" {word.arguments[0].example} ", f" {number} ", 1)
    (found,) = [each for each in analyze(program).diagnostics if each.severity is Severity.ERROR]
    better = word.arguments[0].rule(Fraction(number))
    assert (found.code, program[slice(*found.span)]) == ("bad-number", number)
    assert found.message == f"write the number after `{word.text}` {better}"
