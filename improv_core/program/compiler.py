"""Compiles an analysis to a score, and to the segments that `improv compile` prints."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from itertools import islice
from typing import Any

from improv_core.program.analysis import Analysis
from improv_core.robots.start_poses import start_poses
from improv_core.score.movement import ENDLESS, brief
from improv_core.score.score import Part, Score, twist
from improv_core.score.walk import walk

MOST_SEGMENTS = 10_000
LONGEST_TEXT = 200_000
"""The most characters of a program that is sent with its score, so that it can be shown while it plays."""
_MOMENTS_PER_SEGMENT = 2
"""Adjacent moments that merge are walked one by one. Even a part that never ends and never changes must stop here."""


def score_of(analysis: Analysis) -> Score:
    """The score of a program."""
    cast = analysis.cast
    robots = {name: cast.robot(name) for name in analysis.robots}
    poses = start_poses(robots, cast.world.size)
    parts = {}
    for name, robot in robots.items():
        profile = replace(robot.profile, message=robot.message)
        parts[name] = Part(
            name, (analysis.robots[name],), profile, poses[name], robot.topic, robot.reset, cast.use_sim_time
        )
    if len(analysis.text) > LONGEST_TEXT:
        return Score(analysis.tempo, parts, world=cast.world, safety=cast.safety)
    offsets = dict(zip(analysis.statement_ids, analysis.offsets, strict=True))
    return Score(analysis.tempo, parts, analysis.text, offsets, cast.world, cast.safety)


def compiled(analysis: Analysis, most_segments: int = MOST_SEGMENTS) -> Mapping[str, Any]:
    """The program as JSON values: the tempo, and each robot's length and segments in seconds, m/s, and rad/s."""
    score = score_of(analysis)
    tempo = score.tempo
    return {
        "ok": analysis.ok,
        "beat": int(tempo) if tempo.denominator == 1 else float(tempo),
        "robots": {name: _robot(score, part, most_segments) for name, part in score.parts.items()},
    }


def _robot(score: Score, part: Part, most: int) -> Mapping[str, Any]:
    beats = part.movement.duration
    endless = beats == ENDLESS
    segments: list[tuple[Any, Any, Any]] = []  # start and duration in beats, velocity
    truncated = False
    for walked, moment in enumerate(walk(part.movement, merge=True)):
        if segments and segments[-1][2] == moment.velocity:
            start, duration, velocity = segments.pop()
            segments.append((start, duration + moment.duration, velocity))
        elif len(segments) == most:
            truncated = True
            break
        else:
            segments.append((moment.start, moment.duration, moment.velocity))
        if walked >= most * _MOMENTS_PER_SEGMENT:
            truncated = True
            break
    return {
        "beats": None if isinstance(beats, float) else str(brief(beats)),
        "seconds": None if endless else score.seconds(beats),
        "endless": endless,
        "segments": [
            [score.seconds(start), score.seconds(duration), *_numbers(score, part, velocity)]
            for start, duration, velocity in islice(segments, most)
        ],
        "truncated": truncated,
    }


def _numbers(score: Score, part: Part, velocity: Any) -> list[float]:
    moving = twist(velocity, part.profile, score.tempo)
    return [moving.x, moving.y, moving.z, moving.yaw]
