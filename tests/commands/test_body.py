"""`improv body`: the sections that it prints for a URDF, and its errors."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.commands.command_line import run
from tests.robots.test_urdf import DOLL, PARTS

URDF = 'urdf = "doll.urdf" # the page draws the robot from it; the path is from the folder of improv.toml\n'


def test_the_sections_of_a_urdf_are_printed(tmp_path: Path) -> None:
    (tmp_path / "doll.urdf").write_text(DOLL)
    ended = run("body", "doll.urdf", folder=tmp_path)
    printed = ended.stdout.replace(URDF, "", 1)
    assert (ended.returncode, printed[: len(PARTS)]) == (0, PARTS)
    assert f'joint_states = "joint_states"\n{URDF}\n' in ended.stdout


def test_parts_and_the_profile_can_be_named(tmp_path: Path) -> None:
    (tmp_path / "doll.urdf").write_text(DOLL)
    ended = run("body", "doll.urdf", "--profile", "nao", "--part", "chest=torso", folder=tmp_path)
    assert '[profiles.nao.body.chest] # what moves torso\nleft = { joint = "waist", degrees = -30 }\n' in ended.stdout


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        ([], "Error: name either a file or a --topic"),
        (["doll.urdf", "--topic", "/robot_description"], "Error: name either a file or a --topic"),
        (["doll.urdf", "--part", "head"], "Error: write --part NAME=LINK, such as --part head=head_link, not 'head'"),
        (
            ["doll.urdf", "--part", "x=y"],
            "improv: doll.urdf: the file has no link 'y': name another tip for the part 'x'",
        ),
        (["none.urdf"], "improv: none.urdf: no such file or directory"),
        (["wrong.urdf"], "improv: wrong.urdf:2: a link has no name"),
    ],
)
def test_an_unreadable_urdf_is_one_line(arguments: list[str], said: str, tmp_path: Path) -> None:
    (tmp_path / "doll.urdf").write_text(DOLL)
    (tmp_path / "wrong.urdf").write_text("<robot>\n<link/></robot>")
    ended = run("body", *arguments, folder=tmp_path)
    assert (ended.returncode, ended.stderr.splitlines()[-1]) == (2, said)
