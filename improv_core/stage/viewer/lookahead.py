"""What comes next, for the page: a score, and a stretch of it, as plain values. Standard library only."""

from __future__ import annotations

from collections import defaultdict, deque
from collections.abc import Sequence
from dataclasses import astuple
from typing import Any

from improv_core.score import senses
from improv_core.score import world as worlds
from improv_core.score.movement import ENDLESS, Exact, near
from improv_core.score.path import pose_at
from improv_core.score.performer import Performer
from improv_core.score.primitives import PRIMITIVES
from improv_core.score.score import Part, Score, twist
from improv_core.score.walk import walk
from improv_core.stage.messages import Sensed
from improv_core.stage.viewer.messages import RobotWindow, ShownScore

MOST_MOMENTS = 20_000
"""Moments of all robots together in one window."""
MOST_SENSED = 1000
"""Changes of senses to keep, to know what they have decided."""


def about(score: Score, generation: int, *, takes_start_poses: bool) -> ShownScore:
    """The `score` message: text and length, the words that move robots, and the robots (meters, radians)."""
    beats = score.beats
    return {
        "type": "score",
        "generation": generation,
        "tempo": float(score.tempo),
        "scene": score.scene,
        "scenes": list(map(float, score.scene_begins)),
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


def window(score: Score, start: float, end: float, sensed: Sequence[Sensed] = ()) -> dict[str, RobotWindow]:
    """What each robot does from beat `start` to beat `end`, up to `MOST_MOMENTS`.

    `pose` is the robot's ideal pose at `start` (x, y, z, heading), or None if that can't be known. `moments` are lists
    of start and duration in beats, velocity at the score's own tempo (m/s, rad/s), and the words that play: statement,
    and span in it. `until` is the beat they reach. What senses decide is as `sensed` has it (in order of time), and
    after the last of these, no condition holds.
    """
    most = MOST_MOMENTS // max(len(score.parts), 1)
    begin = near(max(start, 0.0))
    return {
        name: _performed(score, part, begin, end, most, [each for each in sensed if each["robot"] == name])
        if part.senses
        else _window(score, part, begin, end, most)
        for name, part in score.parts.items()
    }


def _performed(score: Score, part: Part, begin: Exact, end: float, most: int, sensed: Sequence[Sensed]) -> RobotWindow:
    """A stretch of a part that depends on senses: what they decided is performed again, from where it began."""
    performer = Performer(part.movement, part.begins)
    values: defaultdict[str, bool | None] = defaultdict(bool)
    edges = deque((near(max(each["beat"], float(part.begins))), each["sense"], each["value"]) for each in sensed)
    pose, first = part.entered or part.start, None
    moments: list[list[Any]] = []
    for _ in range(MOST_MOMENTS):
        while edges and edges[0][0] <= performer.beat:
            _, sense, value = edges.popleft()
            values[sense] = value
            performer.settle(values.__getitem__)  # a cue holds for an instant
        performer.settle(values.__getitem__)
        if not edges:
            values.clear()
        if performer.is_over or performer.beat >= end or len(moments) == most:
            break
        until = min(performer.until, edges[0][0] if edges else ENDLESS)
        if until == ENDLESS:
            break
        assert not isinstance(until, float)
        velocity, sources = performer.velocity()
        moving = twist(velocity, part.profile, score.tempo)
        if until > begin:
            first = first or pose.after(moving, score.seconds(max(begin - performer.beat, 0)))
            start = max(performer.beat, begin)
            words = [[source.statement, *source.span] for source in sources]
            moments.append([float(start), float(until - start), *astuple(moving), words])
        pose = pose.after(moving, score.seconds(until - performer.beat))
        performer.advance(until)
    return {"pose": list(astuple(first or pose)), "moments": moments, "until": float(performer.beat)}


def _window(score: Score, part: Part, begin: Exact, end: float, most: int) -> RobotWindow:
    moments: list[list[Any]] = []
    until = float(begin)
    for moment in walk(part.movement, max(begin - part.begins, 0)) if begin < part.ends else ():
        start = part.begins + moment.start
        if start >= end or len(moments) == most:
            break
        moving = twist(moment.velocity, part.profile, score.tempo)
        words = [[source.statement, *source.span] for source in moment.sources]
        moments.append([float(start), float(moment.duration), *astuple(moving), words])
        until = float(start + moment.duration)
    pose = pose_at(part, begin)
    return {"pose": list(astuple(pose)) if pose else None, "moments": moments, "until": until}
