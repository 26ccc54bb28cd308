"""The teacher's desk: the dances that children have sent, their checks, and the one that plays."""

from __future__ import annotations

import asyncio
import math
from collections.abc import Callable, Collection, Mapping, Sequence
from typing import NamedTuple

from improv_core.classroom.checker import DanceReader, Prepared
from improv_core.classroom.kept import harmless
from improv_core.classroom.messages import (
    ChildShown,
    Command,
    DanceRead,
    DanceShown,
    FromChildren,
    FromDesk,
    Handed,
    Perform,
)
from improv_core.ipc.stage_process import StageError
from improv_core.plain import message
from improv_core.program.files import ENDING
from improv_core.protocol.messages import TransportMessage
from improv_core.robots.config import Robots
from improv_core.score.score_json import from_json
from improv_core.session.session import Playback
from improv_core.session.state import PlayScore


class Known(NamedTuple):
    """A child as pages show it, and the texts of the dances that they show, by their numbers."""

    child: ChildShown
    texts: Mapping[int, str]


def handed_in(known: Known, dance: Handed) -> Known:
    """Return a child that has sent another dance: its latest one that can be played stays."""
    latest = DanceShown(count=dance["count"], sent=dance["sent"], ok=None, line="is being read", picture="")
    good = known.child["good"]
    kept = {count: text for count, text in known.texts.items() if good and count == good["count"]}
    return Known({**known.child, "latest": latest}, {**kept, dance["count"]: dance["text"]})


def read_through(known: Known, found: DanceRead) -> Known:
    """Return a child whose dance was read, unless it has sent another one since."""
    latest = known.child["latest"]
    if not latest or latest["count"] != found["count"]:
        return known
    latest = {**latest, "ok": found["ok"], "line": message(found["line"]), "picture": found["picture"]}
    if not found["ok"]:
        return Known({**known.child, "latest": latest}, known.texts)
    count = found["count"]
    return Known({**known.child, "latest": latest, "good": latest}, {count: known.texts[count]})


class Desk:
    """Keeps the dances, and plays them. Use it from one event loop only, except `text` and `files`.

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
        self._children: dict[int, Known] = {}
        self._preparing = DanceReader()
        self._plays: asyncio.Task[None] | None = None
        self._line = ""
        self._begun = math.inf, ""  # the generation from which on the chosen dances play, and the line for them

    def open(self) -> None:
        """Show the real robots, and that nothing plays."""
        self._publish({"type": "robots", "names": [*self._robots.robots]})
        self._say("")

    def hear(self, news: FromChildren) -> None:
        """Take a message about a child: it has joined or left, or its dance was sent or read. Or one about the folder
        in which dances are kept."""
        if news["type"] == "keeping":
            self._publish({**news, "folder": message(news["folder"]), "problem": message(news["problem"])})
            return
        number = news["number"]
        known = self._children.get(number)
        if news["type"] == "joined":
            new = Known(ChildShown(type="child", number=number, name="", here=True, latest=None, good=None), {})
            child, texts = known or new
            self._show(Known({**child, "name": news["name"], "here": news["here"]}, texts))
        elif news["type"] == "gone":
            self._drop([number])
        elif known:  # it wasn't just removed
            self._show(handed_in(known, news) if news["type"] == "handed" else read_through(known, news))

    def text(self, number: int, count: int) -> str | None:
        """A child's `count`-th dance, unaltered; None if pages don't show it any more."""
        known = self._children.get(number)
        return known.texts.get(count) if known else None

    def files(self) -> Sequence[tuple[str, str]]:
        """The names and the texts of files with all dances that pages show."""
        found = []
        for child, texts in [*self._children.values()]:
            latest, good = child["latest"], child["good"]
            name = f"{child['number']:03}-{harmless(child['name'])}"
            if good:
                found.append((f"{name}{ENDING}", texts[good["count"]]))
            if latest and latest != good:
                found.append((f"{name}-latest{ENDING}", texts[latest["count"]]))
        return found

    def take(self, command: Command, asked: int) -> None:
        """Obey a command of the teacher, which arrived when the count of stops was `asked`."""
        if command["type"] == "remove":
            self._remove(command["numbers"])
            self._drop(command["numbers"])
            return
        if self._plays:
            self._plays.cancel()
        self._begun = math.inf, ""
        if command["type"] == "perform":
            self._plays = asyncio.create_task(self._perform(command, asked))
            return
        chosen = [self._children[number] for number in dict.fromkeys(command["numbers"]) if number in self._children]
        dances = [(child["name"], texts[good["count"]]) for child, texts in chosen if (good := child["good"])]
        without = " + ".join(child["name"] for child, _ in chosen if not child["good"])
        if dances:
            self._plays = asyncio.create_task(self._play(dances, without, asked))

    def follow(self, transport: TransportMessage) -> None:
        """Show what has become of the dances that play: they can be paused, stopped, and resumed elsewhere, too."""
        since, line = self._begun
        others = {"paused": f"{line}: paused", "ended": f"{line}: ended", "stopped": "Stopped"}
        shown = others.get(transport["state"], line)
        if transport["generation"] >= since and shown != self._line:
            self._say(shown)

    def stopped(self) -> None:
        """Show that the teacher has stopped everything."""
        self._say("Stopped")

    def close(self) -> None:
        """End the process that prepares dances."""
        if self._plays:
            self._plays.cancel()
        self._preparing.close()

    async def _play(self, dances: Sequence[tuple[str, str]], without: str, asked: int) -> None:
        """Play dances in the simulator, `without` the children who were also chosen, unless a stop has come since the
        count of stops was `asked`."""
        names = " + ".join(name for name, _ in dances)
        self._say(f"Reading {names}")
        ready = await self._preparing.prepare(dances)
        if without:
            ready["notes"] = [f"without {without}: no dance that plays", *ready["notes"]]
        await self._begin(ready, names, asked, simulated=True)

    async def _perform(self, command: Perform, asked: int) -> None:
        """Play the dance that is shown, by a real robot or in the simulator, unless a stop has come since the count of
        stops was `asked`."""
        known, robot = self._children.get(command["number"]), command["robot"]
        if known is None or (robot and robot not in self._robots.robots):
            return
        name, good = known.child["name"], known.child["good"]
        if not good or good["count"] != command["count"]:
            self._say(f"{name} has sent another dance: look at it first")
            return
        text = known.texts[good["count"]]
        if not robot:
            await self._play([(name, text)], "", asked)
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
            self._playback.present(names, "", names=ready["names"])
            begun = await self._playback.play(PlayScore(score, names, asked, simulated=simulated))
        except (StageError, ValueError) as problem:
            self._say(message(str(problem)))
            return
        notes = f" ({'; '.join(ready['notes'])})" if ready["notes"] else ""
        line = f"{names}{message(notes)}"
        if begun:
            self._begun = begun, line
        self._say(line if begun else "Stopped before it began")

    def _say(self, line: str) -> None:
        self._line = line
        self._publish({"type": "playing", "line": line})

    def _drop(self, numbers: Collection[int]) -> None:
        for number in numbers:
            if self._children.pop(number, None):
                self._publish({"type": "gone", "number": number})

    def _show(self, known: Known) -> None:
        """Keep and show the latest news about a child."""
        self._children[known.child["number"]] = known
        self._publish(known.child)
