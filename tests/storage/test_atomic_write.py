"""Files that replace others in one step."""

from __future__ import annotations

import errno
import os
import subprocess
import sys
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest

from improv_core.storage import atomic_write
from improv_core.storage.atomic_write import beside, check_replaceable, real, remove_left, replacing, why
from tests.needs import lacking


@pytest.fixture(autouse=True)
def usual_mask() -> Iterator[None]:
    before = os.umask(0o027)
    yield
    os.umask(before)


def mode(path: Path) -> str:
    return f"{path.stat().st_mode & 0o777:o}"


@pytest.fixture(params=["unnamed", "named"])
def kind(request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch) -> str:
    """Run with and without a file system that has files without a name."""
    if request.param == "named":
        monkeypatch.setattr(os, "open", without_unnamed_files(os.open))
    elif sys.platform != "linux":
        pytest.skip("only Linux has files without a name")
    return str(request.param)


def without_unnamed_files(really: Callable[..., int]) -> Callable[..., int]:
    def opened(path: Any, flags: int, *more: Any, **named: Any) -> int:
        if flags & os.O_TMPFILE == os.O_TMPFILE:
            raise OSError(errno.EOPNOTSUPP, os.strerror(errno.EOPNOTSUPP))
        return really(path, flags, *more, **named)

    return opened


def test_a_new_file_gets_its_name_once_it_is_complete(tmp_path: Path, kind: str) -> None:
    path = tmp_path / "dance.svg"
    with replacing(path) as file:
        file.write(b"new")
        assert [mode(each) for each in tmp_path.iterdir()] == (["600"] if kind == "named" else [])
        assert not path.exists()
    assert list(tmp_path.iterdir()) == [path]
    assert (path.read_bytes(), mode(path)) == (b"new", "640")


def test_nobody_can_guess_a_hidden_name_and_put_a_link_there(tmp_path: Path) -> None:
    names = set()
    for _ in range(2):
        with beside(tmp_path / "dance.svg") as new:
            new.complete()
            names.add(new.named().name)
    assert len(names) == 2


def test_a_file_that_is_replaced_keeps_its_permissions_and_its_link(tmp_path: Path) -> None:
    path, link = tmp_path / "dance.svg", tmp_path / "link.svg"
    path.write_bytes(b"old")
    path.chmod(0o604)
    link.symlink_to(path)
    with replacing(link) as file:
        file.write(b"new")
        assert path.read_bytes() == b"old"
    assert link.is_symlink()
    assert (path.read_bytes(), mode(path)) == (b"new", "604")


@pytest.mark.usefixtures("kind")
@pytest.mark.parametrize("problem", [OSError, KeyboardInterrupt])
def test_a_failed_write_leaves_no_trace(tmp_path: Path, problem: type[BaseException]) -> None:
    path = tmp_path / "dance.svg"
    path.write_bytes(b"old")
    with pytest.raises(problem), replacing(path):
        raise problem
    assert list(tmp_path.iterdir()) == [path]
    assert path.read_bytes() == b"old"


def test_a_folder_is_not_replaced(tmp_path: Path) -> None:
    (tmp_path / "dance.svg").mkdir()
    with (
        pytest.raises(FileExistsError, match="a folder or another special file has that name"),
        replacing(tmp_path / "dance.svg"),
    ):
        pass
    assert [path.name for path in tmp_path.iterdir()] == ["dance.svg"]


def test_a_file_with_several_names_is_not_replaced(tmp_path: Path) -> None:
    path, other = tmp_path / "dance.svg", tmp_path / "other.svg"
    path.write_bytes(b"old")
    other.hardlink_to(path)
    with (
        pytest.raises(OSError, match=r"^\[.*\] it has 2 names \(hard links\), and only one would change"),
        replacing(path),
    ):
        pass
    assert (path.read_bytes(), other.read_bytes()) == (b"old", b"old")
    other.unlink()
    with replacing(path) as file:
        file.write(b"new")
    assert path.read_bytes() == b"new"


