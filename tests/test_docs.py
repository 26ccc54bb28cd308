"""What the documents show is true."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from improv_core.diagnostics import SEVERITIES
from improv_core.program.analysis import analyze
from improv_core.syntax.vocabulary import WORDS
from tests.pictures import pictures

ROOT = Path(__file__).parent.parent
PAGES = [ROOT / "README.md", *sorted((ROOT / "docs").glob("*.md"))]
PROGRAMS = [
    (page.name, program)
    for page in PAGES
    for program in re.findall(r"```improv\n(.*?)```", page.read_text(encoding="utf-8"), re.DOTALL)
]


@pytest.mark.parametrize(("page", "program"), PROGRAMS)
def test_programs_are_right(page: str, program: str) -> None:
    assert analyze(program).diagnostics == ()


def test_the_language_page_has_every_word_and_every_code() -> None:
    page = (ROOT / "docs" / "language.md").read_text(encoding="utf-8")
    written = set(re.findall(r"[\w-]+", " ".join(re.findall(r"`([^`\n]+)`", page))))
    assert set(WORDS) <= written
    assert set(SEVERITIES) <= written


def test_pictures_show_the_programs_above_them() -> None:
    drawn = dict(pictures())
    assert len(drawn) > 3
    for path, picture in drawn.items():
        assert path.read_text(encoding="utf-8") == picture, f"{path}: run `python -m tests.pictures`"


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_links_lead_somewhere(page: Path) -> None:
    for target in re.findall(r"(?:\]\(|src=\")(?!https?:|#)([^)#\"]+)", page.read_text(encoding="utf-8")):
        assert (page.parent / target).exists(), target


def test_ci_runs_the_readmes_test_command() -> None:
    readme = (ROOT / "README.md").read_text(encoding="utf-8")
    (command,) = re.findall(r"^python3 -m venv .*pytest$", readme, re.MULTILINE)
    assert command in (ROOT / ".ci" / "run").read_text(encoding="utf-8").splitlines()
