"""Timed poses of robots → a short program whose paths stay near them. Standard library only."""

from __future__ import annotations

import math
from bisect import bisect_right
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from itertools import dropwhile, pairwise
from typing import NamedTuple, TypeAlias

from improv_core.robots.config import Robots
from improv_core.robots.start_poses import start_poses
from improv_core.score.motion import Pose
from improv_core.transcription.ensemble import SharedLine, formation_of, lines_of
from improv_core.transcription.fits import VelocityFits
from improv_core.transcription.folding import bracketed, folded, with_names, with_whole_turns
from improv_core.transcription.pacing import on_whole_beats
from improv_core.transcription.performing import deviations_of
from improv_core.transcription.rhythm import TimedItem, TrackedRobot, items_of, near_items_of
from improv_core.transcription.rounding import fits_of
from improv_core.transcription.stretches import EvenStretch, stretches_of
from improv_core.transcription.tempo import USUAL, multiples, rareness, tempi
from improv_core.transcription.track import CLEAN, Noise, TimedPlace, Track, noise_of, track_of
from improv_core.transcription.wording import (
    REST,
    Node,
    Rounding,
    cost,
    is_rest,
    series_text,
    term_text,
)
from improv_core.transcription.writing import Guide, written

NOISY = 100 * CLEAN
"""A track with more noise than this, in meters or radians, has its changes on a coarse grid."""
_CHANGE = 0.15
"""Seconds: only changes between longer stretches determine the tempo."""
_SHARE, _DRAWN_SHARE = 15, 5
"""The noise assumed even in exact tracks is the tolerance divided by this: more in drawings, so that a curve becomes a
few arcs that are near enough."""
_FINEST = 9
"""The most times that numbers are made finer."""
_STRICTNESS = 0.25
"""The weight of the misfit when numbers are first rounded; each finer step multiplies it by 4."""
_TELLING = 40
"""The number of stretches that determine the tempo."""
_CLOSELY = 3
"""The number of tempi that are compared closely."""
_CLOSER = 0.2
"""The share of a tolerance that rounding may take where noise takes the rest."""
_HIDDEN, _REACHED = 2.0, 5.0
"""The standard deviations by which noise may hide the error of a mean of poses, and by which it hardly ever moves one
pose."""
_NEAR, _NEAREST = 1, 2
"""A robot that is too far off is written again, guided by its track: by stretches that are nearer to it, and then the
nearest: from pose to pose, with no amounts in common."""
_NATS = 4.0
"""Natural units of information that a misfit costs for each word."""


_MAX_TURN = math.radians(60)
"""The most that a robot's heading may be off in a drawing, however large the tolerance is."""


class Tolerance(NamedTuple):
    """The distance that a program may be from what it transcribes: meters, radians, and seconds."""

    meters: float = 0.03
    radians: float = math.radians(5)
    seconds: float = 0.05

    @property
    def for_drawings(self) -> Tolerance:
        """The same, with an angle that grows with the distance: a drawing has no headings but those of its lines."""
        usual = Tolerance()
        return self._replace(radians=min(max(self.radians, usual.radians * self.meters / usual.meters), _MAX_TURN))


@dataclass(frozen=True, slots=True)
class Transcription:
    """A program and its tempo, and how far each robot's path is from it at most, in meters and radians."""

    text: str
    tempo: int
    deviations: Mapping[str, tuple[float, float]]


def transcribe(
    recorded: Mapping[str, Sequence[TimedPlace]],
    robots: Robots = Robots(),  # noqa: B008
    tolerance: Tolerance = Tolerance(),  # noqa: B008
    tempo: int | None = None,
    stops: Callable[[], bool] = lambda: False,
    is_whole: bool = True,
    drawn: Collection[str] = (),
) -> Transcription:
    """Return the shortest program found whose paths stay within a tolerance of the recorded places.

    Each robot has at least two places, in the order of their times (s). `stops` ends the search: what was found so far
    counts. A program that isn't `is_whole`, but is put beside other robots, says where each of its own starts. The ways
    of robots that are `drawn` have no rhythm of their own: their movements get whole beats.
    """
    if recorded.keys() <= set(drawn):
        tolerance = tolerance.for_drawings
    tracks = {robot: track_of(places) for robot, places in recorded.items()}
    begin = min(track[0].time for track in tracks.values())
    tracks = {robot: _from(track, begin) for robot, track in tracks.items()}
    tracked = {robot: _tracked(track, noise_of(track), tolerance, robot in drawn) for robot, track in tracks.items()}
    timed = {robot: each for robot, each in tracked.items() if robot not in drawn}
    tempo = tempo or (_tempo(timed, robots, tolerance, stops) if timed else None)
    tempo, paced = on_whole_beats({robot: tracked[robot] for robot in drawn}, tempo)
    tracked |= paced
    items = {robot: items_of(each, tempo, stops)[1] for robot, each in tracked.items()}
    draft = _draft(tracked, items, tempo, robots, tolerance, 0, stops)
    for closeness in (_NEAR, _NEAREST):
        for robot, part in draft.items():
            if part.excess and not stops():
                late = {robot: tracked[robot]}
                near = {robot: near_items_of(late[robot], tempo, closeness == _NEAREST)}
                draft = _nearer(draft, _draft(late, near, tempo, robots, tolerance, closeness, stops))
    deviations = {robot: part.deviation for robot, part in draft.items()}
    return Transcription(_program(draft, tempo, robots, is_whole), tempo, deviations)


