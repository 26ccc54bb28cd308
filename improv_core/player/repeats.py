"""Repeats the velocities that robots hold. It never reads a clock; times are performance times, in seconds.

A base stops by itself if no command comes for a while, so every velocity is repeated at the command rate. Repeats are
less urgent than changes of velocity, so they are spread over the period in slots: a change never has to wait for more
than one slot's repeats.
"""

from __future__ import annotations

import math
import sys

from improv_core.score.performance import Mover

SLOTS = 10
"""Slots in a period. With a hundred robots, a slot has ten sends, which take a fraction of a millisecond."""
SHORTEST_SLOT = 0.002
"""Seconds. A slot for each of 1,000 robots would mean 20,000 wake-ups a second, which no machine keeps up with."""
SLOWEST = 4.0
"""The most that a period may be stretched, as a factor, if the machine is too slow.

At the default rate, 20 Hz, that is 0.2 s: a base that stops after 0.5 s (diff_drive_controller, Create 3) still gets
two commands in that time, so one may be late. A base with a shorter limit needs a profile with a higher rate, and keeps
the same margin.
"""
RESERVE = 1.1
"""The factor by which repeats become slower than measured, so that the rate can be kept."""
WINDOW = 1.0
"""Seconds over which the rate is measured. Only two bad windows in a row lower it, since one may be a hiccup."""
MANY = 2_000
"""Repeats a second that take a noticeable share of this machine: a twentieth of a processor or more. If fewer are due
and some are lost, other programs keep the processor busy, and a lower rate would help nobody."""
SURE = 3
"""Windows in a row after which a lowered rate counts as reached."""
KEPT = 0.9
"""The share of repeats that must be sent. A burst of changes may take the place of a few."""
HOPELESS = 0.4
"""The share of repeats at the lowest rate below which robots get no command for 0.5 s, so bases stop and go."""


class Repeats:
    """The robots that hold a velocity, and the rate at which this machine can repeat it.

    A robot's slot depends only on the robots that came before it, so other parts don't shift its repeats.
    """

    def __init__(self) -> None:
        self._wheels: dict[float, _Wheel] = {}  # by rate
        self._held: dict[Mover, _Wheel] = {}
        self._stretch = 1.0  # periods are this many times longer than usual
        self._lowered_for = 0  # the number of robots held when that was last raised
        self._window = math.inf  # when the current window ends
        self._served = self._skipped = 0  # slots in this window
        self._behind = 0  # windows in a row that lost repeats
        self._kept = 0  # windows in a row that didn't
        self._untold = False
        self.hopeless = False
        """True if even at the lowest rate, robots get too few commands to keep moving."""

    def restart(self) -> None:
        """Start performance time over, with no robot moving. A machine that was too slow for them still is."""
        for mover in list(self._held):
            self.release(mover)
        self._window, self._served, self._skipped, self._behind = math.inf, 0, 0, 0
        self.hopeless = False

    def hold(self, mover: Mover, rate: float, at: float) -> None:
        """Repeat a velocity that a robot was sent at this time, at `rate` Hz, until the robot is sent another."""
        wheel = self._wheels.get(rate) or self._wheels.setdefault(rate, _Wheel(rate, self._stretch))
        if self._held.get(mover) is not wheel:
            self.release(mover)
            self._held[mover] = wheel
        wheel.hold(mover, at)
        if self._window == math.inf:
            self._window = at + WINDOW

    def release(self, mover: Mover) -> None:
        """Stop repeating a robot's velocity."""
        if wheel := self._held.pop(mover, None):
            wheel.release(mover)

    @property
    def due(self) -> float:
        return min((wheel.due for wheel in self._wheels.values()), default=math.inf)

    def take(self, performed: float) -> list[Mover]:
        """Return the robots of the slot that is due: if more than a period is overdue, only the latest repeats."""
        wheel = min(self._wheels.values(), key=lambda wheel: wheel.due)
        self._skipped += wheel.catch_up(performed)
        self._served += 1
        robots = wheel.take()
        if performed >= self._window:
            self._measure()
            self._window = performed + WINDOW
        return robots

    def news(self) -> str | None:
        """Return a line for people, once, if the rate was lowered and is kept now."""
        if not self._untold or self._kept < SURE:
            return None
        self._untold = False
        rate, count = max(((wheel.rate, wheel.count) for wheel in self._wheels.values()), key=lambda each: each[1])
        return (
            f"this machine can't send {count} robots {rate:g} commands a second each: those that hold a velocity are "
            f"now sent {rate / self._stretch:.1f} a second, and every change of velocity is still sent at its time"
        )

    def _measure(self) -> None:
        """Lower the rate if many repeats are due and some were lost in two windows in a row."""
        share = self._served / (self._served + self._skipped)
        self._behind, self._kept = (self._behind + 1, 0) if share < KEPT else (0, self._kept + 1)
        if len(self._held) < self._lowered_for:
            self._set_stretch(1.0)
        elif sum(wheel.rate * wheel.count for wheel in self._wheels.values()) < MANY:
            self._behind = 0
        elif self._behind >= 2 and self._stretch < SLOWEST:
            self._set_stretch(min(self._stretch / share * RESERVE, SLOWEST))
            self._untold, self._behind = True, 0
        elif self._behind >= 2 and share < HOPELESS:
            self.hopeless = True
        self._served = self._skipped = 0

    def _set_stretch(self, stretch: float) -> None:
        self._stretch = stretch
        self._lowered_for = len(self._held) if stretch > 1 else 0
        for wheel in self._wheels.values():
            wheel.turn_at(stretch)


