"""The rules that find faults of a robot: `look(watch, known, rules) -> (watch, news)`, without side effects or a clock.

Times are the clock's, in seconds; other units are meters and radians. Standard library only.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import NamedTuple

from improv_core.protocol.output import Unfollowed
from improv_core.safety.odometry import Comparison
from improv_core.score.faults import Fault, FaultRules

SILENT = 1.0
"""Seconds without a pose after which a robot is silent, if its poses usually come at least every third of that."""
USUAL = 3
"""The factor by which the time between two poses may exceed the usual one otherwise, while the robot is sent
velocities: localization sends a pose only after a robot has moved."""
LONGEST_USUAL = 1.0
"""The longest usual time between two poses, in seconds."""
BACK = 0.8
"""The share of the limits within which a robot is back on its path: less than 1, so one at the limit is news once."""
STUCK = 0.7
"""Seconds for which a robot that is sent a velocity may stand. One that speeds up by 0.9 m/s², and whose poses come 80
ms late, has moved by `MOVES` after 0.34 s; at 0.2 m/s, with poses 0.3 s late, after 0.6 s."""
TOLD, TOLD_TURN = 0.05, math.radians(6)
"""Meters and radians that it should have moved meanwhile, even if it lags: a robot that should only tremble on the spot
is not stuck. With `MOVES`, a lag of 0.4 s at any speed leaves it unblamed."""
MOVES, MOVES_TURN = 0.03, math.radians(3)
"""Meters and radians from which a robot really moves. Measured poses tremble by less."""
FRESH = 0.5
"""Seconds after which a pose is too old to show that a robot stands."""
LATE = 0.02
"""Seconds by which a command may leave too late. A base doesn't notice such a delay: its own cycle takes as long."""
SWAPPED = 0.5
"""Two robots seem to be swapped if they have jumped within this many seconds, and each is where the other one was, to
within this share of the distance. Both keep moving meanwhile, so it isn't less."""
RUSHED = "the program changes velocities faster than accelerations in improv.toml allow: see `improv check`"
"""The reason for which a robot is off its path that isn't the robot's."""
QUIET = 10.0
"""Seconds without a jump or a late command that end that fault. Two nodes on one topic make twenty jumps a second."""


class Worst(NamedTuple):
    """The largest extent of a fault: meters and radians off a path or jumped, and seconds without poses, without
    movement, or late."""

    distance: float = 0.0
    turn: float = 0.0
    seconds: float = 0.0


class FaultBegan(NamedTuple):
    """A fault of a robot begins. A robot that has jumped seems to be `swapped` with another one if each of them is
    where the other one was. `why` is the cause in words, if it is known."""

    fault: Fault
    worst: Worst
    swapped: str = ""
    why: str = ""


class FaultOver(NamedTuple):
    """A fault of a robot is over. `worst` is its largest extent."""

    fault: Fault
    worst: Worst


News = FaultBegan | FaultOver


@dataclass(frozen=True, slots=True)
class RobotFacts:
    """The facts about a robot."""

    now: float
    poses: Sequence[Comparison] = ()
    """The poses that have come since the last check."""
    heard: float | None = None
    """All poses that were sent by this time have come; None if nothing measures the robot."""
    moves: float | None = None
    """The time since which it has been sent velocities; None if it stands."""
    gone: bool = False
    """True if nothing listens for it."""
    late: float = 0.0
    """Seconds by which its commands since the last check left late, at most."""
    unfollowed: Unfollowed | None = None
    """Its joints that don't follow their commands."""
    rushed: bool = False
    """True if its part changed its velocity faster than its accelerations allow."""
    lost: str = ""
    """The reason why its output can't reach it."""


@dataclass(frozen=True, slots=True)
class RobotWatch:
    """One robot that is watched: its open faults, with the time at which each began and its extent so far.

    `latest` is its latest pose, and `usual` the usual time until the next one. `anchor` is the pose from which it has
    not moved since. `jumped` and `late` are the times of its latest jump and its latest late command, and `left` is its
    pose before it jumped.
    """

    open: Mapping[Fault, tuple[float, Worst]] = field(default_factory=dict)
    latest: Comparison | None = None
    usual: float = 0.0
    anchor: Comparison | None = None
    jumped: float = -math.inf
    left: Comparison | None = None
    late: float = -math.inf


def look(watch: RobotWatch, known: RobotFacts, rules: FaultRules) -> tuple[RobotWatch, list[News]]:
    """Find the faults of a robot that have begun since the last check, and those that are over."""
    found: dict[Fault, Worst | None] = {}  # None: the fault is over; faults that aren't in it stay as they are
    for pose in known.poses:
        watch = _posed(watch, pose, found, rules)
    if watch.anchor and (known.gone or (known.moves is not None and watch.anchor.raw.at < known.moves)):
        watch = replace(watch, anchor=watch.latest)
    _find_silence(watch, known, found)
    _find_standstill(watch, known, found)
    found["gone"] = Worst(seconds=known.now - _since(watch, "gone", known.now)) if known.gone else None
    found["joints"] = Worst(seconds=known.unfollowed.seconds) if known.unfollowed else None
    if known.late > LATE:
        watch = replace(watch, late=known.now)
        found["late"] = Worst(seconds=known.late)
    calm: Mapping[Fault, float] = {"jumped": watch.jumped, "late": watch.late}
    for fault, last in calm.items():
        if fault not in found and known.now >= last + QUIET:
            found[fault] = None
    watch, news = _settled(watch, found, known.now)
    return watch, [_explained(each, known) for each in news]


