"""`improv format`, run as people run it."""

from __future__ import annotations

from pathlib import Path

import pytest

from improv_core.commands.format import format_files
from tests.commands.command_line import run, written

ROOT = Path(__file__).parents[2]
UNTIDY, TIDY = "r$( left  right )\n", "r $ (left right)\n"


@pytest.fixture
def untidy(tmp_path: Path) -> Path:
    return written(tmp_path, UNTIDY)


def contents(folder: Path) -> dict[str, bytes]:
    return {path.name: path.read_bytes() for path in folder.iterdir() if path.is_file()}


def test_format_rewrites_only_unformatted_files(untidy: Path, tmp_path: Path) -> None:
    tidy = written(tmp_path, TIDY, "tidy.improv")
    untouched = tidy.stat()
    done = run("format", untidy, tidy)
    assert (done.returncode, done.stdout, done.stderr) == (0, f"formatted {untidy}\n", "")
    assert untidy.read_text() == TIDY
    assert (tidy.stat().st_ino, tidy.stat().st_mtime_ns) == (untouched.st_ino, untouched.st_mtime_ns)
    assert set(contents(tmp_path)) == {"dance.improv", "tidy.improv"}
    assert run("format", untidy, tidy).stdout == ""


def test_check_names_unformatted_files_and_writes_nothing(untidy: Path, tmp_path: Path) -> None:
    before = contents(tmp_path)
    done = run("format", "--check", untidy)
    assert (done.returncode, done.stdout, done.stderr) == (1, f"would format {untidy}\n", "")
    assert contents(tmp_path) == before
    untidy.write_text(TIDY)
    done = run("format", "--check", untidy)
    assert (done.returncode, done.stdout) == (0, "")


def test_diff_shows_changes_and_writes_nothing(untidy: Path, tmp_path: Path) -> None:
    untidy.write_text("beat 60\nx=left")
    before = contents(tmp_path)
    done = run("format", "--diff", untidy)
    assert (done.returncode, done.stderr) == (0, "")
    assert done.stdout.splitlines() == [
        f"--- {untidy}",
        f"+++ {untidy} (formatted)",
        "@@ -1,2 +1,2 @@",
        " beat 60",
        "-x=left",
        "\\ No newline at end of file",
        "+x = left",
    ]
    assert contents(tmp_path) == before
    assert run("format", "--diff", "--check", untidy).returncode == 1


def test_an_unwritable_file_stays_as_it_was(
    untidy: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr("os.access", lambda *_: False)
    assert format_files([untidy], check=False, diff=False) == 2
    assert capsys.readouterr() == ("", f"improv: {untidy}: permission denied\n")
    assert contents(untidy.parent) == {untidy.name: UNTIDY.encode()}


def test_folders_hold_programs_and_pages(untidy: Path, tmp_path: Path) -> None:
    (tmp_path / "deep" / "er").mkdir(parents=True)
    (tmp_path / ".hidden").mkdir()
    page = tmp_path / "deep" / "page.md"
    page.write_text(f"```improv\n{UNTIDY}```\n")
    for other in (tmp_path / "deep" / "er" / "x.improv", tmp_path / "notes.txt", tmp_path / ".hidden" / "x.improv"):
        other.write_text(UNTIDY)
    done = run("format", "--check", tmp_path, untidy)
    named = [untidy, page, tmp_path / "deep" / "er" / "x.improv"]
    assert done.stdout.splitlines() == [f"would format {path}" for path in named]


def test_only_programs_and_pages_are_formatted(untidy: Path, tmp_path: Path) -> None:
    others = [tmp_path / name for name in ("improv.toml", "x.py", "notes.txt")]
    for other in others:
        other.write_text('[a]\n  text = """\n\n  one\n"""\n')
    before = contents(tmp_path)
    done = run("format", *others, untidy)
    assert (done.returncode, done.stdout) == (2, f"formatted {untidy}\n")
    assert done.stderr.splitlines() == [
        f"improv: {other}: it was not changed: only .improv and .md files are formatted" for other in others
    ]
    assert contents(tmp_path) == before | {untidy.name: TIDY.encode()}


def test_an_empty_name_is_not_this_folder(untidy: Path) -> None:
    done = run("format", "", folder=untidy.parent)
    assert (done.returncode, done.stderr.splitlines()[-1]) == (2, "Error: Invalid value for 'FILES...': it is empty.")
    assert untidy.read_text() == UNTIDY


def test_standard_input_is_printed(tmp_path: Path) -> None:
    for text, printed in [(UNTIDY, TIDY), (TIDY, TIDY), ("", "")]:
        done = run("format", "-", text=text)
        assert (done.returncode, done.stdout, done.stderr) == (0, printed, "")
    done = run("format", "-", "--check", text=UNTIDY)
    assert (done.returncode, done.stdout) == (1, "would format -\n")
    assert run("format", "-", "--diff", text=UNTIDY).stdout.splitlines()[-1] == f"+{TIDY.rstrip()}"


PAGE = """\
# A  page ( with  blanks )
```improv
{0}```

1. In a list:

   ```improv
   {1}
   s $ ( not   closed
   ```

```sh
{2}```

````md
```improv
{2}```
````

```improv
"""


def test_only_blocks_of_improv_are_formatted_in_a_page(tmp_path: Path) -> None:
    page = tmp_path / "page.md"
    page.write_text(PAGE.format(UNTIDY, "  x=(a # why\n\n     b\n   )", UNTIDY))
    assert run("format", page).returncode == 0
    assert page.read_text() == PAGE.format(TIDY, "x = (\n     a  # why\n     b\n   )", UNTIDY)


def test_a_block_that_leaves_its_list_stays(tmp_path: Path) -> None:
    page = tmp_path / "page.md"
    page.write_text("- A list\n  ```improv\n  x=(a\nb )\n  ```\n")
    done = run("format", page)
    assert (done.returncode, done.stdout) == (0, "")


def test_examples_and_documents_are_formatted() -> None:
    pages = [ROOT / "README.md", ROOT / "CONTRIBUTING.md", ROOT / "docs"]
    done = run("format", "--check", *sorted((ROOT / "examples").rglob("*.improv")), *pages)
    assert (done.returncode, done.stdout, done.stderr) == (0, "", "")
