"""`improv check`, run as people run it."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from tests.commands.command_line import SQUARE, run, shown_in_terminal, written


def test_check_shows_the_place_of_each_error(broken: Path) -> None:
    done = run("check", SQUARE, broken)
    assert done.returncode == 1
    assert done.stdout.splitlines() == [
        f"{broken}:2:5: error[unclosed-bracket] close this bracket with `)`",
        "    r $ (forward 😀 foward",
        "        ^",
        f"{broken}:2:16: error[unknown-name] `foward` is not defined: did you mean `forward`?",
        "    r $ (forward 😀 foward",
        "                    ^^^^^^",
    ]
    assert done.stderr == ""


def test_check_says_in_a_terminal_that_there_are_no_errors(tmp_path: Path) -> None:
    for name in ("a", "b"):
        (tmp_path / f"{name}.improv").write_text("r $ left\n")
    assert shown_in_terminal("check", tmp_path) == "no errors in 2 programs\n"
    assert run("check", tmp_path).stdout == ""


def test_check_as_json_counts_from_0_in_code_points(broken: Path) -> None:
    done = run("check", "--format", "json", broken)
    (line,) = map(json.loads, done.stdout.splitlines())
    assert line["file"] == str(broken)
    assert line["ok"] is False
    assert line["diagnostics"][1]["range"] == {
        "start": {"line": 1, "character": 15},
        "end": {"line": 1, "character": 21},
    }


def test_unreadable_files_are_named_and_the_others_checked(broken: Path, tmp_path: Path) -> None:
    latin = tmp_path / "latin.improv"
    latin.write_bytes(b"# caf\xe9\n")
    done = run("check", tmp_path / "none.improv", latin, broken)
    assert done.returncode == 2
    assert len(done.stdout.splitlines()) == 2 * 3
    assert done.stderr.splitlines() == [
        f"improv: {tmp_path / 'none.improv'}: no such file or directory",
        f"improv: {latin}: it is not UTF-8 text",
    ]


MEETING = "ada at 0 0\nbo at 1 -1 facing 90\nada $ forward\nbo $ forward\n"


def test_check_shows_meetings_and_its_last_beat(tmp_path: Path) -> None:
    program = written(tmp_path, MEETING, "meeting.improv")
    done = run("check", program, SQUARE)
    assert done.returncode == 0
    message = "`ada` and `bo` meet at beat 1.29, as near as 0 m: keep them 0.6 m apart"
    assert done.stdout.splitlines() == [
        f"{program}:4:6: warning[meets] {message}",
        "    bo $ forward",
        "         ^^^^^^^",
    ]
    end = "after which everything has ended or repeats"
    assert done.stderr == f"{program}: meetings and hits are checked to the end of beat 1, {end}\n"
    (annotation,) = run("check", "--format", "github", program).stdout.splitlines()
    assert annotation.startswith("::warning title=meets,file=")


def test_check_as_json_has_its_last_beat(tmp_path: Path) -> None:
    program = written(tmp_path, "ada bo $ repeat forward\n", "drift.improv")
    line = json.loads(run("check", "--format", "json", program).stdout)
    assert line["checked"] == {"beat": 1000, "all": False, "assumes": False}
    assert "checked" not in json.loads(run("check", "--format", "json", SQUARE).stdout)


def test_check_and_plot_show_what_robots_do_where_they_sense_walls(tmp_path: Path) -> None:
    program = written(tmp_path, "room 6 4\nr $ repeat 3 (until near (repeat forward) left)\n", "walk.improv")
    done = run("check", program)
    end = "after which everything has ended or repeats, with what robots sense in the simulator"
    assert (done.stdout, done.stderr) == (
        "",
        f"{program}: no robot meets or hits anything: checked to the end of beat 6, {end}\n",
    )
    assert run("plot", program, "-o", tmp_path / "walk.svg").returncode == 0
    assert "stroke-dasharray" not in (tmp_path / "walk.svg").read_text(), "nothing is assumed"


ROBOTS = "[robots.r]\ntopic = 1\n"


@pytest.fixture
def project(tmp_path: Path) -> Path:
    """Two programs with an error each, and one in their `improv.toml`."""
    (tmp_path / "100%" / ".hidden").mkdir(parents=True)
    (tmp_path / "improv.toml").write_text(ROBOTS)
    (tmp_path / "b.improv").write_text("r $ lft\n")
    (tmp_path / "notes.txt").write_text("r $ lft\n")
    (tmp_path / "100%" / "a,b.improv").write_text("d = left (\nr $ d ()\n")
    (tmp_path / "100%" / ".hidden" / "c.improv").write_text("r $ lft\n")
    return tmp_path


def test_check_takes_folders_and_reports_the_robots_of_several_programs_once(project: Path) -> None:
    done = run("check", ".", "b.improv", folder=project)
    assert [line for line in done.stdout.splitlines() if not line.startswith("    ")] == [
        "b.improv:1:5: error[unknown-name] `lft` is not defined: did you mean `left`?",
        f"{project}/improv.toml:2:9: error[robots] write `topic` as text, in quotes",
        "100%/a,b.improv:1:10: error[unclosed-bracket] close this bracket with `)`",
        "100%/a,b.improv:2:7: warning[empty-group] `()` is empty: write a movement in it or remove it",
    ]
    assert (done.returncode, done.stderr) == (1, "")


def test_a_folder_without_programs_is_no_success(project: Path) -> None:
    (project / "improv.toml").unlink()
    (project / "empty").mkdir()
    for command in ("check", "compile", "format"):
        done = run(command, "empty", folder=project)
        assert (done.returncode, done.stdout) == (2, "")
        assert done.stderr.startswith("improv: empty: it has no files that end in .improv")


def test_an_improv_toml_is_checked_as_such_and_nothing_else_takes_it_for_a_program(project: Path) -> None:
    done = run("check", "improv.toml", folder=project)
    assert (done.returncode, done.stdout.splitlines()[0]) == (
        1,
        "improv.toml:2:9: error[robots] write `topic` as text, in quotes",
    )
    (project / "improv.toml").write_text("[robots.r]\n")
    done = run("check", "--format", "json", "improv.toml", folder=project)
    assert (done.returncode, json.loads(done.stdout)) == (0, {"file": "improv.toml", "ok": True, "diagnostics": []})
    for command in (["plot", "-o", "x.svg"], ["watch"], ["compile"], ["play"], ["edit"]):
        done = run(*command, "improv.toml", folder=project)
        assert (done.returncode, done.stdout) == (2, "")
        assert done.stderr == "improv: improv.toml: it describes robots: name a program instead, such as dance.improv\n"


def test_a_folder_is_checked_with_its_improv_toml(project: Path) -> None:
    (project / "only").mkdir()
    (project / "only" / "improv.toml").write_text("oops")
    assert "only/improv.toml:1:5: error[syntax]" in run("check", ".", folder=project).stdout
    assert run("check", "only", folder=project).returncode == 1


def test_check_for_github_annotates_the_lines_of_a_pull_request(project: Path) -> None:
    done = run("check", "--format", "github", project, folder=project)
    assert done.stdout.splitlines() == [
        "::error title=unknown-name,file=b.improv,line=1,endLine=1,col=5,endColumn=8"
        "::b.improv:1:5: error[unknown-name] `lft` is not defined: did you mean `left`?",
        "::error title=robots,file=improv.toml,line=2,endLine=2,col=9,endColumn=10"
        "::improv.toml:2:9: error[robots] write `topic` as text, in quotes",
        "::error title=unclosed-bracket,file=100%25/a%2Cb.improv,line=1,endLine=1,col=10,endColumn=11"
        "::100%25/a,b.improv:1:10: error[unclosed-bracket] close this bracket with `)`",
        "::warning title=empty-group,file=100%25/a%2Cb.improv,line=2,endLine=2,col=7,endColumn=9"
        "::100%25/a,b.improv:2:7: warning[empty-group] `()` is empty: write a movement in it or remove it",
    ]
    assert done.returncode == 1


def test_a_program_from_standard_input_is_for_the_robots_of_the_folder(project: Path) -> None:
    done = run("check", "-", text="\ufeffr $ lft 😀\n", folder=project)
    assert done.stdout.splitlines()[0].startswith("-:1:5: error[unknown-name] ")
    assert f"{project}/improv.toml:2:9: error[robots] " in done.stdout
    assert run("check", "-", text="r $ left\n", folder=project.parent).stdout == ""
