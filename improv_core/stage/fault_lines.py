"""The faults of robots in words: each line says what is wrong and what to do."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from typing import NamedTuple

from improv_core.score.faults import Fault, Response
from improv_core.score.score import Part, Rejoin
from improv_core.stage.faults import FaultBegan, News, Worst

NAMED = 3
"""So many robots are named in a line about more; the page lists all."""


class SeenNews(NamedTuple):
    """What is new about a robot, and whether it stands because of a fault."""

    part: Part
    news: News
    stands: bool


def as_line(found: SeenNews, beat: str, response: Response, rejoin: Rejoin) -> str:
    """One line about a robot. `beat` names the beat."""
    (part, (fault, worst), stands) = found
    if isinstance(found.news, FaultBegan):
        return f"{beat}: {_BEGAN[fault](part, worst)}{_FOLLOWS[response]}"
    back = _BACK[rejoin] if fault == "gone" else ""
    return f"{beat}: {_OVER[fault](part.robot, worst)}{'; it stands until you unmute it' if stands else back}"


def as_lines(found: Sequence[SeenNews], beat: str, responses: Callable[[Fault], Response], rejoin: Rejoin) -> list[str]:
    """What people are told about all that is new: for each robot a line, or "" if that of one before it covers it.

    If the same is new about several robots, the line names the first three and counts the others.
    """
    alike: dict[tuple[object, ...], list[SeenNews]] = {}
    for each in found:
        alike.setdefault(_kind(each), []).append(each)
    lines = []
    for each in found:
        group = alike.pop(_kind(each), [])
        response = responses(each.news.fault)
        if len(group) > 1:
            lines.append(_line_of_several(group, beat, response, rejoin))
        else:
            lines.append(as_line(each, beat, response, rejoin) if group else "")
    return lines


def in_words(worst: Worst) -> str:
    """`0.31 m and 4 degrees`."""
    degrees = round(math.degrees(worst.turn))
    return f"{worst.distance:.2f} m and {degrees} degree{'' if degrees == 1 else 's'}"


def _kind(found: SeenNews) -> tuple[object, ...]:
    return type(found.news), found.news.fault, found.stands


def _line_of_several(found: Sequence[SeenNews], beat: str, response: Response, rejoin: Rejoin) -> str:
    news, fault = found[0].news, found[0].news.fault
    robots = _names([each.part.robot for each in found])
    worst = Worst(*(max(values) for values in zip(*(each.news.worst for each in found), strict=True)))
    if isinstance(news, FaultBegan):
        follows = _FOLLOWS[response].replace("it stands until you unmute it", _THEY_STAND)
        return f"{beat}: {_SEVERAL_BEGAN[fault](robots, worst)}{follows}"
    back = _BACK[rejoin].replace("continues", "continue").replace("stands", "stand") if fault == "gone" else ""
    return f"{beat}: {_SEVERAL_OVER[fault](robots, worst)}{f'; {_THEY_STAND}' if found[0].stands else back}"


def _names(robots: Sequence[str]) -> str:
    """`ada and bo`, `ada, bo, and cy`, `ada, bo, cy, and 27 more`."""
    if len(robots) == 2:
        return " and ".join(robots)
    *others, last = robots if len(robots) <= NAMED else [*robots[:NAMED], f"{len(robots) - NAMED:,} more"]
    return f"{', '.join(others)}, and {last}"


_BEGAN: Mapping[Fault, Callable[[Part, Worst], str]] = {
    "off_path": lambda part, worst: (
        f"{part.robot} is {in_words(worst)} off its path: put it back, calibrate it, or look for what holds it up"
    ),
    "silent": lambda part, worst: (
        f"no pose of {part.robot} has come for {worst.seconds:.1f} s: "
        f"check its network and what publishes on {part.odom}"
    ),
    "jumped": lambda part, worst: (
        f"the pose of {part.robot} jumped by {in_words(worst)}: check what publishes on {part.odom}"
    ),
    "stuck": lambda part, worst: (
        f"{part.robot} is told to move but stands: check its motors, its battery, and what is in its way"
    ),
    "gone": lambda part, worst: f"{part.robot} is gone, nothing listens on {part.topic}: start its driver again",
    "late": lambda part, worst: (
        f"commands for {part.robot} leave {worst.seconds * 1000:.0f} ms late: "
        "close other programs on this machine or play fewer robots"
    ),
}
_SEVERAL_BEGAN: Mapping[Fault, Callable[[str, Worst], str]] = {
    "off_path": lambda robots, worst: (
        f"{robots} are up to {in_words(worst)} off their paths: "
        "put them back, calibrate them, or look for what holds them up"
    ),
    "silent": lambda robots, worst: (
        f"no poses of {robots} have come for {worst.seconds:.1f} s: check the network and what publishes their poses"
    ),
    "jumped": lambda robots, worst: (
        f"the poses of {robots} jumped by up to {in_words(worst)}: check what publishes them"
    ),
    "stuck": lambda robots, worst: (
        f"{robots} are told to move but stand: check their motors, their batteries, and what is in their way"
    ),
    "gone": lambda robots, worst: (
        f"{robots} are gone, nothing listens on their topics: check the network, or start their drivers again"
    ),
    "late": lambda robots, worst: (
        f"commands for {robots} leave up to {worst.seconds * 1000:.0f} ms late: "
        "close other programs on this machine or play fewer robots"
    ),
}
_OVER: Mapping[Fault, Callable[[str, Worst], str]] = {
    "off_path": lambda robot, worst: f"{robot} is back on its path, it was at most {in_words(worst)} off",
    "silent": lambda robot, worst: f"poses of {robot} come again, after {worst.seconds:.1f} s",
    "jumped": lambda robot, worst: f"the poses of {robot} no longer jump",
    "stuck": lambda robot, worst: f"{robot} is no longer stuck, it was for {worst.seconds:.1f} s",
    "gone": lambda robot, worst: f"{robot} listens again, after {worst.seconds:.1f} s",
    "late": lambda robot, worst: (
        f"commands for {robot} leave in time again, they were at most {worst.seconds * 1000:.0f} ms late"
    ),
}
_SEVERAL_OVER: Mapping[Fault, Callable[[str, Worst], str]] = {
    "off_path": lambda robots, worst: f"{robots} are back on their paths, they were at most {in_words(worst)} off",
    "silent": lambda robots, worst: f"poses of {robots} come again, after up to {worst.seconds:.1f} s",
    "jumped": lambda robots, worst: f"the poses of {robots} no longer jump",
    "stuck": lambda robots, worst: f"{robots} are no longer stuck, they were for up to {worst.seconds:.1f} s",
    "gone": lambda robots, worst: f"{robots} listen again, after up to {worst.seconds:.1f} s",
    "late": lambda robots, worst: (
        f"commands for {robots} leave in time again, they were at most {worst.seconds * 1000:.0f} ms late"
    ),
}
_FOLLOWS: Mapping[Response, str] = {
    "tell": "",
    "stand": "; it stands until you unmute it",
    "stop": "; all robots are told to stop: save to play again",
}
_THEY_STAND = "they stand until you unmute them"
_BACK: Mapping[Rejoin, str] = {
    "continue": ", and continues in the middle of the program",
    "scene": ", and stands until the next scene",
    "next": ", and stands until the next play",
    "pause": "",
}
