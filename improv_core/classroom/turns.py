"""Has children's dances read in turns: the latest of each child, and a light one before a heavy one."""

from __future__ import annotations

import asyncio
from collections import defaultdict
from collections.abc import Callable, Collection, Mapping

from improv_core.classroom.checker import HEAVY, LIMIT, QUICK, DanceReader
from improv_core.classroom.messages import DanceRead, Handed


def next_child(waiting: Collection[int], spent: Mapping[int, float]) -> int:
    """The child whose turn it is: the one whose dances have taken the least processor time so far, in seconds; among
    equals, the first of `waiting`, which has waited longest."""
    return min(waiting, key=lambda number: spent.get(number, 0.0))


class Turns:
    """Two processes read: a dance that takes long in the first one moves to the second, which reads only such dances.
    `tell` gets the results."""

    def __init__(self, tell: Callable[[DanceRead], None], quick: float = QUICK, limit: float = LIMIT) -> None:
        self._tell = tell
        self._quick, self._slow = _Lane(quick), _Lane(limit)
        self._spent: dict[int, float] = defaultdict(float)
        self._latest: dict[int, int] = {}

    def put(self, dance: Handed) -> None:
        """Add a dance that a child has sent."""
        self._latest[dance["number"]] = dance["count"]
        self._slow.drop(dance["number"])
        self._quick.put(dance)

    def forget(self, numbers: Collection[int]) -> None:
        """Drop children that have left."""
        for number in numbers:
            self._latest.pop(number, None)
            self._spent.pop(number, None)
            self._quick.drop(number)
            self._slow.drop(number)

    async def serve(self) -> None:
        """Read dances forever."""
        try:
            await asyncio.gather(self._serve(self._quick), self._serve(self._slow))
        finally:
            self._quick.reader.close()
            self._slow.reader.close()

    async def _serve(self, lane: _Lane) -> None:
        while True:
            dance = await lane.take(self._spent)
            number, count = dance["number"], dance["count"]
            found = await lane.reader.look(dance["text"])
            if self._latest.get(number) != count:
                continue
            self._spent[number] += found["spent"] if found else lane.limit
            if not found and lane is self._quick:
                self._slow.put(dance)
                continue
            ok, line, picture = (found["ok"], found["line"], found["picture"]) if found else (False, HEAVY, "")
            self._tell(DanceRead(type="looked", number=number, count=count, ok=ok, line=line, picture=picture))


class _Lane:
    """Dances that wait for a process that reads each of them for `limit` seconds at most."""

    def __init__(self, limit: float) -> None:
        self.limit, self.reader = limit, DanceReader(limit)
        self._waiting: dict[int, Handed] = {}
        self._some = asyncio.Event()

    def put(self, dance: Handed) -> None:
        self._waiting[dance["number"]] = dance
        self._some.set()

    def drop(self, number: int) -> None:
        self._waiting.pop(number, None)

    async def take(self, spent: Mapping[int, float]) -> Handed:
        while not self._waiting:
            self._some.clear()
            await self._some.wait()
        return self._waiting.pop(next_child(self._waiting, spent))
