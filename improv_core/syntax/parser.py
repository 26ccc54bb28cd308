"""Parses a statement. Never raises: missing tokens are inserted, extra ones are skipped, and each is reported."""

from __future__ import annotations

import sys
from collections import OrderedDict
from collections.abc import Sequence
from functools import lru_cache

from improv_core.diagnostics import Diagnostic, Fix, replace
from improv_core.score.movement import hold
from improv_core.syntax.brackets import close_brackets
from improv_core.syntax.derivation import Branch, Leaf, derive
from improv_core.syntax.lexer import Token, lex
from improv_core.syntax.nodes import (
    LONGEST,
    Apply,
    Bracket,
    Missing,
    Name,
    Node,
    Parallel,
    Primitive,
    Series,
    Statement,
)
from improv_core.syntax.slips import late_number, without_commas, without_sign
from improv_core.syntax.vocabulary import WORDS
from improv_core.text import Span

DEEPEST = 200
"""How deeply brackets and transformers may be nested."""

# Code that reads a tree recurses up to ten frames per level, which is more than Python's default limit of 1,000.
sys.setrecursionlimit(max(sys.getrecursionlimit(), 5_000))


MOST_KEPT = 4_000_000
"""The most characters of all statements whose trees are cached. A tree takes about 50 bytes per character."""


LONGEST_KEPT = 10_000
"""The most characters of a statement whose tree is cached, so edits to a huge line don't evict everything else."""


def parse_statement(text: str) -> Statement:
    """The tree of one statement and its syntax errors."""
    return _KEPT.get(text) if len(text) <= LONGEST_KEPT else _parsed(text)


class Kept:
    """The trees of the most recently parsed statements, up to `most` characters in all."""

    def __init__(self, most: int) -> None:
        self._most = most
        self._characters = 0
        self._statements: OrderedDict[str, Statement] = OrderedDict()

    def get(self, text: str) -> Statement:
        statements = self._statements
        known = statements.get(text)
        if known is not None:
            statements.move_to_end(text)
            return known
        made = statements[text] = _parsed(text)
        self._characters += len(text)
        while self._characters > self._most:
            self._characters -= len(statements.popitem(last=False)[0])
        return made


_KEPT = Kept(MOST_KEPT)


def _parsed(text: str) -> Statement:
    if len(text) > LONGEST:
        message = f"this statement has more than {LONGEST:,} characters: split it up"
        return Statement(text, (Diagnostic("syntax", Span(0, len(text)), message),), None)
    all_tokens = lex(text)
    if too_deep := _too_deep(all_tokens):
        return Statement(text, (too_deep,), _sign(all_tokens))
    tokens, diagnostics = close_brackets(all_tokens)
    tokens, commas = without_commas(tokens)
    diagnostics += commas
    heads, sign, rest, wrong_heads = _heads(text, tokens)
    diagnostics += wrong_heads
    feed = [*heads, sign, *rest] if sign and sign.type != "BEAT" else rest
    body, wrong_form = _parse(feed)
    if not diagnostics:  # one error, one message: a wrong bracket or head makes the rest look wrong too
        diagnostics += wrong_form
    number = next((token for token in rest if token.type == "NUMBER"), None) if body is None else None
    names = dict.fromkeys(token.text for token in rest if token.type == "NAME")
    defines = heads[0].text if sign and sign.type == "EQUAL" and heads[0].text not in ("", *WORDS) else None
    voices = any(token.type == "BAR" for token in rest)
    return Statement(text, tuple(diagnostics), sign, tuple(heads), body, number, defines, tuple(names), voices)


def _heads(text: str, tokens: Sequence[Token]) -> tuple[list[Token], Token | None, list[Token], list[Diagnostic]]:
    """The names before the sign (as HEAD tokens), the sign, the tokens to parse, and the errors before them."""
    sign = _sign(tokens)
    if sign is None:
        return [], None, list(tokens), [without_sign(tokens)]
    if sign.type == "BEAT":
        return [], sign, list(tokens), []
    place = next(index for index, token in enumerate(tokens) if token is sign)
    before, rest = _joined(text, tokens[:place]), list(tokens[place + 1 :])
    names = [token._replace(type="HEAD") for token in before if token.type not in ("LPAR", "RPAR", "LSQB", "RSQB")]
    what = "a name" if sign.type == "EQUAL" else "a robot's name"
    if not names:
        nothing = Token("HEAD", "", sign.start, sign.start)
        return [nothing], sign, rest, [Diagnostic("syntax", sign.span, f"write {what} before `{sign.text}`")]
    if len(names) < len(before):
        wrong = next(token for token in before if token.type in ("LPAR", "RPAR", "LSQB", "RSQB"))
        names = names[:1] if sign.type == "EQUAL" else names
        return names, sign, rest, [Diagnostic("syntax", wrong.span, f"write {what} without brackets")]
    if sign.type == "EQUAL":
        wrong_name = [token for token in names if not (token.text[0].isalpha() or token.text[0] == "_")]
        if wrong_name:
            message = f"`{wrong_name[0].text}` is not a valid name: start it with a letter or `_`"
            return names[:1], sign, rest, [Diagnostic("syntax", wrong_name[0].span, message)]
        if len(names) > 1:
            return names[:1], sign, rest, [Diagnostic("syntax", names[1].span, "write only one name before `=`")]
    return names, sign, rest, []


def _sign(tokens: Sequence[Token]) -> Token | None:
    for token in tokens:
        if token.type in ("EQUAL", "DOLLAR"):
            return token
    return tokens[0] if tokens and tokens[0].type == "BEAT" else None


