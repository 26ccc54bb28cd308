"""The faults of robots in words: each line names the problem and what to do."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
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


def in_words(worst: Worst) -> str:
    """Return `0.31 m and 4 degrees`, or one of them if the other is zero."""
    degrees = round(math.degrees(worst.turn))
    far, turned = f"{worst.distance:.2f} m", f"{degrees} degree{'' if degrees == 1 else 's'}"
    if not degrees:
        return far
    return turned if far == "0.00 m" else f"{far} and {turned}"


class _Robots(NamedTuple):
    """The robots that a line is about."""

    parts: Sequence[Part]
    names: str

    def pick(self, one: str, several: str) -> str:
        """Return the words for one robot, or those for several."""
        return one if len(self.parts) == 1 else several


def _kind(found: SeenNews) -> tuple[object, ...]:
    other = found.news.swapped if isinstance(found.news, FaultBegan) else ""
    pair = frozenset((found.part.robot, other)) if other else None
    return type(found.news), found.news.fault, found.stands, found.newly, pair


def _line(found: Sequence[SeenNews], beat: str, response: Response, rejoin: Rejoin) -> str:
    """Return one line about all robots with the same news."""
    first, fault = found[0], found[0].news.fault
    robots = _Robots([each.part for each in found], in_one_phrase([each.part.robot for each in found]))
    worst = Worst(*(max(values) for values in zip(*(each.news.worst for each in found), strict=True)))
    stand = f"; {robots.pick('it stands until you unmute it', 'they stand until you unmute them')}"
    if isinstance(first.news, FaultBegan):
        follows = _ALL_STOP if response == "stop" else stand if first.newly else ""
        what = (
            _swapped([first.part.robot, first.news.swapped], worst)
            if first.news.swapped
            else _BEGAN[fault](robots, worst)
        )
        return f"{beat}: {what}{follows}"
    follows = _BACK[rejoin](robots) if fault == "gone" else ""
    if first.stands:
        follows = stand if response == "stand" else ""
    return f"{beat}: {_OVER[fault](robots, worst)}{follows}"


def _swapped(pair: Sequence[str], worst: Worst) -> str:
    names = " and ".join(sorted(pair))
    return f"{names} seem to be swapped, their poses jumped by {in_words(worst)}: check what tells them apart"


def in_one_phrase(robots: Sequence[str]) -> str:
    """Return the names of robots: `ada`, `ada and bo`, `ada, bo, and cy`, `ada, bo, cy, and 27 more`."""
    if len(robots) <= 2:
        return " and ".join(robots)
    *others, last = robots if len(robots) <= NAMED else [*robots[:NAMED], f"{len(robots) - NAMED:,} more"]
    return f"{', '.join(others)}, and {last}"


_ALL_STOP = "; all robots were stopped: play again once that is fixed"
_BEGAN: Mapping[Fault, Callable[[_Robots, Worst], str]] = {
    "off_path": lambda robots, worst: (
        f"{robots.names} {robots.pick('is', 'are up to')} {in_words(worst)} off "
        + robots.pick(
            "its path: put it back, calibrate it, or look for what holds it up",
            "their paths: put them back, calibrate them, or look for what holds them up",
        )
    ),
    "silent": lambda robots, worst: (
        f"no {robots.pick('pose', 'poses')} of {robots.names} {robots.pick('has', 'have')} come "
        f"for {worst.seconds:.1f} s: check {robots.pick('its', 'the')} network "
        f"and what publishes {robots.pick(f'on {robots.parts[0].odom}', 'their poses')}"
    ),
    "jumped": lambda robots, worst: (
        f"the {robots.pick('pose', 'poses')} of {robots.names} jumped by {robots.pick('', 'up to ')}{in_words(worst)}: "
        f"check what publishes {robots.pick(f'on {robots.parts[0].odom}', 'them')}"
    ),
    "stuck": lambda robots, worst: (
        f"{robots.names} {robots.pick('is', 'are')} told to move but {robots.pick('stands', 'stand')}: check "
        + robots.pick(
            "its motors, its battery, and what is in its way", "their motors, their batteries, and what is in their way"
        )
    ),
    "gone": lambda robots, worst: (
        f"{robots.names} {robots.pick('is', 'are')} gone, nothing listens on "
        + robots.pick(
            f"{robots.parts[0].topic}: start its driver again",
            "their topics: check the network, or start their drivers again",
        )
    ),
    "late": lambda robots, worst: (
        f"commands for {robots.names} leave {robots.pick('', 'up to ')}{worst.seconds * 1000:.0f} ms late: "
        "close other programs on this machine or play fewer robots"
    ),
}
_OVER: Mapping[Fault, Callable[[_Robots, Worst], str]] = {
    "off_path": lambda robots, worst: (
        f"{robots.names} {robots.pick('is back on its path, it was', 'are back on their paths, they were')} "
        f"at most {in_words(worst)} off"
    ),
    "silent": lambda robots, worst: (
        f"poses of {robots.names} come again, after {robots.pick('', 'up to ')}{worst.seconds:.1f} s"
    ),
    "jumped": lambda robots, worst: f"the poses of {robots.names} no longer jump",
    "stuck": lambda robots, worst: (
        f"{robots.names} {robots.pick('is no longer stuck, it was for', 'are no longer stuck, they were for up to')} "
        f"{worst.seconds:.1f} s"
    ),
    "gone": lambda robots, worst: (
        f"{robots.names} {robots.pick('listens again, after', 'listen again, after up to')} {worst.seconds:.1f} s"
    ),
    "late": lambda robots, worst: (
        f"commands for {robots.names} leave in time again, they were at most {worst.seconds * 1000:.0f} ms late"
    ),
}
_BACK: Mapping[Rejoin, Callable[[_Robots], str]] = {
    "continue": lambda robots: f", and {robots.pick('continues', 'continue')} in the middle of the program",
    "scene": lambda robots: f", and {robots.pick('stands', 'stand')} until the next scene",
    "next": lambda robots: f", and {robots.pick('stands', 'stand')} until the next play",
    "return": lambda robots: "",  # other lines describe it
    "pause": lambda robots: "",
}
