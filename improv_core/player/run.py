"""Everything decided about a performance, as one value: its score, beat, and speed, and the robots that stand."""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping
from dataclasses import dataclass, field, replace
from fractions import Fraction
from functools import cached_property

from improv_core.player.start_gate import Gate
from improv_core.protocol.commands import AUTOMATIONS, Automation, is_muted
from improv_core.protocol.fields import within_reach
from improv_core.protocol.messages import State
from improv_core.safety.interlocks import EmergencyStops
from improv_core.safety.preflight import Standing
from improv_core.score.movement import ENDLESS, Duration, Exact, near
from improv_core.score.outside_clock import Following
from improv_core.score.score import Score
from improv_core.score.takeover import PendingTakeover, never_ends
from improv_core.score.transport import BEATS_PER_BAR, Switch, Transport

Mode = State
"""stopped, waiting (for listeners, before beat 0), playing, paused, or ended."""
ONE = Fraction(1)
"""The pace without a clock from outside."""
EMPTY = Score(Fraction(60), {})
"""The score that plays before anything has been loaded."""


@dataclass(frozen=True, slots=True)
class Silenced:
    """The robots that people have muted, and those that they have soloed."""

    muted: frozenset[str] = frozenset()
    soloed: frozenset[str] = frozenset()


@dataclass(frozen=True)
class Run:
    """A performance at a moment. Only `decide` makes the next one.

    Some methods need the beat at which the last part of this scene is `over`: ENDLESS if senses have yet to decide.
    """

    mode: Mode = "stopped"
    score: Score = EMPTY
    """The score that plays, or played last, with the beats at which its parts began."""
    begun: Score = EMPTY
    """The `score` as it took over, before scenes began that could not be foreseen."""
    scene: int = 0
    """The number of the scene that plays, from 0."""
    generation: int = 0
    """The number of the score."""
    restarted: int = 0
    """The number of the score with which the performance began."""
    transport: Transport = field(default_factory=lambda: Transport(0.0, 0.0, 0, EMPTY.tempo))
    next: PendingTakeover | None = None
    """The score that waits to take over."""
    speed: Fraction = Fraction(1)
    silenced: Silenced = Silenced()
    stood: Mapping[str, float] = field(default_factory=dict)
    """Robots that stand because of a fault, each since a time on the clock."""
    stops: EmergencyStops = field(default_factory=EmergencyStops)
    continues: bool = False
    """True if the pause ends by itself once no condition is left."""
    misplaced: Mapping[str, Standing] | None = None
    """Robots that have to be in their places before a person plays again; None if playing waits for none."""
    anyway: bool = False
    """True if robots need not be in their places."""
    too_near: tuple[str, ...] = ()
    """Robots that are too near to each other; their pause ends when a person resumes it."""
    blind: float = -math.inf
    """The time at which the latest pause for an unseen robot began."""
    gate: Gate | None = None
    """The gate that holds beat 0 back once everything is ready."""
    is_due: bool = False
    """True if beat 0 no longer waits for anything, and comes with the next decision."""
    unasked: bool = False
    """True after a stop that nobody asked for: people are offered to continue from there."""
    startable_by: frozenset[Automation] = AUTOMATIONS
    """The automations that may have robots begin or continue without a person. After a stop, only the automation that
    caused it may, until a person plays again."""
    clock: Following | None = None
    """The clock from outside that this stage follows."""
    pace: Fraction = ONE
    """The factor on the score's tempo and the speed with which this stage follows a clock, or with which the stage that
    leads does."""
    behind: float = 0.0
    """Seconds by which it plays behind the stage that leads."""

    @property
    def beat_period(self) -> float:
        """The seconds that a beat takes."""
        return float(60 / self.tempo)

    @cached_property
    def tempo(self) -> Fraction:
        """The actual tempo in beats per minute, including the speed factor and the pace of a clock from outside."""
        usual = self.score.tempo * self.speed
        return usual if self.pace is ONE else usual * self.pace

    @property
    def bar(self) -> int:
        """The number of beats in a bar."""
        return self.score.bar or BEATS_PER_BAR

    @property
    def slope(self) -> Fraction:
        """Beats that pass for each unit of the clock that is followed: its beats, or a simulation's seconds."""
        return self.speed if self.clock and self.clock.is_music else self.speed * self.score.tempo / 60

    def pace_at(self, rate: float) -> Fraction:
        """Return the pace at which this many units of the clock pass in a second."""
        return within_reach(rate * 60 / float(self.score.tempo) if self.clock and self.clock.is_music else rate)

    @property
    def simulated_pace(self) -> float:
        """The simulated seconds that pass in a second, by which a simulation's robots understand velocities."""
        return float(self.pace) if self.clock and not self.clock.is_music else 1.0

    def later(self, beat: Exact, seconds: float) -> Exact:
        """Return the beat that comes this many seconds after another one, at the run's tempo, even past the end."""
        return near(max(float(beat) + seconds / self.beat_period, 0.0)) if seconds else beat

    def aligned(self, beat: Exact, now: float) -> Run:
        """Return this run with its clock aligned, as it continues from a beat at a time on our clock."""
        if not self.clock or not self.clock.rate:
            return self
        clock = self.clock.aligned(self.slope, float(beat), now)
        return replace(self, clock=replace(clock, looks=self.transport.performed(now)), pace=self.pace_at(clock.rate))

    @property
    def may_move(self) -> bool:
        """True if robots move, or may begin to without another request."""
        if self.mode == "paused":
            return self.continues
        return self.mode in ("waiting", "playing") or self.next is not None

    @property
    def has_next_scene(self) -> bool:
        return self.scene + 1 < self.score.scenes

    def ends(self, over: Duration) -> Duration:
        """Return the beat at which the next scene begins, or the score ends."""
        return over if isinstance(over, float) or not self.has_next_scene else math.ceil(over)

    def is_over(self, beat: Exact, over: Duration) -> bool:
        """Return whether the whole score is over at a beat."""
        return not self.has_next_scene and not isinstance(over, float) and beat >= near(float(over))

    def beats(self, over: Duration) -> Duration:
        """Return the length of the score in beats, as far as that is known."""
        if not self.score.open:
            return self.score.beats
        return ENDLESS if self.has_next_scene else over

    def beat(self, now: float, over: Duration) -> Exact:
        playing = self.mode == "playing"
        return self.transport.beat(now, self.beats(over)) if playing else self.transport.origin

    def switch_time(self, when: Switch, performed: float, beats_per_bar: int, over: Duration) -> float:
        """Return when another score takes over. One that waits for the end of an open score waits until that is known.

        The bars are those of the score that plays, if it sets their length.
        """
        beats = self.beats(over)
        if when == "end" and beats == ENDLESS and not never_ends(self.score):
            return math.inf
        return self.transport.switch_time(when, performed, beats, self.score.bar or beats_per_bar)

    def stands(self, robot: str, standing: Collection[str]) -> bool:
        """True if a robot stands although its part moves it; `standing` are those that wait for the next play."""
        return robot in standing or robot in self.stood or is_muted(robot, self.silenced.muted, self.silenced.soloed)

    def may_start(self, by: Automation | None) -> bool:
        """Return whether an automation may have robots begin or continue. A person (None) always may."""
        return by is None or by in self.startable_by

    def started(self, by: Automation | None) -> Run:
        """Return the run after an allowed request to play. If a person made it, automations may play again."""
        return self if by else replace(self, startable_by=AUTOMATIONS)

    def at_scene_of(self, score: Score, beat: Exact) -> Run:
        """Return the run with this score, at the scene that plays at a beat if no sense ever holds."""
        index, _ = score.scene_at(beat)
        return replace(self, score=score, begun=score, scene=index)

    def left_at(self, beat: Exact) -> Run:
        """Return the run with this as the beat at which playing stopped."""
        return replace(self, transport=replace(self.transport, origin=beat))
