"""The end of a save, by a clock that only waiting moves."""

from __future__ import annotations

import asyncio
from pathlib import Path

import pytest

from improv_core.storage.saves import EMPTY_SETTLING, MID_LINE_SETTLING, SETTLING, read_saved, settle

WHOLE, HALF = b"r $ left left\n", b"r $ left"
Write = tuple[float, bytes | None]
"""The time of a write, and its content; None: the file is removed."""


class Editor:
    """Writes a file, slowly."""

    def __init__(self, path: Path, writes: list[Write]) -> None:
        self.now = 0.0
        self._path = path
        self._writes = writes
        self._write()

    def _write(self) -> None:
        while self._writes and self._writes[0][0] <= self.now:
            _, contents = self._writes.pop(0)
            if contents is None:
                self._path.unlink()
            else:
                self._path.write_bytes(contents)

    async def sleep(self, seconds: float) -> None:
        self.now += seconds
        self._write()


@pytest.mark.parametrize(
    ("writes", "text", "at"),
    [
        ([(0, WHOLE)], WHOLE, SETTLING),
        ([(0, b"r $ left\r")], b"r $ left\r", SETTLING),
        ([(0, HALF)], HALF, MID_LINE_SETTLING),
        ([(0, b"")], b"", EMPTY_SETTLING),
        ([(0, b""), (4, WHOLE)], WHOLE, 4 + SETTLING),  # an editor that empties the file first
        ([(0, b"r $ le"), (0.3, HALF), (0.7, HALF + b" \xc3"), (3, WHOLE)], WHOLE, 3 + SETTLING),
        ([(0, HALF + b"\xc3\n"), (2, WHOLE)], WHOLE, 2 + SETTLING),  # half a character
        ([(0, HALF), (0.1, None), (3, WHOLE)], WHOLE, 3 + SETTLING),  # deleted and made again
        ([(0, HALF), (0.1, None)], None, 0.1 + EMPTY_SETTLING),
        ([(0, b"# \xc3\n")], None, EMPTY_SETTLING),
    ],
)
def test_a_save_counts_once_it_stays_as_it_is(
    tmp_path: Path, writes: list[Write], text: bytes | None, at: float
) -> None:
    path = tmp_path / "dance.improv"
    before = read_saved(path)
    editor = Editor(path, writes)
    saved = asyncio.run(settle(path, before, lambda: editor.now, editor.sleep))
    assert saved.text == (None if text is None else text.decode())
    assert editor.now == pytest.approx(at, abs=2 * SETTLING)


ROBOTS = b"[robots.r]\n"


@pytest.mark.parametrize(
    ("before", "writes", "at"),
    [
        (ROBOTS, [(0, ROBOTS + ROBOTS)], SETTLING),
        (ROBOTS, [(0, b""), (4, ROBOTS)], 4 + SETTLING),  # without it, robots have no limits
        (ROBOTS, [(0, None), (4, ROBOTS)], 4 + SETTLING),
        (ROBOTS, [(0, b"[rob"), (0.4, ROBOTS)], 0.4 + SETTLING),
        (ROBOTS, [(0, None)], EMPTY_SETTLING),
        (b"", [(0, b"")], SETTLING),  # it has long been empty
        (None, [], SETTLING),
    ],
)
def test_a_change_of_the_robots_counts_once_it_stays(
    tmp_path: Path, before: bytes | None, writes: list[Write], at: float
) -> None:
    path, robots = tmp_path / "dance.improv", tmp_path / "improv.toml"
    path.write_bytes(WHOLE)
    if before is not None:
        robots.write_bytes(before)
    known = read_saved(path)
    editor = Editor(robots, writes)
    asyncio.run(settle(path, known, lambda: editor.now, editor.sleep))
    assert editor.now == pytest.approx(at, abs=2 * SETTLING)
