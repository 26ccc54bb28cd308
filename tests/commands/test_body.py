"""`improv body`: the sections that it prints for a URDF, and its errors."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest

from improv_core.commands import xacro
from tests.commands.command_line import program, run
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


ADVICE = "run `xacro doll.xacro > robot.urdf`, and read that"
FIND = "from ament_index_python.packages import get_package_share_directory as find"
PYTHON = f'exec {sys.executable} -c "{FIND}; {{}}"'
XACRO = '<robot name="doll"><xacro:include filename="arms.xacro"/></robot>'


@pytest.mark.parametrize(
    ("script", "said"),
    [
        ("cat ../doll.urdf", "# From doll.xacro, expanded by xacro. "),
        (
            PYTHON.format("print(open(find('doll_description') + '/doll.urdf').read())"),
            "# From doll.xacro, expanded by xa",
        ),
        (
            PYTHON.format("find('arms')"),
            f"(LookupError: the package arms is neither installed nor near the file): {ADVICE}",
        ),
        (
            "echo 'error: Undefined substitution argument side' >&2; exit 1",
            "run `xacro doll.xacro side:=VALUE > robot.urdf`, and read that",
        ),
        (
            "echo 'error: no such macro' >&2; echo in file >&2; exit 1",
            f"can't expand it (error: no such macro): {ADVICE}",
        ),
        ("cat; echo error: $(ulimit -v) kB >&2; exit 1", f"can't expand it (error: 1953125 kB): {ADVICE}"),
        ("kill -9 $$", f"can't expand it (it was killed): {ADVICE}"),
        ("exec sleep 100", f"can't expand it (it took more than 0.5 s): {ADVICE}"),
        ("exec yes", "improv: doll.xacro, expanded by xacro: it is larger than 5 MB"),
        (None, "improv: doll.xacro:1: this is a xacro file: run `xacro FILE > robot.urdf`, and read that"),
    ],
)
def test_a_xacro_file_is_expanded_in_a_process_with_limits(
    script: str | None, said: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    programs = tmp_path / "bin"
    if script:
        program(programs / "xacro", f"cd {programs}\n{script}")
    monkeypatch.setenv("PATH", f"{programs}:/usr/bin:/bin")
    monkeypatch.setattr(xacro, "LIMIT", 0.5 if script == "exec sleep 100" else 10.0)
    (tmp_path / "doll.urdf").write_text(DOLL)
    (tmp_path / "doll.xacro").write_text(XACRO)
    (tmp_path / "package.xml").write_text('<package format="3">\n  <name>doll_description</name>\n</package>\n')
    ended = run("body", "doll.xacro", folder=tmp_path)
    assert said in ended.stdout + ended.stderr
    assert "urdf = " not in ended.stdout
