"""Every time in a message is translated, there and back."""

from __future__ import annotations

from types import UnionType
from typing import Any, get_args, get_origin

import pytest

from improv_core.hosts.clock_offset import RemoteClock
from improv_core.hosts.time_translation import SECOND, TimeTranslation, to_local, to_remote
from improv_core.protocol.decoding import by_type
from improv_core.protocol.messages import FromStage, ToStage
from improv_core.score.json_types import hints_of

AHEAD, WALL_AHEAD, ASLEEP = 1_000.0, 50.0, 20.0
"""Seconds by which the monotonic and the Unix clock there are ahead, and for which that machine slept longer."""
TRANSLATION = TimeTranslation(
    RemoteClock(0.0, AHEAD),
    lead=1_700_000_000 * SECOND,
    remote_lead=round((1_700_000_000 - AHEAD + WALL_AHEAD) * SECOND),
    asleep=ASLEEP,
)


def test_numbers_in_scores_are_no_times() -> None:
    load: Any = {"type": "load", "at": 1.0, "score": {"at": 1}}
    assert to_remote(load, TRANSLATION) == {"type": "load", "at": 1.0 + AHEAD, "score": {"at": 1}}
    armed: Any = {"type": "armed", "generation": 1, "armed": True, "begins": None}
    assert to_local(armed, TRANSLATION) == armed


def test_a_machine_there_opens_no_page_here_and_sends_only_requests_that_ros_may() -> None:
    ready = {"type": "ready", "protocol": 3, "sink": "ROS 2", "real": True}
    assert to_local({**ready, "page": "http://example.org"}, TRANSLATION) == ready
    asked = [{"type": "request", "command": {"type": kind}} for kind in ("editing", "change", "seek", "page_opened")]
    assert [to_local(each, TRANSLATION) for each in asked] == [None] * 4
    stop = {"type": "request", "command": {"type": "stop"}}
    assert to_local(stop, TRANSLATION) == stop
    person = {"type": "request", "command": {"type": "resume", "anyway": True}}
    assert to_local(person, TRANSLATION) == {"type": "request", "command": {"type": "resume", "by": "ros"}}


TIMES = {"at": AHEAD, "monotonic": AHEAD, "wall": WALL_AHEAD, "begins": WALL_AHEAD, "asleep": ASLEEP}
"""The fields that are times, and by how much they differ there."""


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


@pytest.mark.parametrize(("union", "cross", "sign"), [(ToStage, to_remote, 1), (FromStage, to_local, -1)])
def test_every_time_in_every_message_is_translated(union: Any, cross: Any, sign: int) -> None:
    """`begins` of parts and scenes is in beats. Only `wall` may be in whole nanoseconds."""
    in_beats = {f"{at}{place}" for at in ("", ".entry", ".stood") for place in (".begins.r", ".scene.begins")}
    for kind, message in by_type(union).items():
        before = example(message)
        after = None if kind == "request" else cross(before, TRANSLATION)
        if after is None:
            continue
        expected = {
            where: time + sign * TIMES[where.rpartition(".")[2]] * (SECOND if isinstance(time, int) else 1)
            for where, time in times_in(before).items()
            if where not in in_beats
        }
        found = {where: time for where, time in times_in(after).items() if where not in in_beats}
        assert found == pytest.approx(expected, rel=1e-9), kind
