"""Find the statement, the token, and the nodes at the cursor."""

from __future__ import annotations

from bisect import bisect_left, bisect_right
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from improv_core.program.analysis import Analysis
from improv_core.program.program import Placed
from improv_core.syntax import nodes
from improv_core.syntax.heads import classified, split_head
from improv_core.syntax.lexer import Token, lex
from improv_core.syntax.nodes import Node, Parameter, Statement
from improv_core.syntax.opening import opening_line
from improv_core.syntax.statements import split
from improv_core.text import Span

_MARK = "x"  # stands for the word being typed, so the lexer and the splitter see where it will be


@dataclass(frozen=True, slots=True)
class Cursor:
    """The statement and the token that the cursor touches, and the nodes around the token, outermost first."""

    placed: Placed
    token: Token
    around: tuple[Node, ...]

    @property
    def node(self) -> Node | None:
        """The innermost node that owns the token, if any."""
        return self.around[-1] if self.around else None


def cursor(analysis: Analysis, offset: int, *, before: bool = False) -> Cursor | None:
    """Return the token that the cursor touches. Between two tokens, take the one after the cursor, or that `before`."""
    placed = analysis.statement_at(offset)
    if not placed:
        return None
    place = offset - placed.start
    touching = [token for token in placed.statement.tokens if token.start <= place <= token.end]
    if not touching:
        return None
    token = touching[0 if before else -1]
    # A head may consist of several tokens that touch, such as my-robot.
    token = next((head for head in placed.statement.heads if head.span.holds(place)), token)
    statement = placed.statement
    in_movement = statement.body and token not in statement.heads and token != statement.sign
    return Cursor(placed, token, around(placed.body, token.span) if in_movement else ())


def around(body: Node | None, span: Span) -> tuple[Node, ...]:
    """Return the nodes that contain a whole span, outermost first. The span counts from the start of the statement."""
    found: list[Node] = []
    inside: tuple[Node, ...] = (body,) if body else ()
    while node := next((each for each in inside if each.span.start <= span.start and span.end <= each.span.end), None):
        found.append(node)
        inside = nodes.children(node)
    return tuple(found)


@dataclass(frozen=True, slots=True)
class BeforeCursor:
    """The text before the cursor in its statement, which may have errors.

    `begun` is the word or number that ends at the cursor, if there is one, and `unit` the letters behind the number.
    `heads` and `tokens` are those before it: up to and after the `sign`. Without a sign, all are `heads`. `statement`
    is the index that the statement has or will have, and `parameters` are its own. A line of the opening, such as
    `ada at`, is the `opening`.
    """

    heads: Sequence[Token]
    sign: Token | None
    tokens: Sequence[Token]
    begun: str
    in_number: bool
    statement: int
    parameters: Sequence[Parameter]
    opening: Statement | None = None
    unit: str = ""

    @property
    def measures(self) -> Token | None:
        """The primitive or the `radius` behind which a measure is being typed, or has been."""
        place = len(self.tokens) - 1
        while place >= 0 and self.tokens[place].type in ("NUMBER", "PARAM", "OPERATOR", "UNIT"):
            place -= 1
        head = self.tokens[place] if place >= 0 else None
        return head if head and head.type in ("PRIMITIVE", "RADIUS") else None


def before(analysis: Analysis, offset: int) -> BeforeCursor | None:
    """Read the text before the cursor; None in a comment, and in a statement that is too long to be read."""
    index = bisect_left(analysis.offsets, offset)
    begin = analysis.offsets[index - 1] if index else 0
    pieces = list(split(analysis.text[begin:offset] + _MARK))
    start, piece = pieces[-1] if pieces else (0, "")
    tokens = lex(piece) if len(piece) <= nodes.LONGEST else []
    if not tokens or begin + start + tokens[-1].end != offset + len(_MARK):
        return None
    *tokens, last = tokens
    statement = index - 1 if start == 0 and index else index
    in_number = bool(tokens) and tokens[-1].type == "NUMBER" and tokens[-1].end == last.start
    letters = piece[last.start : last.end - len(_MARK)]
    opening = opening_line(piece, tokens)
    begun = tokens.pop().text if in_number else letters
    unit = letters if in_number else ""
    head, rest = split_head(piece, tokens)
    if head.sign is None or head.sign.type in ("BEAT", "SCENE"):
        return BeforeCursor(tokens, None, (), begun, in_number, statement, (), opening, unit)
    heads = tokens[: len(tokens) - len(rest) - 1]
    rest = classified(rest, head.parameters)
    return BeforeCursor(heads, head.sign, rest, begun, in_number, statement, head.parameters, None, unit)


def touching(analysis: Analysis, span: Span) -> Iterator[Placed]:
    """Yield the statements that a span touches, in the order of the text."""
    for index in range(max(bisect_right(analysis.offsets, span.start) - 1, 0), len(analysis.offsets)):
        placed = analysis.placed(index)
        if placed.start > span.end:
            return
        if placed.span.end >= span.start:
            yield placed
