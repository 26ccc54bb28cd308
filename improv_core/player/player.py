"""The interface through which a stage uses its player. The rest is in `engine.py`.

It never reads a clock; callers pass the time in. `now` is the clock's time in seconds.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Iterable
from dataclasses import replace

from improv_core.player import events
from improv_core.player.engine import Engine
from improv_core.player.run import Mode
from improv_core.player.sensing import Foreseen
from improv_core.player.start_gate import Gate
from improv_core.protocol.commands import Automation
from improv_core.protocol.messages import Poses, When
from improv_core.protocol.output import Edge, RawJoints, RawPose, StopButton
from improv_core.safety.interlocks import EmergencyStops
from improv_core.score.peer_clock import Anchor
from improv_core.score.score import Score
from improv_core.score.senses import CUE, BuiltIn, Key, OscName, RobotSense
from improv_core.score.takeover import Takeover
from improv_core.score.transport import BEATS_PER_BAR


class Player(Engine):
    """Plays one score at a time on a sink and reports what it does in messages (see docs/protocol.md)."""

    @property
    def state(self) -> Mode:
        """stopped, waiting (for listeners), playing, paused, or ended."""
        return self.run.mode

    @property
    def generation(self) -> int:
        """The number of the score that plays, or played last."""
        return self.run.generation

    @property
    def score(self) -> Score:
        """The score that plays, or played last, with the beats at which its parts began."""
        return self.run.score

    @property
    def reached(self) -> float:
        """The time on the clock up to which everything has been sent."""
        return self._tracks.reached

    @property
    def stops(self) -> EmergencyStops:
        """The emergency stops that are on."""
        return self.run.stops

    @stops.setter
    def stops(self, stops: EmergencyStops) -> None:
        self._tracks.run = replace(self.run, stops=stops)

    @property
    def backend(self) -> str:
        """The output that plays everything, in words for people."""
        return self._tracks.backend

    @backend.setter
    def backend(self, backend: str) -> None:
        self._tracks.backend = backend

    # Requests of people and of the stage that leads

    def load(
        self,
        score: Score,
        generation: int,
        when: When,
        now: float,
        entry: Takeover | None = None,
        beats_per_bar: int = BEATS_PER_BAR,
        senses: Iterable[Foreseen] | None = None,
        stops: int | None = None,
        anyway: bool = False,
        gate: Gate | None = None,
        not_before: float = -math.inf,
        late: float = 0.0,
        by: Automation | None = None,
    ) -> None:
        """Play a score: `restart` from beat 0 and start poses, or take over `now`, at the next `beat` or `bar`, or at
        the `end`.

        A score that takes over is an edit of the one that plays: the beat keeps counting, parts of the same edition
        play on, and all others begin. `entry` has the time of the takeover if another stage has decided it. If playback
        is paused, the score continues from there; if nothing plays, it restarts. If `senses` are given, robots sense
        only these after a restart. A score that moves real robots is refused while an emergency stop is on, or if one
        was pressed after the request, before which there were `stops` presses. One that an automation requests (`by`
        its name) is refused after a stop that wasn't its own. After a restart, a `gate` holds beat 0 back. A score
        takes over `not_before` this time on the clock. One that comes `late` seconds late still takes over when it did
        in other stages.
        """
        bar = max(beats_per_bar, 1)
        load = events.Load(score, generation, when, entry, bar, senses, stops, anyway, gate, not_before, late, by)
        if entry:
            self._tracks.informed = now
        self._take(load, now)

    def stop(self, now: float, by: Automation | None = None) -> None:
        """Stop every robot at once. If one can't be stopped, the others still are, and the first exception is raised.
        After that, only a person, or the automation that the stop was `by`, can have robots move again.

        Does nothing while the player waits for listeners only to stop their robots: none of them would hear it yet.
        """
        self._take(events.Stop(by), now)

    def pause(self, now: float) -> None:
        """Stop every robot at once, to resume from here later."""
        self._catch_up(now)
        self._take(events.Pause(), now)

    def resume(self, now: float, *, anyway: bool = False, late: float = 0.0, by: Automation | None = None) -> None:
        """Begin an armed score, or continue a paused one, as soon as nothing has to be waited for. An automation (`by`
        its name) can't do so after a stop that wasn't its own.

        Robots whose poses are in the world must be in their places, except with `anyway`. If other stages did it `late`
        seconds ago, this one continues from where they are now. The same holds for `seek` and `set_speed`.
        """
        self._take(events.Resume(anyway, late, by), now)

    def seek(self, beat: float, now: float, late: float = 0.0) -> None:
        """Jump to another beat and keep playing, or stay paused there. Simulated robots move to their poses there.

        Decisions of senses are forgotten: up to that beat, it is as if no sense had been true. Does nothing before beat
        0, or if nothing has been loaded.
        """
        self._take(events.Seek(beat, late), now)

    def set_speed(self, factor: float, now: float, late: float = 0.0) -> None:
        """Set the speed factor, 0.1 to 4. Later scores keep it."""
        self._catch_up(now)
        self._take(events.Speed(factor, late), now)

    def hear_clock(self, anchor: Anchor, now: float) -> None:
        """Follow a clock from outside, if the score wants that."""
        self._catch_up(now)
        self._take(events.Anchored(anchor), now)

    def bend(self, pace: float, beat: float, at: float, now: float) -> None:
        """Play as the stage that leads does, which was at a beat at a time on the clock and plays at this pace."""
        self._catch_up(now)
        self._take(events.Bend(pace, beat, at), now)

    def stand(self, robot: str, now: float) -> None:
        """Have a simulated robot stand because the real one does, until somebody unmutes it."""
        self._catch_up(now)
        self._take(events.Stand(robot), now)

    def set_silent(self, muted: Collection[str], soloed: Collection[str], now: float) -> None:
        """Have muted robots, or all except soloed ones, stand still while others play. Applies to later scores too."""
        self._catch_up(now)
        self._take(events.Silence(muted, soloed), now)

    # Senses and measurements

    def sense(self, edge: Edge, now: float) -> None:
        """Handle an edge. An emergency stop stops all robots, releasing the deadman button pauses them, and a sense
        makes its robot react."""
        if isinstance(edge.what, RobotSense):
            self._catch_up(max(min(edge.at, now), self.reached))
            self._tracks.sense(edge.what, edge.value, edge.at, now)
        elif isinstance(edge.what, StopButton):
            self._take(events.EmergencyStop(edge.what.topic, bool(edge.value)), now)
        else:
            self._tracks.sensing.hold(edge.what, edge.value)
            self._take(events.Changed(), now)

    def cue(self, now: float) -> None:
        """Give the cue, which holds for an instant."""
        self._catch_up(now)
        for robot, part in list(self.score.parts.items()):
            if isinstance(part.senses.get(CUE), BuiltIn):
                self._tracks.sense(RobotSense(robot, CUE), True, now, now)

    def hold_key(self, key: str, held: bool, now: float) -> None:
        """Handle a key that somebody holds or releases: the senses that are declared with it become true or false."""
        self._catch_up(now)
        self._tracks.sensing.hold_key(key, held)
        for robot, part in list(self.score.parts.items()):
            for sense, source in part.senses.items():
                if isinstance(source, Key) and source.key == key and not self._tracks.sensing.follows:
                    self._tracks.sense(RobotSense(robot, sense), held, now, now)

    def hear_osc(self, name: str, robot: str, value: bool, now: float) -> None:
        """Handle an OSC message: the senses of a robot that are declared with this name become true or false."""
        self._catch_up(now)
        part = self.score.parts.get(robot)
        for sense, source in part.senses.items() if part else ():
            if source == OscName(name) and not self._tracks.sensing.follows:
                self._tracks.sense(RobotSense(robot, sense), value, now, now)

    def force(self, what: RobotSense, value: bool | None, now: float) -> None:
        """Force the value of a simulated robot's sense. None ends that."""
        if self._sink.real:
            line = f"{what.robot} is a real robot: its senses can't be forced"
            self._tracks.tell({"type": "warning", "message": line})
            return
        self._catch_up(now)
        self._tracks.sensing.force(what, value)
        if what.robot in self.score.parts:
            self._tracks.react(what, now, now)

    def foresee(self, edge: Foreseen, now: float) -> None:
        """Take an edge at its beat, as reported by the stage that leads."""
        self._catch_up(now)
        self._tracks.informed = now
        self._tracks.sensing.announce([edge])
        self._catch_up(now)

    def measure(self, poses: Iterable[RawPose], now: float) -> None:
        """Take measured poses, and report where robots were and where they ideally would have been. If real robots are
        too near to each other, everything pauses."""
        self._tracks.measure(poses, now)
        if self.run.misplaced is not None:
            self._take(events.Stood(), now)
        if self.run.mode == "paused" and self.run.continues and self.run.score.safety.sight:
            self._take(events.Changed(), now)
        if event := self._tracks.separation.look(self.run, now):
            self._take(event, now)

    def measure_joints(self, joints: RawJoints, now: float) -> None:
        """Report where joints of a real robot were."""
        self._tracks.measure_joints(joints, now)

    def whereabouts(self) -> Poses:
        """The poses of simulated robots at beat 0 and now; empty for real robots."""
        return self._tracks.whereabouts()
