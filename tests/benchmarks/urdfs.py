"""URDFs of real robots: the bodies that `improv body` proposes, how many of their joints dance, and how they play.

Improv brings no URDFs: set IMPROV_URDFS to a folder that has some. It plays twenty of them, which takes
2 to 13 s of CPU each.
"""

from __future__ import annotations

import math
import os
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import replace
from fractions import Fraction
from pathlib import Path

from improv_core.outputs.ros.joints.channels import LONGEST_WINDOW, channels_of, window_of
from improv_core.program.analysis import analyze
from improv_core.program.compiler import score_of
from improv_core.program.joint_check import check_joints
from improv_core.robots.bodies import DIRECTIONS
from improv_core.robots.config import read_robots
from improv_core.robots.urdf import UrdfError, read_urdf
from improv_core.robots.urdf_parts import drives_base
from improv_core.robots.urdf_sections import sections
from improv_core.score.body import Body
from improv_core.score.joints import joint_moments, limbs_of
from improv_core.score.score import Part
from tests.benchmarks.tables import print_head, print_row
from tests.outputs.dances import dance

OPPOSITES = {"forward": "backward", "strafeleft": "straferight", "up": "down", "left": "right"}
SHARES = {
    "URDFs": "",
    "can be read": "URDFs",
    "have a joint with a motor that isn't a wheel's": "can be read",
    "get a body that `improv.toml` accepts": "have a joint with a motor that isn't a wheel's",
    "dance within their limits, and end at rest": "get a body that `improv.toml` accepts",
    "are played, a few of them, with messages up to 0.1 s late": "",
    "end where the program ends, at rest": "are played, a few of them, with messages up to 0.1 s late",
    "keep limits, speeds, and accelerations": "are played, a few of them, with messages up to 0.1 s late",
    "joints with a motor, without wheels'": "",
    "get a direction": "joints with a motor, without wheels'",
    "get one that isn't a guess": "joints with a motor, without wheels'",
}
"""Rows, and the row of which each is a share."""
URDFS, READ, JOINTED, ACCEPTED, DANCING, PLAYED, ARRIVED, KEPT, JOINTS, DIRECTED, CLEAR = SHARES
MOST_PLAYED = 20
LATE = (0.0, 0.0, 0.1, 0.003, 0.0, 0.06, 0.0)
"""Seconds by which messages are late, in turns."""
BRISK = 4
"""URDFs state no accelerations. Joints get so much that they reach their speed in a quarter of a second."""
TEMPO = Fraction(60)
TICK = 0.01
SPARE = 1.02
"""The share of its acceleration that a joint may need: positions and times are rounded."""
NEAR = 1e-4
"""Radians or meters."""


def run(quick: bool) -> None:
    """Measure and print; `quick` takes every tenth file."""
    files = sorted(Path(os.environ["IMPROV_URDFS"]).rglob("*.urdf"))[:: 10 if quick else 1]
    played = {*files[:: max(len(files) // MOST_PLAYED, 1)]}
    found = Counter(each for file in files for each in _look(file.read_bytes(), play=file in played))
    print_head("of them", "there are", "share")
    for row, whole in SHARES.items():
        print_row(row, f"{found[row]:,}", f"{found[row] / found[whole]:.1%}" if found[whole] else "")


def _look(source: bytes, *, play: bool) -> Iterator[str]:
    """Yield the rows in which a URDF counts, and those of each of its joints."""
    yield URDFS
    try:
        urdf = read_urdf(source)
    except UrdfError:
        return
    yield READ
    joints = [joint for joint in urdf.joints if joint.driven and not drives_base(joint)]
    yield from [JOINTS] * len(joints)
    if joints:
        yield JOINTED
    try:
        toml = sections(urdf, "a file", "dancer")
    except UrdfError:
        return
    robots = read_robots(f'{toml}\n[robots.ada]\nprofile = "dancer"\n')
    body = robots.profiles["dancer"].body
    if robots.diagnostics or not body:
        return
    yield ACCEPTED
    directions = sum(len(part.drives) for part in body.parts)
    yield from [DIRECTED] * directions
    yield from [CLEAR] * (directions - toml.count("} # a guess"))
    analysis = analyze(_dance(body), robots)
    if not (analysis.diagnostics or check_joints(analysis)):
        yield DANCING
    if play:
        yield from _play(score_of(analysis).parts["ada"])


def _play(part: Part) -> Iterator[str]:
    """Yield the rows in which a robot counts whose controllers perform its part."""
    yield PLAYED
    body = part.profile.body
    assert body
    speeds = {drive.joint: abs(drive.per_step) for each in body.parts for drive in each.drives}
    brisk = [replace(joint, max_acceleration=BRISK * speeds.get(joint.name, 1.0)) for joint in body.joints]
    part = replace(part, profile=replace(part.profile, body=replace(body, joints=brisk)))
    arrived = kept = True
    for channel in channels_of(part):
        channel = replace(channel, window=window_of(part, channel, TEMPO))
        program = _program(part, [joint.name for joint in channel.joints])
        last = program[-1][0]
        danced = dance(
            channel, program, lambda number: LATE[number % len(LATE)], seconds=last + LONGEST_WINDOW, tick=TICK
        )
        for number, joint in enumerate(channel.joints):
            (end, speed), goal = danced.passed[-1][number], danced.program[-1][number]
            arrived = arrived and abs(end - goal) < NEAR and not speed
            states = [each[number] for each in danced.passed]
            kept = kept and all(abs(joint.within(position) - position) < NEAR for position, _ in states)
            kept = kept and all(abs(speed) <= (joint.max_velocity or math.inf) + NEAR for _, speed in states)
            kept = kept and danced.steepest(number) <= SPARE * (joint.max_acceleration or math.inf) + NEAR
    yield from [ARRIVED] * arrived
    yield from [KEPT] * kept


def _program(part: Part, joints: Sequence[str]) -> list[tuple[float, list[float]]]:
    """The velocities of these joints from a time on, from 1 s."""
    changes = dict[float, dict[str, float]]()
    for limb in limbs_of(part, TEMPO):
        for scene in part.scenes:
            for each in joint_moments(scene, limb):
                changes.setdefault(1 + float(each.moment.start), {}).update(each.velocities)
            changes.setdefault(1 + float(scene.duration), {}).update(dict.fromkeys(joints, 0.0))
    now, program = dict.fromkeys(joints, 0.0), []
    for at in sorted(changes):
        now |= changes[at]
        program.append((at, [now[joint] for joint in joints]))
    return program


def _dance(body: Body) -> str:
    """Return a program in which each joint goes to the side where it has room, and back, so that it ends at rest."""
    words = {component: word for word, component in DIRECTIONS.items()}
    movements = []
    for part in body.parts:
        for drive in part.drives:
            joint, word = body.joint[drive.joint], words[drive.direction]
            there = joint.start + drive.per_step
            pair = (word, OPPOSITES[word]) if joint.within(there) == there else (OPPOSITES[word], word)
            movements.append(f"{part.name} ({' '.join(pair)})")
    return f"beat 60\nada $ {' '.join(movements)}"
