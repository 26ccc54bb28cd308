"""What stands where the cursor is."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from improv_core.analysis import Analysis, Placed
from improv_core.syntax import nodes
from improv_core.syntax.lexer import Token
from improv_core.syntax.nodes import Node


@dataclass(frozen=True, slots=True)
class Cursor:
    """The statement and the token that the cursor touches, and the innermost node that owns the token, if any."""

    placed: Placed
    token: Token
    node: Node | None


def cursor(analysis: Analysis, offset: int) -> Cursor | None:
    """What the cursor touches; between two tokens, the one behind it."""
    placed = analysis.statement_at(offset)
    if not placed:
        return None
    place = offset - placed.start
    touching = [token for token in placed.statement.tokens if token.start <= place <= token.end]
    if not touching:
        return None
    token = touching[-1]
    # A head may be made of several tokens that touch, such as my-robot.
    token = next((head for head in placed.statement.heads if head.span.holds(place)), token)
    return Cursor(placed, token, _owner(placed.statement, token))


def _owner(statement: nodes.Statement, token: Token) -> Node | None:
    if not statement.body or token in statement.heads or token == statement.sign:
        return None
    around: Sequence[Node] = [
        node for node in nodes.nodes(statement.body) if node.span.start <= token.start and token.end <= node.span.end
    ]
    return around[-1] if around else None
