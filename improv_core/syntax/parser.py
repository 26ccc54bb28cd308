"""Parse a statement. Never raises: missing tokens are inserted, extra ones are skipped, and each is reported."""

from __future__ import annotations

import dataclasses
import sys
from collections.abc import Sequence
from itertools import pairwise

from improv_core.diagnostics import Diagnostic, Fix, replace
from improv_core.syntax.brackets import BRACKETS, close_brackets
from improv_core.syntax.characters import SEPARATORS
from improv_core.syntax.derivation import Leaf, repair
from improv_core.syntax.descent import SAME, TooDeepError, descend, descend_tempo
from improv_core.syntax.heads import Head, classified, has_measures, split_head
from improv_core.syntax.lexer import Token, lex
from improv_core.syntax.nodes import LONGEST, Node, Number, Statement
from improv_core.syntax.opening import opening_line
from improv_core.syntax.slips import bracketed_number, misplaced_number
from improv_core.syntax.tried_words import either
from improv_core.syntax.vocabulary import WORDS
from improv_core.syntax.wrong_characters import can_remove, number_meant, shown, wrong_character
from improv_core.text import Span

# Code that reads a tree recurses up to ten frames per level, which is more than Python's default limit of 1,000.
sys.setrecursionlimit(max(sys.getrecursionlimit(), 5_000))


MAX_KEPT = 4_000_000
"""The most characters of all statements whose trees are cached. A tree takes about 50 bytes per character."""


LONGEST_KEPT = 10_000
"""The most characters of a statement whose tree is cached, so edits to a huge line don't evict everything else."""


def parse_statement(text: str) -> Statement:
    """Return the tree of one statement and its syntax errors."""
    return _KEPT.get(text) if len(text) <= LONGEST_KEPT else _parsed(text)


class Kept:
    """The trees of the most recently parsed statements, up to `most` characters in all."""

    def __init__(self, most: int) -> None:
        self._most = most
        self.characters = 0
        self._statements: dict[str, Statement] = {}

    def get(self, text: str) -> Statement:
        statements = self._statements
        known = statements.pop(text, None)
        if known is None:
            known = _parsed(text)
            if text in statements:  # it was parsed elsewhere while a checkpoint interrupted this
                return statements[text]
            self.characters += len(text)
        statements[text] = known  # as the latest
        while self.characters > self._most:
            oldest = next(iter(statements))
            del statements[oldest]
            self.characters -= len(oldest)
        return known


_KEPT = Kept(MAX_KEPT)


def _parsed(text: str) -> Statement:
    found = _read(text)
    if not any(word.type == "RADIUS" for word in found.words):
        return found
    other = _read(text, hides_radius=True)
    uses = tuple(dict.fromkeys([*found.uses, *other.uses]))
    return dataclasses.replace(found, uses=uses, as_names=dataclasses.replace(other, uses=uses))


def _read(text: str, hides_radius: bool = False) -> Statement:
    if len(text) > LONGEST:
        message = f"this statement has more than {LONGEST:,} characters: split it up"
        return Statement(text, (Diagnostic("syntax", Span(0, len(text)), message),), None)
    tokens = lex(text)
    head, rest = split_head(text, tokens)
    is_opening = not head.sign or head.sign.type in ("BEAT", "SCENE")
    types = {token.type for token in rest}
    before = tokens[: len(tokens) - len(rest)]
    is_strange = "STRAY" in types or not text.isascii() or "STRAY" in [token.type for token in before]
    strange = wrong_character(text, tokens, _is_right) if is_strange else None
    if is_opening and (line := opening_line(text, tokens)):
        if strange and line.kind == "AT" and text.count(",") == 1 and _is_right(text.replace(",", " ")):
            comma = Span(text.index(","), text.index(",") + 1)
            strange = Diagnostic("syntax", comma, "separate numbers with spaces", replace("Remove ,", comma, " "))
        return dataclasses.replace(line, diagnostics=(strange,), opening=None) if strange else line
    if head.parameters or "GUARD" in types or "IF" in types or ("PRIMITIVE" in types and has_measures(rest)):
        rest = classified(rest, head.parameters, hides_radius)
        types = {token.type for token in rest}
    sign, diagnostics = head.sign and SAME[head.sign], list(head.diagnostics)
    try:
        body, tempo = (descend(rest), None) if head.names else (None, descend_tempo(rest))
        if not body and not tempo:
            if not types.isdisjoint(BRACKETS):
                rest, wrong_brackets = close_brackets(rest)
                diagnostics += wrong_brackets
            body, tempo, wrong_form = parse_and_repair(rest, head)
            if not diagnostics:  # one error, one message: a wrong bracket or head makes the rest look wrong too
                diagnostics += wrong_form
    except TooDeepError as error:
        return Statement(text, (Diagnostic("too-deep", error.span, str(error)),), sign)
    if strange:
        diagnostics = [strange]
    name = head.names[0].text if sign and sign.type == "EQUAL" else None
    movements = {each.name for each in head.parameters if not each.is_number}
    return Statement(
        text,
        tuple(diagnostics),
        sign,
        head.names,
        body,
        tempo,
        name if name and name not in WORDS else None,
        tuple(dict.fromkeys([each.text for each in rest if each.type == "NAME" and each.text not in movements])),
        "BAR" in types,
        not _BY_ROBOT.isdisjoint([token.text for token in rest]),
        "SENSE" in types,
        "NAME" in types and not types.isdisjoint(("NUMBER", "PARAM")) and _has_arguments(rest),
        not types.isdisjoint(_OF_MEASURES) and has_measures(rest),
        head.parameters,
        words=tuple([token for token in rest if token.type in _ELSEWHERE_NAMES]) if types & _ELSEWHERE_NAMES else (),
    )


