"""The senses of robots, from the latest edges, the keys that people hold, the cue, and values that people force."""

from __future__ import annotations

from collections import deque
from collections.abc import Iterable
from typing import NamedTuple

from improv_core.protocol.commands import Cue, Force, OscSense
from improv_core.protocol.messages import Sensed
from improv_core.score.movement import Exact, near
from improv_core.score.score import Score
from improv_core.score.senses import BUILT_IN, CUE, BuiltIn, Key, OscName, RobotSense, Source


class Foreseen(NamedTuple):
    """An edge of a robot's sense at a beat of the performance."""

    beat: Exact
    what: RobotSense
    value: bool | None


def foreseen(sensed: Sensed) -> Foreseen:
    return Foreseen(near(sensed["beat"]), RobotSense(sensed["robot"], sensed["sense"]), sensed["value"])


class Sensing:
    """The state of all senses and of deadman buttons, and the announced edges."""

    def __init__(self) -> None:
        self._latest: dict[RobotSense, bool | None] = {}
        self._forced: dict[RobotSense, bool] = {}
        self._keys: set[Key] = set()  # keys that people hold
        self._announced: deque[Foreseen] = deque()  # in order
        self.held: frozenset[str] = frozenset()
        """The deadman buttons that are held."""
        self.cued = False
        """True while the cue is given."""
        self.follows = False
        """True if only announced edges count."""
        self.replays = False
        """True if they are from a recording, and not from the stage that leads."""

    def restart(self, *, follows: bool, replays: bool) -> None:
        """Start the performance over. A stage that follows forgets the values of senses."""
        self.follows, self.replays = follows, replays
        if follows:
            self._latest = {}

    def value(self, what: RobotSense, score: Score) -> bool | None:
        """Return the value of a robot's sense now; None if it is unknown."""
        if what in self._forced:
            return self._forced[what]
        part = score.parts.get(what.robot)
        source = part.senses.get(what.sense) if part else None
        if what.sense == CUE and isinstance(source, BuiltIn):
            return self.cued
        if isinstance(source, Key) and not self.follows:
            return source in self._keys
        if isinstance(source, OscName) and not self.follows:
            return self._latest.get(what, False)
        return self._latest.get(what)

    def take(self, what: RobotSense, value: bool | None) -> None:
        self._latest[what] = value

    def hold(self, button: str, held: bool | None) -> None:
        """Handle a deadman button that somebody holds or releases; silence counts as released."""
        self.held = self.held | {button} if held else self.held - {button}

    def hold_key(self, key: Key, held: bool, score: Score) -> list[RobotSense]:
        """Handle a key that somebody holds or releases. Return the senses that it decides."""
        (self._keys.add if held else self._keys.discard)(key)
        return self._decided_by(key, score)

    def hear(self, message: Cue | OscSense | Force, score: Score) -> list[RobotSense]:
        """Take a message about senses. Return those that it decides."""
        match message["type"]:
            case "cue":
                return self._decided_by(BUILT_IN[CUE], score)
            case "osc_sense":
                found = self._decided_by(OscName(message["name"]), score)
                ours = [what for what in found if what.robot == message["robot"] and not self.follows]
                self._latest.update(dict.fromkeys(ours, message["value"]))
                return ours
            case "force":
                what = RobotSense(message["robot"], message["sense"])
                self._forced.pop(what, None)
                if message["value"] is not None:
                    self._forced[what] = message["value"]
                return [what]

    def _decided_by(self, source: Source, score: Score) -> list[RobotSense]:
        """Return the senses of robots that this source decides now: none that is forced."""
        return [
            what
            for robot, part in score.parts.items()
            for sense, each in part.senses.items()
            if each == source and (what := RobotSense(robot, sense)) not in self._forced
        ]

    def is_forced(self, what: RobotSense) -> bool:
        """Return whether a sense has a forced value, so that its edges change nothing."""
        return what in self._forced

    def announce(self, edges: Iterable[Foreseen]) -> None:
        self._announced.extend(edges)

    @property
    def announced(self) -> Exact | None:
        return self._announced[0].beat if self._announced else None

    def take_announced(self) -> list[Foreseen]:
        """Take the announced edges of the next beat that has any."""
        beat, taken = self.announced, list[Foreseen]()
        while self._announced and self._announced[0].beat == beat:
            edge = self._announced.popleft()
            self.take(edge.what, edge.value)
            taken.append(edge)
        return taken

    def forget_announced(self) -> None:
        """Forget the announced edges, because playback jumps."""
        self._announced.clear()
