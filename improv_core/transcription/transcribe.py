"""Timed poses of robots → a short program whose paths stay near them. Standard library only."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from itertools import dropwhile, pairwise
from typing import NamedTuple

from improv_core.score.motion import Pose
from improv_core.score.profiles import DEFAULT, Profile
from improv_core.transcription.ensemble import SharedLine, formation_of, is_rest, lines_of
from improv_core.transcription.folding import bracketed, folded, with_names
from improv_core.transcription.grouping import grouped
from improv_core.transcription.performing import deviation_of, refined
from improv_core.transcription.rhythm import Gentle, Item, RateCurve, items_of
from improv_core.transcription.stretches import EvenStretch, stretches_of
from improv_core.transcription.tempo import USUAL, tempi
from improv_core.transcription.track import CLEAN, Noise, TimedPlace, Track, noise_of, track_of
from improv_core.transcription.wording import (
    ANGLES,
    LENGTHS,
    Node,
    Rounding,
    Shaped,
    cost,
    cost_of_text,
    moves_for,
    number_text,
    series_text,
    term_text,
)

NOISY = 100 * CLEAN
"""A track with more noise than this, in meters or radians, has its changes on a coarse grid."""
_CHANGE = 0.15
"""Seconds: only changes between longer stretches tell the tempo."""
_SHARE = 40
"""A fit may be off by a tenth of the tolerance: by four standard deviations, which are this part of it."""
_HALVINGS = 12


class Tolerance(NamedTuple):
    """The distance that a program may be from what it transcribes: meters, radians, and seconds."""

    meters: float = 0.03
    radians: float = math.radians(5)
    seconds: float = 0.05


@dataclass(frozen=True, slots=True)
class Transcription:
    """A program, and how far each robot's path is from it at most, in meters and radians."""

    text: str
    deviations: Mapping[str, tuple[float, float]]


def transcribe(
    recorded: Mapping[str, Sequence[TimedPlace]],
    profiles: Mapping[str, Profile] = {},
    tolerance: Tolerance = Tolerance(),  # noqa: B008
    tempo: int | None = None,
    stops: Callable[[], bool] = lambda: False,
) -> Transcription:
    """Return the shortest program found whose paths stay within a tolerance of the recorded places.

    Each robot has at least two places, in the order of their times (s). `stops` ends the search: what was found so far
    counts.
    """
    tracks = {robot: track_of(places) for robot, places in recorded.items()}
    noises = {robot: noise_of(track) for robot, track in tracks.items()}
    noisy = {robot: max(noises[robot]) > NOISY for robot in tracks}
    noises = {robot: _at_least(noise, tolerance) for robot, noise in noises.items()}
    stretches = {robot: stretches_of(track, noises[robot]) for robot, track in tracks.items()}
    begin = min(track[0].time for track in tracks.values())
    tracks = {robot: _from(track, begin) for robot, track in tracks.items()}
    allowed = {robot: _allowed(tracks[robot], noisy[robot], tolerance) for robot in tracks}
    changes = [time - begin for each in stretches.values() for time in _changes(each)]

    def items(robot: str, tempo: int, gently: bool = True) -> Sequence[Item]:
        return items_of(tracks[robot], stretches[robot], noises[robot], tempo, allowed[robot], noisy[robot], gently)

    def price(tempo: int) -> float:
        """Return what the part of the busiest robot costs at a tempo."""
        written = _written(items(busiest, tempo), profiles.get(busiest, DEFAULT), Rounding(*tolerance[:2]))
        written = list(dropwhile(is_rest, written))
        return cost(folded(bracketed(written))) + (0.0 if tempo == USUAL else cost_of_text(f"beat {tempo}"))

    busiest = max(stretches, key=lambda robot: len(stretches[robot]))
    likely = [tempo] if tempo else tempi(changes, max(allowed.values(), default=tolerance.seconds))
    best, least = likely[0], math.inf
    for each in likely if len(likely) > 1 else ():
        if (needed := price(each)) < least:
            best, least = each, needed
        if stops():
            break

    def draft_of(parts: Mapping[str, Sequence[Item]]) -> _Draft:
        return _draft(tracks, noises, parts, best, profiles, tolerance, any(noisy.values()))

    draft = draft_of({robot: items(robot, best) for robot in tracks})
    if _misses(draft, tolerance):
        plain = draft_of({robot: items(robot, best, gently=False) for robot in tracks})
        draft = min(draft, plain, key=lambda each: _misses(each, tolerance))
    return Transcription(_program(draft), draft.deviations)


@dataclass(frozen=True, slots=True)
class _Draft:
    """The content of a program: its tempo, the robots' starts and parts, and how far they are from the tracks."""

    tempo: int
    starts: Mapping[str, Pose]
    parts: Mapping[str, Sequence[Node]]
    rounding: Rounding
    deviations: Mapping[str, tuple[float, float]]


def _at_least(noise: Noise, tolerance: Tolerance) -> Noise:
    """Return the noise that fits are to allow: also of exact tracks, a part of the tolerance is left to them."""
    return Noise(max(noise.meters, tolerance.meters / _SHARE), max(noise.radians, tolerance.radians / _SHARE))


def _misses(found: _Draft, tolerance: Tolerance) -> float:
    """Return what being outside of the tolerance costs: more than any words."""
    worst = max(
        (max(far / tolerance.meters, turn / tolerance.radians) for far, turn in found.deviations.values()), default=0.0
    )
    return 1000.0 * worst if worst > 1 else 0.0


