"""`improv watch`: plays at every save, in every way that editors save (tests/storage/test_saves has the end of a
save)."""

from __future__ import annotations

import asyncio
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, NoReturn

import pytest

import improv_core.commands.watching
from improv_core.safety.stops import Stops
from improv_core.slices import checkpoint
from tests.commands.command_line import LIMIT, SIMULATED, Running
from tests.open_page import connected, heard, live_behind

KEEPS = "✗ the previous dance keeps playing\n"


@pytest.fixture
def program(tmp_path: Path) -> Path:
    path = tmp_path / "folder" / "dance.improv"
    path.parent.mkdir()
    path.write_text("r $ repeat forward\n")
    return path


@contextmanager
def watching(program: Path, *options: str) -> Iterator[Running]:
    watch = Running("watch", program, *SIMULATED, *options)
    yield watch
    watch.close()


@pytest.fixture
def watch(program: Path) -> Iterator[Running]:
    with watching(program) as watch:
        watch.wait("▶ r ∞")
        yield watch


def test_ctrl_c_stops_robots_at_once_and_ends_while_a_long_program_is_understood(
    program: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    watch = Running("watch", program, *SIMULATED)
    watch.wait("▶ r ∞")
    begun, stopped = threading.Event(), threading.Event()
    monkeypatch.setattr(Stops, "stop", lambda stops: stopped.set())

    def understand(text: str, robots: object) -> NoReturn:
        begun.set()
        assert stopped.wait(LIMIT)  # although this keeps the event loop from seeing the interrupt
        while True:
            checkpoint()

    monkeypatch.setattr(improv_core.commands.watching, "analyze", understand)
    program.write_text("r $ left\n")
    assert begun.wait(LIMIT)
    watch.interrupt()
    assert watch.end() == (130, [])


def test_files_play_whether_written_in_place_or_replaced(watch: Running, program: Path) -> None:
    program.write_text("r $ left\n")
    assert watch.next() == "▶ r 1 beat, 1.0 s at beat 60, simulator\n"
    for beats in (2, 3):
        new = program.with_suffix(".new")
        new.write_text(f"r $ repeat {beats} left\n")
        new.rename(program)
        assert watch.next().startswith(f"▶ r {beats} beats")


def test_its_folder_is_renamed_and_another_takes_its_place(watch: Running, program: Path) -> None:
    folder = program.parent
    folder.rename(folder.with_name("old"))
    (folder.with_name("old") / program.name).write_text("r $ left left left\n")  # no longer the watched file
    folder.mkdir()
    for beats in (1, 2):
        program.write_text(f"r $ repeat {beats} left\n")
        assert f"▶ r {beats} beat" in watch.next()


def test_errors_of_a_save_are_printed_as_by_check(watch: Running, program: Path) -> None:
    program.write_text("r $ lft\n")
    assert watch.next().endswith(":1:5: error[unknown-name] `lft` is not defined: did you mean `left`?\n")
    assert watch.next() == KEEPS
    program.write_text("r $ left left\n")
    assert watch.next().startswith("▶ r 2 beats")


def test_a_file_unreadable_for_long_is_reported(watch: Running, program: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("improv_core.storage.saves.EMPTY_SETTLING", 0.5)
    program.write_bytes(b"r $ left # \xc3\n")
    assert [watch.next(), watch.next()] == [f"improv: {program}: it is not UTF-8 text\n", KEEPS]
    program.unlink()
    assert [watch.next(), watch.next()] == [f"improv: {program}: no such file or directory\n", KEEPS]
    program.write_text("")
    assert watch.next() == "▶ no robot plays, simulator\n"


def test_a_save_of_the_robots_plays_again(watch: Running, program: Path) -> None:
    robots = program.with_name("improv.toml")
    robots.write_text("[robots.s]\n")
    watch.wait("`r` is not in improv.toml")
    assert watch.next() == KEEPS
    robots.write_text("[robots.r]\n")
    watch.wait("▶ r ∞")


def test_after_improv_toml_is_deleted_only_the_second_save_plays(
    watch: Running, program: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("improv_core.storage.saves.EMPTY_SETTLING", 0.5)
    robots = program.with_name("improv.toml")
    robots.write_text("[robots.r]\n")
    watch.wait("▶ r ∞")
    robots.unlink()
    assert watch.next() == f"improv: {robots} is gone: save again to play without its limits\n"
    assert watch.next() == KEEPS
    program.write_text("r $ left\n")
    assert watch.next().startswith("▶ r 1 beat")


def test_a_program_with_errors_from_the_start_plays_nothing(program: Path) -> None:
    program.write_text("r $ lft\n")
    with watching(program) as watch:
        watch.wait("`lft` is not defined")
        assert watch.next() == "✗ nothing is playing: fix the program and save\n"


def test_a_file_that_is_created_later_plays(program: Path) -> None:
    program.unlink()
    with watching(program) as watch:
        watch.wait("waiting for dance.improv: save it to play it")
        program.write_text("r $ left\n")
        watch.wait("▶ r 1 beat")


@pytest.mark.parametrize(("options", "begins"), [([], None), (["--continue"], {"s"}), (["--continue-at-bar"], {"s"})])
def test_a_save_edits_the_dance_on_request(program: Path, options: list[str], begins: set[str] | None) -> None:
    program.write_text("beat 240\nr $ repeat (forward left)\ns $ repeat forward\n")
    with watching(program, *options) as watch:
        address = live_behind(watch.wait("watch it at").split()[-1])
        watch.wait("▶ r")
        program.write_text("beat 240\nr $ repeat (forward left)\ns $ repeat left\n")
        watch.wait("▶ r")
        told = asyncio.run(transport(address, generation=2))
        assert told.get("begins", {}).keys() == (begins or set())
        assert told["restarted"] == (1 if begins else 2)


async def transport(address: str, generation: int) -> Any:
    """Build the message that a score of this generation plays."""
    async with connected(address) as page:
        return await heard(page, lambda told: told["type"] == "transport" and told["generation"] == generation)


def test_only_the_wanted_scenes_play_at_each_save(program: Path) -> None:
    program.write_text("r at 0 0\nr $ forward\n--- on\nr $ repeat left\n")
    with watching(program, "--from", "on") as watch:
        watch.wait("▶ scene on: r ∞")
        program.write_text("r at 0 0\nr $ forward\n--- one\nr $ left\n")
        watch.wait("✗ the previous dance keeps playing")
        program.write_text("r at 0 0\nr $ forward\n--- on\nr $ left\n")
        watch.wait("▶ scene on: r 1 beat")
