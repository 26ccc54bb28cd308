"""The state of emergency stops: the messages of their publishers, and a stage's knowledge of those that no score
names."""

from __future__ import annotations

from collections.abc import Iterable

import pytest

from improv_core.protocol.messages import Pressed
from improv_core.safety.interlocks import OLDER, RELEASED, EmergencyStops, StopTopic
from improv_core.score.score import Safety

T, F = True, False


def turns(told: Iterable[tuple[float, list[bool]]], until: float) -> list[tuple[float, bool | None]]:
    """Return the times at which an emergency stop turns on or off if these messages come, with a look every 0.05 s."""
    stop, found, waiting = StopTopic(), list[tuple[float, bool | None]](), list(told)
    for now in [step / 20 for step in range(round(until * 20) + 1)]:
        before = stop
        while waiting and waiting[0][0] <= now:
            stop = stop.heard(waiting.pop(0)[1], now)
        stop = stop.looked(now)
        if stop.on != before.on:
            found.append((now, stop.on))
    return found


@pytest.mark.parametrize(
    ("told", "turned"),
    [
        ([(1, [T])], [(1, T)]),
        ([(1, [T]), (2, [F])], [(1, T), (2, F)]),
        ([(1, [F])], [(1, F)]),
        ([(0, [F]), (1, [F, T, F, F])], [(0, F), (1, T), (1 + RELEASED, F)]),  # one press among others' falses
        ([(1, [T]), (1.1, [F])], [(1, T), (1 + RELEASED, F)]),  # though nothing comes anymore
        ([(1, [T]), (2, [F, T])], [(1, T)]),
        ([], []),
    ],
)
def test_each_true_stops_and_a_false_releases(
    told: list[tuple[float, list[bool]]], turned: list[tuple[float, bool]]
) -> None:
    assert turns(told, until=4) == turned


def test_constant_falses_do_not_release_a_stop_that_another_node_holds() -> None:
    told = [(step / 20, [F, F, T] if step % 8 == 0 else [F]) for step in range(20, 60)]
    assert turns(told, until=4) == [(1.0, F), (1.2, T), (2.8 + RELEASED, F)]


def test_presses_are_counted_and_stay_until_they_are_released() -> None:
    none = EmergencyStops()
    one = none.heard("/a", True)
    both = one.heard("/a", True).heard("/b", True)
    assert both == EmergencyStops(frozenset({"/a", "/b"}), 2)
    assert both.heard("/a", False) == EmergencyStops(frozenset({"/b"}), 2)
    assert none.heard("/a", False) == none


@pytest.mark.parametrize(
    ("knows", "told", "then"),
    [
        (EmergencyStops(), (["/a"], 3), EmergencyStops(frozenset({"/a"}), 3)),
        (EmergencyStops(), ([], 3), EmergencyStops(frozenset(), 3)),
        (EmergencyStops(frozenset(), 3), (["/a"], 3), EmergencyStops(frozenset(), 3)),  # it has received the release
    ],
)
def test_a_stage_learns_of_presses_that_others_received(
    knows: EmergencyStops, told: tuple[list[str], int], then: EmergencyStops
) -> None:
    pressed: Pressed = {"type": "pressed", "topics": told[0], "count": told[1]}
    assert knows.merged(pressed) == then


ON = "✗ the emergency stop on /a is on: release it, then save again"
STILL_ON = (
    "✗ the emergency stop on /a is still on, although improv.toml no longer names it: release it "
    "(`ros2 topic pub --once /a std_msgs/msg/Bool '{data: false}'`) or restart Improv, then save again"
)


@pytest.mark.parametrize(
    ("stops", "named", "known", "line"),
    [
        (EmergencyStops(), "/a", 0, None),
        (EmergencyStops(frozenset(), 2), "/a", 2, None),
        (EmergencyStops(frozenset(), 2), "/a", None, None),
        (EmergencyStops(frozenset(), 2), None, 1, OLDER),
        (EmergencyStops(frozenset({"/a"}), 2), "/a", 2, ON),
        (EmergencyStops(frozenset({"/a"}), 2), "/b", 2, STILL_ON),
        (EmergencyStops(frozenset({"/a"}), 2), None, 2, STILL_ON),
    ],
)
def test_stops_refuse_scores(stops: EmergencyStops, named: str | None, known: int | None, line: str | None) -> None:
    assert stops.refusal(Safety(stop=named), known) == line
