"""When a standby takes over: it is told what the stage says, and the time."""

from __future__ import annotations

import pytest

from improv_core.stage.protocol import ToStandby
from improv_core.stage.standby import LOOK, Watch

MOVES: ToStandby = {"type": "moves", "topic": "/r/cmd_vel", "frame": "base_link", "patience": 0.5}
PULSE: ToStandby = {"type": "pulse", "patience": 0.5}
LOADS: ToStandby = {"type": "pulse", "patience": 10.0}
STANDS: ToStandby = {"type": "stands"}
END: ToStandby = {"type": "end"}

Story = list[tuple[float, ToStandby]]


def verdict(story: Story, now: float, gone: bool = False, halted: bool = False) -> bool:
    """Whether robots have to be stopped at a time, after what the stage said at others; looked at again and again."""
    watch = Watch(0.0)
    looks = round(now / LOOK)
    for look in range(looks):
        for at, message in story:
            if look * LOOK <= at < (look + 1) * LOOK:
                watch.take(message, at)
        if watch.must_stop((look + 1) * LOOK, gone and look == looks - 1, halted and look == looks - 1):
            return True
    return False


@pytest.mark.parametrize(
    ("story", "now", "expected"),
    [
        ([(0.0, MOVES)], 0.4, False),
        ([(0.0, MOVES)], 0.7, True),
        ([(0.0, MOVES), (0.4, PULSE)], 0.7, False),
        ([(0.0, MOVES), (0.4, LOADS)], 9.0, False),
        ([(0.0, MOVES), (0.4, LOADS)], 11.0, True),
        ([(0.0, MOVES), (0.4, STANDS)], 11.0, False),
        ([(0.0, MOVES), (0.4, END)], 11.0, False),
        ([], 11.0, False),
    ],
)
def test_a_stage_that_says_nothing(story: Story, now: float, expected: bool) -> None:
    assert verdict(story, now) is expected


@pytest.mark.parametrize("how", ["gone", "halted"])
def test_a_stage_that_is_gone_or_halted(how: str) -> None:
    assert verdict([(0.0, MOVES)], 0.3, **{how: True})
    assert not verdict([(0.0, MOVES), (0.1, STANDS)], 0.3, **{how: True}), "robots stand: they are somebody else's"


def test_a_standby_that_was_halted_itself() -> None:
    watch = Watch(0.0)
    watch.take(MOVES, 0.0)
    looks = [watch.must_stop(5.0 + look * LOOK, gone=False, halted=False) for look in range(6)]
    assert looks == [False] * 5 + [True], "the stage gets as much time again"
