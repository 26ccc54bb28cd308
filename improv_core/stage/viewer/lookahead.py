"""What comes next, for the page: a score, and a stretch of it, as plain values. Standard library only."""

from __future__ import annotations

from dataclasses import astuple
from itertools import islice, takewhile
from typing import Any

from improv_core.score import senses
from improv_core.score import world as worlds
from improv_core.score.movement import ENDLESS, near
from improv_core.score.primitives import PRIMITIVES
from improv_core.score.replay import Replay
from improv_core.score.score import Score, twist
from improv_core.stage.viewer.messages import RobotWindow, ShownScore

MOST_MOMENTS = 20_000
"""Moments of all robots together in one window."""


def about(score: Score, generation: int, *, takes_start_poses: bool) -> ShownScore:
    """The `score` message: text and length, the words that move robots, and the robots (meters, radians)."""
    beats = score.beats
    return {
        "type": "score",
        "generation": generation,
        "tempo": float(score.tempo),
        "scene": score.scene,
        "scenes": list(map(float, score.scene_begins)),
        "scene_names": list(score.scene_names),
        "bar": score.bar,
        "beats": None if beats == ENDLESS else float(beats),
        "world": worlds.to_json(score.world),
        "text": score.text,
        "offsets": {str(number): offset for number, offset in score.offsets.items()},
        "words": {word: list(map(float, velocity)) for word, velocity in PRIMITIVES.items()},
        "takes_start_poses": takes_start_poses,
        "deadman": {"button": deadman.button} if (deadman := score.safety.deadman) else None,
        "robots": {
            name: {
                "profile": part.profile.name,
                "dynamics": part.profile.dynamics,
                "radius": part.profile.radius,
                "motions": list(part.profile.motions),
                "start_pose": list(astuple(part.start)),
                "begins": float(part.begins),
                "ends": None if part.ends == ENDLESS else float(part.ends),
                "senses": senses.to_json(part.senses),
                "near": part.profile.reach,
            }
            for name, part in score.parts.items()
        },
    }


def window(replay: Replay, start: float, end: float) -> dict[str, RobotWindow]:
    """What each robot does from beat `start` to beat `end`, up to `MOST_MOMENTS`.

    `pose` is the robot's ideal pose at `start` (x, y, z, heading), or None if that can't be known. `moments` are lists
    of start and duration in beats, velocity at the score's own tempo (m/s, rad/s), and the words that play: statement,
    and span in it. `until` is the beat they reach.
    """
    score, begin = replay.score, near(max(start, 0.0))
    most = MOST_MOMENTS // max(len(score.parts), 1)
    found: dict[str, RobotWindow] = {}
    for name, part in score.parts.items():
        moments: list[list[Any]] = []
        until = float(begin)
        for moment in takewhile(lambda each: each.start < end, islice(replay.moments(name, begin), most)):
            moving = twist(moment.velocity, part.profile, score.tempo)
            words = [[source.statement, *source.span] for source in moment.sources]
            moments.append([float(moment.start), float(moment.duration), *astuple(moving), words])
            until = float(moment.start + moment.duration)
        pose = replay.pose(name, begin)
        found[name] = {"pose": list(astuple(pose)) if pose else None, "moments": moments, "until": until}
    return found
