"""`improv watch`: plays at every save, however an editor saves."""

from __future__ import annotations

import asyncio
import json
import queue
import subprocess
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import aiohttp
import pytest

from tests.commands.command_line import IMPROV, LIMIT
from tests.page import live_behind
from tests.strange_files import StrangeFile

PIECE, LONG = 0.03, 0.7
"""Seconds between two pieces of a file that is written slowly; and longer than any look at a file takes to come."""


class Watch:
    """A running `improv watch`, and the lines it prints."""

    def __init__(self, path: Path, *options: str) -> None:
        command = [*IMPROV, "watch", str(path), "--backend", "sim", "--no-browser", *options]
        self._process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
        self._lines: queue.SimpleQueue[str] = queue.SimpleQueue()
        threading.Thread(target=self._read, daemon=True).start()

    def wait(self, part: str) -> str:
        """The next line with `part` in it."""
        while part not in (line := self.next()):
            pass
        return line

    def next(self) -> str:
        """The next line."""
        return self._lines.get(timeout=LIMIT)

    def says_nothing(self, seconds: float) -> None:
        with pytest.raises(queue.Empty):
            self._lines.get(timeout=seconds)

    def close(self) -> None:
        self._process.terminate()
        assert self._process.wait(LIMIT) == 130

    def _read(self) -> None:
        assert self._process.stdout
        for line in self._process.stdout:
            self._lines.put(line)


@pytest.fixture
def program(tmp_path: Path) -> Path:
    path = tmp_path / "folder" / "dance.improv"
    path.parent.mkdir()
    path.write_text("r $ repeat forward\n")
    return path


@contextmanager
def watching(program: Path, *options: str) -> Iterator[Watch]:
    watch = Watch(program, *options)
    yield watch
    watch.close()


@pytest.fixture
def watch(program: Path) -> Iterator[Watch]:
    with watching(program) as watch:
        watch.wait("▶ r ∞")
        yield watch


def test_written_in_place(watch: Watch, program: Path) -> None:
    program.write_text("r $ left\n")
    watch.wait("▶ r 1 beat")


def test_replaced_by_rename(watch: Watch, program: Path) -> None:
    for beats in ("2", "3"):
        new = program.with_suffix(".new")
        new.write_text(f"r $ repeat {beats} left\n")
        new.rename(program)
        watch.wait(f"▶ r {beats} beats")


def test_emptied_and_then_written(watch: Watch, program: Path) -> None:
    with program.open("w") as file:
        watch.says_nothing(LONG)
        file.write("r $ left\n")
    assert watch.next() == "▶ r 1 beat, 1.0 s at beat 60, simulator\n"


def test_written_in_pieces_that_would_be_programs(watch: Watch, program: Path) -> None:
    whole = "r $ left left # ça va\n".encode()
    with program.open("wb", buffering=0) as file:
        for piece in (b"r $ le", b"ft", b" left", b" # \xc3"):
            file.write(piece)
            watch.says_nothing(PIECE)
        file.write(whole[file.tell() :])
    assert "▶ r 2 beats" in watch.next()


def test_what_is_not_text_is_waited_out(watch: Watch, program: Path) -> None:
    program.write_bytes(b"r $ left # \xc3\n")
    watch.says_nothing(LONG)
    program.write_text("r $ left left\n")
    assert "▶ r 2 beats" in watch.next()


def test_deleted_and_made_again(watch: Watch, program: Path) -> None:
    program.unlink()
    watch.says_nothing(LONG)
    program.write_text("r $ left\n")
    assert "▶ r 1 beat" in watch.next()


def test_its_folder_is_renamed_and_another_takes_its_place(watch: Watch, program: Path) -> None:
    folder = program.parent
    folder.rename(folder.with_name("old"))
    watch.says_nothing(LONG)
    (folder.with_name("old") / program.name).write_text("r $ left left left\n")  # no longer the file that is watched
    watch.says_nothing(LONG)
    folder.mkdir()
    for beats in (1, 2):
        program.write_text(f"r $ repeat {beats} left\n")
        assert f"▶ r {beats} beat" in watch.next()


def test_its_folder_is_deleted_and_made_again(watch: Watch, program: Path) -> None:
    program.unlink()
    program.parent.rmdir()
    watch.says_nothing(LONG)
    program.parent.mkdir()
    program.write_text("r $ left\n")
    assert "▶ r 1 beat" in watch.next()


