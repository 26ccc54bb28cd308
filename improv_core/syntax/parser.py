"""A statement's text to its tree. Never raises: what is missing is put in, what is too much left out, and both said."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache, lru_cache
from importlib.resources import files
from typing import Any, cast

from lark import Lark, Transformer, UnexpectedToken
from lark.lexer import Lexer

from improv_core.diagnostics import Diagnostic
from improv_core.syntax.brackets import close_brackets
from improv_core.syntax.lexer import Token, lex
from improv_core.syntax.nodes import Apply, Bracket, Missing, Name, Node, Parallel, Primitive, Series, Statement
from improv_core.syntax.vocabulary import WORDS
from improv_core.text import Span

DEEPEST = 200
"""How many brackets and transformers may stand within one another."""


@lru_cache(maxsize=50_000)
def parse_statement(text: str) -> Statement:
    """The tree of one statement, and what is wrong with its form."""
    all_tokens = tuple(lex(text))
    if too_deep := _too_deep(all_tokens):
        return Statement(text, all_tokens, (too_deep,), _sign(all_tokens))
    tokens, diagnostics = close_brackets(all_tokens)
    heads, sign, rest, wrong_heads = _heads(text, tokens)
    diagnostics += wrong_heads
    feed = [*heads, sign, *rest] if sign and sign.type != "BEAT" else rest
    tree, wrong_form = _parse(feed)
    if not diagnostics:  # one mistake, one message: a bracket or a head that is wrong makes the rest look wrong too
        diagnostics += wrong_form
    number = tree if isinstance(tree, Token) else None
    body = None if isinstance(tree, Token) else tree
    return Statement(text, all_tokens, tuple(diagnostics), sign, tuple(heads), body, number)


@cache
def _lark() -> Lark:
    grammar = files("improv_core.syntax").joinpath("grammar.lark").read_text(encoding="utf-8")
    return Lark(grammar, start="statement", parser="lalr", lexer=_TokensAsTheyAre, transformer=_Build())


def _start() -> Any:
    """An interactive parser (which lark leaves untyped), ready for the first token."""
    return _lark().parse_interactive()


def may_come_next(tokens: Sequence[Token]) -> frozenset[str]:
    """The terminals the grammar accepts after these tokens, which are mended first where they are wrong."""
    parser = _start()
    for token in tokens:
        _feed(parser, token)
    return frozenset(parser.accepts())


class _TokensAsTheyAre(Lexer):
    """Our lexer has done the work; lark only asks for one."""

    def __init__(self, lexer_conf: Any) -> None: ...

    def lex(self, lexer_state: Any, parser_state: Any) -> Any:
        return iter(())


def _span(pieces: Sequence[Token | Node]) -> Span:
    return Span(pieces[0].span.start, pieces[-1].span.end)


class _Build(Transformer[Any, Any]):
    """Makes our nodes while lark parses; one method for each rule of the grammar."""

    def word(self, parts: list[Any]) -> Node:
        return Primitive(parts[0].span, WORDS[parts[0].text])

    def name(self, parts: list[Any]) -> Node:
        return Name(parts[0].span, parts[0].text)

    def missing(self, parts: list[Any]) -> Node:
        return Missing(parts[0].span)

    def bracket(self, parts: list[Any]) -> Node:
        body = parts[1] if len(parts) == 3 else None
        return Bracket(_span(parts), parts[0].type == "LSQB", body)

    def apply(self, parts: list[Any]) -> Node:
        argument = parts[1] if isinstance(parts[1], Token) else None
        return Apply(_span(parts), parts[0], argument, parts[-1])

    def series(self, parts: list[Any]) -> Node:
        return cast(Node, parts[0]) if len(parts) == 1 else Series(_span(parts), tuple(parts))

    def movement(self, parts: list[Any]) -> Node:
        return Parallel(_span(parts), tuple(part for part in parts if not isinstance(part, Token)))

    def tempo(self, parts: list[Any]) -> Any:
        return parts[-1]

    definition = play = loose = tempo


def _heads(text: str, tokens: Sequence[Token]) -> tuple[list[Token], Token | None, list[Token], list[Diagnostic]]:
    """The names before the sign (as HEAD tokens), the sign, the tokens to parse, and what is wrong up to there."""
    sign = _sign(tokens)
    if sign is None:
        return [], None, list(tokens), _without_sign(tokens)
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
        return names, sign, rest, [Diagnostic("syntax", wrong.span, f"write {what} without brackets")]
    if sign.type == "EQUAL":
        wrong_name = [token for token in names if not (token.text[0].isalpha() or token.text[0] == "_")]
        if wrong_name:
            message = f"a name begins with a letter: `{wrong_name[0].text}` can't be one"
            return names[:1], sign, rest, [Diagnostic("syntax", wrong_name[0].span, message)]
        if len(names) > 1:
            return names[:1], sign, rest, [Diagnostic("syntax", names[1].span, "write one name before `=`")]
    return names, sign, rest, []


def _sign(tokens: Sequence[Token]) -> Token | None:
    for token in tokens:
        if token.type in ("EQUAL", "DOLLAR"):
            return token
    return tokens[0] if tokens and tokens[0].type == "BEAT" else None


def _without_sign(tokens: Sequence[Token]) -> list[Diagnostic]:
    whole = Span(tokens[0].start, tokens[-1].end) if tokens else Span(0, 0)
    first = tokens[0] if tokens else None
    if first and first.type == "NAME" and len(tokens) > 1 and tokens[1].type not in ("NAME", "STRAY", "NUMBER"):
        return [Diagnostic("syntax", first.span, f"write `$` after the robot's name: `{first.text} $ …`")]
    if first and first.type not in ("NAME", "STRAY", "NUMBER"):
        return [Diagnostic("syntax", whole, "say which robot moves, or name the movement: `turtle1 $ …` or `name = …`")]
    return [Diagnostic("syntax", whole, "write `robot $ movement`, `name = movement` or `beat 60`")]


def _joined(text: str, tokens: Sequence[Token]) -> list[Token]:
    """Names and strays that touch become one token, so that `my-robot` is one wrong name and not three."""
    joined: list[Token] = []
    for token in tokens:
        last = joined[-1] if joined else None
        if last and last.end == token.start and {last.type, token.type}.isdisjoint({"LPAR", "RPAR", "LSQB", "RSQB"}):
            joined[-1] = Token("STRAY", text[last.start : token.end], last.start, token.end)
        else:
            joined.append(token)
    return joined


def _too_deep(tokens: Sequence[Token]) -> Diagnostic | None:
    """Brackets within brackets, and transformers of transformers; a transformer lasts until its one term begins."""
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
            message = f"name a part and use the name: this is nested deeper than {DEEPEST} levels"
            return Diagnostic("too-deep", token.span, message)
    return None


def _parse(tokens: Sequence[Token]) -> tuple[Any, list[Diagnostic]]:
    parser = _start()
    diagnostics: list[Diagnostic] = []
    last = None
    for token in tokens:
        if mistake := _feed(parser, token):
            diagnostics.append(Diagnostic("syntax", token.span, _wanted(last, token, mistake)))
        last = token
    place = last.end if last else 0
    while True:
        try:
            return parser.feed_token(Token("$END", "", place, place)), diagnostics[:1]
        except UnexpectedToken:
            if last:
                diagnostics.append(Diagnostic("syntax", last.span, _wanted(last, None, parser.accepts())))
            _mend(parser, place)


def _feed(parser: Any, token: Token) -> set[str] | None:
    """Feed a token; where it does not fit, put in what is missing before it, or leave it out. None if it fitted."""
    try:
        parser.feed_token(token)
    except UnexpectedToken:
        wanted: set[str] = parser.accepts()
        trial = parser.copy()
        for mends in range(1, _MOST_MENDS + 1):
            if not _mend(trial, token.start):
                break
            if token.type in trial.accepts():
                for _ in range(mends):
                    _mend(parser, token.start)
                parser.feed_token(token)
                break
        return wanted
    return None


_MOST_MENDS = 2  # `fast ||` lacks a number and a movement


def _mend(parser: Any, place: int) -> bool:
    """Put in the one thing that is missing here, if there is one."""
    wanted = parser.accepts()
    for kind in ("MISSING", "NUMBER", "PLANE"):
        if kind in wanted:
            parser.feed_token(Token(kind, "", place, place))
            return True
    return False


def _wanted(last: Token | None, found: Token | None, accepts: set[str]) -> str:
    """What to write instead of `found` (None at the statement's end), after `last`."""
    after = f" after `{last.text}`" if last else ""
    if accepts == {"PLANE"}:
        return f"write a plane{after}: YZ, XZ or XY"
    if accepts == {"NUMBER"}:
        example = f", such as `{WORDS[last.text].usage}`" if last and last.text in WORDS else ""
        return f"write a number{after}{example}"
    if found is None or found.type in ("BAR", "RPAR", "RSQB"):
        return f"write a movement{after}"
    if found.type == "NUMBER":
        return f"remove `{found.text}`: a number stands only after `repeat`, `fast`, `slow` or `scale`"
    if found.type == "PLANE":
        return f"write `reflect` before `{found.text}`"
    if found.type == "STRAY":
        return _STRAYS.get(found.text, f"remove `{found.text}`: it is not part of the language")
    return f"remove `{found.text}`, or begin a new line before it"


_STRAYS = {
    "|": "write `||` between movements that play in parallel",
    ",": "remove `,`: movements follow one another with only a blank between them",
    "}": "write `)` or `]` instead of `}`",
    "{": "write `(` or `[` instead of `{`",
    "\0": "remove the invisible character here",
}
