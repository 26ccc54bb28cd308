"""The teacher's desk: the dances that children have sent, their checks, and the one that plays."""

from __future__ import annotations

import asyncio
from collections.abc import Callable, Collection, Sequence
from typing import NamedTuple

from improv_core.classroom.checker import DanceReader, Prepared
from improv_core.classroom.messages import ChildShown, Command, FromChildren, FromDesk, Perform
from improv_core.ipc.stage_process import StageError
from improv_core.plain import message
from improv_core.robots.config import Robots
from improv_core.score.score_json import from_json
from improv_core.session.session import Playback
from improv_core.session.state import PlayScore


class Latest(NamedTuple):
    """A child as pages show it, and its latest dance."""

    child: ChildShown
    text: str


class Desk:
    """Keeps the dances, and plays them. Use it from one event loop only, except `messages` and `text`.

    `publish` gets messages for the teacher's pages. `remove` removes children from the class. A real robot of `robots`
    moves only when the teacher has it perform a dance that is shown in front.
    """

    def __init__(
        self,
        playback: Playback,
        publish: Callable[[FromDesk], None],
        remove: Callable[[Collection[int]], None],
        robots: Robots | None = None,
    ) -> None:
        self._playback, self._publish, self._remove = playback, publish, remove
        self._robots = robots or Robots()
        self._latest: dict[int, Latest] = {}
        self._preparing = DanceReader()
        self._plays: asyncio.Task[None] | None = None
        self._line = ""

    def hear(self, news: FromChildren) -> None:
        """Take a message about a child: it has joined or left, or its dance was sent or read."""
        number = news["number"]
        if news["type"] == "joined":
            shown = ChildShown(type="child", number=number, name=news["name"], count=0, ok=False, line="", picture="")
            self._show({**shown, "line": "has joined"}, "")
        elif news["type"] == "gone":
            self._drop([number])
        elif latest := self._latest.get(number):  # it wasn't just removed
            known = latest.child
            if news["type"] == "handed":
                unread: ChildShown = {**known, "ok": False, "line": "is being read", "picture": ""}
                self._show({**unread, "count": news["count"]}, news["text"])
            elif known["count"] == news["count"]:
                line = message(news["line"])
                self._show({**known, "ok": news["ok"], "line": line, "picture": news["picture"]}, latest.text)

    def text(self, number: int, count: int) -> str | None:
        """A child's `count`-th dance, unaltered; None if it has sent another one since."""
        latest = self._latest.get(number)
        return latest.text if latest and latest.child["count"] == count else None

    def messages(self) -> Sequence[FromDesk]:
        """The messages for a page that was just opened."""
        return [
            {"type": "robots", "names": [*self._robots.robots]},
            *(latest.child for latest in [*self._latest.values()]),
            {"type": "playing", "line": self._line},
        ]

    def take(self, command: Command, asked: int) -> None:
        """Obey a command of the teacher, which arrived when the count of stops was `asked`."""
        if command["type"] == "remove":
            self._remove(command["numbers"])
            self._drop(command["numbers"])
            return
        if self._plays:
            self._plays.cancel()
        if command["type"] == "perform":
            self._plays = asyncio.create_task(self._perform(command, asked))
            return
        chosen = [self._latest[number] for number in dict.fromkeys(command["numbers"]) if number in self._latest]
        if dances := [(each.child["name"], each.text) for each in chosen]:
            self._plays = asyncio.create_task(self._play(dances, asked))

    def stopped(self) -> None:
        """Show that the teacher has stopped everything."""
        self._say("Stopped")

    def close(self) -> None:
        """End the process that prepares dances."""
        if self._plays:
            self._plays.cancel()
        self._preparing.close()

    async def _play(self, dances: Sequence[tuple[str, str]], asked: int) -> None:
        """Play dances in the simulator, unless a stop has come since the count of stops was `asked`."""
        names = " + ".join(name for name, _ in dances)
        self._say(f"Reading {names}")
        await self._begin(await self._preparing.prepare(dances), names, asked, simulated=True)

    async def _perform(self, command: Perform, asked: int) -> None:
        """Have a real robot perform a dance, unless a stop has come since the count of stops was `asked`."""
        latest, robot = self._latest.get(command["number"]), command["robot"]
        if latest is None or robot not in self._robots.robots:
            return
        name, text = latest.child["name"], latest.text
        if latest.child["count"] != command["count"]:
            self._say(f"{name} has sent another dance: look at it first")
            return
        self._say(f"Reading {name}")
        ready = await self._preparing.embody(name, text, robot, self._robots.text)
        await self._begin(ready, f"{name}, performed by {robot}", asked, simulated=False)

    async def _begin(self, ready: Prepared, names: str, asked: int, *, simulated: bool) -> None:
        """Play a dance that was read, and show what plays, or why it doesn't."""
        if ready["score"] is None:
            self._say(message(ready["problem"]))
            return
        try:
            score = await asyncio.to_thread(from_json, ready["score"])  # a long score must not block the loop
            self._playback.present(names, "")
            begun = await self._playback.play(PlayScore(score, names, asked, simulated=simulated))
        except (StageError, ValueError) as problem:
            self._say(message(str(problem)))
            return
        notes = f" ({'; '.join(ready['notes'])})" if ready["notes"] else ""
        self._say(f"{names}{message(notes)}" if begun else "Stopped before it began")

    def _say(self, line: str) -> None:
        self._line = line
        self._publish({"type": "playing", "line": line})

    def _drop(self, numbers: Collection[int]) -> None:
        for number in numbers:
            if self._latest.pop(number, None):
                self._publish({"type": "gone", "number": number})

    def _show(self, child: ChildShown, text: str) -> None:
        """Keep and show the latest news about a child, and its latest dance."""
        self._latest[child["number"]] = Latest(child, text)
        self._publish(child)