class _Wheel:
    """The robots with one command rate. Its slots take turns, at multiples of a slot's length since time 0."""

    def __init__(self, rate: float, stretch: float) -> None:
        self.rate = rate
        self.count = 0
        """The number of its robots."""
        self.due = math.inf
        """The time at which the next slot that has robots is due."""
        self._slots: list[dict[Mover, float]] = [{} for _ in range(max(1, min(SLOTS, int(1 / rate / SHORTEST_SLOT))))]
        self._places: dict[Mover, int] = {}  # the slot of each robot
        self._seconds = stretch / rate / len(self._slots)  # of a slot
        self._next = _NEVER  # the number of the next turn that has robots
        self._taken = -1  # the number of the latest turn

    def hold(self, mover: Mover, at: float) -> None:
        place = self._places.setdefault(mover, len(self._places) % len(self._slots))
        if mover not in self._slots[place]:
            self.count += 1
        self._slots[place][mover] = at  # when it was sent another velocity
        turn = math.floor(at / self._seconds) + 1
        turn += (place - turn) % len(self._slots)
        self._go_to(min(self._next, max(turn, self._taken + 1)))

    def release(self, mover: Mover) -> None:
        del self._slots[self._places[mover]][mover]
        self.count -= 1
        if not self.count:
            self._taken = -1
        self._go_to(self._next)

    def catch_up(self, performed: float) -> int:
        """Skip whole rounds that are overdue. Return the number of slots with robots in them."""
        rounds = math.floor((performed - self.due) / (self._seconds * len(self._slots)))
        self._go_to(self._next + rounds * len(self._slots))
        return rounds * sum(map(bool, self._slots))

    def take(self) -> list[Mover]:
        """Return the robots of the slot that is due, unless they got another velocity less than a slot ago."""
        slot, before = self._slots[self._next % len(self._slots)], self.due - self._seconds * _ALMOST
        self._taken = self._next
        self._go_to(self._next + 1)
        return [mover for mover, at in slot.items() if at <= before]

    def turn_at(self, stretch: float) -> None:
        """Set the length of periods, as a multiple of the rate's."""
        now, self._seconds = self.due, stretch / self.rate / len(self._slots)
        if self.count:
            self._taken = math.floor(now / self._seconds)
            self._go_to(self._taken + 1)

    def _go_to(self, turn: int) -> None:
        """Choose the next turn that has robots, from this one on."""
        if not self.count:
            self._next, self.due = _NEVER, math.inf
            return
        while not self._slots[turn % len(self._slots)]:
            turn += 1
        self._next, self.due = turn, turn * self._seconds


_NEVER = sys.maxsize
_ALMOST = 1 - 1e-9
"""The times of slots are rounded."""
