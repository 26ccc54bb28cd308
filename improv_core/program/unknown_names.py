"""Diagnostics about names that no statement defines: likely meanings, and fixes that keep all that was written."""

from __future__ import annotations

import dataclasses
import re
from collections.abc import Iterator, Sequence

from improv_core.diagnostics import Diagnostic, Fix, replace
from improv_core.program.program import Program
from improv_core.score.primitives import PRIMITIVES
from improv_core.syntax import nodes
from improv_core.syntax.characters import BOM, in_words, usual
from improv_core.syntax.lexer import Token
from improv_core.syntax.slips import closest, has_more, number_first
from improv_core.syntax.tried_words import figure, instead
from improv_core.syntax.vocabulary import UNITS, WORDS
from improv_core.syntax.word import Kind
from improv_core.syntax.wrong_characters import number_meant
from improv_core.text import Span

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
    if meant := instead(tokens, at):
        return Diagnostic("unknown-name", node.span, *meant)
    if (size := _length_after(tokens, at)) and (drawn := figure(name, "".join(each.text for each in size))):
        fixes = replace(f"Change to {drawn}", Span(node.span.start, size[1].end), drawn)
        return Diagnostic("unknown-name", node.span, f"`{name}` is not defined: write `{drawn}`", fixes)
    if found := _of_body_or_kind(program, index, node):
        return found
    parameters = [each.name for each in statement.parameters]
    near = program.bindings.nearest(name) or closest(name, program.config.part_words)
    drawn = figure(name)
    if (
        near
        and (near in program.bindings.defined or not drawn)
        and not has_more(name, near, lambda each: _is_known(program, each) or each in parameters)
    ):
        message = f"`{name}` is not defined: did you mean `{near}`?"
        return Diagnostic("unknown-name", node.span, message, replace(f"Change to {near}", node.span, near))
    if not drawn and (name in program.parts or name in program.config.robots):
        message = f"`{name}` is a robot, not a movement: name the movement that both perform, and write that name here"
        return Diagnostic("unknown-name", node.span, message)
    if at and name in UNITS and tokens[at - 1].type == "NUMBER" and tokens[at - 1].end == node.span.start:
        measure = f"{tokens[at - 1].text}{name}"
        message = f"`{measure}` is a measure: write it behind a word such as `forward`, `left`, or `radius`"
        return Diagnostic("unknown-name", node.span, message)
    message = f"`{name}` is not defined: write `{name} = {drawn or '…'}` above this line"
    joined = _NUMBERED.fullmatch(name)
    if joined and joined[1] in PRIMITIVES:
        end = node.span.start + len(joined[1])
        word, gone = Token("PRIMITIVE", joined[1], node.span.start, end), Span(end, node.span.end)
        message, fixes = number_first(joined[2], word, True, gone)
        return Diagnostic("unknown-name", node.span, message, fixes)
    if joined and _takes_number(program, index, joined[1]):
        message = f"`{name}` is not defined: write `{joined[1]} {joined[2]}`, with a space"
    elif program.config.path and _takes_a_term(program.meanings[index].body, node):
        message += f", or, if it is a body part, `[profiles.NAME.body.{name}]` in improv.toml"
    above = f"{name} = {drawn or 'rest'}{program.lines.ending(program.offsets[index])}"
    fixes = replace(f"Define {name}{'' if drawn else ' as rest'} above", Span(0, 0), above, guess=True)
    return Diagnostic("unknown-name", node.span, message, fixes)


def misspelled(program: Program) -> Iterator[int]:
    """Yield the definitions of names that unknown names are like. They are used once those are corrected."""
    defined, nearest = program.bindings.defined, program.bindings.nearest
    for index in program.unusual.faulty:
        for name in program.statements[index].uses:
            if name not in defined and (near := nearest(name)):
                yield from defined.get(near, ())


def _of_body_or_kind(program: Program, index: int, node: nodes.Name) -> Diagnostic | None:
    """Return the diagnostic about a pose without `to`, or a profile without `is`; None if the name is neither."""
    name, statement, profiles = node.text, program.statements[index], program.config.profiles
    sign = statement.sign
    if name in profiles and statement.defines and sign and statement.body is node:
        form = f"{statement.defines} is {name}"
        fixes = replace(f"Change to {form}", sign.span, "is")
        return Diagnostic("unknown-name", node.span, f"`{name}` is a profile: write `{form}`", fixes)
    if any(each.body and name in each.body.pose_names for each in profiles.values()):
        fixes = replace(f"Change to to {name}", node.span, f"to {name}")
        return Diagnostic("unknown-name", node.span, f"`{name}` is a pose: write `to {name}`", fixes)
    return None


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
        is_near = _SPACES.fullmatch(usual(text[one.end : other.start]))
        for whole, between in ((one.text + other.text, ""), (f"{one.text}_{other.text}", "_")) if is_near else ():
            if whole in program.bindings.defined or whole in WORDS or whole in program.config.part_words:
                return replace(f"Change to {whole}", Span(one.end, other.start), between)
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
