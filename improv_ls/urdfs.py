"""URDFs that improv.toml files name. A large one is read in slices: until then, robots that need it don't play."""

from __future__ import annotations

import threading
from collections.abc import Callable
from concurrent.futures import Future
from functools import partial
from typing import TYPE_CHECKING

from improv_ls.slices import Slices

if TYPE_CHECKING:
    from improv_core.robots.skeletons import Skeleton

SMALL = 100_000
"""Bytes of a URDF that is read at once: that takes about as long as a slice."""
MAX_KEPT = 8
BEING_READ = " is being read"


class Urdfs:
    """The skeletons in URDFs, by their contents. `read` is called on the event loop once another one has been read."""

    def __init__(self, slices: Slices, read: Callable[[], object]) -> None:
        self._slices = slices
        self._read = read
        self._thread = threading.get_ident()
        self._found: dict[bytes, Skeleton | str] = {}
        self.works: dict[bytes, Future[Skeleton | str]] = {}
        """The URDFs that are being read. Once one leaves, `read` has been called."""

    def skeleton_in(self, source: bytes) -> Skeleton | str:
        """Return the skeleton in a URDF, or that it is being read. Other threads, and requests that run in slices, wait
        for it."""
        from improv_core.robots.skeletons import skeleton_in

        if source in self._found:
            return self._found[source]
        if len(source) <= SMALL or self._slices.is_working or threading.get_ident() != self._thread:
            return skeleton_in(source)
        if source not in self.works:
            work = self._slices.begin(partial(skeleton_in, source))
            if work.done():
                return work.result()
            self.works[source] = work
            work.add_done_callback(partial(self._done, source))
        return BEING_READ

    def _done(self, source: bytes, work: Future[Skeleton | str]) -> None:
        self._found[source] = work.result()
        for oldest in [*self._found][:-MAX_KEPT]:
            del self._found[oldest]
        del self.works[source]
        self._read()
