"""The only loop of a player: it decides what follows from an event, does that, and sends what is due.

It never reads a clock; callers pass the time in. `now` is the clock's time in seconds. `performed` and `at` are
performance times: seconds since the latest restart, including pauses.
"""

from __future__ import annotations

import math
from collections.abc import Callable

from improv_core.player import agenda, events
from improv_core.player.agenda import Rank
from improv_core.player.apply import do
from improv_core.player.decide import decide, trouble
from improv_core.player.events import Event
from improv_core.player.reports import Told
from improv_core.player.return_state import HomeStep, Sightings
from improv_core.player.run import Run
from improv_core.player.start_gate import time_left
from improv_core.player.tracks import Tracks
from improv_core.protocol.output import Sink

LOOK_AGAIN = 0.01
"""Seconds between two checks for listeners before beat 0, and between two of robots that still move after the end."""
LOOK_WHILE_ARMED = 0.1
"""Seconds between two looks at the wall clock while beat 0 waits for a person, or for a time that is not yet near."""


class Engine:
    """A run, which only this loop replaces, and the tracks that play it on a sink."""

    def __init__(self, sink: Sink, tell: Callable[[Told], None], wall: Callable[[], float]) -> None:
        self._sink = sink
        self._tracks = Tracks(sink, tell, wall)

    @property
    def run(self) -> Run:
        """The latest decision about the performance."""
        return self._tracks.run

    def deadline(self, now: float) -> float | None:
        """The time on the clock at which `advance` must be called next; None if nothing is left to do."""
        if self.run.mode == "waiting":
            if self.run.is_due:
                return now
            left = time_left(gate, self._tracks.wall()) if (gate := self.run.gate) else 0.0
            return now + (min(LOOK_WHILE_ARMED, left) if left > 0 else LOOK_AGAIN)
        due = self._tracks.next_due().at
        if due < math.inf:
            separation = self._tracks.separation
            at = min(self.run.transport.clock(due), separation.deadline(self.run), separation.due, self._returns_due)
            return min(at, now + self._sink.period) if self._sink.period else at
        if self._looks_while_paused:
            return max(min(self._tracks.listeners.next_look, self._tracks.faults.next_look), now)
        return now + (self._sink.period or LOOK_AGAIN) if self._sink.coasting() else None

    @property
    def is_exact(self) -> bool:
        """True while the next thing due must be sent at its exact time. Repeats may be a little late."""
        return self._tracks.next_due().rank != Rank.REPEATS

    def advance(self, now: float) -> None:
        """Do everything that is due."""
        if self.run.mode == "waiting":
            self._take(events.Awaited(), now)
        else:
            self._tracks.unsettled = True
            is_seen = now < self._tracks.separation.deadline(self.run)
            self._take(None if is_seen else events.Changed(), now)

    def _catch_up(self, now: float) -> None:
        """Send what is due before something changes, so robots don't miss it."""
        if self.run.mode == "playing":
            self.advance(now)

    def _take(self, event: Event | None, now: float) -> None:
        """Decide and do what follows from an event, and then everything that is due. This is the only loop: no act and
        no decision starts another."""
        tracks = self._tracks
        while event or (event := self._send_due(now)):
            tracks.run, todo = decide(tracks.run, event, tracks.facts(now, event))
            event = None
            for act in todo:
                event = do(act, tracks, now) or event
        if tracks.unseen:
            robots, tracks.unseen = tracks.unseen, []
            tracks.look([robot for robot in robots if robot in tracks.run.score.parts])

    def _send_due(self, now: float) -> Event | None:
        """Send everything that is due and has been decided. Return the next event to decide."""
        tracks, run = self._tracks, self._tracks.run
        if not tracks.unsettled:
            return None
        due = tracks.next_due().at
        late = run.transport.performed(now) - max(due, run.transport.performed(tracks.informed))
        overloaded = tracks.queue.repeats.hopeless
        if reason := trouble(run, self._sink.real, late, overloaded):
            tracks.unsettled = False
            return reason
        tracks.reached = now
        performed = agenda.performed(run, now, due)
        if decision := tracks.send_due(performed):
            if decision.rank != Rank.TAKEOVER:  # a takeover sends the rest itself
                tracks.send_repeats(decision.last_before(Rank.CHANGES))
            return decision
        tracks.send_repeats(performed)
        tracks.unsettled = False
        if self._sink.real and (line := tracks.queue.repeats.news()):
            tracks.tell({"type": "warning", "message": line})
        if now >= tracks.separation.due and (event := tracks.separation.look(self.run, now)):
            return event
        if now >= self._returns_due:
            return events.Returning(self._steps(now))
        return self._look_around(now)

    @property
    def _returns_due(self) -> float:
        """The time on the clock of the next look at robots that drive back to their parts."""
        return self._tracks.returns.due(self.run, self._tracks.listeners.returning)

    def _steps(self, now: float) -> list[HomeStep]:
        """Return the next steps of robots that drive back to their parts."""
        run, tracks, over = self.run, self._tracks, self._tracks.active_parts.over
        ready = tracks.listeners.returning - tracks.listeners.away
        back = [robot for robot in run.score.parts if robot in ready and not run.stands(robot, ())]
        ideal = {robot: each.ideal for robot, each in tracks.odometry.places(now).items()}
        doubtful = [robot for robot in back if tracks.odometry.is_doubtful(robot, now)]
        ends = run.transport.clock(run.transport.end(run.ends(over)))
        seen = Sightings(now, run.beat(now, over), tracks.separation.poses(run, now), ideal, doubtful, ends)
        return tracks.returns.look(run, back, seen)

    def _look_around(self, now: float) -> Event | None:
        """Check a few robots for faults and, if that is due, for listeners."""
        tracks = self._tracks
        if not (self.run.mode == "playing" or self._looks_while_paused):
            return None
        if found := tracks.find_faults(now):
            return events.Faults(found)
        if now < tracks.listeners.next_look:
            return None
        waits = self.run.mode == "paused" and self.run.continues
        standing, done = tracks.listeners.look_around(self.run.score, now, waits)
        tracks.queue.silence(standing)
        if done:
            tracks.tell_news()
            tracks.tell_unguarded(now)
        return events.Changed()

    @property
    def _looks_while_paused(self) -> bool:
        """True while real robots are paused: somebody may carry them away, or they may get lost."""
        return self.run.mode == "paused" and self._sink.real
