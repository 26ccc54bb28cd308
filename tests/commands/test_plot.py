"""`improv plot`: a picture in a file."""

from __future__ import annotations

from pathlib import Path
from xml.etree import ElementTree

import pytest

from tests.commands.command_line import run, written

UNKNOWN = "`forwrd` is not defined: did you mean `forward`?"


def draw(folder: Path, program: str, output: str, *options: str) -> tuple[int, str]:
    done = run("plot", written(folder, program), "-o", folder / output, *options)
    return done.returncode, (done.stdout + done.stderr).replace(str(folder), "…")


def test_plot_writes_svg_and_png(tmp_path: Path) -> None:
    assert draw(tmp_path, "r $ forward left\n", "dance.svg") == (0, "")
    ElementTree.parse(tmp_path / "dance.svg")
    assert draw(tmp_path, "r $ forward left\n", "dance.PNG", "--timeline") == (0, "")
    assert (tmp_path / "dance.PNG").read_bytes().startswith(b"\x89PNG")


@pytest.mark.parametrize(
    ("program", "output", "code", "line"),
    [
        ("r $ forwrd\n", "dance.svg", 1, f"…/dance.improv:1:5: error[unknown-name] {UNKNOWN}"),
        ("r $ left\n", "dance.pdf", 2, "improv: …/dance.pdf: the picture's name must end in .svg or .png"),
        ("r $ left\n", "no/dance.svg", 2, "improv: …/no/dance.svg: no such file or directory"),
    ],
)
def test_undrawable_programs_are_refused(tmp_path: Path, program: str, output: str, code: int, line: str) -> None:
    got, told = draw(tmp_path, program, output)
    assert (got, told.strip()) == (code, line)
    assert not (tmp_path / output).exists()


def test_a_png_has_the_names_of_the_robots(tmp_path: Path) -> None:
    pictures = []
    for name in ("anna", "otto"):
        assert draw(tmp_path, f"{name} $ forward left\n", "dance.png") == (0, "")
        pictures.append((tmp_path / "dance.png").read_bytes())
    assert pictures[0] != pictures[1]


def test_the_picture_shows_where_robots_meet(tmp_path: Path) -> None:
    starts = "ada at 0 0\nbo at 1 -1 facing 90\n"
    assert draw(tmp_path, f"{starts}ada $ forward\nbo $ forward\n", "dance.svg") == (0, "")
    drawn = (tmp_path / "dance.svg").read_text()
    assert "<title>ada and bo meet at beat 1.29</title>" in drawn
    assert drawn.count('fill-opacity="0.3"') == 2
    assert draw(tmp_path, f"{starts}ada $ forward\nbo $ rest forward\n", "dance.svg") == (0, "")
    assert "meet at" not in (tmp_path / "dance.svg").read_text()