def test_a_read_only_file_system_has_its_own_line(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = tmp_path / "dance.svg"
    path.write_bytes(b"old")
    monkeypatch.setattr(os, "access", lambda *_: False)
    with pytest.raises(PermissionError):
        check_replaceable(path)
    monkeypatch.setattr(os, "statvfs", lambda _: Flags(os.ST_RDONLY))
    with pytest.raises(OSError, match="Read-only") as refused:
        check_replaceable(path)
    assert why(refused.value) == "its file system is read-only: write elsewhere"


class Flags:
    def __init__(self, flags: int) -> None:
        self.f_flag = flags


def test_a_file_keeps_its_owner_and_its_group(tmp_path: Path) -> None:
    if os.geteuid():
        lacking("only root can give files to others")
    path = tmp_path / "dance.svg"
    path.write_bytes(b"old")
    os.chown(path, 12_345, 54_321)
    path.chmod(0o664)
    with replacing(path) as file:
        file.write(b"new")
    found = path.stat()
    assert (path.read_bytes(), found.st_uid, found.st_gid, mode(path)) == (b"new", 12_345, 54_321, "664")


def test_a_file_whose_owner_or_group_can_not_be_kept_stays(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = tmp_path / "dance.svg"
    path.write_bytes(b"old")
    another = path.stat()
    fstat = os.fstat

    def in_another_group(file: int) -> os.stat_result:
        found = [*fstat(file)]
        return os.stat_result([*found[:5], another.st_gid + 1, *found[6:]])

    monkeypatch.setattr(os, "fstat", in_another_group)

    def refuse(*_: int) -> None:
        raise PermissionError(errno.EPERM, os.strerror(errno.EPERM))

    monkeypatch.setattr(os, "fchown", refuse)
    with pytest.raises(PermissionError) as refused, replacing(path) as file:
        file.write(b"new")
    assert why(refused.value) == "you can't keep its owner and its group: change a copy"
    assert path.read_bytes() == b"old"


def test_a_file_keeps_its_attributes(tmp_path: Path) -> None:
    path = tmp_path / "dance.svg"
    path.write_bytes(b"old")
    try:
        os.setxattr(path, "user.tag", b"mine")
    except (OSError, AttributeError):
        lacking("this file system has no attributes")
    with replacing(path) as file:
        file.write(b"new")
    assert os.getxattr(path, "user.tag") == b"mine"


def test_a_link_to_itself_is_an_error_of_the_system(tmp_path: Path) -> None:
    path = tmp_path / "dance.svg"
    path.symlink_to(path)
    assert real(path) == path
    with pytest.raises(OSError, match="symbolic links"), replacing(path) as file:
        file.write(b"new")
    assert list(tmp_path.iterdir()) == [path]


KILLED = """
import sys, time
from pathlib import Path
from improv_core.storage import atomic_write
if sys.argv[2] == "named":
    atomic_write.Path.exists = lambda path: False  # as without /proc
with atomic_write.beside(Path(sys.argv[1])) as new:
    new.file.write(b"half")
    if sys.argv[2] == "exchanging":
        new.complete()
        new.named()
    print("halted", flush=True)
    time.sleep(1000)
"""


@pytest.mark.parametrize(("phase", "leaves"), [("unnamed", 0), ("named", 1), ("exchanging", 1)])
def test_files_left_by_a_killed_process_are_removed_by_the_next_one(tmp_path: Path, phase: str, leaves: int) -> None:
    if sys.platform != "linux" and phase != "named":
        pytest.skip("only Linux has files without a name")
    path, kept = tmp_path / "dance.svg", list[bytes]()
    path.write_bytes(b"old")
    with subprocess.Popen([sys.executable, "-c", KILLED, path, phase], stdout=subprocess.PIPE) as process:
        assert process.stdout
        assert process.stdout.readline() == b"halted\n"
        remove_left(path, kept.append)
        assert len(list(tmp_path.iterdir())) == 1 + leaves  # it is in use
        process.kill()
    assert len(list(tmp_path.iterdir())) == 1 + leaves
    remove_left(tmp_path / "another.svg", kept.append)
    assert (len(list(tmp_path.iterdir())), kept) == (1 + leaves, [])
    remove_left(path, kept.append)
    assert [*tmp_path.iterdir()] == [path]
    assert kept == ([b"half"] if phase == "exchanging" else [b""] if leaves else [])


def test_nothing_is_removed_through_a_link_or_before_it_is_kept(tmp_path: Path) -> None:
    path, secret = tmp_path / "dance.svg", tmp_path / "secret"
    secret.write_bytes(b"secret")
    strange = {path.with_name(f"{atomic_write._prefix(path)}{number}") for number in range(3)}
    link, pipe, text = sorted(strange)
    link.symlink_to(secret)
    os.mkfifo(pipe)
    text.write_bytes(b"theirs")

    def fail(_: bytes) -> None:
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    remove_left(path, fail)
    assert {*tmp_path.iterdir()} == {secret, *strange}
    remove_left(path)
    assert {*tmp_path.iterdir()} == {secret, link, pipe}
