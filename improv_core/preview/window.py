"""The next stretch of a score, for the page, as plain values. Standard library only."""

from __future__ import annotations

from dataclasses import asdict, astuple
from fractions import Fraction
from itertools import islice, takewhile
from typing import Any, cast

from improv_core.protocol.page_messages import RobotWindow, ShownBone, ShownScore
from improv_core.protocol.robot_messages import RobotLook, ShownBodyPart, ShownJoint
from improv_core.score.joints import limbs_of
from improv_core.score.json_types import as_json
from improv_core.score.measured import in_si
from improv_core.score.movement import ENDLESS, near
from improv_core.score.primitives import PRIMITIVES
from improv_core.score.profiles import Profile
from improv_core.score.projection import BASE
from improv_core.score.replay import Replay
from improv_core.score.score import Part, Score, speeds_of, twist
from improv_core.score.walk import Moment
from improv_core.score.world import EMPTY, World

MAX_MOMENTS = 20_000
"""The most moments of all robots together in one window."""


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
        "world": _world(score.world),
        "text": score.text,
        "offsets": {str(number): offset for number, offset in score.offsets.items()},
        "words": {word: [in_si(each, 1.0, 1.0, 1.0) for each in velocity] for word, velocity in PRIMITIVES.items()},
        "takes_start_poses": takes_start_poses,
        "deadman": {"button": deadman.button} if (deadman := score.safety.deadman) else None,
        "music": {"file": music.file, "first_beat": music.first_beat, "volume": music.volume}
        if (music := score.music)
        else None,
        "robots": {
            name: {
                **look_of(part, score),
                "dynamics": part.profile.dynamics,
                "speeds": [speeds.x, speeds.yaw],
                "start_pose": list(astuple(part.start)),
                "begins": float(part.begins),
                "ends": None if part.ends == ENDLESS else float(part.ends),
                "senses": as_json(part.senses),
                "near": part.profile.reach,
            }
            for name, part in score.parts.items()
            for speeds in (speeds_of(part.profile, score.tempo),)
        },
        "skeletons": {
            part.profile.name: [cast(ShownBone, asdict(bone)) for bone in part.profile.body.skeleton]
            for part in score.parts.values()
            if part.profile.body and part.profile.body.skeleton
        },
    }


def _world(world: World) -> dict[str, Any] | None:
    """Return the world as pages show it; None if it is empty."""
    if world == EMPTY:
        return None
    return {
        "size": list(world.size) if world.size else None,
        "walls": [list(wall) for wall in world.walls],
        "circles": [circle._asdict() for circle in world.circles],
        "boxes": [box._asdict() for box in world.boxes],
        "margin": world.margin,
        "keep_apart": world.keep_apart,
    }


def look_of(part: Part, score: Score) -> RobotLook:
    """Return the looks of a robot, also for a program that doesn't play yet."""
    profile = part.profile
    return {
        "profile": profile.name,
        "radius": profile.radius,
        "motions": list(profile.motions),
        "body": body_of(part, score),
    }


def body_of(part: Part, score: Score) -> list[ShownBodyPart]:
    """Return the parts of a robot's body as pages show it, if it has one."""
    if not (body := part.profile.body):
        return []
    moved = {limb.part.name for limb in limbs_of(part, score.tempo)}
    shown: list[ShownBodyPart] = []
    for each in body.parts:
        joints: list[ShownJoint] = []
        for drive in each.drives:
            joint = body.joint[drive.joint]
            joints.append(
                {
                    "name": joint.name,
                    "axis": drive.direction,
                    "sign": 1 if drive.per_step > 0 else -1,
                    "slides": joint.slides,
                    "min": joint.min,
                    "max": joint.max,
                    "start": joint.start,
                }
            )
        shown.append({"name": each.name, "joints": joints, "moves": each.name in moved})
    return shown


def window(replay: Replay, start: float, end: float) -> dict[str, RobotWindow]:
    """The moments of each robot from beat `start` to beat `end`, up to `MAX_MOMENTS`.

    `pose` is the robot's ideal pose at `start` (x, y, z, heading), or None if that can't be known. `moments` are lists
    of start and duration in beats, velocity at the score's own tempo (m/s, rad/s; that of a body part is converted as
    if it were the base's), and the words that play: statement, and span in it. `until` is the beat they reach.
    """
    score, begin = replay.score, near(max(start, 0.0))
    moving = {name: replay.body_parts(name) for name in score.parts}
    most = MAX_MOMENTS // max(sum(1 + len(parts) for parts in moving.values()), 1)

    def track(part: Part, body_part: str) -> list[list[Any]]:
        moments = islice(replay.moments(part.robot, begin, body_part), most)
        return [_moment(each, part.profile, score.tempo) for each in takewhile(lambda each: each.start < end, moments)]

    found: dict[str, RobotWindow] = {}
    for name, part in score.parts.items():
        moments = track(part, BASE)
        body = {each: track(part, each) for each in moving[name]}
        reached = [track[-1][0] + track[-1][1] if track else float(begin) for track in (moments, *body.values())]
        pose = replay.pose(name, begin)
        found[name] = {
            "pose": list(astuple(pose)) if pose else None,
            "moments": moments,
            "body": body,
            "until": min(reached),
        }
    return found


def _moment(moment: Moment, profile: Profile, tempo: Fraction) -> list[Any]:
    words = [[source.statement, *source.span] for source in moment.sources]
    return [float(moment.start), float(moment.duration), *astuple(twist(moment.velocity, profile, tempo)), words]
