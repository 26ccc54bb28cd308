"""The standard layout of programs: spaces, line ends, comments, and our characters in place of those that stand for
them. The meaning of a program never changes."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import lru_cache
from itertools import accumulate
from typing import NamedTuple

from improv_core.diagnostics import Edit, Severity
from improv_core.slices import in_slices
from improv_core.syntax.characters import COMMENT, HASHES, usual
from improv_core.syntax.heads import classified
from improv_core.syntax.lexer import Token, lex
from improv_core.syntax.nodes import OfKind, Statement
from improv_core.syntax.parser import LONGEST_KEPT, parse_statement
from improv_core.syntax.statements import split
from improv_core.syntax.vocabulary import TRANSFORMERS
from improv_core.text import LINE_END, Span

WIDTH = 100
"""The most columns of code on a line. Longer brackets are broken over lines; comments may be longer."""

INDENT = "  "
_OPENERS, _CLOSERS = ("LPAR", "LSQB"), ("RPAR", "RSQB")
_IN_NUMBERS = ("NUMBER", "PARAM", "OPERATOR", "UNIT", "RADIUS")
_LEADS = frozenset({*(kind.value for kind in TRANSFORMERS), "IF", "ELSE", "NOT", "SENSE", "PLANE"})
"""Kinds of tokens that a term may start with, besides the numbers of a transformer."""
_COMMENT = re.compile(COMMENT)
_NAMES = ("NAME", "PARAM", "SENSE")
_SPACES = " \t\ufeff"
_BOM = "\ufeff"


def format_text(text: str) -> str:
    """Return the program in the standard layout. Statements with syntax errors stay as they are."""
    pieces, place = [], 0
    for edit in edits(text):
        pieces += [text[place : edit.span.start], edit.text]
        place = edit.span.end
    return "".join([*pieces, text[place:]])


def edits(text: str) -> list[Edit]:
    """Return the edits that give a program the standard layout, in the order of the text. None overlap."""
    parts = [
        _Part(start, source, _cached_lines(source) if len(source) <= LONGEST_KEPT else _lines(source))
        for start, source in in_slices(_parts(text))
    ]
    line_end = _line_end(text, [part for part in parts if part.lines is None])
    mark = _BOM if text.startswith(_BOM) else ""
    made: list[Edit] = []
    place = 0
    for part in in_slices(parts):
        blank = len(LINE_END.findall(text, place, part.start)) > 1
        made.append(Edit(Span(place, part.start), line_end * (1 + blank) if made else mark))
        place = part.start + len(part.source)
        made.append(Edit(Span(part.start, place), part.source if part.lines is None else line_end.join(part.lines)))
    made.append(Edit(Span(place, len(text)), line_end if parts else mark))
    return [edit for edit in made if edit.text != text[slice(*edit.span)]]


@dataclass(frozen=True, slots=True)
class _Part:
    """A statement or a comment line, and the lines it becomes (None if it stays as it is)."""

    start: int
    source: str
    lines: Sequence[str] | None


def _parts(text: str) -> Iterator[tuple[int, str]]:
    """Return the offset and text of each statement and comment line. Only spaces and line ends are between them."""
    place = 0
    for start, source in [*split(text), (len(text), "")]:
        for comment in _COMMENT.finditer(text, place, start):
            yield comment.start(), comment.group().rstrip(_SPACES)
        if source:
            yield start, source
        place = start + len(source)


def _line_end(text: str, kept: Sequence[_Part]) -> str:
    """Return the most common line end, or the first of several. Those in unchanged parts only count without others."""
    others, place = [], 0
    for part in kept:
        others += LINE_END.findall(text, place, part.start)
        place = part.start + len(part.source)
    others += LINE_END.findall(text, place)
    return next(iter(Counter(others or LINE_END.findall(text)).most_common(1)), ("\n", 1))[0]


def _lines(source: str) -> Sequence[str] | None:
    if source.startswith(tuple(HASHES)):
        return ["#" + source[1:]]
    statement = parse_statement(source)
    if _is_wrong(statement) and (not statement.as_names or _is_wrong(statement := statement.as_names)):
        return None
    words = {token.start: token for token in statement.words}
    tokens = [words.get(token.start, token) for token in classified(lex(source), statement.parameters, True)]
    if isinstance(statement.opening, OfKind):  # its profile may have several
        profile = statement.opening.profile
        tokens = [*(token for token in tokens if token.end <= profile.start), profile]
    sign = next(
        (place for place, token in enumerate(tokens) if statement.sign and token.start == statement.sign.start), 0
    )
    return _broken(_flat(source, tokens, sign))


def _is_wrong(statement: Statement) -> bool:
    return any(diagnostic.severity is Severity.ERROR for diagnostic in statement.diagnostics)


_cached_lines = lru_cache(maxsize=20_000)(_lines)  # most statements stay the same between two saves


class _Comment(NamedTuple):
    """A comment: it may be `alone` on its line, and `set_off` by a blank line before it."""

    text: str
    alone: bool
    set_off: bool


@dataclass(frozen=True, slots=True)
class _Flat:
    """A statement on one line, without its comments.

    For each token: its start and end in that line, the comments after it, and the number of comments before it. For
    each opening bracket: the token that closes it. `glued` are the tokens that only a comment may separate from the
    token that follows, and `breaks` those outside all brackets that continue the statement on a new line.
    """

    line: str
    tokens: Sequence[Token]
    starts: Sequence[int]
    ends: Sequence[int]
    comments: Sequence[Sequence[_Comment]]
    comments_before: Sequence[int]
    closers: dict[int, int]
    glued: frozenset[int]
    breaks: frozenset[int]

    def width(self, first: int, last: int) -> int:
        return self.ends[last] - self.starts[first]

    def commented(self, first: int, last: int) -> bool:
        return self.comments_before[last] > self.comments_before[first]

    def breakable(self, index: int) -> bool:
        """Return whether a token is an opening bracket that is not empty."""
        closer = self.closers.get(index, 0)
        return closer > index + 1 or self.commented(index, closer)

    def term_end(self, index: int) -> int:
        """Return the last token of the term that starts here."""
        while index in self.glued:
            index += 1
        return self.closers.get(index, index)

    def line_end(self, index: int) -> int:
        """Return the last token that stays on the line of a token outside brackets, up to the next breakable
        bracket."""
        last = len(self.tokens) - 1
        for later in range(index + 1, last):
            if later in self.breaks:
                return later - 1
            if self.breakable(later):
                return later
        return last


def _flat(source: str, tokens: Sequence[Token], sign: int) -> _Flat:
    line = ""
    starts, ends, opened, breaks = [], [], [], []
    closers: dict[int, int] = {}
    for index, token in enumerate(tokens):
        last = tokens[index - 1] if index else None
        # Tokens that touch before the sign are one name, such as `my-robot`, even if it is invalid.
        touches = last is not None and index < sign and last.end == token.start and last.type not in _CLOSERS
        if last and not (
            (touches and token.type not in _OPENERS)
            or last.type in _OPENERS
            or token.type in _CLOSERS
            or "OPERATOR" in (last.type, token.type)
            or token.type == "UNIT"
        ):
            line += " "
        starts.append(len(line))
        line += _written(source, token)
        ends.append(len(line))
        if token.type in _OPENERS:
            opened.append(index)
        elif token.type in _CLOSERS:
            opener = opened.pop()
            if index > sign:  # the head of a phrase stays on one line: on two, it would not begin a statement
                closers[opener] = index
        elif token.type in ("BAR", "ELSE") and last and not opened and LINE_END.search(source, last.end, token.start):
            breaks.append(index)
    places = [token.start for token in tokens[1:]] + [len(source)]
    comments = [_comments(token, source[token.end : place]) for token, place in zip(tokens, places, strict=True)]
    before = [0, *accumulate(map(len, comments))]
    return _Flat(line, tokens, starts, ends, comments, before, closers, _glued(tokens), frozenset(breaks))


def _written(source: str, token: Token) -> str:
    """Return a token in its usual spelling. Names keep their letters."""
    return usual(source[token.start : token.end]) if token.type in _NAMES else token.text


def _glued(tokens: Sequence[Token]) -> frozenset[int]:
    found = set()
    after_name = False  # the numbers of a name or a primitive end its term, and those of a transformer don't
    for index, token in enumerate(tokens[:-1]):
        number_follows = tokens[index + 1].type in _IN_NUMBERS
        if token.type not in _IN_NUMBERS:
            after_name = token.type in ("NAME", "PRIMITIVE")
        if token.type in _LEADS or (number_follows if after_name else token.type in _IN_NUMBERS):
            found.add(index)
    return frozenset(found)


def _comments(token: Token, gap: str) -> list[_Comment]:
    """Return the comments between a token and the next."""
    found: list[_Comment] = []
    place = 0
    for match in _COMMENT.finditer(gap):
        line_ends = len(LINE_END.findall(gap, place, match.start()))
        opens = not found and token.type in _OPENERS
        found.append(_Comment("#" + match.group()[1:].rstrip(_SPACES), line_ends > 0, line_ends > 1 and not opens))
        place = match.end()
    return found


def _broken(flat: _Flat) -> list[str]:
    """Return the lines of a statement. Brackets that don't fit or contain a comment are broken over lines, outermost
    first.

    Outside of brackets, a `||` or `else` that begins a line still does.
    """
    lines: list[str] = []
    continued = 0  # 1 after a line that begins with `||` or `else`: the rest is indented
    line = ""
    open_until: list[int] = []  # the closing tokens of the broken brackets that contain this token
    index, closed = 0, -1

    def end_line() -> str:
        if line:
            lines.append(line)
        return ""

    while index < len(flat.tokens):
        if open_until and index == open_until[-1]:
            line, closed = end_line(), open_until.pop()
        elif open_until and line and _begins_line(flat, index, len(line), after_broken=closed == index - 1):
            line = end_line()
        elif index in flat.breaks:
            line, continued = end_line(), 1
        indent = INDENT * (len(open_until) + continued)
        line += flat.line[flat.ends[index - 1] : flat.starts[index]] if line else indent
        last, breaks = flat.closers.get(index, index), False
        if flat.breakable(index):
            until = last if open_until else flat.line_end(last)
            breaks = flat.commented(index, last) or len(line) + flat.width(index, until) > WIDTH
        if breaks:
            open_until.append(last)
            last = index
        line += flat.line[flat.starts[index] : flat.ends[last]]
        for comment in flat.comments[last]:
            if comment.alone:
                line = end_line()
                lines += [""] * comment.set_off + [INDENT * max(len(open_until) + continued, 1) + comment.text]
            else:
                line += "  " + comment.text
        if breaks or flat.comments[last]:
            line = end_line()
        index = last + 1
    end_line()
    return lines


def _begins_line(flat: _Flat, index: int, column: int, *, after_broken: bool) -> bool:
    """Return whether a token starts a new line in a broken bracket: voices do, and terms that don't fit on the line."""
    if flat.tokens[index].type == "BAR":
        return True
    if flat.tokens[index - 1].type == "BAR" or index - 1 in flat.glued:
        return False
    end = flat.term_end(index)
    return after_broken or flat.commented(index, end) or column + 1 + flat.width(index, end) > WIDTH