def test_a_save_that_changes_nothing_plays_anew(watch: Watch, program: Path) -> None:
    for _ in range(2):
        program.write_text(program.read_text())
        assert watch.wait("▶").startswith("▶ r ")


def test_a_wrong_save_is_told_as_check_tells_it(watch: Watch, program: Path) -> None:
    program.write_text("r $ lft\n")
    assert watch.wait("error").endswith(":1:5: error[unknown-name] `lft` is not defined: did you mean `left`?\n")
    assert watch.next() == "✗ the previous dance keeps playing\n"
    program.write_text("r $ left left\n")
    watch.wait("▶ r 2 beats")


def test_what_is_empty_or_can_not_be_read_for_long_is_told(tmp_path: Path) -> None:
    """All three wait at the same time: each waits for long."""
    broken, gone, empty = (tmp_path / name / "dance.improv" for name in ("broken", "gone", "empty"))
    for path in (broken, gone, empty):
        path.parent.mkdir()
        path.write_text("r $ repeat forward\n")
    with watching(broken) as of_broken, watching(gone) as of_gone, watching(empty) as of_empty:
        for watch in (of_broken, of_gone, of_empty):
            watch.wait("▶ r ∞")
        broken.write_bytes(b"r $ left # \xc3\n")
        gone.unlink()
        empty.write_text("")
        assert of_broken.next() == f"improv: {broken}: it is not UTF-8 text\n"
        assert of_gone.next() == f"improv: {gone}: no such file or directory\n"
        for watch in (of_broken, of_gone):
            assert watch.next() == "✗ the previous dance keeps playing\n"
        assert of_empty.next() == "▶ no robot plays, simulator\n"


def test_a_save_of_the_robots_plays_anew(watch: Watch, program: Path) -> None:
    robots = program.with_name("improv.toml")
    robots.write_text("[robots.s]\n")
    watch.wait("`r` is not in improv.toml")
    assert watch.next() == "✗ the previous dance keeps playing\n"
    robots.write_text("[robots.r]\n")
    watch.wait("▶ r ∞")


def test_wrong_from_the_beginning(program: Path) -> None:
    program.write_text("r $ lft\n")
    with watching(program) as watch:
        watch.wait("`lft` is not defined")
        assert watch.next() == "✗ nothing is playing: fix the program and save\n"


def test_saved_only_later(program: Path) -> None:
    program.unlink()
    with watching(program) as watch:
        watch.wait("waiting for dance.improv: save it to play it")
        program.write_text("r $ left\n")
        watch.wait("▶ r 1 beat")


def test_robots_of_a_file_that_can_not_be_read_do_not_move(watch: Watch, program: Path) -> None:
    robots = program.with_name("improv.toml")
    robots.write_bytes(b"# \xff\n")
    watch.wait(f"improv: {robots}: it is not UTF-8 text")
    assert watch.next() == "✗ the previous dance keeps playing\n"


@pytest.mark.parametrize("kind", ["pipe", "terabyte"])
def test_a_strange_improv_toml_stops_new_dances_only(watch: Watch, program: Path, kind: str) -> None:
    strange_file = StrangeFile(program.parent, kind)
    robots = strange_file.make("improv.toml")
    program.write_text("r $ left\n")
    assert watch.next().startswith(f"improv: {robots}: {strange_file.problem}")
    assert watch.next() == "✗ the previous dance keeps playing\n"


@pytest.mark.parametrize(("options", "begins"), [([], None), (["--continue"], {"s"})])
def test_a_save_edits_what_plays_if_it_is_to(program: Path, options: list[str], begins: set[str] | None) -> None:
    program.write_text("beat 240\nr $ repeat (forward left)\ns $ repeat forward\n")
    with watching(program, *options) as watch:
        address = live_behind(watch.wait("watch it at").split()[-1])
        watch.wait("▶ r")
        program.write_text("beat 240\nr $ repeat (forward left)\ns $ repeat left\n")
        watch.wait("▶ r")
        told = asyncio.run(transport(address, generation=2))
        assert told.get("begins", {}).keys() == (begins or set())
        assert told["restarted"] == (1 if begins else 2)


async def transport(address: str, generation: int) -> dict[str, Any]:
    """The message that tells the page that a score of this generation plays."""
    async with (
        aiohttp.ClientSession() as session,
        session.ws_connect(address, origin=address.split("/live")[0]) as page,
    ):
        async for message in page:
            told: dict[str, Any] = json.loads(message.data)
            if told["type"] == "transport" and told["generation"] == generation:
                return told
    raise AssertionError("the page was closed")