_OF_MEASURES = frozenset({"NUMBER", "PARAM", "RADIUS"})
_ELSEWHERE_NAMES = frozenset({"UNIT", "RADIUS"})
_BY_ROBOT = frozenset([text for text, word in WORDS.items() if word.by_robot])


def _is_right(text: str) -> bool:
    return len(text) <= LONGEST_KEPT and not parse_statement(text).diagnostics


def _has_arguments(tokens: Sequence[Token]) -> bool:
    """Return whether a number follows a name."""
    types = [token.type for token in tokens]
    return any(map({("NAME", "NUMBER"), ("NAME", "PARAM")}.__contains__, pairwise(types)))


def parse_and_repair(rest: Sequence[Token], head: Head) -> tuple[Node | None, Number | None, list[Diagnostic]]:
    """Return the movement or the tempo of a statement, and its first syntax error. Later ones may only follow from it.

    `rest` are the tokens after the head.
    """
    tokens = [*head.names, head.sign, *rest] if head.sign and head.names else rest
    repaired = repair(tuple([token.type for token in tokens]))
    diagnostics = []
    if unexpected := repaired.unexpected:
        last = tokens[unexpected.at - 1] if unexpected.at else None
        found = tokens[unexpected.at] if unexpected.at < len(tokens) else None
        if marked := found or last:
            wrong = _wrong_kind(found, last, unexpected.wanted, head) if found else None
            wrong = wrong or (number_meant(tokens, unexpected.at) if found else None)
            wrong = wrong or bracketed_number(tokens, unexpected.at)
            wrong = wrong or (None if "SENSE" in unexpected.wanted else misplaced_number(tokens, unexpected.at))
            diagnostics.append(
                wrong or Diagnostic("syntax", marked.span, *_wanted(tokens, unexpected.at, unexpected.wanted)),
            )
    movement = _tokens(repaired.leaves[len(tokens) - len(rest) :], tokens)
    tempo = None if head.names else descend_tempo(movement)
    return (None if tempo else descend(movement)), tempo, diagnostics


def _tokens(leaves: Sequence[Leaf], tokens: Sequence[Token]) -> list[Token]:
    """Return the tokens of a repair. A movement is missing in brackets that are empty only because it has skipped all
    that they had."""
    found: list[Token] = []
    for place, leaf in enumerate(leaves):
        if not leaf.inserted:
            token = tokens[leaf.at]
        else:
            at = tokens[leaf.at].start if leaf.at < len(tokens) else tokens[-1].end if tokens else 0
            token = Token(leaf.type, "", at, at)
        if found and (found[-1].type, token.type) in _PAIRS and leaf.at > leaves[place - 1].at + 1:
            found.append(Token("MISSING", "", found[-1].end, found[-1].end))
        found.append(token)
    return found


_PAIRS = frozenset({("LPAR", "RPAR"), ("LSQB", "RSQB")})
_IN_NUMBERS = frozenset({"NUMBER", "PARAM", "OPERATOR"})
_OF_ITEMS = frozenset(word.text for word in WORDS.values() if word.of_items)
_IN_CONDITIONS = frozenset({"NOT", "SENSE"})


def _wrong_kind(found: Token, last: Token | None, accepts: frozenset[str], head: Head) -> Diagnostic | None:
    """Return the error if `found` is a number in place of a movement, or a movement in place of a number, or multiplies
    the movement that is `last`."""
    is_factor = last is not None and last.type == "NAME" and found.type == "OPERATOR"
    found = last if last and is_factor else found
    name = found.text
    if found.type == "PARAM" and "PRIMITIVE" in accepts:
        message = f"`{name}` is a number here: write `({name})` in the head to make it a movement"
        return Diagnostic("parameter-kind", found.span, message, head.of_other_kind(name))
    if (
        found.type == "NAME"
        and (is_factor or accepts <= _IN_NUMBERS)
        and name in (each.name for each in head.parameters)
    ):
        message = f"`{name}` is a movement here: write it without brackets in the head to make it a number"
        return Diagnostic("parameter-kind", found.span, message, head.of_other_kind(name))
    return None


