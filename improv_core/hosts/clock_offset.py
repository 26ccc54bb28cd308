"""How the clock of another machine reads, from messages that travel with random delays. It never reads a clock.

Each exchange has four times, as in NTP (RFC 5905, section 8): sent here, arrived there, answered there, heard here. NTP
trusts the exchange with the least round trip. We take the least delay of each direction for itself, because delays
there and back are independent: both are rarely short in the same exchange. Drift tilts the floor under the delays, up
in one direction and down in the other. The drift that lifts both floors the highest is the one that fits, which is the
linear program of Moon, Skelly, and Towsley ("Estimation and removal of clock skew from network delay measurements",
1999) with one slope for both directions. How much a drift lifts them is weighed against how unlikely it is.

What no such method can see is how much the least delays of both directions differ: half of that stays as an error.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

BUCKET = 1.0
"""Seconds of which only the least delay of each direction is kept."""
MEMORY = 60.0
"""Seconds of exchanges that count: clocks drift evenly for so long."""
KNOWN_AFTER = 3.0
"""Seconds of exchanges after which the clock is known, however much they were delayed."""
GOOD = 0.0005
"""Seconds of error with which the clock is known at once."""
LEAST = 20
"""Exchanges without which it is never known."""
USUAL_DRIFT = 40e-6
"""Seconds per second by which clocks of computers differ: two of three by no more."""
MOST_DRIFT = 300e-6
"""Seconds per second that no two clocks differ by: cheap quartz has 100e-6, and what sets a clock may add as much."""
STEP = 0.02
"""Seconds of difference that are made up at once: the machine was asleep, or the first estimates were poor."""
SLEW = 0.005
"""Seconds per second by which smaller differences are made up."""
FEW = 3
"""Seconds with exchanges in fewer of which chance can't be told from delay: then half the round trip is the error."""
CERTAIN = 2.0
"""How many times the probable error is the one that 19 of 20 estimates keep."""
FINEST = 0.1e-6
"""Seconds per second to which drift is computed."""


@dataclass(frozen=True, slots=True)
class Exchange:
    """The monotonic times of one exchange in seconds: `sent` and `heard` by the clock here, the others by the other."""

    sent: float
    arrived: float
    answered: float
    heard: float


@dataclass(frozen=True, slots=True)
class Floor:
    """The least delay of one direction in a bucket: when it was sent or heard here, and what the clocks made of it."""

    at: float
    delay: float


@dataclass(frozen=True, slots=True)
class Exchanges:
    """What is remembered of them: the least delays, and when the first came."""

    since: float = math.inf
    count: int = 0
    down: tuple[Floor, ...] = ()
    up: tuple[Floor, ...] = ()


@dataclass(frozen=True, slots=True)
class Estimated:
    """At the time `at` here, the clock there reads `at + offset`, and gains `drift` seconds each second. `error` is how
    far off the offset may be (19 times of 20, if both directions have the same least delay), `round_trip` the least."""

    at: float
    offset: float
    drift: float
    error: float
    round_trip: float


@dataclass(frozen=True, slots=True)
class Clocks:
    """How the clock there is read: `offset` at the time `at` here, and how much it grows per second.

    Readings follow each other without a gap, so that no time that is translated goes back.
    """

    at: float
    offset: float
    rate: float = 0.0

    def there(self, here: float) -> float:
        """What the clock there reads at a time here."""
        return here + self.offset + self.rate * (here - self.at)

    def here(self, there: float) -> float:
        """The time here at which the clock there reads this."""
        return self.at + (there - self.offset - self.at) / (1 + self.rate)


def noted(exchanges: Exchanges, new: Exchange) -> Exchanges:
    """With one more exchange. What is too old is forgotten, and all is if a clock has jumped, since a machine slept."""
    if _contradicts(exchanges, new):
        exchanges = Exchanges()
    return Exchanges(
        min(exchanges.since, new.sent),
        exchanges.count + 1,
        _lowered(exchanges.down, Floor(new.sent, new.arrived - new.sent)),
        _lowered(exchanges.up, Floor(new.heard, new.heard - new.answered)),
    )


