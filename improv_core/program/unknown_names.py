"""Diagnostics about names that no statement defines: likely meanings, and fixes that keep all that was written."""

from __future__ import annotations

import dataclasses
import re
from collections.abc import Mapping, Sequence

from improv_core.diagnostics import Diagnostic, Fix, replace
from improv_core.program.program import Program
from improv_core.syntax import nodes
from improv_core.syntax.characters import BOM, in_words, usual
from improv_core.syntax.lexer import Token
from improv_core.syntax.slips import MEANT, closest, has_more, logo_repeat, meant_instead
from improv_core.syntax.vocabulary import UNITS, WORDS
from improv_core.syntax.words import Kind
from improv_core.syntax.wrong_characters import number_meant
from improv_core.text import Span

_FIGURES: Mapping[str, str] = {
    "arc": "left 90deg radius 1m",
    "circle": "left 360deg radius 50cm",
    "eight": "left 360deg radius 50cm right 360deg radius 50cm",
    "heart": "forward 70cm left 180deg radius 35cm right 90deg left 180deg radius 35cm forward 70cm",
    "square": "repeat 4 (forward left)",
    "star": "repeat 5 (forward left 144deg)",
    "triangle": "repeat 3 (forward left 120deg)",
}
"""Figures that people name before they define them, each with a movement that draws it."""
_NUMBERED = re.compile(r"(.*?[^\W\d])(\d+)")
_SPACES = re.compile(r"[ \t\ufeff]*")


def unknown_name(program: Program, index: int, node: nodes.Name, tokens: Sequence[Token], at: int) -> Diagnostic:
    """Return the diagnostic about a name that no statement defines: the token `at` of its statement."""
    name, statement = node.text, program.statements[index]
    if number := number_meant(tokens, at):
        before = tokens[at - 1] if at else None
        is_second = before is not None and before.type in ("NUMBER", "PARAM") and before.end < number.span.start
        fixes = tuple(dataclasses.replace(fix, guess=True) for fix in number.fixes) if is_second else number.fixes
        return Diagnostic("unknown-name", node.span, f"`{name}` is not defined: {number.message}", fixes)
    halves = _in_two(program, statement.text, tokens, at)
    if BOM in statement.text[max(node.span.start - 1, 0) : node.span.start] + statement.text[node.span.end :][:1]:
        message = f"`{name}` is not defined: there is {in_words(BOM)}, beside it"
        return Diagnostic("unknown-name", node.span, message, halves)
    if halves:
        message = f"`{name}` is not defined: write `{halves[0].title.removeprefix('Change to ')}` as one word"
        return Diagnostic("unknown-name", node.span, message, halves)
    if logo := logo_repeat(tokens, at):
        return Diagnostic("unknown-name", node.span, *logo)
    if name.lower() in MEANT:
        message, fixes = meant_instead(tokens, at)
        return Diagnostic("unknown-name", node.span, message, fixes)
    if name.lower() == "circle" and (size := _length_after(tokens, at)):
        text = f"left 360deg radius {size[0].text}{size[1].text}"
        fixes = replace(f"Change to {text}", Span(node.span.start, size[1].end), text)
        return Diagnostic("unknown-name", node.span, f"`{name}` is not defined: write `{text}`", fixes)
    parameters = [each.name for each in statement.parameters]
    near = program.bindings.nearest(name) or closest(name, program.config.part_words)
    figure = _FIGURES.get(name)
    if (
        near
        and (near in program.bindings.defined or not figure)
        and not has_more(name, near, lambda each: _is_known(program, each) or each in parameters)
    ):
        message = f"`{name}` is not defined: did you mean `{near}`?"
        return Diagnostic("unknown-name", node.span, message, replace(f"Change to {near}", node.span, near))
    if not figure and (name in program.parts or name in program.config.robots):
        message = f"`{name}` is a robot, not a movement: name the movement that both perform, and write that name here"
        return Diagnostic("unknown-name", node.span, message)
    if at and name in UNITS and tokens[at - 1].type == "NUMBER" and tokens[at - 1].end == node.span.start:
        measure = f"{tokens[at - 1].text}{name}"
        message = f"`{measure}` is a measure: write it behind a word such as `forward`, `left`, or `radius`"
        return Diagnostic("unknown-name", node.span, message)
    message = f"`{name}` is not defined: write `{name} = {figure or '…'}` above this line"
    if (joined := _NUMBERED.fullmatch(name)) and _takes_number(program, index, joined[1]):
        message = f"`{name}` is not defined: write `{joined[1]} {joined[2]}`, with a space"
    elif program.config.path and _takes_a_term(program.meanings[index].body, node):
        message += f", or, if it is a body part, `[profiles.NAME.body.{name}]` in improv.toml"
    above = f"{name} = {figure or 'rest'}{program.lines.ending(program.offsets[index])}"
    fixes = replace(f"Define {name}{'' if figure else ' as rest'} above", Span(0, 0), above, guess=True)
    return Diagnostic("unknown-name", node.span, message, fixes)


def _length_after(tokens: Sequence[Token], at: int) -> tuple[Token, Token] | None:
    """Return the number and the unit of a length that follows a name; None if none does."""
    number, unit = [*tokens[at + 1 : at + 3], None, None][:2]
    is_length = (
        number and unit and number.type == "NUMBER" and unit.text in UNITS and UNITS[unit.text].field == "meters"
    )
    return (number, unit) if number and unit and is_length else None


def _is_known(program: Program, name: str) -> bool:
    return name in WORDS or name in program.bindings.defined or name in program.config.part_words


def _in_two(program: Program, text: str, tokens: Sequence[Token], at: int) -> tuple[Fix, ...]:
    """Return the fix that joins this part of a known word and the next part."""
    for one, other in zip(tokens[max(at - 1, 0) :], tokens[max(at - 1, 0) + 1 : at + 2], strict=False):
        whole = one.text + other.text
        is_near = _SPACES.fullmatch(usual(text[one.end : other.start]))
        if is_near and (whole in program.bindings.defined or whole in WORDS):
            return replace(f"Change to {whole}", Span(one.end, other.start), "")
    return ()


def _takes_number(program: Program, index: int, name: str) -> bool:
    """Return whether a number can follow a word of the language, or a name that is defined above."""
    if name in WORDS:
        return WORDS[name].kind in (Kind.REPEAT, Kind.FACTOR, Kind.RAMP)
    definition = program.definition(name, index)
    return definition is not None and definition.phrase is not None and bool(definition.phrase.numbers)


def _takes_a_term(body: nodes.Node | None, name: nodes.Name) -> bool:
    """Return whether another term follows a name, as it follows a word for a body part."""
    every = nodes.nodes(body) if body else ()
    return any(isinstance(each, nodes.Series) and name in each.items[:-1] for each in every)
