"""Compile an analysis to a score, and to the segments that `improv compile` prints."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from fractions import Fraction
from itertools import islice
from typing import Any

from improv_core.program.analysis import Analysis
from improv_core.program.timing import brief
from improv_core.robots.config import Robots
from improv_core.robots.limits import exactly, excess
from improv_core.robots.start_poses import start_poses
from improv_core.score.joints import Limb, limbs_of
from improv_core.score.measured import Measure
from improv_core.score.motion import Pose, wrapped
from improv_core.score.movement import ENDLESS, Duration, Exact, Movement, Velocity
from improv_core.score.performance import Mover, SenseSpan, perform
from improv_core.score.profiles import Profile
from improv_core.score.reactions import senses_read
from improv_core.score.score import NOTHING, Part, Score, twist
from improv_core.score.senses import Senses
from improv_core.score.smoothing import smoothed
from improv_core.score.walk import Moment, walk
from improv_core.slices import checkpoint

MAX_SEGMENTS = 10_000
LONGEST_TEXT = 200_000
"""The most characters of a program that is sent with its score, to show it while it plays."""
_MOMENTS_PER_SEGMENT = 2
"""Adjacent moments that merge are walked one by one. Even a part that never ends and never changes must stop here."""


def score_of(analysis: Analysis) -> Score:
    """Return the score of a program."""
    config, poses = analysis.opening.config, starts_of(analysis)
    parts, smooth = {}, _Smooth(analysis.tempo)
    nothing = (NOTHING,) * analysis.scene_count
    for name in analysis.all_robots:
        checkpoint()
        robot = config.robot(name)
        profile = replace(robot.profile, message=robot.message)
        scenes = analysis.parts.get(name, nothing)
        parts[name] = Part(
            name,
            tuple(smooth(scene, robot.profile) for scene in scenes) if profile.smooth else scenes,
            profile,
            poses[name],
            robot.topic,
            robot.reset,
            config.use_sim_time or (config.clock is not None and config.clock.follow == "ros"),
            robot.odom,
            _senses(config, name, scenes),
            frame=robot.frame,
            follow=robot.follow,
            odom_frame=robot.odom_frame,
            battery=robot.battery,
            namespace=config.namespace_of(name),
            host=robot.host,
            device=robot.device,
        )
    score = Score(
        analysis.tempo,
        parts,
        world=config.world,
        safety=config.safety,
        publish=config.publish,
        osc=config.osc,
        bar=analysis.opening.bar,
        scene_names=tuple(analysis.scene_names),
        clock=config.clock,
        music=config.music,
        count_in=config.music is not None and config.music.count_in,
    )
    if len(analysis.text) > LONGEST_TEXT:
        return score
    offsets = dict(zip(analysis.statement_ids, analysis.offsets, strict=True))
    return replace(score, text=analysis.text, offsets=offsets)


def starts_of(analysis: Analysis) -> Mapping[str, Pose]:
    """Return the start poses of all robots of a program, also of those that a selection leaves out."""
    config = analysis.opening.config
    named = (name for line in analysis.played.values() for name, _ in line.parts)
    robots = {name: config.robot(name) for name in dict.fromkeys([*named, *analysis.parts])}
    return {**start_poses(robots, config.world.size, config.formation), **analysis.opening.places}


@dataclass(frozen=True, slots=True)
class _Smooth:
    """Smooths scenes within the limits of profiles. Robots of one line share the result."""

    tempo: Fraction
    made: dict[tuple[int, Profile], Movement] = field(default_factory=dict)

    def __call__(self, scene: Movement, profile: Profile) -> Movement:
        key = id(scene), profile
        if key not in self.made:
            self.made[key] = smoothed(scene, lambda velocity: excess(velocity, profile, self.tempo) is None)
        return self.made[key]


def _senses(config: Robots, robot: str, scenes: Sequence[Movement]) -> Senses:
    """Return the senses that a robot's part reads. An unknown one is an error in the program."""
    names = frozenset[str]().union(*(senses_read(scene) for scene in scenes if scene.open))
    return {name: config.sense(robot, name) for name in config.sense_names if name in names}


def compiled(
    analysis: Analysis, most_segments: int = MAX_SEGMENTS, script: Sequence[SenseSpan] = ()
) -> Mapping[str, Any]:
    """Return the program as JSON values: the tempo, the bar and the floor if the program sets them, and each robot's
    start (meters and degrees), length, and segments in seconds, m/s, and rad/s.

    If senses decide something, only the senses in the script are true.
    """
    score = score_of(analysis)
    tempo, parts = score.tempo, score.parts.values()
    limbs = {Mover(each.robot, limb.part.name): limb for each in parts for limb in limbs_of(each, tempo)}
    movers = {
        Mover(each.robot): _Segments(most_segments, each.movement.duration, profile=each.profile) for each in parts
    }
    segments = {**movers, **{mover: _Segments(most_segments, ENDLESS, limb) for mover, limb in limbs.items()}}
    if any(part.movement.open for part in parts):
        _perform(score, most_segments, script, segments)
    else:
        for (robot, _), each in segments.items():
            _walk(score.parts[robot], each)
    opening = {"bar": analysis.opening.bar, "room": analysis.opening.room}
    return {
        "ok": analysis.ok,
        "beat": int(tempo) if tempo.denominator == 1 else float(tempo),
        **{name: value for name, value in opening.items() if value},
        "robots": {
            name: {
                **_robot(score, part, segments[Mover(name)]),
                **_joints(score, part, [segments[mover] for mover in limbs if mover.robot == name]),
            }
            for name, part in score.parts.items()
        },
    }


