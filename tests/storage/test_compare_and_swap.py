"""A file is replaced only while it holds the text that was read; texts that other programs write meanwhile are never
lost."""

from __future__ import annotations

import asyncio
import os
import random
import subprocess
import sys
import threading
from collections.abc import Callable
from pathlib import Path

import pytest

from improv_core.commands.answers import TypedAnswers
from improv_core.commands.calibrate import offer
from improv_core.commands.exit_codes import CommandError
from improv_core.commands.format import format_files
from improv_core.program.files import robots_near
from improv_core.storage import compare_and_swap
from improv_core.storage.compare_and_swap import swap
from improv_core.storage.history import VARIABLE, read
from improv_core.storage.program_file import Version, WriteError, read_version, write_text
from improv_core.storage.song_offset import write_first_beat

LIMIT = 60.0
linux = pytest.mark.skipif(sys.platform != "linux", reason="only Linux exchanges two files in one step")


def in_place(path: Path, text: bytes) -> None:
    path.write_bytes(text)


def renamed(path: Path, text: bytes) -> None:
    new = path.with_name("theirs")
    new.write_bytes(text)
    new.replace(path)


def before_exchanges(
    monkeypatch: pytest.MonkeyPatch, path: Path, *texts: bytes, write: Callable[[Path, bytes], None] = in_place
) -> None:
    """Have another program write one of these texts into the file just before each exchange."""
    exchange, theirs = compare_and_swap._exchange, iter(texts)

    def slow(one: Path, other: Path) -> bool:
        if text := next(theirs, None):
            write(path, text)
        return exchange(one, other)

    monkeypatch.setattr(compare_and_swap, "_exchange", slow)


@linux
@pytest.mark.parametrize("write", [in_place, renamed])
def test_a_text_written_just_before_the_exchange_is_put_back(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, write: Callable[[Path, bytes], None]
) -> None:
    path, others = tmp_path / "dance.improv", list[bytes]()
    path.write_bytes(b"before")
    before_exchanges(monkeypatch, path, b"theirs", b"theirs, later", write=write)
    assert not swap(path, b"before", b"mine", others.append)
    assert (path.read_bytes(), others) == (b"theirs, later", [b"theirs"])
    assert [each.name for each in tmp_path.iterdir()] == ["dance.improv"]
    assert swap(path, b"theirs, later", b"mine", others.append)
    assert path.read_bytes() == b"mine"


@linux
@pytest.mark.parametrize(
    ("history", "theirs", "beside"),
    [("on", b"theirs", []), ("off", b"theirs", [b"theirs"]), ("on", b"theirs \xff", [b"theirs \xff"])],
)
def test_of_two_texts_written_while_the_page_saves_the_earlier_is_kept_in_the_history_or_beside_the_file(
    tmp_path: Path, state: Path, monkeypatch: pytest.MonkeyPatch, history: str, theirs: bytes, beside: list[bytes]
) -> None:
    monkeypatch.setenv(VARIABLE, history)
    path = tmp_path / "dances" / "dance.improv"
    path.parent.mkdir()
    path.write_text("before")
    before_exchanges(monkeypatch, path, theirs, b"theirs, later")
    with pytest.raises(WriteError, match="another program has changed it"):
        write_text(path, "mine", read_version(path).revision)
    assert path.read_bytes() == b"theirs, later"
    assert [each.read_bytes() for each in path.parent.glob("dance.kept-*.improv")] == beside
    assert [each.text for each in read().programs] == ([] if beside else ["theirs"])


