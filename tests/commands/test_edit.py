"""`improv new`, and the start of `improv edit` (tests/page/test_editor.py writes with it)."""

from __future__ import annotations

import asyncio
import gc
import os
from pathlib import Path

import pytest

from improv_core.storage.program_file import TEMPLATE, create, latest
from improv_core.syntax import derivation
from tests.commands.command_line import SIMULATED, Running, run
from tests.open_page import connected, heard, live_behind


@pytest.fixture(autouse=True)
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)


def test_new_makes_a_small_program() -> None:
    made = [run("new"), run("new"), run("new", "mine")]
    names = ["dance.improv", "dance-2.improv", "mine.improv"]
    assert [each.stdout for each in made] == [f"made {name}\n" for name in names]
    assert {Path(name).read_text() for name in names} == {TEMPLATE}
    again = run("new", "mine.improv")
    assert (again.returncode, again.stderr.count("\n")) == (2, 1)
    assert again.stderr.startswith("improv: mine.improv: it exists already")
    assert run("check", *names).returncode == 0


def test_an_unusable_file_is_refused_in_one_line(tmp_path: Path) -> None:
    file = tmp_path / "dance.improv"
    file.write_bytes(b"r $ left # \xff\n")
    for arguments, problem in (
        (("-",), "standard input can't be edited: name a file"),
        ((file,), f"{file}: it is not UTF-8 text"),
    ):
        done = run("edit", *arguments)
        assert (done.returncode, done.stderr) == (2, f"improv: {problem}\n")


def test_edit_opens_the_latest_save_until_new_makes_another(tmp_path: Path) -> None:
    assert latest() is None
    first, second = create(), create()
    os.utime(second, (1, 1))
    (tmp_path / "other.improv").touch()
    (tmp_path / "dance-9.improv").mkdir()
    assert latest() == first
    os.utime(first, (0, 0))
    assert latest() == second
    done = run("edit", "--backend", "ros")
    assert done.returncode == 2
    second.write_bytes(b"\xff")
    done = run("edit", *SIMULATED)
    assert done.stdout == f"opened {second}, saved last here: improv new makes another program\n"
    assert done.stderr == f"improv: {second}: it is not UTF-8 text\n"


def test_no_key_waits_for_a_garbage_collection_of_the_whole_heap_or_for_the_grammar() -> None:
    usual, frozen = gc.get_threshold(), gc.get_freeze_count()
    derivation._lark.cache_clear()
    loaded = [[each] for each in range(10_000)]
    edit = Running("edit", *SIMULATED)
    edit.wait("editing dance.improv")
    edit.close()
    try:
        assert derivation._lark.cache_info().currsize == 1
        assert gc.get_freeze_count() >= frozen + len(loaded)
        young, middle, _ = gc.get_threshold()
        assert young * middle > 20_000_000, "objects, after which all that are new are looked through"
    finally:
        gc.set_threshold(*usual)


def test_edit_begins_a_new_program_and_serves_each_file_at_the_same_address(tmp_path: Path) -> None:
    """A browser keeps unsaved text by address, so that it is found again."""
    addresses: list[str] = []
    for name in ("dance", "dance.improv"):
        edit = Running("edit", name, *SIMULATED)
        if not addresses:
            assert edit.next() == "made dance.improv\n"
        addresses.append(edit.next().partition("?")[0])
        edit.wait("editing dance.improv")
        edit.close()
    assert addresses[0] == addresses[1]
    assert addresses[0].startswith("watch it at http://127.0.0.1:")
    assert (tmp_path / "dance.improv").read_text() == TEMPLATE


@pytest.mark.parametrize("complete", [True, False])
def test_no_save_plays_by_robots_that_were_different_just_before(complete: bool, tmp_path: Path) -> None:
    """Without its `improv.toml`, or by an earlier one, a robot may move too fast."""
    program, robots = tmp_path / "dance.improv", tmp_path / "improv.toml"
    program.write_text("")
    robots.write_text("[robots.r]\n")
    edit = Running("edit", program, *SIMULATED)
    live = live_behind(edit.wait("watch it at").split()[-1])
    edit.wait("editing dance.improv")

    async def save() -> None:
        async with connected(f"{live}&page=abcdefghijklmnop") as page:
            source = await heard(page, lambda told: told["type"] == "source")
            robots.write_text("[robots.s]\n" if complete else "")
            write = {"type": "write", "number": 1, "text": "r $ left\n", "revision": source["revision"]}
            await page.send_json(write)
            await heard(page, lambda told: told["type"] == "write")
            robots.write_text("[robots.s]\n")

    asyncio.run(save())
    assert "`r` is not in improv.toml" in edit.next()
    edit.close()
