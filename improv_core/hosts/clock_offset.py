"""Estimates the clock of another machine, from messages that travel with random delays. It never reads a clock.

Each exchange has four times, as in NTP (RFC 5905, section 8): sent here, arrived there, answered there, heard here. NTP
trusts the exchange with the least round trip. We take the least delay of each direction for itself, because delays
there and back are independent: both are rarely short in the same exchange.

Drift tilts the floor under the delays, up in one direction and down in the other. The drift that lifts both floors the
highest is the one that fits, which is the linear program of Moon, Skelly, and Towsley ("Estimation and removal of clock
skew from network delay measurements", 1999) with one slope for both directions. The gain in height is weighed against
the probability of such a drift. No such method can measure the difference between the least delays of both directions:
half of that stays as an error.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

BUCKET = 1.0
"""Seconds of which only the least delay of each direction is kept."""
MEMORY = 60.0
"""Seconds for which exchanges count: clocks drift evenly for so long."""
KNOWN_AFTER = 3.0
"""Seconds of exchanges after which the clock is known, no matter how late they were."""
GOOD = 0.0005
"""Seconds of error with which the clock is known at once."""
MIN_EXCHANGES = 20
"""The fewest exchanges after which it is known."""
USUAL_DRIFT = 40e-6
"""Seconds per second by which two of three pairs of computer clocks differ at most."""
MAX_DRIFT = 300e-6
"""Seconds per second by which any two clocks differ at most: cheap quartz has 100e-6, and a service that sets a clock
may add as much."""
STEP = 0.02
"""Seconds of difference that are corrected at once: the machine was asleep, or the first estimates were poor."""
SLEW = 0.005
"""Seconds per second by which smaller differences are corrected."""
FEW = 3
"""The seconds with exchanges below which chance can't be told from delay: then half the round trip is the error."""
CERTAIN = 2.0
"""The ratio of the error that 19 of 20 estimates keep to the probable error."""
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
class LeastDelay:
    """The least delay of one direction in a bucket: when it was sent or received here, and the delay by both clocks."""

    at: float
    delay: float


@dataclass(frozen=True, slots=True)
class Exchanges:
    """The exchanges that are remembered: the least delays, and the time of the first."""

    since: float = math.inf
    count: int = 0
    down: tuple[LeastDelay, ...] = ()
    up: tuple[LeastDelay, ...] = ()


@dataclass(frozen=True, slots=True)
class Estimated:
    """An estimate: at the time `at` here, the clock there reads `at + offset`, and gains `drift` seconds each second.
    `error` is the most by which the offset may be wrong (19 times of 20, if both directions have the same least delay),
    and `round_trip` the least one."""

    at: float
    offset: float
    drift: float
    error: float
    round_trip: float


@dataclass(frozen=True, slots=True)
class RemoteClock:
    """A reading of the other machine's clock: `offset` at the local time `at`, and the growth of the offset per second.

    Readings follow each other without a gap, so that no translated time goes back.
    """

    at: float
    offset: float
    rate: float = 0.0

    def remote(self, local: float) -> float:
        """Return the time of the other clock at a local time."""
        return local + self.offset + self.rate * (local - self.at)

    def local(self, remote: float) -> float:
        """Return the local time at which the other clock shows this time."""
        return self.at + (remote - self.offset - self.at) / (1 + self.rate)


def noted(exchanges: Exchanges, new: Exchange) -> Exchanges:
    """Return the exchanges with one more. Forgets old ones, or all if a clock has jumped because a machine slept."""
    if _contradicts(exchanges, new):
        exchanges = Exchanges()
    return Exchanges(
        min(exchanges.since, new.sent),
        exchanges.count + 1,
        _lowered(exchanges.down, LeastDelay(new.sent, new.arrived - new.sent)),
        _lowered(exchanges.up, LeastDelay(new.heard, new.heard - new.answered)),
    )


