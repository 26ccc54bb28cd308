"""The edits of a program for what people do on the page: they move robots, bend movements, draw, and perform."""

from __future__ import annotations

import math
from collections.abc import Sequence
from fractions import Fraction
from typing import TypeGuard

from improv_core.diagnostics import Edit
from improv_core.ide.bending import bent, lengthened
from improv_core.ide.insertion import as_line, gap_at, poses_in
from improv_core.ide.placing import formed, in_tempo, placed
from improv_core.program.analysis import Analysis
from improv_core.program.compiler import score_of, starts_of
from improv_core.protocol.editing import DrawPath, PerformPart, ProgramChange, TuneMusic
from improv_core.score.motion import Pose
from improv_core.score.path import pose_at
from improv_core.score.score import speeds_of
from improv_core.transcription.gestures import MIN_LENGTH, DrawnPoint, PressedKeys, words_drawn, words_performed

MAX_PARTS = 12
"""The beat from which on a robot is moved by hand has at most this denominator."""


def is_first_beat(change: ProgramChange) -> TypeGuard[TuneMusic]:
    """Return whether a change is one of `improv.toml`, not of the program."""
    return change["type"] == "tune" and change["key"] == "first_beat"


def edits_of(analysis: Analysis, change: ProgramChange) -> Sequence[Edit] | None:
    """Return the edits of a program that make a change; None if the person has to fix a line of it first."""
    analysis = analysis.settled()
    match change["type"]:
        case "tune":
            return in_tempo(analysis, max(change["value"], 1))
        case "arrange":
            return formed(analysis, change["shape"], change["distance"], change["facing"])
        case "place":
            starts = change["start_poses"]
            return placed(analysis, {name: (each["x"], each["y"], each["heading"]) for name, each in starts.items()})
        case "bend":
            x, y = change["place"]
            return bent(analysis, change["offset"], (x, y), change["freely"])
        case "lengthen":
            return lengthened(analysis, change["offset"], change["steps"], change["freely"])
        case "draw":
            return _drawn(analysis, change)
        case "perform":
            return _performed(analysis, change)


def _drawn(analysis: Analysis, change: DrawPath) -> Sequence[Edit] | None:
    robot, offset, parts = change["robot"], change.get("offset"), change["parts"]
    stroke = [DrawnPoint(*each) for each in change["points"]]
    profile = analysis.opening.config.robot(robot).profile
    gap = gap_at(analysis, offset) if offset is not None else None
    poses = poses_in(analysis, gap) if gap else {}
    if gap and (robot in poses or not poses):
        pose = poses.get(robot)
        if pose and math.dist((pose.x, pose.y), stroke[0][1:]) >= MIN_LENGTH:
            stroke.insert(0, DrawnPoint(stroke[0].beat, pose.x, pose.y))
        _, words = words_drawn(stroke, pose.heading if pose else None, profile, parts)
        return [gap.filled(words)] if words else ()
    known, begin = _pose(analysis, change), _begin(change)
    stays = known is not None and (begin > 0 or math.dist((known.x, known.y), stroke[0][1:]) < MIN_LENGTH)
    start, words = words_drawn(stroke, known.heading if known and stays else None, profile, parts)
    if not words:
        return ()
    places = () if stays else placed(analysis, {robot: (start.x, start.y, math.degrees(start.heading))})
    return None if places is None else [*places, *as_line(analysis, robot, words, begin)]


def _performed(analysis: Analysis, change: PerformPart) -> Sequence[Edit]:
    robot, parts = change["robot"], max(change["parts"], 1)
    profile = analysis.opening.config.robot(robot).profile
    keys = [PressedKeys(beat, round(ahead), round(turn)) for beat, ahead, turn in change["keys"]]
    words = words_performed(keys, change["end"], speeds_of(profile, analysis.tempo), profile, parts)
    return list(as_line(analysis, robot, words, _begin(change))) if words else ()


def _begin(change: DrawPath | PerformPart) -> Fraction:
    return Fraction(change.get("begin", 0)).limit_denominator(MAX_PARTS)


def _pose(analysis: Analysis, change: DrawPath) -> Pose | None:
    """Return where a robot stands as somebody begins to move it; None if the program doesn't place it."""
    start, begin = starts_of(analysis).get(change["robot"]), _begin(change)
    part = score_of(analysis).parts.get(change["robot"]) if begin and analysis.ok else None
    return (pose_at(part, begin) if part else None) or start
