"""Programs and improv.toml in files: unreadable ones are refused in one line, at once."""

from __future__ import annotations

from pathlib import Path

import pytest

from improv_core.diagnostics import MAX_SHOWN
from improv_core.program.analysis import LONGEST_PROGRAM, analyze
from improv_core.program.files import (
    LARGEST_ROBOTS_FILE,
    PlayedRobots,
    ReadError,
    analyze_file,
    read_program,
    robots_near,
    robots_or_problem,
)
from improv_core.storage.saves import saved_or_awaited
from tests.strange_files import StrangeFile


def test_a_strange_program_is_refused(strange_file: StrangeFile) -> None:
    path = strange_file.make("dance.improv")
    with pytest.raises(ReadError) as refused:
        analyze_file(path)
    assert str(refused.value).startswith(f"{path}: {strange_file.problem}")


def test_a_strange_improv_toml_is_refused_and_not_the_one_above_used(strange_file: StrangeFile) -> None:
    (strange_file.folder.parent / "improv.toml").write_text("[robots.r]\n")
    path = strange_file.make("improv.toml")
    program = path.with_name("dance.improv")
    program.write_text("r $ forward\n")
    for read in (lambda: robots_near(path.parent), lambda: analyze_file(program)):
        with pytest.raises(ReadError) as refused:
            read()
        assert str(refused.value).startswith(f"{path}: {strange_file.problem}")


def test_a_name_without_its_ending_is_completed_in_the_message(tmp_path: Path) -> None:
    program = tmp_path / "dance.improv"
    program.write_text("r $ forward\n")
    for read in (read_program, saved_or_awaited):
        with pytest.raises(ReadError) as refused:
            read(tmp_path / "dance")
        assert str(refused.value) == f"{tmp_path / 'dance'}: no such file or directory: did you mean {program}?"


def test_files_up_to_a_size_are_read(tmp_path: Path) -> None:
    program, robots = tmp_path / "dance.improv", tmp_path / "improv.toml"
    program.write_bytes(b"#" * LONGEST_PROGRAM)
    robots.write_bytes(b"#" * LARGEST_ROBOTS_FILE)
    assert len(read_program(program)) == LONGEST_PROGRAM
    assert robots_near(tmp_path).ok
    program.write_bytes(b"#" * (LONGEST_PROGRAM + 1))
    robots.write_bytes(b"#" * (LARGEST_ROBOTS_FILE + 1))
    with pytest.raises(ReadError, match="it is larger than 10 MB"):
        read_program(program)
    with pytest.raises(ReadError, match="it is larger than 1 MB"):
        robots_near(tmp_path)


def test_a_program_that_is_too_long_is_not_analyzed_until_it_is_shorter() -> None:
    text = "r $ forward\n"
    too_long = "#" * LONGEST_PROGRAM
    before = analyze(text)
    longer = before.edited(len(text), len(text), too_long)
    assert [each.message for each in longer.diagnostics] == [
        "split this program: it has more than 10,000,000 characters"
    ]
    assert not longer.ok
    assert longer.robots == {}
    shorter = longer.edited(len(text), len(text) + len(too_long), "")
    assert shorter.ok
    assert list(shorter.robots) == ["r"]


@pytest.mark.parametrize("line", ["r $ oops{0}\n", "name{0} = oops{0}\n", "r $ left )\n", "beat 60\n"])
def test_of_many_wrong_lines_the_first_are_marked_and_the_others_counted(line: str) -> None:
    analysis = analyze("".join(line.format(number) for number in range(MAX_SHOWN + 100)))
    assert len(analysis.diagnostics) == MAX_SHOWN + 1
    assert "more lines have problems that aren't marked yet" in analysis.diagnostics[-1].message
    assert not analysis.ok


def test_hints_that_are_not_marked_do_not_keep_a_program_from_playing() -> None:
    unused = "".join(f"name{number} = left\n" for number in range(2_000))
    analysis = analyze(f"{unused}r $ left\n")
    assert [each.message for each in analysis.diagnostics if each.code == "more-hints"] == [
        "fix what is marked first: 1,500 more lines have hints that aren't marked yet"
    ]
    assert analysis.ok
    wrong = analyze(f"{unused}r $ oops\n")
    assert not wrong.ok
    assert wrong.diagnostics[-1].code == "unknown-name"


def test_errors_that_are_not_marked_still_keep_a_program_from_playing() -> None:
    shown = "r $ fast 1000 forward\n" * MAX_SHOWN  # too short for a command: a warning
    lengths = "".join(f"r $ fast {10**28 + number} forward\n" for number in range(60))
    analysis = analyze(shown + lengths)
    assert {each.code for each in analysis.diagnostics} == {"too-short", "more-errors"}
    assert not analysis.ok


def test_values_of_an_improv_toml_are_counted_too(tmp_path: Path) -> None:
    (tmp_path / "improv.toml").write_text("".join(f"wrong{number} = 1\n" for number in range(2_000)))
    robots = robots_near(tmp_path)
    assert len(robots.diagnostics) == MAX_SHOWN + 1
    assert "1,500 more values are wrong" in robots.diagnostics[-1].message


@pytest.mark.parametrize("text", ["", "\n"])
def test_robots_of_an_empty_improv_toml_are_refused(tmp_path: Path, text: str) -> None:
    """Somebody may just be writing it: without their limits, robots could move too fast."""
    (tmp_path / "improv.toml").write_text(text)
    with pytest.raises(ReadError, match="it is empty: describe robots in it, or delete it"):
        robots_near(tmp_path)
    assert not robots_or_problem(tmp_path).ok


def test_a_program_is_refused_once_after_its_improv_toml_is_gone(tmp_path: Path) -> None:
    inner, program, other = tmp_path / "inner", tmp_path / "inner" / "dance.improv", tmp_path / "dance.improv"
    inner.mkdir()
    for file in (above := tmp_path / "improv.toml", near := inner / "improv.toml"):
        file.write_text("[robots.r]\n")
    played = PlayedRobots()

    def refused(path: Path) -> bool:
        try:
            played.check(path, robots_near(path.parent))
        except ReadError as error:
            return "is gone: save again to play without its limits" in str(error)
        return False

    assert [refused(program), refused(other)] == [False, False]
    near.unlink()
    assert [refused(other), refused(program), refused(program)] == [False, True, False], "the one above has the robots"
    near.write_text("[robots.s]\n")
    assert not refused(program)
    above.unlink()
    assert [refused(program), refused(other), refused(other)] == [False, True, False]