@dataclass(slots=True)
class _Segments:
    """Stretches of constant velocity of one robot, or of one of its limbs: their starts and durations in beats, and the
    velocities of the limb's joints. `profile` is that of a base. `beats` is the whole length, and `range` the least and
    greatest positions of the joints."""

    most: int
    beats: Duration
    limb: Limb | None = None
    profile: Profile | None = None
    stretches: list[tuple[Exact, Exact, Velocity]] = field(default_factory=list)
    moments: int = 0
    truncated: bool = False
    range: dict[str, tuple[float, float]] = field(default_factory=dict)

    def __post_init__(self) -> None:
        self._widen()

    def add(self, moment: Moment) -> None:
        last = self.stretches[-1] if self.stretches else None
        if self.truncated:
            return
        if last and self._is_same(last[2], moment.velocity):
            self.stretches[-1] = last[0], last[1] + moment.duration, last[2]
        elif len(self.stretches) == self.most:
            self.truncated = True
            return
        else:
            self.stretches.append((moment.start, moment.duration, moment.velocity))
        self.moments += 1
        self.truncated = self.moments > self.most * _MOMENTS_PER_SEGMENT
        if self.limb:
            self.limb.move(self.limb.velocities(moment.velocity), moment.duration)
            self._widen()

    def _is_same(self, one: Velocity, other: Velocity) -> bool:
        if one == other or not self.profile:
            return one == other
        is_measured = any(isinstance(each, Measure) for each in (*one, *other))
        return is_measured and exactly(one, self.profile) == exactly(other, self.profile)

    def _widen(self) -> None:
        for name, position in self.limb.positions.items() if self.limb else ():
            least, greatest = self.range.get(name, (position, position))
            self.range[name] = min(least, position), max(greatest, position)


def _walk(part: Part, segments: _Segments) -> None:
    movement = segments.limb.performs(part.movement) if segments.limb else part.movement
    for moment in walk(movement, merge=True):
        segments.add(moment)
        if segments.truncated:
            break


def _perform(score: Score, most: int, script: Sequence[SenseSpan], found: Mapping[Mover, _Segments]) -> None:
    """Perform all robots. A robot that still moves after too many moments has no known length."""
    scenes = [
        {
            mover: each.limb.performs(score.parts[mover.robot].of_scene(scene))
            if each.limb
            else score.parts[mover.robot].of_scene(scene)
            for mover, each in found.items()
        }
        for scene in range(score.scenes)
    ]
    for segments in found.values():
        segments.beats = 0
    moments = perform(scenes, script)
    for _, mover, moment in islice(moments, most * _MOMENTS_PER_SEGMENT * len(found)):
        found[mover].beats = moment.start + moment.duration
        found[mover].add(moment)
    if next(moments, None):
        latest = max(segments.beats for segments in found.values())
        for segments in found.values():
            if segments.beats == latest:
                segments.beats, segments.truncated = ENDLESS, True


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


def _joints(score: Score, part: Part, limbs: Sequence[_Segments]) -> Mapping[str, Any]:
    """Return the commanded velocities of a robot's joints that move, and the ranges of their positions."""
    if not part.profile.body:
        return {}
    joints: dict[str, list[list[float]]] = {}
    for each in limbs:
        for drive in each.limb.part.drives if each.limb else ():
            stretches: list[list[float]] = []
            for start, duration, velocity in each.stretches:
                assert each.limb
                speed = each.limb.velocities(velocity)[drive.joint]
                if stretches and stretches[-1][2] == speed:
                    stretches[-1][1] = score.seconds(start + duration) - stretches[-1][0]
                else:
                    stretches.append([score.seconds(start), score.seconds(duration), speed])
            if any(speed for _, _, speed in stretches):
                joints[drive.joint] = stretches
    ranges = {name: list(ends) for each in limbs for name, ends in each.range.items()}
    return {"joints": joints, "range": ranges}


def _degrees(heading: float) -> float:
    return wrapped(round(math.degrees(heading), 9))


def _numbers(score: Score, part: Part, velocity: Velocity) -> list[float]:
    moving = twist(velocity, part.profile, score.tempo)
    return [moving.x, moving.y, moving.z, moving.yaw]
