"""URDFs that an `improv.toml` names: their drawing, and their errors, at the right place."""

from __future__ import annotations

import json
import math
import os
from pathlib import Path

import pytest

from improv_core.preview.window import about
from improv_core.program.analysis import analyze
from improv_core.program.compiler import score_of
from improv_core.program.files import robots_from, robots_in
from improv_core.robots.config import Robots, read_robots
from improv_core.robots.skeletons import bones
from improv_core.robots.urdf import read_urdf
from improv_core.score.body import Bone
from improv_core.score.score_json import from_json, to_json
from tests.robots.test_urdf import BOMB, robot

LINKS = "".join(f'<link name="{name}"/>' for name in "abcdefg")
URDF = robot(
    LINKS,
    '<joint name="pan" type="revolute"><parent link="a"/><child link="b"/><axis xyz="0 0 2"/>'
    '<origin xyz="0 0 1" rpy="0 0 0.5"/><limit lower="0.25" upper="1" velocity="1"/></joint>',
    '<joint name="lift" type="prismatic"><parent link="b"/><child link="c"/><axis xyz="0 0 1"/>'
    '<limit lower="0" upper="1" velocity="1"/></joint>',
    '<joint name="camera" type="fixed"><parent link="c"/><child link="d"/></joint>',
    '<joint name="finger" type="continuous"><parent link="c"/><child link="e"/>'
    '<mimic joint="pan" multiplier="-2" offset="0.1"/></joint>',
    '<joint name="f" type="fixed"><parent link="a"/><child link="f"/></joint>',
    '<joint name="g" type="fixed"><parent link="a"/><child link="g"/></joint>',
)
TOML = """\
[profiles.r]
step = 1
urdf = "r.urdf"
[profiles.r.body.head]
left = { joint = "pan", degrees = 30 }
up = { joint = "lift", meters = 0.1 }
[profiles.r.joints.pan]
start = 30
[robots.ada]
profile = "r"
joints.pan.offset = 3
"""


def read(folder: Path, urdf: str = URDF, toml: str = TOML) -> Robots:
    """Read an improv.toml beside a URDF."""
    (folder / "r.urdf").write_text(urdf)
    return robots_from(toml, folder / "improv.toml")


def check(folder: Path, urdf: str, message: str, toml: str = TOML) -> None:
    """Check that the error is marked at the URDF's name, robots don't play, and nothing is drawn."""
    robots = read(folder, urdf, toml)
    (found,) = robots.diagnostics
    assert robots.text[found.span.start : found.span.end] == '"r.urdf"'
    assert found.message == message
    assert not robots.ok


def skeleton_of(robots: Robots, name: str) -> tuple[Bone, ...]:
    body = robots.robot(name).profile.body
    assert body
    return tuple(body.skeleton)


def test_each_joint_is_drawn_from_the_one_that_carries_it() -> None:
    assert [(each.joint, each.carrier, each.way) for each in bones(read_urdf(URDF.encode()))] == [
        ("pan", -1, "turns"),
        ("lift", 0, "slides"),
        ("camera", 1, "stays"),
        ("finger", 1, "turns"),
        ("f", -1, "stays"),
        ("g", -1, "stays"),
    ]


def test_a_bone_has_its_place_its_axis_and_its_leader() -> None:
    pan, _, _, finger, *_ = bones(read_urdf(URDF.encode()))
    assert pan == Bone("pan", -1, (0, 0, 1), (0, 0, 0.5), (0, 0, 1), "turns", 0.25)  # it can't stand at 0
    assert (finger.follows, finger.ratio, finger.shift) == ("pan", -2, 0.1)


def test_the_urdf_is_beside_improv_toml_wherever_people_are(tmp_path: Path) -> None:
    (tmp_path / "r.urdf").write_text(URDF)
    (tmp_path / "improv.toml").write_text(TOML)
    robots = robots_in(tmp_path / "improv.toml")
    assert robots.diagnostics == ()
    assert skeleton_of(robots, "ada") == bones(read_urdf(URDF.encode()))
    body = robots.robot("ada").profile.body
    assert body
    assert body.joint["pan"].offset == pytest.approx(math.radians(3))  # and the robot's own values stay


