"""The two orders in which to visit something made of parts, without recursion. Standard library only."""

from __future__ import annotations

from collections.abc import Callable, Hashable, Iterable, Iterator
from typing import TypeVar

from improv_core.slices import checkpoint

T = TypeVar("T")


def inner_first(whole: T, inside: Callable[[T], Iterable[T]], key: Callable[[T], Hashable] = id) -> Iterator[T]:
    """Yield a part and all parts inside it, each once and after those inside itself.

    Parts with the same `key` are the same. Chains of names may be longer than Python's recursion is deep.
    """
    done: set[Hashable] = set()
    waiting = [whole]
    while waiting:
        checkpoint()
        part = waiting[-1]
        if unknown := [each for each in inside(part) if key(each) not in done]:
            waiting += unknown
            continue
        waiting.pop()
        if (own := key(part)) not in done:
            done.add(own)
            yield part


def outer_first(whole: T, inside: Callable[[T], Iterable[T]], key: Callable[[T], Hashable] = id) -> Iterator[T]:
    """Yield a part and all parts inside it, each once and before those inside itself, in the order of the parts."""
    seen: set[Hashable] = set()
    waiting = [whole]
    while waiting:
        part = waiting.pop()
        if (own := key(part)) not in seen:
            seen.add(own)
            yield part
            waiting += reversed([*inside(part)])
