"""The times at which a standby takes over, given the stage's messages."""

from __future__ import annotations

import pytest

from improv_core.outputs.ros.standby.process import LOOK, ParentWatch
from improv_core.protocol.standby_messages import ToStandby

MOVES: ToStandby = {"type": "moves", "topic": "/r/cmd_vel", "frame": "base_link", "patience": 0.5}
PULSE: ToStandby = {"type": "pulse", "patience": 0.5, "ahead": 0}
LOADS: ToStandby = {"type": "pulse", "patience": 10.0, "ahead": 0}
STANDS: ToStandby = {"type": "stands"}
CONFIRMED: ToStandby = {"type": "confirmed", "topic": "/r/cmd_vel"}
END: ToStandby = {"type": "end"}

Story = list[tuple[float, ToStandby]]


def verdict(story: Story, now: float, gone: bool = False, halted: bool = False) -> bool:
    """Return whether robots have to be stopped at a time, after earlier messages of the stage; checked repeatedly."""
    watch = ParentWatch(0.0)
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
def test_the_standby_stops_moving_robots_whose_stage_is_silent_for_too_long(
    story: Story, now: float, expected: bool
) -> None:
    assert verdict(story, now) is expected


@pytest.mark.parametrize("how", ["gone", "halted"])
def test_the_standby_stops_moving_robots_whose_stage_is_gone_or_halted(how: str) -> None:
    assert verdict([(0.0, MOVES)], 0.3, **{how: True})
    known = [(0.0, MOVES), (0.1, STANDS), (0.2, CONFIRMED)]
    assert not verdict(known, 0.3, **{how: True}), "robots stand, and have heard it: they are somebody else's"


def test_a_stage_counts_as_silent_after_the_time_between_two_pulses_however_often_its_standby_looks() -> None:
    watch = ParentWatch(0.0)
    watch.take(MOVES, 1.0)
    assert not any(watch.is_silent(1.0 + look / 100) for look in range(12))
    assert watch.is_silent(1.0 + LOOK)
    watch.take(PULSE, 1.2)
    assert not watch.is_silent(1.3)


def test_only_a_halted_stage_is_killed_for_pending_zeros() -> None:
    """As far as is known, they stand. So only a halted stage has to be killed; one that is gone leaves the zeros to the
    standby."""
    stopped: Story = [(0.0, MOVES), (0.1, STANDS)]
    assert verdict(stopped, 0.3, halted=True)
    assert not verdict(stopped, 0.3, gone=True)
    assert not verdict(stopped, 11.0)


OTHER: ToStandby = {"type": "moves", "topic": "/s/cmd_vel", "frame": "base_link", "patience": 0.5}
PENDING: ToStandby = {"type": "pending", "topic": "/s/cmd_vel", "frame": "base_link"}


@pytest.mark.parametrize(
    ("said", "pending", "moved"),
    [
        ([MOVES, OTHER], set(), {"/r/cmd_vel", "/s/cmd_vel"}),
        ([MOVES, OTHER, STANDS], {"/r/cmd_vel", "/s/cmd_vel"}, set()),
        ([MOVES, OTHER, STANDS, CONFIRMED], {"/s/cmd_vel"}, set()),
        ([MOVES, OTHER, CONFIRMED], set(), {"/s/cmd_vel"}),
        ([MOVES, OTHER, CONFIRMED, STANDS], {"/s/cmd_vel"}, set()),
        ([MOVES, STANDS, MOVES], set(), {"/r/cmd_vel"}),
        ([MOVES, PENDING], {"/s/cmd_vel"}, {"/r/cmd_vel"}),
    ],
)
def test_zeros_stay_pending_until_robots_confirm_them(
    said: list[ToStandby], pending: set[str], moved: set[str]
) -> None:
    watch = ParentWatch(0.0)
    for message in said:
        watch.take(message, 0.0)
    assert ({*watch.pending}, {*watch.moved}) == (pending, moved)


def test_a_standby_that_was_itself_halted_gives_the_stage_as_much_time_again() -> None:
    watch = ParentWatch(0.0)
    watch.take(MOVES, 0.0)
    looks = [watch.must_stop(5.0 + look * LOOK, gone=False, halted=False) for look in range(6)]
    assert looks == [False] * 5 + [True], "the stage gets as much time again"
