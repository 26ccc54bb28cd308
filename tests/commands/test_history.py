"""`improv history`."""

from __future__ import annotations

import shutil
from datetime import datetime, timedelta, timezone
from pathlib import Path

from improv_core.storage.history import keep
from tests.commands.command_line import SIMULATED, Ended, run

NOON = datetime(2026, 11, 22, 12, tzinfo=timezone.utc)


def history(*arguments: str) -> Ended:
    return run("history", *arguments)


def test_programs_are_listed_printed_and_played_again(tmp_path: Path, state: Path) -> None:
    assert history().stdout == "nothing has played yet\n"
    folder, texts = tmp_path / "folder", ["beat 600\r\nr $ forward\r\n", "beat 600\nr q $ left\n"]
    folder.mkdir()
    for second, text in enumerate(texts):
        keep(str(folder / "dance.improv"), text, NOON + timedelta(seconds=second))
    assert [line.split(maxsplit=3) for line in history().stdout.splitlines()] == [
        ["2", "2026-11-22", f"{NOON.astimezone():%H:%M}:00", "folder/dance.improv  r $ forward"],
        ["1", "2026-11-22", f"{NOON.astimezone():%H:%M}:01", "folder/dance.improv  r q $ left"],
    ]
    assert [history(number).stdout for number in "21"] == texts

    (folder / "improv.toml").write_text('[robots.r]\nprofile = "turtlebot3_burger"\n')
    again = run("history", "play", "2", *SIMULATED)
    assert again.returncode == 0
    assert "limit of 0.22 m/s" in again.stderr  # as the current improv.toml beside its file sets it
    assert "▶ r 1 beat, 0.10 s at beat 600, simulator" in again.stdout
    assert history("1").stdout == texts[0]

    shutil.rmtree(folder)
    gone = history("play", "2")
    assert (gone.returncode, gone.stderr[: len(f"improv: {folder} is gone")]) == (2, f"improv: {folder} is gone")


def test_a_missing_program_is_one_line(tmp_path: Path, state: Path) -> None:
    state.mkdir(parents=True)
    (state / "1.improv").write_text("damaged")
    damaged = history()
    assert (damaged.returncode, damaged.stdout) == (0, "")
    assert damaged.stderr.startswith("improv: 1 file of the history can't be read and was left out: look at it in ")
    for arguments in (("1",), ("play", "1")):
        done = history(*arguments)
        assert (done.returncode, done.stdout, done.stderr.count("\n")) == (2, "", 1)