def estimate(exchanges: Exchanges, now: float) -> Estimated | None:
    """What the exchanges say about the clock there; None before `LEAST` of them."""
    if exchanges.count < LEAST:
        return None
    down = [(floor.at - now, floor.delay) for floor in exchanges.down]
    up = [(floor.at - now, floor.delay) for floor in exchanges.up]
    drift = 0.0
    for _ in range(2):  # first as if the clocks didn't drift, which makes floors look farther apart than they are
        spread = _spread(down, drift) + _spread(up, -drift)
        drift = _drift(down, up, max(spread, 1e-6))
    lowest_down, lowest_up = _lowest(down, drift), _lowest(up, -drift)
    round_trip = max(lowest_down + lowest_up, 0.0)
    error = round_trip / 2
    if len(down) > FEW and len(up) > FEW:
        error = min(error, CERTAIN * (_spread(down, drift) + _spread(up, -drift)))
    return Estimated(now, (lowest_down - lowest_up) / 2, drift, error, round_trip)


def is_known(exchanges: Exchanges, found: Estimated) -> bool:
    """Whether an estimate can be trusted with what robots do."""
    return found.error <= GOOD or found.at - exchanges.since >= KNOWN_AFTER


def steered(clocks: Clocks | None, found: Estimated) -> Clocks:
    """The next clocks: it leads to the estimate within a few seconds, without a step unless it is far off."""
    if clocks is None:
        return Clocks(found.at, found.offset, found.drift)
    offset = clocks.there(found.at) - found.at
    off = found.offset - offset
    if abs(off) > STEP:
        return Clocks(found.at, found.offset, found.drift)
    return Clocks(found.at, offset, found.drift + max(-SLEW, min(SLEW, off)))


def _contradicts(exchanges: Exchanges, new: Exchange) -> bool:
    """Whether a message would have come before it was sent, by what is remembered of the other direction."""
    down, up = new.arrived - new.sent, new.heard - new.answered
    least = -MOST_DRIFT * MEMORY
    return any(down + floor.delay < least for floor in exchanges.up) or any(
        up + floor.delay < least for floor in exchanges.down
    )


def _lowered(floors: tuple[Floor, ...], new: Floor) -> tuple[Floor, ...]:
    if floors and math.floor(floors[-1].at / BUCKET) == math.floor(new.at / BUCKET):
        return floors if floors[-1].delay <= new.delay else (*floors[:-1], new)
    recent = floors if not floors or floors[0].at > new.at - MEMORY else floors[1:]
    return (*recent, new)


_Floors = list[tuple[float, float]]  # when, in seconds from now, and the delay


def _lowest(floors: _Floors, slope: float) -> float:
    """How high a line of this slope lies now if it touches the lowest floors."""
    return min(delay - slope * at for at, delay in floors)


def _spread(floors: _Floors, slope: float) -> float:
    """How far above the real floor the lowest one probably is: the mean distance of n floors from the lowest of them is
    n times that."""
    lowest = _lowest(floors, slope)
    return sum(delay - slope * at - lowest for at, delay in floors) / max(len(floors) - 1, 1) / len(floors)


def _drift(down: _Floors, up: _Floors, spread: float) -> float:
    """The likeliest slope: what it gains in height counts in units of `spread`, as it does where delays fall off
    exponentially above the floor. This is concave, so its maximum is found by taking thirds."""

    def likelihood(slope: float) -> float:
        return (_lowest(down, slope) + _lowest(up, -slope)) / spread - (slope / USUAL_DRIFT) ** 2 / 2

    middle = sum(at for at, _ in (*down, *up)) / (len(down) + len(up))
    down, up = [(at - middle, delay) for at, delay in down], [(at - middle, delay) for at, delay in up]
    least, most = -MOST_DRIFT, MOST_DRIFT
    while most - least > FINEST:
        left, right = least + (most - least) / 3, most - (most - least) / 3
        if likelihood(left) < likelihood(right):
            least = left
        else:
            most = right
    return (least + most) / 2
