"""The order in which to compute something made of parts: inner parts first. Standard library only."""

from __future__ import annotations

from collections.abc import Callable, Hashable, Iterable, Iterator
from typing import TypeVar

from improv_core.slices import checkpoint

T = TypeVar("T")


def inner_first(whole: T, inside: Callable[[T], Iterable[T]], key: Callable[[T], Hashable] = id) -> Iterator[T]:
    """Yield a part and all parts inside it, each once and after those inside itself.

    Parts with the same `key` are the same. It needs no recursion, so it can follow long chains of names.
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