def _joined(text: str, tokens: Sequence[Token]) -> list[Token]:
    """Names and strays that touch become one token, so `my-robot` is one invalid name instead of three tokens."""
    joined: list[Token] = []
    for token in tokens:
        last = joined[-1] if joined else None
        if last and last.end == token.start and {last.type, token.type}.isdisjoint({"LPAR", "RPAR", "LSQB", "RSQB"}):
            joined[-1] = Token("STRAY", text[last.start : token.end], last.start, token.end)
        else:
            joined.append(token)
    return joined


def _too_deep(tokens: Sequence[Token]) -> Diagnostic | None:
    """The error if brackets and transformers are nested too deeply. A transformer applies until its term starts."""
    brackets, waiting = [], 0
    for token in tokens:
        if token.type in ("LPAR", "LSQB"):
            brackets.append(waiting)
            waiting += 1
        elif token.type in ("RPAR", "RSQB"):
            waiting = brackets.pop() if brackets else 0
        elif token.type in ("MIRROR", "REPEAT", "REFLECT", "FACTOR"):
            waiting += 1
        elif token.type in ("PRIMITIVE", "NAME"):
            waiting = brackets[-1] + 1 if brackets else 0
        if waiting > DEEPEST:
            message = f"this is nested more than {DEEPEST} levels deep: name a part and use the name"
            return Diagnostic("too-deep", token.span, message)
    return None


def _parse(tokens: Sequence[Token]) -> tuple[Node | None, list[Diagnostic]]:
    """The movement of a statement, and its first syntax error. Later ones may only follow from it."""
    derivation = derive(tuple(token.type for token in tokens))
    diagnostics = []
    if unexpected := derivation.unexpected:
        last = tokens[unexpected.at - 1] if unexpected.at else None
        found = tokens[unexpected.at] if unexpected.at < len(tokens) else None
        if late := late_number(tokens, unexpected.at):
            diagnostics.append(late)
        elif marked := found or last:
            diagnostics.append(Diagnostic("syntax", marked.span, *_wanted(last, found, unexpected.wanted)))
    statement = derivation.statement
    movement = statement.parts[-1] if statement and statement.rule != "tempo" else None
    return _node(movement, tokens) if isinstance(movement, Branch) else None, diagnostics


def _node(shape: Branch, tokens: Sequence[Token]) -> Node:
    """The node of a shape, filled in with these tokens."""
    rule, parts = shape.rule, shape.parts
    if rule == "series":
        items = tuple([_node(part, tokens) for part in parts if isinstance(part, Branch)])
        return items[0] if len(items) == 1 else Series(_span(items[0].span.start, items[-1].span.end), items)
    if rule == "movement":
        voices = tuple([_node(part, tokens) for part in parts if isinstance(part, Branch)])
        return Parallel(_span(voices[0].span.start, voices[-1].span.end), voices)
    first, last = parts[0], parts[-1]
    assert isinstance(first, Leaf)
    token = _token(first, tokens)
    if rule == "word":
        return _primitive(token.text, token.start)
    if rule == "name":
        return _name(token.text, token.start)
    if rule == "missing":
        return Missing(token.span)
    if isinstance(last, Leaf):
        body = _node(parts[1], tokens) if isinstance(parts[1], Branch) else None
        return Bracket(_span(token.start, _token(last, tokens).end), token.type == "LSQB", body)
    term = _node(last, tokens)
    argument = _token(parts[1], tokens) if isinstance(parts[1], Leaf) else None
    return Apply(_span(token.start, term.span.end), token, argument, term)


_span = lru_cache(maxsize=20_000)(Span)


@lru_cache(maxsize=20_000)
def _primitive(text: str, start: int) -> Primitive:
    """Shared by all statements that have this word at this offset: most nodes are primitives."""
    span, word = _span(start, start + len(text)), WORDS[text]
    return Primitive(span, word, hold(word.velocity, span=span))


@lru_cache(maxsize=20_000)
def _name(text: str, start: int) -> Name:
    return Name(_span(start, start + len(text)), text)


def _token(leaf: Leaf, tokens: Sequence[Token]) -> Token:
    if not leaf.inserted:
        return tokens[leaf.at]
    place = tokens[leaf.at].start if leaf.at < len(tokens) else tokens[-1].end if tokens else 0
    return Token(leaf.type, "", place, place)


def _wanted(last: Token | None, found: Token | None, accepts: frozenset[str]) -> tuple[str, tuple[Fix, ...]]:
    """The message about `found` (None at the end of the statement), which comes after `last`, and its fixes."""
    after = f" after `{last.text}`" if last else ""
    if accepts == {"PLANE"}:
        return f"write a plane{after}: YZ, XZ, or XY", ()
    if accepts == {"NUMBER"}:
        example = f", such as `{WORDS[last.text].usage}`" if last and last.text in WORDS else ""
        return f"write a number{after}{example}", ()
    if found is None or found.type in ("BAR", "RPAR", "RSQB"):
        return f"write a movement{after}", ()
    if found.type == "PLANE":
        before = Span(found.start, found.start)
        return f"write `reflect` before `{found.text}`", replace("Insert reflect", before, "reflect ")
    remove = replace(f"Remove {found.text}", found.span, "")
    if found.type == "NUMBER":
        return f"remove `{found.text}`: a number can only follow `repeat`, `fast`, `slow`, or `scale`", remove
    if found.text == "|":
        return "write `||` between movements that play in parallel", replace("Change to ||", found.span, "||")
    if found.text == ",":
        return "remove `,`: separate movements with spaces", remove
    if found.type == "STRAY":
        return f"remove `{found.text}`: it is not part of the language", remove
    return f"remove `{found.text}` or start a new line before it", remove
