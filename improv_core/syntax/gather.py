"""Give names the movements that they take. Their definitions set the number of movements, so the parser can't do this.

Nor does the parser know which names are words for body parts, which take one movement.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Container
from dataclasses import dataclass, replace

from improv_core.syntax.descent import DEEPEST, TooDeepError
from improv_core.syntax.nodes import (
    Apply,
    Bracket,
    Call,
    Choice,
    Name,
    Node,
    Parallel,
    PartTerm,
    PoseTerm,
    Series,
)
from improv_core.text import Span


def gather(
    body: Node, movements_of: Callable[[str], int], parts: Container[str] = (), poses: Container[str] = ()
) -> Node:
    """Return the tree in which each name has the number of following terms that `movements_of` returns, if there are
    enough.

    `parts` are words for body parts, and the name of a pose follows those in `poses`. A name binds as tightly as a
    transformer. Raises TooDeepError.
    """
    return _Gatherer(movements_of, parts, poses).whole(body, 0)


@dataclass(frozen=True, slots=True)
class _Gatherer:
    movements_of: Callable[[str], int]
    parts: Container[str]
    poses: Container[str]

    def whole(self, node: Node, level: int) -> Node:
        """Return the tree of a node that no terms follow which it could take."""
        if isinstance(node, Parallel):
            return replace(node, voices=tuple([self.whole(voice, level) for voice in node.voices]))
        if not isinstance(node, Series):
            return self._term(node, deque(), level)
        rest = deque(node.items)
        items = []
        while rest:
            items.append(self._term(rest.popleft(), rest, level))
        return items[0] if len(items) == 1 else replace(node, items=tuple(items))

    def _term(self, node: Node, rest: deque[Node], level: int) -> Node:
        """Return the term that begins with this node and takes the terms it needs from the rest."""
        if level > DEEPEST:
            raise TooDeepError(node.span)
        if isinstance(node, Name) and node.text in self.parts and rest:
            performed = self._term(rest.popleft(), rest, level + 1)
            return PartTerm(_until(node, performed), node, performed)
        if isinstance(node, Name) and node.text in self.poses and rest and isinstance(rest[0], Name):
            pose = rest.popleft()
            assert isinstance(pose, Name)
            return PoseTerm(_until(node, pose), node, pose)
        if isinstance(node, (Name, Call)):
            return self._called(node, rest, level)
        if isinstance(node, Apply):
            body = self._term(node.body, rest, level + 1)
            return node if body is node.body else replace(node, span=_until(node, body), body=body)
        if isinstance(node, Bracket) and node.body:
            return replace(node, body=self.whole(node.body, level + 1))
        if isinstance(node, Choice):
            then = self.whole(node.then, level + 1)
            otherwise = self._term(node.otherwise, rest, level + 1)
            return replace(node, span=_until(node, otherwise), then=then, otherwise=otherwise)
        return node

    def _called(self, node: Name | Call, rest: deque[Node], level: int) -> Node:
        name, numbers = (node, ()) if isinstance(node, Name) else (node.name, node.numbers)
        wanted = self.movements_of(name.text)
        movements: list[Node] = []
        while rest and len(movements) < wanted:
            movements.append(self._term(rest.popleft(), rest, level + 1))
        return Call(_until(node, movements[-1]), name, numbers, tuple(movements)) if movements else node


def _until(first: Node, last: Node) -> Span:
    return Span(first.span.start, last.span.end)
