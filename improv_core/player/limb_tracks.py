"""Body parts as they are commanded: where their joints stand, and how fast they move. Standard library only.

It never reads a clock. Times are performance times, in seconds.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from fractions import Fraction
from itertools import zip_longest
from typing import NamedTuple

from improv_core.player import setpoint_queue
from improv_core.score.body import Body
from improv_core.score.budget import Budget, TooLongError
from improv_core.score.joints import DisturbedError, JointMotion, JointOutcomes, Limb
from improv_core.score.movement import Exact, Movement, Velocity
from improv_core.score.performance import Mover
from improv_core.score.score import Part
from improv_core.score.walk import walk

MAX_LEARNED = 100_000
"""The most parts of movements that are visited before a dance begins, to compute where they lead joints."""


MAX_PLACED = 3_000
"""The most parts of movements that a jump visits to compute where all joints stand then. It takes 0.1 s at most."""


class LimbTrack:
    """One body part of one robot. `limb` has the positions of its joints when it was settled last."""

    def __init__(self, limb: Limb) -> None:
        self.limb = limb
        self._at = 0.0
        self._told: Mapping[str, float] = {}  # the speeds of its joints from then on
        self._begins: Exact | None = None  # the beat at which the part that it plays began
        self._entered = limb.positions
        self._scenes: tuple[Movement, ...] = ()  # the scenes that it may perform, and its parts of them
        self._performed: dict[int, Movement] = {}
        self._outcomes = JointOutcomes(limb.part, limb.body)

    def settle(self, at: float) -> None:
        """Advance it to a time, unless that has passed."""
        if (seconds := at - self._at) > 0:
            self._at = at
            self.limb.turn(self._told, seconds)

    def speeds(self, velocity: Velocity, tempo: Fraction) -> Mapping[str, float]:
        """Return the speeds of its joints from now on. A joint at a limit doesn't move beyond it."""
        self.limb.tempo = tempo
        return self.limb.possible(self.limb.velocities(velocity))

    def tell(self, speeds: setpoint_queue.Velocity, at: float) -> dict[str, JointMotion]:
        self.settle(at)
        self._told = self.limb.possible(speeds) if isinstance(speeds, Mapping) else {}
        return {name: JointMotion(at, self._told.get(name, 0.0)) for name, at in self.limb.positions.items()}

    @property
    def limit_at(self) -> float:
        """The performance time at which the first of its joints reaches a limit."""
        return self._at + self.limb.seconds_to_limit(self._told)

    def begin(self, begins: Exact) -> None:
        """Note that it plays a part that began at this beat of the performance. A new part begins from here."""
        if begins != self._begins:
            self._begins, self._entered = begins, dict(self.limb.positions)

    def performs(self, scene: Movement) -> Movement:
        """Return its part of a scene that it was given by `set_scenes`."""
        if id(scene) not in self._performed:
            self._performed[id(scene)] = self.limb.performs(scene)
        return self._performed[id(scene)]

    def set_scenes(self, scenes: tuple[Movement, ...]) -> None:
        if not all(one is other for one, other in zip_longest(scenes, self._scenes)):
            self._scenes, self._outcomes = scenes, JointOutcomes(self.limb.part, self.limb.body)
            known = set(map(id, scenes))
            self._performed = {key: each for key, each in self._performed.items() if key in known}

    def learn(self, budget: Budget) -> None:
        """Compute where all its scenes lead, so that a jump takes no time. Raises TooLongError."""
        for scene in self._scenes:
            if scene.dice:
                continue  # each time through may lead elsewhere
            with suppress(DisturbedError):
                self._outcomes.positions({}, self.performs(scene), scene.duration, budget)

    def place(self, part: Part, beat: Exact, budget: Budget) -> None:
        """Stand where a part ideally leads at a beat, as if no sense ever held.

        Raises TooLongError if that takes too long to compute; then the joints stand where the scenes before lead.
        """
        self.limb.positions, self._told = dict(self._entered), {}
        begins = (part.begins, *part.scene_begins[1:])
        for scene, begin in zip(part.scenes[part.scene :], begins, strict=False):
            if begin < beat:
                self._pass(self.performs(scene), beat - begin, budget)

    def _pass(self, movement: Movement, beats: Exact, budget: Budget) -> None:
        try:
            self.limb.positions = self._outcomes.positions(self.limb.positions, movement, beats, budget)
        except DisturbedError:
            for moment in walk(movement, merge=True):
                if moment.start >= beats:
                    break
                budget.spend(1)
                self.limb.move(self.limb.velocities(moment.velocity), min(moment.duration, beats - moment.start))

    def renew(self, body: Body) -> None:
        """Take over a changed body. Joints that it still has stay where they are."""
        before, self.limb = self.limb, Limb(body.part[self.limb.part.name], body, self.limb.tempo)
        for name in self.limb.positions.keys() & before.positions.keys():
            self.limb.positions[name] = body.joint[name].within(before.positions[name])
        self._told = {}
        self._scenes, self._performed = (), {}


