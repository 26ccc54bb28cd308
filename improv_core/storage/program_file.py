"""A program in its file, written so that nobody's text is lost. Its encoding, line ends, and permissions are kept."""

from __future__ import annotations

import codecs
import hashlib
from collections import Counter
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

from improv_core import LineError
from improv_core.program.files import ENDING, ReadError, read_bytes, refuse_robots_file
from improv_core.protocol.fields import LONGEST_TEXT
from improv_core.storage.atomic_write import check_replaceable, real, why
from improv_core.storage.compare_and_swap import swap
from improv_core.text import LINE_END

TEMPLATE = """\
# A robot, a dollar sign, and what the robot does. Change it and play it again.
beat 60
turtle1 $ repeat 4 (forward left)
"""
FREE_NAME = f"dance{ENDING}"


class WriteError(LineError):
    """A file can't be written; one plain line that says why."""


@dataclass(frozen=True, slots=True)
class Version:
    """Content of a file. The lines of `text` end in \n, no matter which line ends the file has."""

    data: bytes

    @property
    def raw(self) -> str:
        return self.data.decode("utf-8-sig")

    @property
    def text(self) -> str:
        return LINE_END.sub("\n", self.raw)

    @property
    def revision(self) -> str:
        """Name of this version: another version has another revision."""
        return hashlib.sha256(self.data).hexdigest()[:16]

    def edited(self, text: str) -> Version:
        """Return the version with this text. Lines that did not change keep their ends; the others get the usual
        one."""
        mark = codecs.BOM_UTF8 if self.data.startswith(codecs.BOM_UTF8) else b""
        return Version(mark + _with_ends(self.raw, text).encode())


def read_version(path: Path) -> Version:
    """Read a file. Raises ReadError unless it is UTF-8 text that fits on the page."""
    refuse_robots_file(path)
    version = Version(read_bytes(path))
    try:
        length = len(version.text)
    except UnicodeDecodeError:
        raise ReadError(f"{path}: it is not UTF-8 text") from None
    if length > LONGEST_TEXT:
        raise ReadError(f"{path}: it is too long for the page: edit it in an editor, and use `improv watch`")
    return version


def write_text(path: Path, text: str, revision: str) -> Version:
    """Replace a file in one step by an edit of the version with this revision. A file that is gone is made again.

    Raises WriteError if it can't be written, or holds another version that would be lost.
    """
    try:
        check_replaceable(real(path))
        before = read_version(path) if path.exists() else None
        after = (before or Version(b"")).edited(text)
        is_other = before is not None and before.data and revision != before.revision and after != before
        if is_other or not swap(path, before.data if before else None, after.data):
            raise WriteError(f"{path.name}: another program has changed it")
    except OSError as error:
        raise WriteError(f"{path.name}: {why(error)}") from None
    except ReadError as error:
        raise WriteError(str(error)) from None
    return after


def create(path: Path | None = None) -> Path:
    """Make a file with a small program: at `path`, or in this folder with the first free name. Raises WriteError."""
    free = Path(FREE_NAME)
    names = [path] if path else [free, *(free.with_stem(f"{free.stem}-{number}") for number in range(2, 1000))]
    for name in names:
        try:
            with name.open("x", encoding="utf-8", newline="\n") as file:
                file.write(TEMPLATE)
        except FileExistsError:
            continue
        except OSError as error:
            raise WriteError(f"{name}: {why(error)}") from None
        return name
    raise WriteError(f"{names[0]}: it exists already: choose another name, or edit it with `improv edit`")


def latest() -> Path | None:
    """Return the program in this folder that was saved last, among those that `create` named; None if there is none."""
    saved: list[tuple[int, Path]] = []
    for path in Path().glob(f"{Path(FREE_NAME).stem}*{ENDING}"):
        with suppress(OSError):  # it may have been removed
            if path.is_file():
                saved.append((path.stat().st_mtime_ns, path))
    return max(saved)[1] if saved else None


def _with_ends(before: str, text: str) -> str:
    """Give a text whose lines end in \n the line ends of the text that it replaces."""
    ends = LINE_END.findall(before)
    old, new = LINE_END.split(before), text.split("\n")
    usual = Counter(ends).most_common(1)[0][0] if ends else "\n"
    same = 0
    while same < min(len(old), len(new)) and old[same] == new[same]:
        same += 1
    same_below = 0
    while same_below < min(len(old), len(new)) - same and old[-1 - same_below] == new[-1 - same_below]:
        same_below += 1
    first = ends[: min(same, len(new) - 1)]
    last = ends[len(ends) - same_below + 1 :] if same_below else []
    between = [usual] * (len(new) - 1 - len(first) - len(last))
    result = "".join(line + end for line, end in zip(new, [*first, *between, *last, ""], strict=True))
    # Next to each other, a \r and a \n that were apart would be one end.
    return result if LINE_END.sub("\n", result) == text else text.replace("\n", usual)