def test_a_changed_urdf_is_read_again(tmp_path: Path) -> None:
    assert read(tmp_path).ok
    check(tmp_path, URDF.replace("pan", "yaw"), "`r.urdf` has no joint `pan`, but `yaw`, `lift`, `finger`")


def test_a_profile_has_the_urdf_of_its_base(tmp_path: Path) -> None:
    robots = read(tmp_path, toml=f'{TOML}[profiles.s]\nbase = "r"\n[robots.bo]\nprofile = "s"\n')
    assert len(skeleton_of(robots, "bo")) == 6


def test_a_text_without_a_file_has_no_skeletons() -> None:
    """As on a website, which has no files."""
    assert robots_from(TOML, None) == read_robots(TOML)


@pytest.mark.parametrize(
    ("urdf", "message"),
    [
        ("", "`r.urdf`, line 1: this is not XML: no element found"),
        (BOMB, "`r.urdf`, line 1: a URDF must not declare a document type or entities: remove them"),
        (
            URDF.replace('<parent link="b"/>', '<parent link="c"/>'),
            "`r.urdf`, line 1: the joint 'lift' is in a loop: all links must form one tree",
        ),
        (
            URDF.replace('lower="0.25"', 'lower="2"'),
            "`r.urdf`, line 1: the joint 'pan' has its lower limit 2 above its upper limit 1",
        ),
        (URDF.replace('name="pan"', 'name="yaw"'), "`r.urdf` has no joint `pan`, but `yaw`, `lift`, `finger`"),
        (
            URDF.replace('"lift" type="prismatic"', '"lift" type="revolute"'),
            "`r.urdf` has `lift` turn: say in degrees how far it moves",
        ),
        (
            URDF.replace('"lift" type="prismatic"', '"lift" type="fixed"'),
            "`r.urdf` has `lift` as a joint that doesn't move: remove it from the body",
        ),
    ],
)
def test_a_urdf_that_can_t_be_drawn_is_marked_where_it_is_named(urdf: str, message: str, tmp_path: Path) -> None:
    check(tmp_path, urdf, message)


def test_a_joint_that_follows_another_can_t_be_moved_by_itself(tmp_path: Path) -> None:
    toml = TOML.replace('"pan"', '"finger"').replace("joints.pan", "joints.finger").replace("start = 30", "max = 3")
    check(tmp_path, URDF, "`r.urdf` has `finger` follow `pan`: move that instead", toml)


def test_a_urdf_with_thousands_of_joints_is_not_drawn(tmp_path: Path) -> None:
    links = "".join(f'<link name="l{number}"/>' for number in range(1_002))
    chain = "".join(
        f'<joint name="j{number}" type="fixed"><parent link="l{number}"/><child link="l{number + 1}"/></joint>'
        for number in range(1_001)
    )
    check(tmp_path, robot(links, chain), "`r.urdf`: it has 1,001 joints: at most 1,000 can be drawn")


@pytest.mark.parametrize(("make", "problem"), [(None, "no such file or directory"), (Path.mkdir, "is a directory")])
def test_a_path_to_no_file_is_marked(make: object, problem: str, tmp_path: Path) -> None:
    if callable(make):
        make(tmp_path / "r.urdf")
    (found,) = robots_from(TOML, tmp_path / "improv.toml").diagnostics
    assert found.message == f"`r.urdf`: {problem}"


def test_a_pipe_blocks_nothing(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "r.urdf")
    (found,) = robots_from(TOML, tmp_path / "improv.toml").diagnostics
    assert found.message == "`r.urdf`: it is not a regular file"


def test_the_page_gets_each_skeleton_once(tmp_path: Path) -> None:
    robots = read(tmp_path, toml=f'{TOML}[robots.bo]\nprofile = "r"\n')
    score = score_of(analyze("ada bo $ head left\ncleo $ forward\n", robots))
    again = from_json(json.loads(json.dumps(to_json(score))))  # as it reaches the stage
    shown = about(again, 1, takes_start_poses=False)["skeletons"]
    assert list(shown) == ["r"]
    assert [each["joint"] for each in shown["r"]] == ["pan", "lift", "camera", "finger", "f", "g"]
    assert shown["r"][0]["turn"] == (0, 0, 0.5)
