"""The near end's knowledge about the clock at its far end, and the times of its questions. It reads no clock."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

from improv_core.hosts.clock_offset import (
    Estimated,
    Exchange,
    Exchanges,
    RemoteClock,
    estimate,
    is_known,
    noted,
    steered,
)
from improv_core.hosts.frames import RemoteTimes
from improv_core.hosts.time_translation import SECOND, TimeTranslation

OFTEN, MOVING, RESTING = 0.05, 0.1, 0.5
"""Seconds between two questions: at first, while robots may move, and otherwise."""
AT_FIRST = 30.0
"""Seconds at first in which questions are frequent."""
LOST = 30.0
"""Seconds after which no answer is expected anymore."""
MAX_WAYS = 400
"""The questions whose ways there are remembered: if one packet in fifty is sent again, some show the time."""
LOOK_PERIOD = 1.0
"""Seconds between two estimates, once the clock is known."""


@dataclass(frozen=True, slots=True)
class Asking:
    """The latest question's `number`, the open questions and their times, and the results of the answers."""

    since: float
    number: int = 0
    questions: Mapping[int, float] = field(default_factory=dict)
    exchanges: Exchanges = field(default_factory=Exchanges)
    latest: RemoteTimes | None = None
    found: Estimated | None = None
    clock: RemoteClock | None = None
    ways: tuple[float, ...] = ()
    """The times that the latest questions took to get there, by both clocks, in seconds."""


def period(asking: Asking, now: float, *, moves: bool) -> float:
    """Seconds until the next question."""
    return OFTEN if now < asking.since + AT_FIRST else MOVING if moves else RESTING


def asked(asking: Asking, number: int, now: float) -> Asking:
    open_ = {other: at for other, at in asking.questions.items() if at > now - LOST}
    return replace(asking, number=number, questions={**open_, number: now})


def answered(asking: Asking, answer: RemoteTimes, now: float) -> Asking:
    """Take an answer. One to a question that was never asked is ignored."""
    sent = asking.questions.get(answer.number)
    if sent is None:
        return asking
    rest = {number: at for number, at in asking.questions.items() if number != answer.number}
    ways = (*asking.ways[-MAX_WAYS + 1 :], answer.arrived / SECOND - sent)
    exchange = Exchange(sent, answer.arrived / SECOND, answer.answered / SECOND, now)
    return replace(asking, questions=rest, exchanges=noted(asking.exchanges, exchange), latest=answer, ways=ways)


def estimated(asking: Asking, now: float) -> Asking:
    """Return the queries with a new estimate, if the clock there is known, and it is time for one."""
    if asking.found and now < asking.found.at + LOOK_PERIOD:
        return asking
    found = estimate(asking.exchanges, now)
    if not found or not (asking.clock or is_known(asking.exchanges, found)):
        return asking
    return replace(asking, found=found, clock=steered(asking.clock, found))


def lag(asking: Asking) -> float:
    """Return the seconds within which a message nearly always arrives: the most that a recent question took."""
    if not asking.clock or not asking.found or not asking.ways:
        return 0.0
    offset = asking.clock.remote(asking.found.at) - asking.found.at
    return max(max(asking.ways) - offset, 0.0)


def translation(asking: Asking, now: int, wall: int, asleep: float) -> TimeTranslation | None:
    """Return how to translate times; None if the one there isn't known yet. Times here are in nanoseconds, as
    those of the answers; `asleep` is in seconds."""
    if not asking.clock or not asking.latest:
        return None
    there = asking.latest
    return TimeTranslation(asking.clock, wall - now, there.wall - there.answered, there.asleep / SECOND - asleep)
