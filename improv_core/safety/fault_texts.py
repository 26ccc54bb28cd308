"""The faults of robots in words: each line names the problem and what to do."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Collection, Mapping, Sequence
from typing import NamedTuple

from improv_core.safety.fault_rules import FaultBegan, News, Worst
from improv_core.score.faults import Fault, Response
from improv_core.score.score import Part, Rejoin

NAMED = 3
"""The most robots that a line names; the page lists all."""


class SeenNews(NamedTuple):
    """News about a robot, and whether it stands because of a fault; `newly` if this fault made it stand."""

    part: Part
    news: News
    stands: bool
    newly: bool = False


def as_line(found: SeenNews, beat: str, response: Response, rejoin: Rejoin) -> str:
    """Return one line about a robot. `beat` names the beat."""
    return _line([found], beat, response, rejoin)


def as_lines(found: Sequence[SeenNews], beat: str, responses: Callable[[Fault], Response], rejoin: Rejoin) -> list[str]:
    """Return the lines about all news: one for each robot, or "" if the line about an earlier robot covers it.

    If several robots have the same news, the line names the first three and counts the others.
    """
    alike: dict[tuple[object, ...], list[SeenNews]] = {}
    for each in found:
        alike.setdefault(_kind(each), []).append(each)
    groups = (alike.pop(_kind(each), []) for each in found)
    return [_line(group, beat, responses(group[0].news.fault), rejoin) if group else "" for group in groups]


def may_still_move(robots: Sequence[str]) -> str:
    """Return the line about robots that were sent zeros while they were out of reach."""
    are = "it is out of reach, so look at it" if len(robots) == 1 else "they are out of reach, so look at them"
    return f"{in_one_phrase(robots)} may still be moving: {are}"


def moved_by_others(others: Mapping[str, Collection[str]]) -> str:
    """Return the line about stopped robots that others can also move: `others` are their names, by robot."""
    names = sorted({name for names in others.values() for name in names})
    moved = "it" if len(others) == 1 else "them"
    return f"{in_one_phrase([*others])} may still be moving: stop {', '.join(names)}, which can move {moved}, too"


def low_battery(robots: Sequence[str], level: float) -> str:
    """Return the line about robots whose batteries have fallen to this level at most, from 0 to 1."""
    if len(robots) == 1:
        return f"the battery of {robots[0]} is at {level:.0%}: charge it soon"
    return f"the batteries of {in_one_phrase(robots)} are at {level:.0%} or less: charge them soon"


def different_frames(frames: Mapping[str, str], strays: Collection[str]) -> str:
    """Return the line about poses in the world with different frames, of which those of the `strays` don't count."""
    by_frame: dict[str, list[str]] = {}
    for robot, frame in sorted(frames.items()):
        by_frame.setdefault(frame, []).append(robot)
    named = in_one_phrase([f"{in_one_phrase(robots)} in {frame!r}" for frame, robots in by_frame.items()])
    return (
        f"poses in the world have different frames: {named}; no check and no correction uses those of "
        f"{in_one_phrase(sorted(strays))}: publish all in one frame"
    )


def in_words(worst: Worst) -> str:
    """Return `0.31 m and 4 degrees`, or one of them if the other is zero."""
    degrees = round(math.degrees(worst.turn))
    far, turned = f"{worst.distance:.2f} m", f"{degrees} degree{'' if degrees == 1 else 's'}"
    if not degrees:
        return far
    return turned if far == "0.00 m" else f"{far} and {turned}"


def _kind(found: SeenNews) -> tuple[object, ...]:
    other, why = (found.news.swapped, found.news.why) if isinstance(found.news, FaultBegan) else ("", "")
    pair = frozenset((found.part.robot, other)) if other else None
    return type(found.news), found.news.fault, found.stands, found.newly, pair, why


