"""What the teacher has: the dances that children have sent, what they are, and what is played of them."""

from __future__ import annotations

import asyncio
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

from improv_core.classroom.checker import DanceReader, Prepared
from improv_core.classroom.messages import Command, FromDesk, Perform
from improv_core.classroom.roster import Member
from improv_core.ipc.stage_process import StageError
from improv_core.plain import message, printable
from improv_core.robots.config import Robots
from improv_core.score.score_json import from_json
from improv_core.session.session import Playback
from improv_core.session.state import PlayScore


@dataclass(frozen=True, slots=True)
class Handed:
    """The latest dance of a child, how many it has sent, and what is known about it: nothing until it was looked at."""

    name: str
    text: str = ""
    count: int = 0
    ok: bool = False
    line: str = "has joined"
    picture: str = ""


class Desk:
    """Has the dances looked at, and plays them. Use it from one event loop only.

    `publish` gets what the teacher's pages show. `remove` sends a child out. One of the real `robots` moves only when
    the teacher has it perform a dance that is in front.
    """

    def __init__(
        self,
        playback: Playback,
        publish: Callable[[FromDesk], None],
        remove: Callable[[int], None],
        robots: Robots | None = None,
    ) -> None:
        self._playback, self._publish, self._remove = playback, publish, remove
        self._robots = robots or Robots()
        self._sent: dict[int, Handed] = {}
        self._waiting: dict[int, None] = {}
        self._wake = asyncio.Event()
        self._looking = DanceReader()
        self._preparing = DanceReader()  # a heavy dance that is looked at delays no other one that is to play
        self._plays: asyncio.Task[None] | None = None
        self._line = ""

    def joined(self, member: Member) -> None:
        """A child has come."""
        self._change(member.number, Handed(member.name))

    def handed(self, member: Member, text: str) -> None:
        """A child has sent a dance."""
        before = self._sent.get(member.number)
        if before is None:
            return  # it was just sent out
        self._change(
            member.number,
            replace(before, text=text, count=before.count + 1, ok=False, line="is being read", picture=""),
        )
        self._waiting[member.number] = None
        self._wake.set()

    def messages(self) -> Sequence[FromDesk]:
        """All that a page has to know that was just opened."""
        return [
            {"type": "robots", "names": [*self._robots.robots]},
            *(_shown(number, sent) for number, sent in self._sent.items()),
            {"type": "playing", "line": self._line},
        ]

    async def serve(self) -> None:
        """Impression at what children send, the latest of each, forever."""
        while True:
            while not self._waiting:
                self._wake.clear()
                await self._wake.wait()
            number = next(iter(self._waiting))
            del self._waiting[number]
            if not (sent := self._sent.get(number)):
                continue
            found = await self._looking.look(sent.text)
            now = self._sent.get(number)
            if now and now.count == sent.count:
                self._change(
                    number, replace(now, ok=found["ok"], line=message(found["line"]), picture=found["picture"])
                )

    def take(self, command: Command) -> None:
        """Do what the teacher asks for."""
        if command["type"] == "remove":
            self._remove(command["number"])
            if self._sent.pop(command["number"], None):
                self._publish({"type": "gone", "number": command["number"]})
            return
        asked = self._playback.stops.count
        if self._plays:
            self._plays.cancel()
        if command["type"] == "perform":
            self._plays = asyncio.create_task(self._perform(command, asked))
            return
        chosen = {number: self._sent[number] for number in command["numbers"] if number in self._sent}
        self._plays = asyncio.create_task(self._play(chosen, asked))

    def stopped(self) -> None:
        """The teacher has stopped everything."""
        self._say("Stopped")

    def close(self) -> None:
        """End the processes that look at dances."""
        self._looking.close()
        self._preparing.close()

    async def _play(self, chosen: Mapping[int, Handed], asked: int) -> None:
        """Play dances in the simulator, unless a stop has come since the count of stops was `asked`."""
        if not chosen:
            return
        names = " + ".join(sent.name for sent in chosen.values())
        self._say(f"Reading {names}")
        ready = await self._preparing.prepare([(sent.name, sent.text) for sent in chosen.values()])
        await self._begin(ready, names, asked, simulated=True)

    async def _perform(self, command: Perform, asked: int) -> None:
        """Have a real robot perform a dance, unless a stop has come since the count of stops was `asked`."""
        sent, robot = self._sent.get(command["number"]), command["robot"]
        if sent is None or robot not in self._robots.robots:
            return
        if sent.count != command["count"]:
            self._say(f"{sent.name} has sent another dance: look at it first")
            return
        self._say(f"Reading {sent.name}")
        ready = await self._preparing.embody(sent.name, sent.text, robot, self._robots.text)
        await self._begin(ready, f"{sent.name}, performed by {robot}", asked, simulated=False)

    async def _begin(self, ready: Prepared, names: str, asked: int, *, simulated: bool) -> None:
        """Play what was read, and say what plays, or why it doesn't."""
        if ready["score"] is None:
            self._say(message(ready["problem"]))
            return
        try:
            score = from_json(ready["score"])
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

    def _change(self, number: int, sent: Handed) -> None:
        self._sent[number] = sent
        self._publish(_shown(number, sent))


def _shown(number: int, sent: Handed) -> FromDesk:
    text = "\n".join(map(printable, sent.text.replace("\t", " ").splitlines()))
    return {
        "type": "child",
        "number": number,
        "name": sent.name,
        "count": sent.count,
        "ok": sent.ok,
        "line": sent.line,
        "picture": sent.picture,
        "text": text,
    }
