"""URDFs of real robots: the bodies that `improv body` proposes, and how many of their joints dance.

Improv brings no URDFs: set IMPROV_URDFS to a folder that has some.
"""

from __future__ import annotations

import os
from collections import Counter
from collections.abc import Iterator
from pathlib import Path

from improv_core.program.analysis import analyze
from improv_core.program.joint_check import check_joints
from improv_core.robots.bodies import DIRECTIONS
from improv_core.robots.config import read_robots
from improv_core.robots.urdf import UrdfError, read_urdf
from improv_core.robots.urdf_parts import drives_base
from improv_core.robots.urdf_sections import sections
from improv_core.score.body import Body
from tests.benchmarks.tables import print_head, print_row

OPPOSITES = {"forward": "backward", "strafeleft": "straferight", "up": "down", "left": "right"}
SHARES = {
    "URDFs": "",
    "can be read": "URDFs",
    "have a joint with a motor that isn't a wheel's": "can be read",
    "get a body that `improv.toml` accepts": "have a joint with a motor that isn't a wheel's",
    "dance within their limits, and end at rest": "get a body that `improv.toml` accepts",
    "joints with a motor, without wheels'": "",
    "get a direction": "joints with a motor, without wheels'",
    "get one that isn't a guess": "joints with a motor, without wheels'",
}
"""Rows, and the row of which each is a share."""
URDFS, READ, JOINTED, ACCEPTED, DANCING, JOINTS, DIRECTED, CLEAR = SHARES


def run(quick: bool) -> None:
    """Measure and print; `quick` takes every tenth file."""
    files = sorted(Path(os.environ["IMPROV_URDFS"]).rglob("*.urdf"))[:: 10 if quick else 1]
    found = Counter(each for file in files for each in _look(file.read_bytes()))
    print_head("of them", "there are", "share")
    for row, whole in SHARES.items():
        print_row(row, f"{found[row]:,}", f"{found[row] / found[whole]:.1%}" if found[whole] else "")


def _look(source: bytes) -> Iterator[str]:
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