def _from(track: Track, begin: float) -> Track:
    """Return a track that begins with all others: its robot stands until its first sample."""
    first = track[0]
    return track if first.time == begin else [first._replace(time=begin), *track]


def _allowed(track: Track, noisy: bool, tolerance: Tolerance) -> float:
    """Return how many seconds a change may be off."""
    steps = sorted(after.time - here.time for here, after in pairwise(track))
    return min(max(1.6 * steps[len(steps) // 2], tolerance.seconds), 0.25) if noisy else tolerance.meters / 3


def _changes(stretches: Sequence[EvenStretch]) -> list[float]:
    return [
        before.end
        for before, after in pairwise(stretches)
        if before.run != after.run or min(before.seconds, after.seconds) > _CHANGE
    ]


def _draft(
    tracks: Mapping[str, Track],
    noises: Mapping[str, Noise],
    items: Mapping[str, Sequence[Item]],
    tempo: int,
    profiles: Mapping[str, Profile],
    tolerance: Tolerance,
    noisy: bool,
) -> _Draft:
    """Return the draft for items at a tempo: its numbers are as coarse as the tolerance allows."""
    groups = grouped(items, tolerance, noises)
    starts: Mapping[str, Pose] = {robot: track[0].pose for robot, track in tracks.items()}
    if noisy:
        groups, starts = refined(groups, starts, tracks, tempo)
    rounding = Rounding(tolerance.meters, tolerance.radians)
    best: _Draft | None = None
    for _ in range(_HALVINGS):
        written = {robot: _written(groups.items(robot), profiles.get(robot, DEFAULT), rounding) for robot in tracks}
        placed = {robot: _start(pose, rounding) for robot, pose in starts.items()}
        deviations = {
            robot: deviation_of(
                track, placed[robot], written[robot], tempo, profiles.get(robot, DEFAULT), noises[robot], tolerance
            )
            for robot, track in tracks.items()
        }
        found = _Draft(tempo, placed, written, rounding, deviations)
        if best is None or _misses(found, tolerance) < _misses(best, tolerance):
            best = found
        if not _misses(found, tolerance):
            break
        rounding = rounding.times(0.5)
    assert best
    return best


def _written(items: Sequence[Item], profile: Profile, rounding: Rounding) -> list[Node]:
    """Return the nodes that make these items, before anything is folded."""
    found: list[Node] = []
    for item in items:
        if isinstance(item, Gentle):
            body = [
                move for motion in item.motions for move in moves_for(motion.beats, motion.amounts, profile, rounding)
            ]
            found.append(_gentle(item.curve, folded(bracketed(body))))
        else:
            found.extend(moves_for(item.beats, item.amounts, profile, rounding))
    return found


def _gentle(curve: RateCurve, body: Node) -> Node:
    return Shaped("ease", (), body) if curve.start is None else Shaped("ramp", (curve.start, curve.end), body)


def _start(pose: Pose, rounding: Rounding) -> Pose:
    """Return a start pose in numbers that people write."""
    x, y, z = _rounded((pose.x, pose.y, pose.z), LENGTHS, rounding.meters)
    (degrees,) = _rounded([math.degrees(pose.heading)], ANGLES, math.degrees(rounding.radians))
    return Pose(x, y, z, math.radians(degrees))


def _rounded(values: Sequence[float], levels: Sequence[Fraction], allowed: float) -> list[float]:
    """Round to the coarsest level that is near enough for all values together."""
    for level in map(float, levels):
        found = [round(round(value / level) * level, 6) + 0.0 for value in values]
        if math.dist(found, values) <= allowed:
            break
    return found


def _program(draft: _Draft) -> str:
    """Return the text of a program."""
    lines = [line for line in lines_of(draft.parts) if line.items]
    bodies = [[folded(bracketed(part)) for part in line.parts] for line in lines]
    names, named = with_names([body for each in bodies for body in each], list(draft.parts))
    text = [f"beat {draft.tempo}"] if draft.tempo != USUAL else []
    text += _opening(draft.starts, draft.rounding)
    text += [""] if text else []
    text += [*(f"{name} = {series_text(body)}" for name, body in names.items()), ""] if names else []
    used = iter(named)
    for line, each in zip(lines, bodies, strict=True):
        text.append(f"{' '.join(line.robots)} $ {_line_text(line, [next(used) for _ in each])}")
    return "\n".join(text) + "\n"


def _line_text(line: SharedLine, bodies: Sequence[Node]) -> str:
    if not line.apart:
        return series_text(bodies[0])
    theme, *after = bodies
    words = [series_text(folded(line.items[: line.rests]))] if line.rests else []
    words += [f"canon {number_text(line.apart)} {term_text(theme)}", *map(series_text, after)]
    return " ".join(words)


def _opening(starts: Mapping[str, Pose], rounding: Rounding) -> list[str]:
    """Return the lines that say where robots start; none for a single robot at the origin."""
    if len(starts) == 1 and next(iter(starts.values())) == Pose():
        return []
    if found := formation_of(starts, rounding):
        robots, words = found
        return [f"{' '.join(robots)} at {words}"]
    return [f"{robot} at {_pose_text(pose)}" for robot, pose in starts.items()]


def _pose_text(pose: Pose) -> str:
    facing = math.degrees(math.remainder(pose.heading, math.tau))
    return f"{pose.x:.6g} {pose.y:.6g}" + (f" facing {facing:.6g}" if abs(facing) > 1e-6 else "")
