"""The robots of a score that listen, and warnings about those that don't. It never reads a clock."""

from __future__ import annotations

import math
from collections.abc import Collection, Iterable, Iterator, Set

from improv_core.player.events import Listened
from improv_core.protocol.output import Sink
from improv_core.score.score import Score

PATIENCE = 5.0
"""Seconds to wait for a new robot's listener before beat 0. ROS 2 discovery took up to 2.64 s in measurements on a
quiet machine, and more than 3 s on a busy one."""
ANSWERS = 10.0
"""Seconds to wait before beat 0 for robots that are there and have yet to confirm that they hear us. A sink reports a
robot that doesn't earlier."""
LOOK_PERIOD = 0.5
"""Seconds in which every robot is checked once: whether it still listens, and whether other nodes move it."""
MAX_LINES = 10
"""The most warnings at once. Nobody reads a thousand."""
LOOK_AT = 20
"""The number of robots to check between two setpoints. With ROS 2, each takes about 0.02 ms."""

_TOPIC = "\0"  # stands for a robot's topic in a line about several robots


class Listeners:
    """The listeners of robots. It asks the sink about a few at a time, and collects warnings: each once, with one line
    for all robots that it applies to."""

    def __init__(self, sink: Sink) -> None:
        self._sink = sink
        self._met: dict[str, float] = {}  # when each robot first had a part
        self._awaited: set[str] = set()  # robots that beat 0 waits for, because nothing listens for them yet
        self._expected = 0.0  # the time since when beat 0 waits
        self._waits = False  # true if any of them may still be found
        self._heard: set[str] = set()  # robots that have listened since the score began
        self.away: set[str] = set()
        """Robots that once listened and no longer do."""
        self.standing: set[str] = set()
        """Robots that were away, and stand until the next scene or the next play, or drive back."""
        self._returns = False
        self.next_look = math.inf
        """The time on the clock at which `look_around` is due."""
        self.gone: dict[str, str] = {}
        """Robots that went away and haven't listened since, even if their parts began again, and a line about each."""
        self._looked_at = 0
        self._robots: list[str] = []  # of the score
        self._others: set[str] = set()  # other names that lines are about
        self._warned: dict[str, str | None] = {}
        self._news: dict[str, list[str]] = {}  # for each new line, without its topic, the topics

    def begin(self, score: Score, entering: Collection[str], now: float) -> None:
        """Begin another score, and with it the parts of these robots. The others are checked in their turn: scores may
        come faster than all robots can be checked."""
        self._robots = list(score.parts)
        self._heard = self._heard.difference(entering)
        self.away = self.away.difference(entering)
        self._returns = score.safety.rejoin == "return"
        self.standing = self.standing & score.parts.keys() if self._returns else set()
        for robot in entering:
            self._met.setdefault(robot, now)

    def expect(self, robots: Iterable[str], now: float) -> None:
        """Have beat 0 wait until these robots listen."""
        self._awaited, self._expected, self._waits = set(robots), now, True

    def find(self, now: float, moving: Collection[str] | None) -> Listened:
        """Find the expected robots that hear us since the last check, and ask the others. Those that are `moving` must
        not keep moving meanwhile."""
        before, missing = self._awaited, self._sink.missing(self._awaited)
        self._sink.ask(missing)
        self._awaited, waited = set(missing), self._waits
        self._heard |= before - self._awaited
        self._waits = any(
            now < self._met[robot] + PATIENCE or (line == "" and now < self._expected + ANSWERS)
            for robot, line in missing.items()
        )
        overdue = waited and not self._waits
        return Listened(before - self._awaited, self._waits, moving, frozenset(missing), overdue)

    def readmit(self) -> None:
        """Let robots that stood play again if they listen."""
        self.standing &= self.away

    def forget(self) -> None:
        """Repeat all warnings from now on, since somebody has restarted everything."""
        self._warned, self._news, self.gone, self.standing = {}, {}, {}, set()

    def wait(self, now: float) -> None:
        """Look around after a whole period at most, so that repeated calls don't put it off forever."""
        if abs(self.next_look - now) > LOOK_PERIOD:
            self.next_look = now + LOOK_PERIOD

    def look_around(self, score: Score, now: float, waits: bool) -> tuple[set[str], bool]:
        """Check the next few robots. Return those that stand from now on, and whether all have been checked.

        The sink asks robots that have gone away whether they hear us if they stand, or if playback `waits` until they
        are back.
        """
        robots = self._robots[self._looked_at : self._looked_at + LOOK_AT]
        standing = self.look(score, robots)
        if asked := (self.away if waits else self.away & self.standing).intersection(robots):
            self._sink.ask(asked)
        self._looked_at += LOOK_AT
        done = self._looked_at >= len(self._robots)
        if done:
            self._looked_at = 0
        self.next_look = now + LOOK_PERIOD * min(LOOK_AT / max(len(self._robots), 1), 1)
        return standing, done

    def look(self, score: Score, robots: Collection[str]) -> set[str]:
        """Check some robots of a score. Return those that stand from now on."""
        missing = self._sink.missing(robots)
        lines = {**self._sink.warnings(robots), **missing}
        others = {name for name in lines if name not in score.parts}
        must_stand = {robot for robot in robots if self._must_stand(score, robot, missing.get(robot))}
        for name in [*robots, *(others | self._others)]:
            line = lines.get(name)
            if line == "" or name in self.gone:  # a fault reports that
                continue
            if line and self._warned.get(name) != line:
                topic = score.parts[name].topic if name in score.parts else line
                self._news.setdefault(line.replace(topic, _TOPIC, 1), []).append(topic)
            self._warned[name] = line
        self._others = others
        return must_stand

    @property
    def returning(self) -> Set[str]:
        """The robots that will drive to their parts once they listen."""
        return self.standing if self._returns else frozenset()

    def news(self) -> Iterator[str]:
        """Yield the lines that have come up since the last call. Lines that differ only in their topic are one."""
        lines, self._news = list(self._news.items()), {}
        for line, topics in lines[:MAX_LINES]:
            count = len(set(topics))
            what = topics[0] if count == 1 else f"{count} topics, such as {topics[0]}"
            yield line.replace(_TOPIC, what)
        if len(lines) > MAX_LINES:
            yield f"and {len(lines) - MAX_LINES} more warnings"

    @property
    def unheard(self) -> bool:
        """True if no robot has listened since the score began, as far as is known."""
        return self._heard.isdisjoint(self._robots) and all(map(self._warned.get, self._robots))

    def _must_stand(self, score: Score, robot: str, problem: str | None) -> bool:
        """Note whether a robot has gone away or come back, and return whether it stands from now on."""
        rejoin = score.safety.rejoin
        if problem is None:
            self._heard.add(robot)
            self.away.discard(robot)
            self.gone.pop(robot, None)
        elif not problem:  # it is found, and will confirm in a moment that it hears us
            self.gone.pop(robot, None)
        elif robot in self._heard - self.away:
            self.away.add(robot)
            self.gone[robot] = problem
            if rejoin in ("scene", "return", "next"):
                self.standing.add(robot)
                return True
        elif rejoin == "return" and robot not in self._heard:  # it has missed the beginning
            self.away.add(robot)
            self.standing.add(robot)
            return True
        return False
