"""Every time in a message is translated, there and back."""

from __future__ import annotations

from types import UnionType
from typing import Any, get_args, get_origin

import pytest

from improv_core.hosts.clock_offset import Clocks
from improv_core.hosts.time_translation import SECOND, Border, to_here, to_there
from improv_core.protocol.decoding import by_type
from improv_core.protocol.messages import FromStage, ToStage
from improv_core.score.fits import hints_of

AHEAD, WALL_AHEAD = 1_000.0, 50.0
"""Seconds by which the monotonic and the Unix clock there are ahead."""
BORDER = Border(
    Clocks(0.0, AHEAD),
    wall=1_700_000_000 * SECOND,
    wall_there=round((1_700_000_000 - AHEAD + WALL_AHEAD) * SECOND),
    asleep=20.0,
)


@pytest.mark.parametrize(
    ("message", "there"),
    [
        ({"type": "pause", "at": 5.0, "after": 3}, {"type": "pause", "at": 1_005.0, "after": 3}),
        (
            {"type": "load", "asleep": 1.5, "at": 1.0, "entry": {"beat": 4.0, "monotonic": 7.0}, "score": {"at": 1}},
            {"type": "load", "asleep": 21.5, "at": 1_001.0, "entry": {"beat": 4.0, "monotonic": 1_007.0}}
            | {"score": {"at": 1}},
        ),
        (
            {"type": "seen", "robots": {"r": {"at": 5.0, "pose": {"x": 1.0}}}},
            {"type": "seen", "robots": {"r": {"at": 1_005.0, "pose": {"x": 1.0}}}},
        ),
        (
            {"type": "load", "arming": {"begins": 1_700_000_007.0}, "senses": [{"wall": 1_700_000_000 * SECOND}]},
            {"type": "load", "arming": {"begins": 1_700_000_057.0}, "senses": [{"wall": 1_700_000_050 * SECOND}]},
        ),
    ],
)
def test_messages_to_a_stage_have_the_times_of_its_machine(message: dict[str, Any], there: dict[str, Any]) -> None:
    assert to_there(message, BORDER) == there


@pytest.mark.parametrize(
    ("message", "here"),
    [
        (
            {"type": "transport", "monotonic": 1_005.0, "wall": 1_700_000_055.0},
            {"type": "transport", "monotonic": 5.0, "wall": 1_700_000_005.0},
        ),
        (
            {"type": "sent", "robot": "r", "twist": [1.0], "wall": 1_700_000_055 * SECOND + 7},
            {"type": "sent", "robot": "r", "twist": [1.0], "wall": 1_700_000_005 * SECOND + 7},
        ),
        (
            {"type": "armed", "generation": 1, "armed": True, "begins": 1_700_000_050.0},
            {"type": "armed", "generation": 1, "armed": True, "begins": 1_700_000_000.0},
        ),
        (
            {"type": "armed", "generation": 1, "armed": True, "begins": None},
            {"type": "armed", "generation": 1, "armed": True, "begins": None},
        ),
    ],
)
def test_messages_from_a_stage_have_the_times_of_this_machine(message: dict[str, Any], here: dict[str, Any]) -> None:
    assert to_here(message, BORDER) == here


def test_a_machine_there_opens_no_page_here_and_sends_only_requests_that_ros_may() -> None:
    ready = {"type": "ready", "protocol": 2, "sink": "ROS 2", "real": True}
    assert to_here({**ready, "page": "http://example.org"}, BORDER) == ready
    asked = [{"type": "request", "command": {"type": kind}} for kind in ("editing", "place", "form", "seek", "watched")]
    assert [to_here(each, BORDER) for each in asked] == [None] * 5
    stop = {"type": "request", "command": {"type": "stop"}}
    assert to_here(stop, BORDER) == stop


TIMES = {"at", "monotonic", "wall", "begins", "asleep"}


def example(hint: Any, name: str = "") -> Any:
    """Return a value of a type whose times are all 1."""
    origin, arguments = get_origin(hint), get_args(hint)
    if hasattr(hint, "__required_keys__"):
        return {key: example(inner, key) for key, inner in hints_of(hint).items() if key != "command"}
    if origin in (UnionType,) or str(origin) == "typing.Union":
        return example(arguments[0], name)
    if str(hint).startswith("typing.Annotated"):
        return example(arguments[0], name)
    if "Mapping" in str(origin):
        return {"r": example(arguments[1], "")}
    if "Sequence" in str(origin):
        return [example(arguments[0], "")]
    if str(origin) == "typing.Literal":
        return arguments[0]
    return {int: 1, float: 1.0, str: "r", bool: True}.get(hint)


def times_in(value: Any, path: str = "") -> dict[str, Any]:
    if isinstance(value, dict):
        return {where: time for key, inner in value.items() for where, time in times_in(inner, f"{path}.{key}").items()}
    if isinstance(value, list):
        return {where: time for inner in value for where, time in times_in(inner, f"{path}.0").items()}
    return {path: value} if path.rpartition(".")[2] in TIMES and type(value) in (int, float) else {}


@pytest.mark.parametrize(("union", "cross"), [(ToStage, to_there), (FromStage, to_here)])
def test_every_time_in_every_message_is_translated(union: Any, cross: Any) -> None:
    """`begins` of parts and scenes is in beats."""
    for kind, message in by_type(union).items():
        if kind == "request":
            continue
        before = example(message)
        after = cross(before, BORDER)
        if after is None:
            continue
        assert len(times_in(after)) == len(times_in(before))
        in_beats = {".begins.r", ".scene.begins", ".entry.begins.r", ".entry.scene.begins"}
        same = {where for where, time in times_in(before).items() if times_in(after).get(where) == time} - in_beats
        assert (kind, same) == (kind, set())