def _line(found: Sequence[SeenNews], beat: str, response: Response, rejoin: Rejoin) -> str:
    """Return one line about all robots with the same news."""
    first, fault, parts = found[0], found[0].news.fault, [each.part for each in found]
    worst = Worst(*(max(values) for values in zip(*(each.news.worst for each in found), strict=True)))
    if isinstance(first.news, FaultBegan):
        text = _SWAPPED if first.news.swapped else (_BECAUSE if first.news.why else _BEGAN)[fault]
        follows = _ALL_STOP if response == "stop" else _STAND if first.newly else ""
        names = " and ".join(sorted([first.part.robot, first.news.swapped])) if first.news.swapped else ""
        return f"{beat}: {_filled(text + follows, parts, worst, names, first.news.why)}"
    follows = _BACK[rejoin] if fault == "gone" else ""
    if first.stands:
        follows = _STAND if response == "stand" else ""
    return f"{beat}: {_filled(_OVER[fault] + follows, parts, worst)}"


def _filled(text: str, parts: Sequence[Part], worst: Worst, names: str = "", why: str = "") -> str:
    """Return a text about the robots of some parts. It has fields, and in brackets the words for one or several."""
    return re.sub(r"\[(.*?)\|(.*?)\]", r"\1" if len(parts) == 1 else r"\2", text).format(
        names=names or in_one_phrase([part.robot for part in parts]),
        off=in_words(worst),
        seconds=worst.seconds,
        milliseconds=worst.seconds * 1000,
        odom=parts[0].odom,
        topic=parts[0].topic,
        why=why,
    )


def in_one_phrase(robots: Sequence[str]) -> str:
    """Return the names of robots: `ada`, `ada and bo`, `ada, bo, and cy`, `ada, bo, cy, and 27 more`."""
    if len(robots) <= 2:
        return " and ".join(robots)
    *others, last = robots if len(robots) <= NAMED else [*robots[:NAMED], f"{len(robots) - NAMED:,} more"]
    return f"{', '.join(others)}, and {last}"


_ALL_STOP = "; all robots were stopped: play again once that is fixed"
_STAND = "; [it stands until you unmute it|they stand until you unmute them]"
_SWAPPED = "{names} seem to be swapped, their poses jumped by {off}: check what tells them apart"
_BEGAN: Mapping[Fault, str] = {
    "off_path": (
        "{names} [is|are up to] {off} off [its path: put it back, calibrate it, or look for what holds it up"
        "|their paths: put them back, calibrate them, or look for what holds them up]"
    ),
    "silent": (
        "no [pose|poses] of {names} [has|have] come for {seconds:.1f} s: "
        "check [its|the] network and what publishes [on {odom}|their poses]"
    ),
    "jumped": (
        "the [pose|poses] of {names} jumped by [|up to ]{off}: unless somebody moved [it|them], "
        "check the node that publishes [on {odom}|them]"
    ),
    "stuck": (
        "{names} [is|are] told to move but [stands|stand]: check [its motors, its battery, and what is in its way"
        "|their motors, their batteries, and what is in their way]"
    ),
    "gone": (
        "{names} [is|are] gone, nothing listens on [{topic}: start its driver again"
        "|their topics: check the network, or start their drivers again]"
    ),
    "late": (
        "commands for {names} leave [|up to ]{milliseconds:.0f} ms late: "
        "close other programs on this machine or play fewer robots"
    ),
}
_BECAUSE: Mapping[Fault, str] = {
    "off_path": "{names} [is|are up to] {off} off [its path|their paths]: {why}",
    "joints": "joints of {names} don't follow: {why}",
    "gone": "{names} [is|are] gone: {why}",
}
"""Texts about faults whose cause is known."""
_OVER: Mapping[Fault, str] = {
    "off_path": "{names} [is back on its path, it was|are back on their paths, they were] at most {off} off",
    "silent": "poses of {names} come again, after [|up to ]{seconds:.1f} s",
    "jumped": "the poses of {names} no longer jump",
    "stuck": "{names} [is no longer stuck, it was for|are no longer stuck, they were for up to] {seconds:.1f} s",
    "joints": "joints of {names} follow again, after [|up to ]{seconds:.1f} s",
    "gone": "{names} [listens again, after|listen again, after up to] {seconds:.1f} s",
    "late": "commands for {names} leave in time again, they were at most {milliseconds:.0f} ms late",
}
_BACK: Mapping[Rejoin, str] = {
    "continue": ", and [continues|continue] in the middle of the program",
    "scene": ", and [stands|stand] until the next scene",
    "next": ", and [stands|stand] until the next play",
    "return": "",  # other lines describe it
    "pause": "",
}
