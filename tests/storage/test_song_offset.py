"""The position of beat 0 in the song, written into improv.toml."""

from __future__ import annotations

from pathlib import Path

import pytest

from improv_core.robots.edits import set_first_beat
from improv_core.storage.song_offset import write_first_beat


@pytest.mark.parametrize(
    ("before", "after"),
    [
        ('[music]\nfile = "a.mp3"\n', '[music]\nfile = "a.mp3"\nfirst_beat = 0.35\n'),
        ('[music]\nfirst_beat = 7 # here\nfile = "a.mp3"\n', '[music]\nfirst_beat = 0.35 # here\nfile = "a.mp3"\n'),
        ('[music]\r\nfile = "a.mp3"\r\n', '[music]\r\nfile = "a.mp3"\r\nfirst_beat = 0.35\r\n'),
        ("[music]\n\n[ros]\nnode = 'a'\n", "[music]\nfirst_beat = 0.35\n\n[ros]\nnode = 'a'\n"),
        ("[ros]\nnode = 'a'\n", None),
        ("[music\n", None),
        ("music = 1\n", None),
    ],
)
def test_first_beat_is_written_and_the_rest_stays(before: str, after: str | None) -> None:
    assert set_first_beat(before, 0.35) == after


def check(folder: Path, before: str | None, after: str | None, problem: str) -> None:
    """Compare the file after the write, and the message to people."""
    path = folder / "improv.toml"
    if before is not None:
        path.write_bytes(before.encode())
    assert write_first_beat(folder, -0.12345) == problem
    assert (path.read_bytes().decode() if path.exists() else None) == after


def test_the_file_is_replaced(tmp_path: Path) -> None:
    check(tmp_path, '[music]\nfile = "a.mp3"\n', '[music]\nfile = "a.mp3"\nfirst_beat = -0.123\n', "")


def test_an_unwritable_file_stays_and_one_line_says_what_to_do(tmp_path: Path) -> None:
    by_hand = "write `first_beat = -0.123` into it yourself"
    check(tmp_path, None, None, f"there is no improv.toml: {by_hand}")
    without = f"improv.toml has no section [music] that can be changed: {by_hand}"
    check(tmp_path, "[world]\n", "[world]\n", without)
    (tmp_path / "improv.toml").write_bytes(b"\xff")
    assert write_first_beat(tmp_path, -0.12345) == f"improv.toml: it can't be read: {by_hand}"
