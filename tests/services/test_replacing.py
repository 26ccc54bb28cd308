"""Files that replace others in one step."""

from __future__ import annotations

import os
from collections.abc import Iterator
from pathlib import Path

import pytest

from improv_core.storage.atomic_write import replacing


@pytest.fixture(autouse=True)
def usual_mask() -> Iterator[None]:
    before = os.umask(0o027)
    yield
    os.umask(before)


def mode(path: Path) -> str:
    return f"{path.stat().st_mode & 0o777:o}"


def test_a_new_file(tmp_path: Path) -> None:
    path = tmp_path / "dance.svg"
    with replacing(path) as file:
        file.write(b"new")
        (temporary,) = tmp_path.iterdir()
        assert (temporary.name[:11], mode(temporary)) == (".dance.svg.", "600")
    assert list(tmp_path.iterdir()) == [path]
    assert (path.read_bytes(), mode(path)) == (b"new", "640")


def test_nobody_can_guess_its_name_and_put_a_link_there(tmp_path: Path) -> None:
    names = set()
    for _ in range(2):
        with replacing(tmp_path / "dance.svg"):
            names |= {path.name for path in tmp_path.iterdir()} - {"dance.svg"}
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


@pytest.mark.parametrize("problem", [OSError, KeyboardInterrupt])
def test_what_fails_leaves_no_trace(tmp_path: Path, problem: type[BaseException]) -> None:
    path = tmp_path / "dance.svg"
    path.write_bytes(b"old")
    with pytest.raises(problem), replacing(path):
        raise problem
    assert list(tmp_path.iterdir()) == [path]
    assert path.read_bytes() == b"old"


def test_a_folder_is_not_replaced(tmp_path: Path) -> None:
    (tmp_path / "dance.svg").mkdir()
    with pytest.raises(FileExistsError, match="something else has that name"), replacing(tmp_path / "dance.svg"):
        pass
    assert [path.name for path in tmp_path.iterdir()] == ["dance.svg"]
