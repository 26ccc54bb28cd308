"""Compiles an analysis to a score, and to the segments that `improv compile` prints."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from fractions import Fraction
from itertools import islice
from typing import Any

from improv_core.program.analysis import Analysis
from improv_core.robots.config import Robots
from improv_core.robots.limits import excess
from improv_core.robots.start_poses import start_poses
from improv_core.score.motion import Pose, wrapped
from improv_core.score.movement import ENDLESS, Duration, Exact, Movement, Velocity, brief
from improv_core.score.performance import SenseSpan, perform
from improv_core.score.profiles import Profile
from improv_core.score.reactions import senses_read
from improv_core.score.scenes import NOTHING
from improv_core.score.score import Part, Score, twist
from improv_core.score.senses import Senses
from improv_core.score.smoothing import smoothed
from improv_core.score.walk import Moment, walk
from improv_core.slices import checkpoint

MOST_SEGMENTS = 10_000
LONGEST_TEXT = 200_000
"""The most characters of a program that is sent with its score, so that it can be shown while it plays."""
_MOMENTS_PER_SEGMENT = 2
"""Adjacent moments that merge are walked one by one. Even a part that never ends and never changes must stop here."""


def score_of(analysis: Analysis) -> Score:
    """The score of a program."""
    cast, poses = analysis.opening.cast, starts_of(analysis)
    parts, smooth = {}, _Smooth(analysis.tempo)
    nothing = (NOTHING,) * analysis.scene_count
    for name in analysis.all_robots:
        checkpoint()
        robot = cast.robot(name)
        profile = replace(robot.profile, message=robot.message)
        scenes = analysis.parts.get(name, nothing)
        parts[name] = Part(
            name,
            tuple(smooth(scene, robot.profile) for scene in scenes) if profile.smooth else scenes,
            profile,
            poses[name],
            robot.topic,
            robot.reset,
            cast.use_sim_time,
            robot.odom,
            _senses(cast, name, scenes),
            frame=robot.frame,
            follow=robot.follow,
            odom_frame=robot.odom_frame,
            battery=robot.battery,
        )
    score = Score(
        analysis.tempo,
        parts,
        world=cast.world,
        safety=cast.safety,
        publish=cast.publish,
        bar=analysis.opening.bar,
        scene_names=tuple(analysis.scene_names),
    )
    if len(analysis.text) > LONGEST_TEXT:
        return score
    offsets = dict(zip(analysis.statement_ids, analysis.offsets, strict=True))
    return replace(score, text=analysis.text, offsets=offsets)


def starts_of(analysis: Analysis) -> Mapping[str, Pose]:
    """Where all robots of a program begin, also those that a selection leaves out."""
    cast = analysis.opening.cast
    named = (name for line in analysis.played.values() for name, _ in line.parts)
    robots = {name: cast.robot(name) for name in dict.fromkeys([*named, *analysis.parts])}
    return {**start_poses(robots, cast.world.size, cast.formation), **analysis.opening.places}


@dataclass(frozen=True, slots=True)
class _Smooth:
    """Smooths scenes within the limits of profiles. Robots of one line share theirs."""

    tempo: Fraction
    made: dict[tuple[int, Profile], Movement] = field(default_factory=dict)

    def __call__(self, scene: Movement, profile: Profile) -> Movement:
        key = id(scene), profile
        if key not in self.made:
            self.made[key] = smoothed(scene, lambda velocity: excess(velocity, profile, self.tempo) is None)
        return self.made[key]


def _senses(cast: Robots, robot: str, scenes: Sequence[Movement]) -> Senses:
    """The senses that a robot's part reads. An unknown one is an error in the program."""
    names = frozenset[str]().union(*map(senses_read, scenes))
    return {name: cast.sense(robot, name) for name in cast.sense_names if name in names}


def compiled(
    analysis: Analysis, most_segments: int = MOST_SEGMENTS, script: Sequence[SenseSpan] = ()
) -> Mapping[str, Any]:
    """The program as JSON values: the tempo, the bar and the floor if it says them, and each robot's start (meters and
    degrees), length, and segments in seconds, m/s, and rad/s.

    If senses decide something, it is performed with the senses that hold according to the script, and with no others.
    """
    score = score_of(analysis)
    tempo, parts = score.tempo, score.parts.values()
    robots = (
        _performed(score, most_segments, script)
        if any(part.movement.open for part in parts)
        else {part.robot: _walked(part, most_segments) for part in parts}
    )
    opening = {"bar": analysis.opening.bar, "room": analysis.opening.room}
    return {
        "ok": analysis.ok,
        "beat": int(tempo) if tempo.denominator == 1 else float(tempo),
        **{name: value for name, value in opening.items() if value},
        "robots": {name: _robot(score, part, robots[name]) for name, part in score.parts.items()},
    }


@dataclass(slots=True)
class _Segments:
    """Stretches of constant velocity of one robot: their starts and durations in beats. `beats` is the whole length."""

    most: int
    beats: Duration
    stretches: list[tuple[Exact, Exact, Velocity]] = field(default_factory=list)
    moments: int = 0
    truncated: bool = False

    def add(self, moment: Moment) -> None:
        last = self.stretches[-1] if self.stretches else None
        if self.truncated:
            return
        if last and last[2] == moment.velocity:
            self.stretches[-1] = last[0], last[1] + moment.duration, last[2]
        elif len(self.stretches) == self.most:
            self.truncated = True
            return
        else:
            self.stretches.append((moment.start, moment.duration, moment.velocity))
        self.moments += 1
        self.truncated = self.moments > self.most * _MOMENTS_PER_SEGMENT


def _walked(part: Part, most: int) -> _Segments:
    segments = _Segments(most, part.movement.duration)
    for moment in walk(part.movement, merge=True):
        segments.add(moment)
        if segments.truncated:
            break
    return segments


def _performed(score: Score, most: int, script: Sequence[SenseSpan]) -> Mapping[str, _Segments]:
    """What all robots do. One that still moves when there are too many moments has no known length."""
    found = {robot: _Segments(most, 0) for robot in score.parts}
    every = [part.scenes for part in score.parts.values()]
    scenes = [dict(zip(score.parts, scene, strict=True)) for scene in zip(*every, strict=True)]
    moments = perform(scenes, script)
    for robot, moment in islice(moments, most * _MOMENTS_PER_SEGMENT * len(found)):
        found[robot].beats = moment.start + moment.duration
        found[robot].add(moment)
    if next(moments, None):
        latest = max(segments.beats for segments in found.values())
        for segments in found.values():
            if segments.beats == latest:
                segments.beats, segments.truncated = ENDLESS, True
    return found


def _robot(score: Score, part: Part, segments: _Segments) -> Mapping[str, Any]:
    beats = segments.beats
    return {
        "beats": None if isinstance(beats, float) else str(brief(beats)),
        "seconds": None if isinstance(beats, float) else score.seconds(beats),
        "endless": beats == ENDLESS == part.movement.duration,
        "open": part.movement.open,
        "start": [part.start.x, part.start.y, _degrees(part.start.heading)],
        "segments": [
            [score.seconds(start), score.seconds(duration), *_numbers(score, part, velocity)]
            for start, duration, velocity in segments.stretches
        ],
        "truncated": segments.truncated,
    }


def _degrees(heading: float) -> float:
    return wrapped(round(math.degrees(heading), 9))


def _numbers(score: Score, part: Part, velocity: Velocity) -> list[float]:
    moving = twist(velocity, part.profile, score.tempo)
    return [moving.x, moving.y, moving.z, moving.yaw]
