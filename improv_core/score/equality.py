"""Compares movements, apart from where they are written. Standard library only."""

from __future__ import annotations

from improv_core.score.algebra import FromStatement
from improv_core.score.movement import Movement

WHERE = frozenset({"span", "statement"})
"""The fields that only say where a movement is written."""


def same(one: Movement, other: Movement) -> bool:
    """Return whether two movements are made alike, names aside, and throw alike: then they play alike.

    Shared movements are compared once, by Hopcroft and Karp's algorithm for finite automata: each pair is taken as
    equal while the parts are compared, so each distinct movement is compared at most once. It needs no recursion.
    """
    leaders: dict[int, int] = {}

    def leader(key: int) -> int:
        while (above := leaders.get(key, key)) != key:
            leaders[key] = leaders.get(above, above)
            key = above
        return key

    waiting = [(one, other)]
    while waiting:
        first, second = map(_without_names, waiting.pop())
        one_leader, other_leader = leader(id(first)), leader(id(second))
        if one_leader == other_leader:
            continue
        inner, others = first.parts, second.parts
        if not _are_alike(first, second) or len(inner) != len(others):
            return False
        leaders[one_leader] = other_leader
        waiting += zip(inner, others, strict=True)
    return True


def _without_names(movement: Movement) -> Movement:
    while isinstance(movement, FromStatement):
        movement = movement.body
    return movement


def _are_alike(one: Movement, other: Movement) -> bool:
    """Return whether two movements are the same if their parts are."""
    return type(one) is type(other) and one.duration == other.duration and _own(one) == _own(other)


def _own(movement: Movement) -> list[object]:
    """Return the fields of a movement, except those that say where it is written."""
    return [getattr(movement, name) for name, _ in movement.FIELDS if name not in WHERE]
