"""The playback position, as a clock's time passes."""

from __future__ import annotations

import math
from fractions import Fraction

import pytest

from improv_core.score.movement import ENDLESS, Duration
from improv_core.score.transport import Switch, Transport

# Performance time 0 was at 1000 s on the clock; at 10 s of it, playing began at beat 2.5, at two beats a second.
TRANSPORT = Transport(1000.0, 10.0, Fraction(5, 2), Fraction(120))


@pytest.mark.parametrize(
    ("now", "beats", "beat"),
    [(1009, 8, 2.5), (1010, 8, 2.5), (1010.25, 8, 3), (1012, 8, 6.5), (1013, 8, 8), (2010, ENDLESS, 2002.5)],
)
def test_beats_pass_at_the_tempo_from_the_origin_to_the_end(now: float, beats: Duration, beat: float) -> None:
    assert TRANSPORT.beat(now, beats) == beat


@pytest.mark.parametrize(("beats", "end"), [(8, 12.75), (2, 9.75), (ENDLESS, math.inf)])
def test_a_score_ends_with_its_last_beat(beats: Duration, end: float) -> None:
    assert TRANSPORT.end(beats) == end


@pytest.mark.parametrize(
    ("when", "performed", "beats", "at"),
    [
        ("now", 11.1, 8, 11.1),
        ("now", 9.0, 8, 10.0),
        ("beat", 9.0, 8, 10.25),
        ("beat", 10.25, 8, 10.25),
        ("end", 11.1, 8, 12.75),
        ("end", 11.1, ENDLESS, 11.25),
    ],
)
def test_another_score_takes_over_in_time(when: Switch, performed: float, beats: Duration, at: float) -> None:
    assert TRANSPORT.switch_time(when, performed, beats) == pytest.approx(at)


def test_the_clock_and_performance_time_are_a_constant_apart() -> None:
    assert TRANSPORT.performed(1012.5) == 12.5
    assert TRANSPORT.clock(12.5) == 1012.5