def _explained(news: News, known: RobotFacts) -> News:
    """Add the cause to a fault that begins, if it is known."""
    if not isinstance(news, FaultBegan):
        return news
    causes: Mapping[Fault, str] = {
        "joints": known.unfollowed.why if known.unfollowed else "",
        "off_path": RUSHED if known.rushed else "",
        "gone": known.lost,
    }
    return news._replace(why=causes.get(news.fault, ""))


def are_swapped(one: RobotWatch, other: RobotWatch) -> bool:
    """Return whether two robots have jumped to each other's earlier places, so that their poses seem to be swapped."""
    if not (one.left and one.latest and other.left and other.latest) or abs(one.jumped - other.jumped) > SWAPPED:
        return False
    far, _ = one.left.pose.apart(other.left.pose)
    offs = one.latest.pose.apart(other.left.pose), other.latest.pose.apart(one.left.pose)
    return all(off < SWAPPED * far for off, _ in offs)


def _settled(watch: RobotWatch, found: Mapping[Fault, Worst | None], now: float) -> tuple[RobotWatch, list[News]]:
    """Return the watch with the faults that were found, and what is new in it."""
    if not watch.open and not any(found.values()):
        return watch, []
    opened, news = dict(watch.open), list[News]()
    for fault, worst in found.items():
        since, before = opened.get(fault, (now, Worst()))
        if worst:
            worst = Worst(*map(max, before, worst))
            if fault not in opened:
                news.append(FaultBegan(fault, worst))
            opened[fault] = since, worst
        elif fault in opened:
            news.append(FaultOver(fault, before))
            del opened[fault]
    return replace(watch, open=opened), news


def _posed(watch: RobotWatch, pose: Comparison, found: dict[Fault, Worst | None], rules: FaultRules) -> RobotWatch:
    before, anchor, usual, jumped, left = watch.latest, watch.anchor, watch.usual, watch.jumped, watch.left
    if before and pose.raw.at - before.raw.at <= SILENT:  # a longer gap is not usual
        usual = min(max(pose.raw.at - before.raw.at, 0.9 * usual), LONGEST_USUAL)
    if pose.jump:
        jumped, left = pose.raw.at, before
        _note(found, "jumped", Worst(*pose.jump))
    _find_deviation(watch, pose, found, rules)
    if pose.jump or not anchor or anchor.aligned != pose.aligned or _has_moved(anchor, pose):
        anchor, found["stuck"] = pose, None
    return replace(watch, latest=pose, usual=usual, anchor=anchor, jumped=jumped, left=left)


def _find_deviation(watch: RobotWatch, pose: Comparison, found: dict[Fault, Worst | None], rules: FaultRules) -> None:
    """Check whether a robot is off its path: away from its ideal pose, and from its ideal poses of a moment ago.

    It is back once it is near all of these. If one were enough, a turn would bring back a robot whose heading is off:
    for a moment, it looks as if it only lagged.
    """
    offs = [pose.pose.apart(each) for each in (pose.ideal, *pose.recent)]
    if all(_is_off(off, rules, 1.0) for off in offs):
        _note(found, "off_path", Worst(*offs[0]))
    elif not any(_is_off(off, rules, BACK) for off in offs):
        found["off_path"] = None


def _is_off(off: tuple[float, float], rules: FaultRules, share: float) -> bool:
    return off[0] > rules.distance * share or off[1] > rules.angle * share


def _has_moved(anchor: Comparison, pose: Comparison) -> bool:
    far, turn = pose.pose.apart(anchor.pose)
    return far >= MOVES or turn >= MOVES_TURN


def _find_silence(watch: RobotWatch, known: RobotFacts, found: dict[Fault, Worst | None]) -> None:
    """Check whether a robot's poses have stopped."""
    if known.heard is None or not watch.latest:
        found["silent"] = None
        return
    at = watch.latest.raw.at
    limit, since = SILENT, at
    if USUAL * watch.usual > SILENT:
        limit, since = USUAL * watch.usual, max(at, known.now if known.moves is None else known.moves)
    if known.heard - since > limit:
        found["silent"] = Worst(seconds=known.heard - at)
    elif known.poses:
        found["silent"] = None


def _find_standstill(watch: RobotWatch, known: RobotFacts, found: dict[Fault, Worst | None]) -> None:
    """Check whether a robot stands although it is sent a velocity."""
    latest, anchor = watch.latest, watch.anchor
    if known.moves is None or not latest or not anchor:
        found["stuck"] = None
        return
    stood = latest.raw.at - max(anchor.raw.at, known.moves)
    far, turn = (latest.recent or (latest.ideal,))[0].apart((anchor.recent or (anchor.ideal,))[0])
    if known.now - latest.raw.at <= FRESH and stood >= STUCK and (far >= TOLD or turn >= TOLD_TURN):
        found["stuck"] = Worst(seconds=stood)


def _note(found: dict[Fault, Worst | None], fault: Fault, worst: Worst) -> None:
    found[fault] = Worst(*map(max, found.get(fault) or Worst(), worst))


def _since(watch: RobotWatch, fault: Fault, now: float) -> float:
    return watch.open[fault][0] if fault in watch.open else now
