"""The claims of the documents are true."""

from __future__ import annotations

import re
from functools import cache
from pathlib import Path

import pytest

from improv_core.diagnostics import SEVERITIES
from improv_core.program.analysis import analyze
from improv_core.robots.config import read_robots
from improv_core.syntax.vocabulary import WORDS
from tests.pictures import pictures
from tests.program.drawing import check

ROOT = Path(__file__).parent.parent
PAGES = [ROOT / "README.md", *sorted((ROOT / "docs").glob("*.md"))]
PROGRAMS = [
    (page.name, program)
    for page in PAGES
    for program in re.findall(r"```improv\n(.*?)```", page.read_text(encoding="utf-8"), re.DOTALL)
]


def test_programs_are_right() -> None:
    assert [(page, program) for page, program in PROGRAMS if analyze(program).diagnostics] == []


def test_the_language_page_has_every_word() -> None:
    page = (ROOT / "docs" / "language.md").read_text(encoding="utf-8")
    written = set(re.findall(r"[\w-]+", " ".join(re.findall(r"`([^`\n]+)`", page))))
    assert set(WORDS) <= written


CODES: dict[str, str] = dict(
    re.findall(
        r"^## ([\w-]+)\n(.*?)(?=^## |\Z)",
        (ROOT / "docs" / "diagnostics.md").read_text("utf-8"),
        re.DOTALL | re.MULTILINE,
    )
)
TOO_LONG = ["too-large", "more-errors", "more-hints"]
"""Codes whose examples would fill pages."""


def test_each_code_has_a_section_that_says_how_severe_it_is() -> None:
    assert list(CODES) == list(SEVERITIES)
    for code, text in CODES.items():
        assert text.startswith(f"{SEVERITIES[code].value.capitalize()}. ")


@pytest.mark.parametrize("code", [code for code in CODES if code not in TOO_LONG])
def test_the_example_of_a_code_has_its_message_and_the_fixed_one_has_none(code: str) -> None:
    robots = ""
    in_room = code in ("meets", "hits", "joint-limit")
    kinds = []
    for kind, block in re.findall(r"```(\w+)\n(.*?)```", CODES[code], re.DOTALL):
        kinds.append(kind)
        if kind == "toml":
            robots = block
            assert read_robots(robots).diagnostics == ()
        elif kind == "improv":
            check(block, hints=True, robots=robots, in_room=in_room)
        elif code == "robots":
            *lines, message = block.splitlines()
            (wrong,) = read_robots("\n".join(lines)).diagnostics
            assert message.strip("^ ") == f"{wrong.code}: {wrong.message}"
        else:
            found = check(block, hints=True, robots=robots, in_room=in_room).diagnostics
            assert [each.code for each in found] == ([] if in_room else [code])
            assert block.count("^ ") == 1
    assert "text" in kinds
    assert kinds[-1] == ("toml" if code == "robots" else "improv")


def test_pictures_show_their_programs() -> None:
    drawn = list(pictures())
    for path, picture in drawn:
        assert path.read_text(encoding="utf-8") == picture, f"{path}: run `python -m tests.pictures`"
    assert {path for path, _ in drawn} == {*(ROOT / "docs" / "images").rglob("*.svg")}


def test_the_gallery_has_every_example() -> None:
    shown = re.findall(
        r'<img src="images/gallery/[^>]*>\]\(\.\./([^)]+)\)', (ROOT / "docs" / "gallery.md").read_text("utf-8")
    )
    assert sorted(shown) == sorted(path.relative_to(ROOT).as_posix() for path in ROOT.glob("examples/**/*.improv"))


EXERCISES = re.split(r"^### ", (ROOT / "docs" / "lesson.md").read_text(encoding="utf-8"), flags=re.MULTILINE)[1:]


@pytest.mark.parametrize("exercise", EXERCISES, ids=lambda exercise: exercise.partition("\n")[0])
def test_an_exercise_matches_its_solution(exercise: str) -> None:
    """Another test above plays the solution and compares the picture."""
    task, solution = exercise.split("<details>")
    assert len(re.findall(r"```improv", solution)) == 1
    if wrong := re.findall(r"```text\n(.*?)```", task, re.DOTALL):
        (messages,) = re.findall(r"```text\n(.*?)```", solution, re.DOTALL)
        found = check(messages)
        assert (found.lines.text, len(found.diagnostics)) == (wrong[0].strip(), 3)  # as the heading promises
    else:
        assert "<img" in task


@pytest.mark.parametrize("page", [*PAGES, ROOT / "CONTRIBUTING.md"], ids=lambda page: page.name)
def test_links_lead_somewhere(page: Path) -> None:
    for target, heading in re.findall(
        r"(?:\]\(|src=\")(?!https?:)([^)#\"]*)(?:#([^)\"]+))?", page.read_text(encoding="utf-8")
    ):
        file = page.parent / target if target else page
        assert file.exists(), target
        assert not heading or heading in anchors(file), f"{target}#{heading}"


@cache
def anchors(page: Path) -> set[str]:
    """Return the anchors that GitHub gives a page's headings."""
    titles = re.findall(r"^#+ (.*)", page.read_text(encoding="utf-8"), re.MULTILINE)
    return {re.sub(r"[^\w -]", "", title).lower().replace(" ", "-") for title in titles}


@pytest.mark.parametrize("page", ["architecture.md", "security.md"])
def test_named_tests_exist(page: str) -> None:
    """Each is a path in `tests/`, with or without that folder, or the end of one."""
    text = (ROOT / "docs" / page).read_text(encoding="utf-8")
    named = set(re.findall(r"`(?:tests/)?([\w/]*(?:test_\w+\.py|\w+\.test\.mjs))`", text))
    files = [path.as_posix() for path in (ROOT / "tests").glob("**/*test*")]
    assert [name for name in named if not any(file.endswith(f"/{name}") for file in files)] == []


def test_ci_runs_the_readmes_test_command() -> None:
    readme = (ROOT / "README.md").read_text(encoding="utf-8")
    (pattern,) = re.findall('grep .*"(.*)" README.md', (ROOT / ".ci" / "run").read_text(encoding="utf-8"))
    (command,) = re.findall(pattern, readme, re.MULTILINE)
    assert command.split(" && ")[-1] == ".venv/bin/python -m pytest"  # CI installs meanwhile what other people have
