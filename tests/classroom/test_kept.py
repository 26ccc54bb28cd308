"""The folder of a class: the dances that it keeps and forgets, and the children who come back to theirs."""

from __future__ import annotations

import os
import stat
import sys
from dataclasses import replace
from pathlib import Path

import pytest

from improv_core.classroom.kept import BLOCK, ROSTER, SAME_LESSON, Folder, FolderError, Limits
from improv_core.classroom.roster import Room, counted, join, people, send

NOW = 1_800_000_000.0


def lesson(folder: Folder, *texts: str, good: int = 0) -> Room:
    """Ada and Bo join, and Ada sends these dances. A `good` one can be played."""
    room = Room("ABC234")
    for secret, name in (("s1", "Ada"), ("s2", "Bo")):
        room, _ = join(room, name, secret, f"browser of {name}")
    folder.keep(room, NOW)
    for number, text in enumerate(texts):
        room = hand_in(folder, room, "s1", text, number)
    room = counted(room, 1, good)
    folder.keep(room, NOW)
    return room


def hand_in(folder: Folder, room: Room, secret: str, text: str, number: int) -> Room:
    """Have a child send its dance of this number, from 0."""
    room, member = send(room, secret, 10.0 * number)
    folder.add(member, text, NOW)
    os.utime(next(folder.path.glob(f"{member.number:03}-*/{member.count:05}.improv")), (NOW, NOW))
    return room


def kill(folder: Folder) -> None:
    """End the process of a class, which frees its folder."""
    if folder._lock is not None:
        os.close(folder._lock)


def texts(folder: Folder, room: Room) -> list[tuple[int, str]]:
    everybody = [*room.away, *room.members.values()]
    return [(count, text) for member in everybody for count, _, text in folder.latest(member)]


def files(path: Path) -> list[str]:
    return sorted(each.relative_to(path).as_posix() for each in path.glob("*/*"))


@pytest.fixture
def path(tmp_path: Path) -> Path:
    return tmp_path / "new" / "dances"


def test_a_class_that_was_killed_continues_where_it_was(path: Path) -> None:
    before = Folder(path)
    room = lesson(before, "one", "two \u202e\r\n", "wrong", good=2)
    kill(before)
    after = Folder(path)
    kept = after.room("FRESH2", NOW + SAME_LESSON - 1)
    assert (kept.code, kept.members.keys()) == (room.code, room.members.keys())
    assert texts(after, kept) == [(2, "two \u202e\r\n"), (3, "wrong")]
    assert send(kept, "s1", 0.0)[1].count == 4  # no dance takes the place of another one


@pytest.mark.skipif(sys.platform == "win32", reason="Windows has no such permissions")
def test_nobody_else_can_read_the_folder(path: Path) -> None:
    lesson(Folder(path), "one")
    kept = (path, path / ROSTER, path / "001-Ada", path / "001-Ada" / "00001.improv")
    assert [stat.S_IMODE(each.stat().st_mode) & 0o077 for each in kept] == [0, 0, 0, 0]


def test_a_dance_that_came_after_the_list_of_children_was_written_is_found(path: Path) -> None:
    before = Folder(path)
    hand_in(before, lesson(before, "one"), "s1", "two", 1)
    kill(before)
    after = Folder(path)
    kept = after.room("FRESH2", NOW)
    assert texts(after, kept) == [(2, "two")]
    assert kept.members["s1"].count == 2


def test_in_the_next_lesson_children_come_back_to_their_dances_by_name(path: Path) -> None:
    before = Folder(path)
    lesson(before, "one", good=1)
    kill(before)
    after = Folder(path)
    room = after.room("FRESH2", NOW + SAME_LESSON)
    assert room.code == "FRESH2"
    assert people(room, NOW) == {1: ("Ada", False)}  # Bo has sent nothing
    assert texts(after, room) == [(1, "one")]
    room, member = join(room, "Ada", "new", "another browser")
    assert (member.number, member.count, member.good) == (1, 1, 1)
    assert join(room, "Cy", "c", "c")[1].number == 3


@pytest.mark.parametrize(
    ("limits", "kept"),
    [
        (Limits(dances=3), [2, 5, 6]),
        (Limits(bytes=2 * BLOCK), [2, 6]),
        (Limits(bytes=0), [2, 6]),  # the ones that the teacher sees
        (Limits(all_bytes=4 * BLOCK), [2, 4, 5, 6]),
        (Limits(), [1, 2, 3, 4, 5, 6]),
    ],
)
def test_the_oldest_dances_are_forgotten_but_none_that_the_teacher_sees(
    path: Path, limits: Limits, kept: list[int]
) -> None:
    folder = Folder(path, limits)
    room = lesson(folder, "one", "two", good=2)
    for number in range(2, 6):
        room = hand_in(folder, room, "s1", "x", number)
    assert files(path) == [f"001-Ada/{count:05}.improv" for count in kept]


def test_the_child_with_the_most_bytes_gives_way_and_one_that_was_sent_out(path: Path) -> None:
    folder = Folder(path, Limits(all_bytes=6 * BLOCK))
    room = lesson(folder, *"abc")
    for number, size in enumerate((2 * BLOCK, 1, 1)):
        room = hand_in(folder, room, "s2", "x" * size, number)
    ada = [f"001-Ada/{count:05}.improv" for count in (1, 2, 3)]
    assert files(path) == [*ada, "002-Bo/00002.improv", "002-Bo/00003.improv"]
    folder.keep(replace(room, members={"s2": room.members["s2"]}), NOW)
    hand_in(folder, room, "s2", "x" * 5 * BLOCK, 3)
    assert files(path) == ["002-Bo/00003.improv", "002-Bo/00004.improv"]


def test_a_name_is_harmless_in_the_folder(path: Path) -> None:
    folder, room = Folder(path), Room("ABC234")
    for number, name in enumerate(("../..\\C:", "Анна", "🦖")):
        room, _ = join(room, name, name, name)
        room = hand_in(folder, room, name, "one", number)
    assert files(path) == [f"{each}/00001.improv" for each in ("001-C", "002-Анна", "003-dance")]


def test_a_folder_with_other_files_or_a_broken_list_is_refused_and_left_alone(path: Path) -> None:
    path.mkdir(parents=True)
    (path / "thesis.txt").write_text("mine")
    with pytest.raises(FolderError, match="has other files in it: name a new folder with --folder"):
        Folder(path)
    (path / ROSTER).write_text('{"code": 1}')
    with pytest.raises(FolderError, match=r"class\.json can't be read: name another folder with --folder"):
        Folder(path).room("FRESH2", NOW)
    assert (path / "thesis.txt").read_text() == "mine"


@pytest.mark.skipif(sys.platform == "win32", reason="Windows has no such locks")
def test_two_classes_share_no_folder(path: Path) -> None:
    folder = Folder(path)
    folder.keep(Room("ABC234"), NOW)
    with pytest.raises(FolderError, match="another class keeps its dances in"):
        Folder(path)