def estimate(exchanges: Exchanges, now: float) -> Estimated | None:
    """Estimate the clock there from the exchanges; None before `MIN_EXCHANGES` of them."""
    if exchanges.count < MIN_EXCHANGES:
        return None
    down = [(each.at - now, each.delay) for each in exchanges.down]
    up = [(each.at - now, each.delay) for each in exchanges.up]
    drift = 0.0
    for _ in range(2):  # first as if the clocks didn't drift, which makes the spread of delays seem larger
        spread = _spread(down, drift) + _spread(up, -drift)
        drift = _drift(down, up, max(spread, 1e-6))
    lowest_down, lowest_up = _lowest(down, drift), _lowest(up, -drift)
    round_trip = max(lowest_down + lowest_up, 0.0)
    error = round_trip / 2
    if len(down) > FEW and len(up) > FEW:
        error = min(error, CERTAIN * (_spread(down, drift) + _spread(up, -drift)))
    return Estimated(now, (lowest_down - lowest_up) / 2, drift, error, round_trip)


def is_known(exchanges: Exchanges, found: Estimated) -> bool:
    """Return whether an estimate is good enough for moving robots."""
    return found.error <= GOOD or found.at - exchanges.since >= KNOWN_AFTER


def steered(clock: RemoteClock | None, found: Estimated) -> RemoteClock:
    """Return the next reading. It approaches the estimate within a few seconds, without a step unless it is far off."""
    if clock is None:
        return RemoteClock(found.at, found.offset, found.drift)
    offset = clock.remote(found.at) - found.at
    off = found.offset - offset
    if abs(off) > STEP:
        return RemoteClock(found.at, found.offset, found.drift)
    return RemoteClock(found.at, offset, found.drift + max(-SLEW, min(SLEW, off)))


def _contradicts(exchanges: Exchanges, new: Exchange) -> bool:
    """Return whether a message would have come before it was sent, by the remembered delays of the other direction."""
    down, up = new.arrived - new.sent, new.heard - new.answered
    least = -MAX_DRIFT * MEMORY
    return any(down + each.delay < least for each in exchanges.up) or any(
        up + each.delay < least for each in exchanges.down
    )


def _lowered(floors: tuple[LeastDelay, ...], new: LeastDelay) -> tuple[LeastDelay, ...]:
    if floors and math.floor(floors[-1].at / BUCKET) == math.floor(new.at / BUCKET):
        return floors if floors[-1].delay <= new.delay else (*floors[:-1], new)
    recent = floors if not floors or floors[0].at > new.at - MEMORY else floors[1:]
    return (*recent, new)


_Floors = list[tuple[float, float]]  # the time, in seconds from now, and the delay


def _lowest(floors: _Floors, slope: float) -> float:
    """Return the present height of a line with this slope that touches the lowest floors."""
    return min(delay - slope * at for at, delay in floors)


def _spread(floors: _Floors, slope: float) -> float:
    """Return the probable height of the lowest floor above the real one: the mean distance from it divided by n."""
    lowest = _lowest(floors, slope)
    return sum(delay - slope * at - lowest for at, delay in floors) / max(len(floors) - 1, 1) / len(floors)


def _drift(down: _Floors, up: _Floors, spread: float) -> float:
    """Return the likeliest slope: its gain in height counts in units of `spread`, as it does if delays fall off
    exponentially above the floor. This is concave, so taking thirds finds the maximum."""

    def likelihood(slope: float) -> float:
        return (_lowest(down, slope) + _lowest(up, -slope)) / spread - (slope / USUAL_DRIFT) ** 2 / 2

    middle = sum(at for at, _ in (*down, *up)) / (len(down) + len(up))
    down, up = [(at - middle, delay) for at, delay in down], [(at - middle, delay) for at, delay in up]
    least, most = -MAX_DRIFT, MAX_DRIFT
    while most - least > FINEST:
        left, right = least + (most - least) / 3, most - (most - least) / 3
        if likelihood(left) < likelihood(right):
            least = left
        else:
            most = right
    return (least + most) / 2