@dataclass(frozen=True, slots=True)
class _Part:
    """A robot's start and its words, how round their numbers are, and how far they are from its track at most.

    `excess` is the share of a tolerance by which they are farther than that.
    """

    start: Pose
    nodes: Sequence[Node]
    rounding: Rounding
    deviation: tuple[float, float]
    excess: float


_Draft: TypeAlias = Mapping[str, _Part]
"""The parts of robots."""


def _nearer(one: _Draft, other: _Draft) -> _Draft:
    """Return a draft that takes from another one the robots that are nearer to their tracks there."""
    return {**one, **{robot: part for robot, part in other.items() if part.excess < one[robot].excess}}


def _tracked(track: Track, noise: Noise, tolerance: Tolerance, is_drawn: bool) -> TrackedRobot:
    """Return a track with what its noise allows: also of exact ones, fits may be off by a part of the tolerance."""
    share = _DRAWN_SHARE if is_drawn else _SHARE
    steps = sorted(after.time - here.time for here, after in pairwise(track))
    noisy = max(noise) > NOISY
    noise = Noise(max(noise.meters, tolerance.meters / share), max(noise.radians, tolerance.radians / share))
    allowed = min(max(1.6 * steps[len(steps) // 2], tolerance.seconds), 0.25) if noisy else tolerance.meters / 3
    fits = VelocityFits(track, noise)
    return TrackedRobot(track, noise, noisy, allowed, fits, stretches_of(fits))


def _tempo(
    tracked: Mapping[str, TrackedRobot],
    robots: Robots,
    tolerance: Tolerance,
    stops: Callable[[], bool],
) -> int:
    """Return the tempo at which the part of the busiest robot costs the least: a likely one or a simple multiple. Its
    first stretches count."""
    changes = [time for each in tracked.values() for time in _changes(each.stretches)]
    found = tempi(changes, max(each.allowed for each in tracked.values()))
    likely = list(dict.fromkeys(other for each in found for other in multiples(each, 2)))
    robot = max(tracked, key=lambda robot: len(tracked[robot].stretches))
    busiest, profile = tracked[robot], robots.profile_of(robot)
    stretches = busiest.stretches[:_TELLING]
    last = bisect_right(busiest.track, busiest.track[0].time + stretches[-1].end, key=lambda each: each.time)
    track = busiest.track[:last]
    busiest = busiest._replace(track=track, fits=VelocityFits(track, busiest.noise), stretches=stretches)

    @lru_cache
    def price(tempo: int, roughly: bool = True) -> float:
        if stops():
            return math.inf
        misfit, items = items_of(busiest, tempo, stops, roughly)
        nodes = written(Pose(), items, profile, exact=Rounding(*tolerance[:2]))
        words = list(dropwhile(is_rest, (node for node, _ in nodes)))
        return misfit / _NATS + cost(folded(bracketed(words))) + rareness(tempo)

    best = min(likely, key=price)
    closest = sorted(dict.fromkeys([*likely, *multiples(best, 4)]), key=price)[:_CLOSELY]
    return min(closest, key=lambda tempo: price(tempo, False))


def _limits(tolerance: Tolerance, robot: TrackedRobot) -> Mapping[int, Tolerance]:
    """Return how far poses and their means may be off: poses as far as the path or as noise moves them, and means less
    than the path, since noise hides some of it."""
    if not robot.noisy:
        return {robot.window: tolerance}
    alone = [max(most - each, _REACHED * each) for most, each in zip(tolerance[:2], robot.noise, strict=True)]
    hidden = [_HIDDEN * each / math.sqrt(robot.window) for each in robot.noise]
    mean = [most - min(less, most / 3) for most, less in zip(tolerance[:2], hidden, strict=True)]
    return {
        1: tolerance._replace(meters=alone[0], radians=alone[1]),
        robot.window: tolerance._replace(meters=mean[0], radians=mean[1]),
    }


def _from(track: Track, begin: float) -> Track:
    """Return a track that begins with all others: its robot stands until its first sample."""
    first = track[0]
    return track if first.time == begin else [first._replace(time=begin), *track]


def _changes(stretches: Sequence[EvenStretch]) -> list[float]:
    return [
        before.end
        for before, after in pairwise(stretches)
        if not before.amounts.is_like(after.amounts) or min(before.seconds, after.seconds) > _CHANGE
    ]


def _draft(
    tracked: Mapping[str, TrackedRobot],
    items: Mapping[str, Sequence[TimedItem]],
    tempo: int,
    robots: Robots,
    tolerance: Tolerance,
    closeness: int,
    stops: Callable[[], bool],
) -> _Draft:
    """Return the draft for items at a tempo: its numbers are as coarse as the tolerance allows.

    All robots have equally coarse numbers, so that they share words, except those that are too far off even with the
    finest ones.
    """
    begun = {robot: each.track[0].pose for robot, each in tracked.items()}
    fitted = [] if closeness == _NEAREST else fits_of(items, begun, tracked, tempo)
    profile = robots.profile_of(next(iter(tracked)))

    def made(step: int) -> _Draft:
        rounding = Rounding(tolerance.meters, tolerance.radians).times(0.5**step)
        played, placed = dict(items), dict(begun)
        for fit in fitted:
            rounded, starts = fit.rounded(_STRICTNESS * 4.0**step, profile)
            played.update(rounded)
            placed.update(starts)
        parts = {}
        for robot, each in tracked.items():
            window = 1 if closeness == _NEAREST else each.window
            guide = Guide(each.track, tempo, window, rounding.times(_CLOSER)) if closeness else None
            words = list(written(placed[robot], played[robot], robots.profile_of(robot), guide))
            limits = _limits(tolerance, each)
            off = deviations_of(each.track, placed[robot], [item for _, item in words], tempo, limits)
            excess = max(
                max(far / most.meters, turned / most.radians, 1.0) - 1
                for (far, turned), most in zip(off, limits.values(), strict=True)
            )
            parts[robot] = _Part(placed[robot], [node for node, _ in words], rounding, off[-1], excess)
        return parts

    draft = made(0)
    if any(part.excess for part in draft.values()) and not stops():
        finest = made(_FINEST)
        hopeful = [robot for robot, part in finest.items() if not part.excess]
        step = 1
        while step < _FINEST and any(draft[robot].excess for robot in hopeful) and not stops():
            draft = made(step)
            step += 1
        draft = _nearer(draft, finest)
    return draft


def _program(draft: _Draft, tempo: int, robots: Robots, is_whole: bool) -> str:
    """Return the text of a program."""
    lines = [line for line in lines_of({robot: part.nodes for robot, part in draft.items()}) if line.theme]
    bodies = [[folded(bracketed(part)) for part in line.parts] for line in lines]
    names, named = with_names([body for each in bodies for body in each], list(draft))
    text = [f"beat {tempo}"] if tempo != USUAL else []
    order = list(dict.fromkeys(robot for line in lines for robot in line.robots))
    starts = {robot: part.start for robot, part in draft.items()}
    if not is_whole or not _start_there(starts, order, robots):
        text += _opening(starts, min(part.rounding for part in draft.values()))
    text += [""] if text else []
    text += [*(f"{name} = {series_text(with_whole_turns(body))}" for name, body in names.items()), ""] if names else []
    used = iter(map(with_whole_turns, named))
    for line, each in zip(lines, bodies, strict=True):
        text.append(f"{' '.join(line.robots)} $ {_line_text(line, [next(used) for _ in each])}")
    return "\n".join(text) + "\n"


def _line_text(line: SharedLine, bodies: Sequence[Node]) -> str:
    theme, *coda = bodies
    if not line.apart:
        return series_text(theme)
    words = [series_text(folded([REST] * line.rests))] if line.rests else []
    return " ".join([*words, f"canon {line.apart} {term_text(theme)}", *map(series_text, coda)])


def _start_there(starts: Mapping[str, Pose], order: Sequence[str], robots: Robots) -> bool:
    """Return whether robots start where Improv places them in this order."""
    usual = start_poses({robot: robots.robot(robot) for robot in order}, robots.world.size, robots.formation)
    return usual.keys() == starts.keys() and all(max(usual[each].apart(starts[each])) < 1e-6 for each in order)


def _opening(starts: Mapping[str, Pose], rounding: Rounding) -> list[str]:
    """Return the lines that place robots at their starts."""
    if found := formation_of(starts, rounding):
        names, words = found
        return [f"{' '.join(names)} at {words}"]
    return [f"{robot} at {_pose_text(pose)}" for robot, pose in starts.items()]


def _pose_text(pose: Pose) -> str:
    facing = math.degrees(math.remainder(pose.heading, math.tau))
    return f"{pose.x:.6g} {pose.y:.6g}" + (f" facing {facing:.6g}" if abs(facing) > 1e-6 else "")