class Limbs:
    """The body parts of all robots that a score moves."""

    def __init__(self) -> None:
        self.track: dict[Mover, LimbTrack] = {}

    def restart(self, robots: Collection[str], performed: float) -> None:
        """Start performance time over. The joints of these robots are at their starts."""
        self.track = {mover: track for mover, track in self.track.items() if mover.robot not in robots}
        for track in self.track.values():
            track.settle(performed)
            track._at = 0.0

    def learn(self, parts: Iterable[Part], tempo: Fraction) -> None:
        """Compute where all parts lead the joints, before robots play them."""
        budget = Budget(MAX_LEARNED)
        with suppress(TooLongError):
            for part in parts:
                for mover in self.movers_of(part, tempo):
                    self.track[mover].learn(budget)

    def place(self, parts: Mapping[str, Part], tempo: Fraction, beat: Exact) -> tuple[Sequence[Mover], Collection[str]]:
        """Move the joints of all parts to where they ideally stand at a beat. Return their movers, and the robots for
        which that takes too long to compute."""
        movers, far = [mover for part in parts.values() for mover in self.movers_of(part, tempo)], dict[str, None]()
        for mover in movers:
            try:
                self.track[mover].place(parts[mover.robot], beat, Budget(MAX_PLACED // len(movers)))
            except TooLongError:
                far[mover.robot] = None
        return movers, far

    def movers_of(self, part: Part, tempo: Fraction) -> list[Mover]:
        """Return the movers of the body parts that a robot's part moves in any scene. Each gets a track."""
        body = part.profile.body
        if not body:
            return []
        asked = (each for scene in part.scenes for each in scene.body_words.asked)
        movers = [Mover(part.robot, name) for name in body.moved_by(asked)]
        for mover in movers:
            known = self.track.get(mover)
            if not known:
                self.track[mover] = LimbTrack(Limb(body.part[mover.part], body, tempo))
            elif known.limb.body != body:
                known.renew(body)
            self.track[mover].set_scenes(part.scenes)
        return movers


class _Command(NamedTuple):
    robot: str
    joints: Mapping[str, JointMotion]
    at: float


class JointCommands:
    """Commands to joints, sent by `send`, which may raise any exception.

    Commands to one robot for the same time are merged: a controller of several body parts gets one message.
    """

    def __init__(self, send: Callable[[str, Mapping[str, JointMotion], float], None]) -> None:
        self._send = send
        self._gathers = False
        self._held: _Command | None = None

    def move(self, robot: str, track: LimbTrack, velocity: setpoint_queue.Velocity, at: float) -> None:
        """Move a body part of a robot from performance time `at` on."""
        self.tell(robot, track.tell(velocity, at), at)

    def tell(self, robot: str, joints: Mapping[str, JointMotion], at: float) -> None:
        """Move some of a robot's joints from performance time `at` on."""
        before, self._held = self._held, _Command(robot, joints, at)
        if before and (before.robot, before.at) == (robot, at):
            self._held = _Command(robot, {**before.joints, **joints}, at)
        elif before:
            self._send(*before)  # if that fails, this one is still sent
        if not self._gathers:
            self._flush()

    @contextmanager
    def together(self) -> Iterator[None]:
        """Gather commands within this context: those to joints of one robot, for the same time, are sent at once."""
        self._gathers = True
        try:
            yield
        finally:
            self._gathers = False
            self._flush()

    def _flush(self) -> None:
        held, self._held = self._held, None
        if held:
            self._send(*held)
