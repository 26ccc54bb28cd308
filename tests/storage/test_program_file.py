"""Saves on the page into a file: text that somebody wrote is never lost, and its layout stays."""

from __future__ import annotations

import stat
from pathlib import Path

import pytest

from improv_core.program.files import ReadError
from improv_core.protocol.fields import LONGEST_TEXT
from improv_core.storage.program_file import TEMPLATE, Version, WriteError, create, read_version, write_text


@pytest.mark.parametrize(
    ("before", "text", "after"),
    [
        ("a\nb\n", "a\nc\n", "a\nc\n"),
        ("a\r\nb\r\n", "a\nc\nd\n", "a\r\nc\r\nd\r\n"),
        ("a\rb", "a\nb\nc", "a\rb\rc"),
        ("a\r\nb\nc\r\nd\r\n", "a\nb\nx\nc\nd\n", "a\r\nb\nx\r\nc\r\nd\r\n"),  # mixed: lines keep theirs
        ("a\rb\nc\nd", "a\n\nc\nd", "a\n\nc\nd"),  # \r and \n must not become one end
        ("", "a\nb", "a\nb"),
        ("a\r\n", "", ""),
        ("\ufeffé\r\n", "é🤖\n", "\ufeffé🤖\r\n"),
    ],
)
def test_line_ends_and_a_byte_order_mark_are_kept(before: str, text: str, after: str) -> None:
    edited = Version(before.encode()).edited(text)
    assert edited == Version(after.encode())
    assert edited.text == text


def test_a_file_keeps_its_permissions_and_stays_a_link(tmp_path: Path) -> None:
    file, link = tmp_path / "dance.improv", tmp_path / "link.improv"
    file.write_bytes(b"r $ left\r\n")
    file.chmod(0o640)
    link.symlink_to(file)
    version = write_text(link, "r $ right\n", read_version(link).revision)
    assert link.is_symlink()
    assert (file.read_bytes(), stat.S_IMODE(file.stat().st_mode)) == (b"r $ right\r\n", 0o640)
    assert version == read_version(file)


def test_another_programs_edit_is_not_overwritten(tmp_path: Path) -> None:
    file = tmp_path / "dance.improv"
    file.write_text("r $ left\n")
    revision = read_version(file).revision
    file.write_text("r $ right\n")
    with pytest.raises(WriteError, match=r"^dance\.improv: another program has changed it$"):
        write_text(file, "r $ forward\n", revision)
    assert file.read_text() == "r $ right\n"
    assert write_text(file, "r $ right\n", revision) == read_version(file)  # both wrote the same
    file.unlink()
    write_text(file, "r $ forward\n", revision)  # there is nothing to lose
    assert file.read_text() == "r $ forward\n"


@pytest.mark.parametrize(
    ("content", "problem"),
    [(b"r $ left # \xff\n", "it is not UTF-8 text"), (b"#" * (LONGEST_TEXT + 1), "it is too long for the page")],
)
def test_an_uneditable_file_is_neither_read_nor_overwritten(tmp_path: Path, content: bytes, problem: str) -> None:
    file = tmp_path / "dance.improv"
    file.write_bytes(content)
    with pytest.raises(ReadError, match=problem):
        read_version(file)
    with pytest.raises(WriteError, match=problem):
        write_text(file, "r $ left\n", "")
    assert file.read_bytes() == content


def test_only_a_file_is_written(tmp_path: Path) -> None:
    with pytest.raises(WriteError, match="a folder or another special file has that name"):
        write_text(tmp_path, "r $ left\n", "")


def test_a_new_program_gets_the_first_free_name(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    assert [create(), create(), create(Path("mine.improv"))] == [
        *map(Path, ("dance.improv", "dance-2.improv", "mine.improv"))
    ]
    assert Path("dance-2.improv").read_text() == TEMPLATE
    with pytest.raises(WriteError, match=r"^mine\.improv: it exists already"):
        create(Path("mine.improv"))
    with pytest.raises(WriteError, match="no such file or directory"):
        create(Path("none", "dance.improv"))
