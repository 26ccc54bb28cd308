"""The faults of robots in words: each line says what is wrong and what to do."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping

from improv_core.score.faults import Fault, Response
from improv_core.score.score import Part, Rejoin
from improv_core.stage.faults import FaultBegan, News, Worst


def as_line(part: Part, news: News, beat: str, response: Response, stands: bool, rejoin: Rejoin) -> str:
    """One line about a robot. `beat` names the beat, and it `stands` because of a fault."""
    robot, (fault, worst) = part.robot, news
    if not isinstance(news, FaultBegan):
        back = _BACK[rejoin] if fault == "gone" else ""
        still = "; it stands until you unmute it" if stands else back
        return f"{beat}: {_OVER[fault](robot, worst)}{still}"
    return f"{beat}: {_BEGAN[fault](part, worst)}{_FOLLOWS[response]}"


def in_words(worst: Worst) -> str:
    """`0.31 m and 4 degrees`."""
    degrees = round(math.degrees(worst.turn))
    return f"{worst.distance:.2f} m and {degrees} degree{'' if degrees == 1 else 's'}"


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
_FOLLOWS: Mapping[Response, str] = {
    "tell": "",
    "stand": "; it stands until you unmute it",
    "stop": "; all robots were stopped: save to play again",
}
_BACK: Mapping[Rejoin, str] = {
    "continue": ", and continues in the middle of the program",
    "scene": ", and stands until the next scene",
    "next": ", and stands until the next play",
    "pause": "",
}
