"""Messages in which a stage reports about a performance, made of the run, the facts, and the clock. Pure functions."""

from __future__ import annotations

import math
from collections.abc import Collection, Iterator, Mapping, Sequence

from improv_core.player.run import Run
from improv_core.protocol.commands import AUTOMATIONS
from improv_core.protocol.fields import PoseJson, to_pose_json
from improv_core.protocol.messages import Decided, Poses, Sensed, TransportMessage
from improv_core.protocol.output import RawJoints
from improv_core.protocol.robot_messages import (
    FaultMessage,
    JointPositions,
    MeasuredRobot,
    RobotInstant,
    Vitals,
    VitalsRobot,
    WorstJson,
)
from improv_core.safety.fault_monitor import RobotNews
from improv_core.safety.fault_rules import FaultBegan, Worst
from improv_core.safety.fault_texts import SeenNews, as_line, as_lines
from improv_core.safety.odometry import Comparison
from improv_core.score.body import Body
from improv_core.score.motion import Pose
from improv_core.score.movement import ENDLESS, Duration, Exact
from improv_core.score.performing import Decision
from improv_core.score.senses import RobotSense


def transport(
    run: Run, over: Duration, waits: list[str], backend: str, poses: Poses, at: float, wall: float
) -> TransportMessage:
    """Report the playback position at a time on the clock, which is `wall` in Unix time."""
    beats = run.beats(over)
    message: TransportMessage = {
        "type": "transport",
        "generation": run.generation,
        "restarted": run.restarted,
        "state": run.mode,
        "backend": backend,
        "tempo": float(run.tempo),
        "speed": float(run.speed),
        "beats": None if beats == ENDLESS else float(beats),
        "beat": float(run.beat(at, over)),
        "performed": run.transport.performed(at),
        "muted": sorted({*run.silenced.muted, *run.stood}),
        "soloed": sorted(run.silenced.soloed),
        "monotonic": at,
        "wall": wall,
    }
    if "start" in poses and "poses" in poses:
        message["start"], message["poses"] = poses["start"], poses["poses"]
    if waits:
        message["waits_for"] = waits
    are_near = run.mode == "paused" and run.too_near
    if are_near:
        message["too_near"] = run.too_near
    if are_near or (run.mode == "stopped" and run.unasked):
        scene = run.score.scene_begins[run.scene - run.score.scene :][:1]
        message["resumes"] = {"scene": float(scene[0] if scene else run.score.since), "beat": message["beat"]}
    if run.startable_by != AUTOMATIONS:
        message["startable_by"] = sorted(run.startable_by)
    if begins := {robot: float(part.begins) for robot, part in run.score.parts.items() if part.begins}:
        message["begins"] = begins
    if run.score.scene or run.score.since:
        message["scene"] = {"index": run.score.scene, "begins": float(run.score.since)}
    if run.score.bar:
        message["bar"] = run.score.bar
    if run.clock or run.pace != 1:
        message["pace"] = float(run.pace)
    if run.behind:
        message["behind"] = run.behind
    return message


def sensed(run: Run, what: RobotSense, value: bool | None, beat: Exact, performed: float, wall: float) -> Sensed:
    robot, sense = what
    return {"type": "sensed", "sense": sense, "value": value, **_moment(run, robot, beat, performed, wall)}


def decided(run: Run, robot: str, decision: Decision, performed: float, wall: float) -> Decided:
    """Report the decision of a word that reads senses."""
    sources = [[source.statement, *source.span] for source in decision.sources]
    moment = _moment(run, robot, decision.beat, performed, wall)
    return {"type": "decided", "sources": sources, "held": decision.held, **moment}


