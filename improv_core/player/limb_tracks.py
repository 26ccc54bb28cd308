"""Body parts as they are told to move: where their joints stand, and how fast they move. Standard library only.

It never reads a clock. Times are performance times, in seconds.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping
from fractions import Fraction
from itertools import islice

from improv_core.player import setpoints
from improv_core.score.body import Body
from improv_core.score.joints import JointMotion, Limb, joint_moments
from improv_core.score.movement import Exact, Movement, Velocity
from improv_core.score.performance import Mover
from improv_core.score.score import Part

MOST_MOMENTS = 10_000
"""How many moments a jump to another beat walks through to find where joints stand there. It takes about 0.2 s."""


class LimbTrack:
    """One body part of one robot. `limb` says where its joints stand at the time at which it was settled last."""

    def __init__(self, limb: Limb) -> None:
        self.limb = limb
        self._at = 0.0
        self._told: Mapping[str, float] = {}  # how fast its joints move from then on
        self._begins: Exact | None = None  # the beat at which the part that it plays began
        self._entered = limb.positions

    def settle(self, at: float) -> None:
        """Bring it to a time, unless that has passed."""
        if (seconds := at - self._at) > 0:
            self._at = at
            self.limb.turn(self._told, seconds)

    def speeds(self, velocity: Velocity, tempo: Fraction) -> Mapping[str, float]:
        """How fast its joints are to move from now on. Those at a limit don't move beyond it."""
        self.limb.tempo = tempo
        return self.limb.possible(self.limb.velocities(velocity))

    def tell(self, speeds: setpoints.Velocity, at: float) -> dict[str, JointMotion]:
        """Have its joints move at these speeds from a time on."""
        self.settle(at)
        self._told = self.limb.possible(speeds) if isinstance(speeds, Mapping) else {}
        return {name: JointMotion(at, self._told.get(name, 0.0)) for name, at in self.limb.positions.items()}

    @property
    def limit_at(self) -> float:
        """When the first of its joints reaches a limit."""
        return self._at + self.limb.seconds_to_limit(self._told)

    def begin(self, begins: Exact) -> None:
        """It plays a part that began at this beat of the performance. If that is a new part, it begins from here."""
        if begins != self._begins:
            self._begins, self._entered = begins, dict(self.limb.positions)

    def place(self, movement: Movement, beats: Exact, tempo: Fraction) -> None:
        """Stand where a part's movement ideally leads after some beats, as if no sense ever held.

        Ends at the last of `MOST_MOMENTS` if it has more.
        """
        moving = Limb(self.limb.part, self.limb.body, tempo)
        moving.positions = dict(self._entered)
        self.limb.positions, self._told = dict(self._entered), {}
        for moment, velocities, begin in islice(joint_moments(movement, moving), MOST_MOMENTS):
            if moment.start >= beats:
                break
            self.limb.tempo, self.limb.positions = tempo, dict(begin)
            self.limb.move(velocities, min(moment.duration, beats - moment.start))

    def renew(self, body: Body) -> None:
        """Have the joints of a body that was changed. They stay where they are, as far as there are any."""
        before, self.limb = self.limb, Limb(body.part[self.limb.part.name], body, self.limb.tempo)
        for name in self.limb.positions.keys() & before.positions.keys():
            self.limb.positions[name] = body.joint[name].within(before.positions[name])
        self._told = {}


class Limbs:
    """The body parts of all robots that a score moves."""

    def __init__(self) -> None:
        self.track: dict[Mover, LimbTrack] = {}

    def restart(self, robots: Collection[str], performed: float) -> None:
        """Performance time starts over. The joints of these robots are at their starts."""
        self.track = {mover: track for mover, track in self.track.items() if mover.robot not in robots}
        for track in self.track.values():
            track.settle(performed)
            track._at = 0.0

    def cast(self, part: Part, tempo: Fraction) -> list[Mover]:
        """Meet the body parts that a robot's part moves in any scene."""
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
        return movers