def _wanted(tokens: Sequence[Token], at: int, accepts: frozenset[str]) -> tuple[str, tuple[Fix, ...]]:
    """Return the message about the token at this index, or about the end of the statement, and its fixes."""
    last, found = tokens[at - 1] if at else None, tokens[at] if at < len(tokens) else None
    after = f" after `{last.text}`" if last else ""
    if accepts == {"PLANE"}:
        before = Span(found.start, found.start) if found else None
        fixes = replace("Insert sagittal", before, "sagittal ", guess=True) if before else ()
        return f"write a plane{after}: `sagittal` mirrors left and right, `frontal` front and back", fixes
    if last and last.type == "SENSE" and (not found or found.type in ("RPAR", "RSQB")):
        guard = next(each.text for each in reversed(tokens[:at]) if each.type in ("GUARD", "IF", "NOT"))
        return f"write the movement after the sense: `{guard} {last.text} (repeat forward)`", ()
    if accepts <= _IN_CONDITIONS:
        wait = f"; to wait, write `repeat {found.text} rest`" if found and found.type == "NUMBER" else ""
        return f"write a sense{after}, such as `cue`{wait}", ()
    if found and found.text in SEPARATORS:
        items = "numbers" if accepts <= _IN_NUMBERS else "movements"
        what, touched = shown(found), [token for token in tokens[at + 1 : at + 2] if token.start == found.end]
        # Before a number it may be a decimal comma without a 0; after one, a decimal comma followed by an extra space.
        may_be_decimal = any(token.type == "NUMBER" for token in (*touched, *tokens[at - 1 : at]))
        remove = replace(f"Remove {found.text}", found.span, " " if touched else "", safe=not may_be_decimal)
        is_safe_to_remove = not touched or touched[0].type != "NUMBER" or (last is not None and last.end == found.start)
        return f"remove {what}: separate {items} with spaces", remove if is_safe_to_remove else ()
    if accepts <= _IN_NUMBERS:
        if last and last.type == "RADIUS":
            return "write a length after `radius`, such as `1m`", ()
        word = next((each for each in reversed(tokens[:at]) if each.type not in _IN_NUMBERS), last)
        arguments = WORDS[word.text].arguments if word and word.text in WORDS else ()
        usage = WORDS[word.text].usage if word and arguments else ""
        lacking = arguments[word is not last :] if last and last.type != "OPERATOR" else ()
        may_follow = found is not None and found.type in ("PRIMITIVE", "NAME", "LPAR", "LSQB")
        number = lacking[0].example if lacking and may_follow else ""
        fixes = (
            replace(f"Insert {number}", Span(found.start, found.start), f"{number} ", guess=True)
            if number and found
            else ()
        )
        return f"write a number{after}{f', such as `{usage}`' if usage else ''}", fixes
    if found is None or found.type in ("BAR", "RPAR", "RSQB"):
        if "ELSE" in accepts:
            return f"write `else` and another movement{after}", ()
        return f"write a movement{after}", ()
    if found.type == "PLANE":
        before = Span(found.start, found.start)
        return f"write `reflect` before `{found.text}`", replace("Insert reflect", before, "reflect ")
    if found.type == "NUMBER" and last and last.type == "EQUAL":
        return f"names stand for movements only: write `{found.text}` where you need it", ()
    if found.type == "NUMBER":
        return f"remove `{found.text}`: a number can only follow a name or a word such as `repeat` or `scale`", ()
    if found.type == "OPERATOR":
        return f"remove `{found.text}`: it can only stand between numbers", ()
    remove = replace(f"Remove {found.text}", found.span, "", guess=True)
    if found.type == "SCENE":
        return f"write `{found.text}` on a line of its own", ()
    if found.type == "ELSE":
        return "remove `else`, or write `if` and a sense before it", remove
    if found.type == "NOT":
        return "remove `not`: it can only follow `until`, `pause`, or `if`", remove
    if found.text in ("+", "&") and last and tokens[at + 1 :]:
        return either(found)
    if found.text == "|" and any(token.text in _OF_ITEMS for token in tokens[:at]):
        return "separate the movements with spaces", replace("Remove |", found.span, "")
    if found.text == "|":
        is_between = "BAR" in accepts and at + 1 < len(tokens)
        fixes = replace("Change to ||", found.span, "||", safe=True) if is_between else ()
        return "write `||` between movements that play in parallel", fixes
    if found.text == "°":
        return "write a turn before these degrees, such as `left 90°`", ()
    if found.type == "STRAY":
        what = shown(found)
        gone = replace("Remove it", found.span, "") if can_remove(tokens, at) else ()
        return f"remove {what}: it is not part of the language", gone
    return f"remove `{found.text}` or start a new line before it", remove