def compared(run: Run, over: Duration, comparison: Comparison, wall: float) -> MeasuredRobot:
    """Return a robot's measured pose, and its ideal pose at that time."""
    raw, pose, ideal, aligned, follows, *_ = comparison
    return {
        "source": raw.source,
        "frame": raw.frame,
        "origin": to_pose_json(raw.pose.then(pose.inverse())),
        "pose": to_pose_json(pose),
        "ideal": to_pose_json(ideal),
        "aligned": aligned,
        "follows": follows,
        "beat": float(run.beat(raw.at, over)),
        "performed": run.transport.performed(raw.at),
        "wall": _nanoseconds(wall),
    }


def joints(run: Run, over: Duration, measured: RawJoints, body: Body, wall: float) -> JointPositions:
    """Report the positions of a robot's joints. Joints that aren't its own are left out."""
    positions = {name: at + body.joint[name].offset for name, at in measured.positions.items() if name in body.joint}
    moment = _moment(run, measured.robot, run.beat(measured.at, over), run.transport.performed(measured.at), wall)
    return {"type": "joints", "positions": positions, **moment}


def faults(run: Run, over: Duration, news: Sequence[RobotNews], now: float, wall: float) -> Iterator[FaultMessage]:
    """Report news about the faults of robots: a message about each, and lines for people."""
    found = [
        SeenNews(run.score.parts[robot], each, robot in run.stood, run.stood.get(robot) == now) for robot, each in news
    ]
    beat, responses, rejoin = run.beat(now, over), run.score.safety.faults.response, run.score.safety.rejoin
    words = beat_in_words(run, beat)
    for each, line in zip(found, as_lines(found, words, responses, rejoin), strict=True):
        response = responses(each.news.fault)
        yield {
            "type": "fault",
            "fault": each.news.fault,
            "over": not isinstance(each.news, FaultBegan),
            "response": response,
            "worst": worst_json(each.news.worst),
            "message": as_line(each, words, response, rejoin),
            "line": line,
            **_moment(run, each.part.robot, beat, run.transport.performed(now), wall),
        }


def vitals(
    run: Run,
    posed: Mapping[str, float],
    batteries: Mapping[str, float],
    standing: Collection[str],
    returning: Collection[str],
) -> Vitals:
    """Report the condition of real robots. `standing` are those that were away; some are `returning`."""
    robots: dict[str, VitalsRobot] = {
        robot: {
            "odom": bool(part.odom),
            "posed": posed.get(robot),
            "battery": batteries.get(robot),
            "instead": "drives back" if robot in returning else "stands" if robot in standing else "",
        }
        for robot, part in run.score.parts.items()
    }
    return {"type": "vitals", "generation": run.generation, "robots": robots}


def beat_in_words(run: Run, beat: Exact) -> str:
    """Return `beat 12`, or `bar 3, beat 4` if the program sets the length of bars. They count from 1."""
    passed = math.floor(beat)
    if not run.score.bar:
        return f"beat {passed + 1}"
    bar, rest = divmod(passed, run.score.bar)
    return f"bar {bar + 1}, beat {rest + 1}"


def worst_json(worst: Worst) -> WorstJson:
    """Return the size of a fault, as far as it has such a number."""
    found: WorstJson = {}
    if worst.distance or worst.turn:
        found["distance"], found["turn"] = worst.distance, worst.turn
    if worst.seconds:
        found["seconds"] = worst.seconds
    return found


def whereabouts(start: Mapping[str, Pose], now: Mapping[str, Pose]) -> Poses:
    """Return the poses of simulated robots at beat 0 and now; empty for real robots."""
    return {"start": _as_json(start), "poses": _as_json(now)} if now else {}


def _as_json(poses: Mapping[str, Pose]) -> dict[str, PoseJson]:
    return {robot: to_pose_json(pose) for robot, pose in poses.items()}


def _moment(run: Run, robot: str, beat: Exact, performed: float, wall: float) -> RobotInstant:
    """Return the fields that all edges and decisions have."""
    return {
        "generation": run.generation,
        "robot": robot,
        "beat": float(beat),
        "performed": performed,
        "wall": _nanoseconds(wall),
    }


def _nanoseconds(seconds: float) -> int:
    return round(seconds * 1e9)