@linux
def test_a_program_that_still_writes_gets_its_file_back(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(compare_and_swap, "WRITER_LIMIT", 0.05)
    path, others = tmp_path / "dance.improv", list[bytes]()
    path.write_bytes(b"before")
    with path.open("ab") as file:
        assert not swap(path, b"before", b"mine", others.append)
        file.write(b" and more")
    assert path.read_bytes() == b"before and more"
    with path.open("rb"):  # a reader disturbs nobody
        assert swap(path, b"before and more", b"mine", others.append)
    assert others == []


def test_a_file_that_appears_is_not_overwritten(tmp_path: Path) -> None:
    path = tmp_path / "dance.improv"
    assert swap(path, None, b"one", list[bytes]().append)
    assert not swap(path, None, b"two", list[bytes]().append)
    assert path.read_bytes() == b"one"
    path.unlink()
    assert swap(path, b"one", b"two", list[bytes]().append)  # it is gone: there is nothing to lose
    assert path.read_bytes() == b"two"


def test_without_an_exchange_the_file_is_read_again(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(compare_and_swap, "_exchange", lambda one, other: False)
    path = tmp_path / "dance.improv"
    path.write_bytes(b"theirs")
    assert not swap(path, b"before", b"mine", list[bytes]().append)
    assert swap(path, b"theirs", b"mine", list[bytes]().append)
    assert path.read_bytes() == b"mine"


ADVERSARY = """
import os, sys, time
path, way, delay, text = sys.argv[1], sys.argv[2], float(sys.argv[3]), sys.argv[4].encode()
print("ready", flush=True)
sys.stdin.readline()
time.sleep(delay)
if way == "in place":
    with open(path, "wb") as file:
        file.write(text)
else:
    with open(path + ".new", "wb") as file:
        file.write(text)
    os.replace(path + ".new", path)
"""


def page_saves(path: Path) -> bool:
    try:
        write_text(path, "mine\n", Version(UNTIDY.encode()).revision)
    except WriteError:
        return False
    return True


def formatted(path: Path) -> bool:
    return format_files([path], check=False, diff=False) == 0


def song_begins(path: Path) -> bool:
    return not write_first_beat(path.parent, 0.5)


def robot_is_calibrated(path: Path) -> bool:
    answers = TypedAnswers(lambda line: None)
    try:
        asyncio.run(offer(robots_near(path.parent), "anna", {"commanded_step": 2.1}, answers, write=True))
    except CommandError:
        return False
    return True


UNTIDY = "r$( left  right )\n"
SONG = "{}[music]\nfile = 'song.mp3'\n[robots.anna]\n"
COMMANDS = [
    (page_saves, "dance.improv", UNTIDY),
    (formatted, "dance.improv", UNTIDY),
    (formatted, "dances.md", f"```improv\n{UNTIDY}```\n"),
    (song_begins, "improv.toml", SONG.format("")),
    (robot_is_calibrated, "improv.toml", SONG.format("")),
]
every_command = pytest.mark.parametrize(("command", "name", "before"), COMMANDS)


@linux
@every_command
def test_a_save_at_the_last_moment_stays_for_every_writer(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, command: Callable[[Path], bool], name: str, before: str
) -> None:
    path = tmp_path / name
    path.write_text(before)
    before_exchanges(monkeypatch, path, b"# theirs\n")
    assert not command(path)
    assert path.read_bytes() == b"# theirs\n"


@every_command
def test_every_writer_refuses_a_file_with_several_names(
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
    command: Callable[[Path], bool],
    name: str,
    before: str,
) -> None:
    path, other = tmp_path / name, tmp_path / "other"
    path.write_text(before)
    other.hardlink_to(path)
    assert not command(path)
    assert other.read_text() == path.read_text() == before
    other.unlink()
    assert command(path)
    assert path.read_text() != before


@linux
@pytest.mark.parametrize("history", ["on", "off"])
@every_command
def test_no_text_of_an_adversary_is_lost(
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    history: str,
    command: Callable[[Path], bool],
    name: str,
    before: str,
) -> None:
    """Run with IMPROV_TRIALS=150 for the figure in docs/security.md."""
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path / "state"))
    monkeypatch.setenv("IMPROV_HISTORY", history)
    path, dice, lost = tmp_path / name, random.Random(1), 0
    for trial in range(int(os.environ.get("IMPROV_TRIALS", "2"))):
        path.write_text(before)
        theirs = f"theirs {trial}\n"
        way = ("in place", "renamed")[trial % 2]
        argv = [sys.executable, "-c", ADVERSARY, str(path), way, str(dice.uniform(0, 0.004)), theirs]
        with subprocess.Popen(argv, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True) as adversary:
            assert adversary.stdin
            assert adversary.stdout
            adversary.stdout.readline()
            adversary.stdin.write("\n")
            adversary.stdin.flush()
            command(path)
        lost += not any(theirs in found.read_text() for found in tmp_path.rglob("*") if found.is_file())
    assert lost == 0
    assert not [*tmp_path.glob(".*")]


@linux
def test_a_killed_save_leaves_nothing_hidden_and_loses_nothing(
    tmp_path: Path, state: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = tmp_path / "dance.improv"
    path.write_bytes(b"before")
    with subprocess.Popen([sys.executable, "-c", KILLED, path], stdout=subprocess.PIPE) as process:
        assert process.stdout
        assert process.stdout.readline() == b"exchanged\n"
        process.kill()
    assert path.read_bytes() == b"mine"
    assert swap(path, b"mine", b"mine, later")
    assert [each.name for each in tmp_path.iterdir() if each.is_file()] == ["dance.improv"]
    assert [each.text for each in read().programs] == ["before"]


KILLED = """
import sys, time
from pathlib import Path
from improv_core.storage import compare_and_swap
def halted(path):
    print("exchanged", flush=True)
    time.sleep(1000)
compare_and_swap._last = halted
compare_and_swap.swap(Path(sys.argv[1]), b"before", b"mine")
"""


@linux
def test_two_of_ours_never_both_replace_one_version(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(compare_and_swap, "WRITER_LIMIT", LIMIT)
    path, done = tmp_path / "dance.improv", list[str]()
    path.write_text("before\n")
    revision = read_version(path).revision

    def write(text: str) -> None:
        try:
            write_text(path, text, revision)
        except WriteError:
            return
        done.append(text)

    threads = [threading.Thread(target=write, args=(f"mine {number}\n",)) for number in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert [path.read_text()] == done
