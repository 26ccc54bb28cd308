"""The programs that played, each in its own file in a folder that only its user can read.

The name of a file is the time when it played, and its first line is a comment with that time. The rest is the program,
word for word: people can read and copy it with any tool. No file is ever changed, so several processes need no lock.
"""

from __future__ import annotations

import json
import os
import re
import secrets
import sys
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from datetime import datetime, timezone
from pathlib import Path

from improv_core.program.files import ReadError, read_program
from improv_core.storage.atomic_write import replacing, why

MAX_VERSIONS = 200
"""Programs that are kept; after that, each new one replaces the oldest."""
VARIABLE = "IMPROV_HISTORY"
"""The environment variable that turns the history off: set it to `off`."""
_HEADER = re.compile(r'# played (\S+) at (".*")\n')


class HistoryError(Exception):
    """The history can't be read or written. The message is one line that says why."""


@dataclass(frozen=True, slots=True)
class Played:
    """A program that played.

    `file` is its path, or the URI of one that was in no file. Later ones have greater ids.
    """

    id: str
    at: datetime
    file: str
    text: str

    @property
    def name(self) -> str:
        """Name of its file, with its folder."""
        return str(Path(*Path(self.file).parts[-2:]))

    @property
    def when(self) -> str:
        """Local time when it played."""
        return f"{self.at.astimezone():%Y-%m-%d %H:%M:%S}"


@dataclass(frozen=True, slots=True)
class History:
    """The programs that played, the latest first, and the number of files that can't be read."""

    programs: Sequence[Played]
    damaged: int = 0

    def of(self, file: str) -> Sequence[Played]:
        """Return the programs of one file."""
        return [each for each in self.programs if each.file == file]

    def news(self, program: Played) -> str:
        """Return the first line that is not in the previous version of that file; its last line if there is none."""
        before = next((each.text for each in self.of(program.file) if each.id < program.id), program.text)
        old = {line.strip() for line in before.splitlines()}
        lines = [line.strip() for line in program.text.splitlines() if line.strip()]
        return next((line for line in lines if line not in old), "".join(lines[-1:]))

    @property
    def complaint(self) -> str | None:
        """One line about the files that can't be read."""
        if not self.damaged:
            return None
        if self.damaged == 1:
            return f"1 file of the history can't be read and was left out: look at it in {folder()}"
        return f"{self.damaged} files of the history can't be read and were left out: look at them in {folder()}"


def keep(file: str, text: str, now: datetime) -> None:
    """Keep a program that plays, unless it is already the latest of its file. Raises HistoryError."""
    if os.environ.get(VARIABLE) == "off":
        return
    latest = next((each for each in _programs(_files()) if each and each.file == file), None)
    if latest and latest.text == text:
        return
    now = now.astimezone(timezone.utc)
    header = f"# played {now.isoformat()} at {json.dumps(file)}\n"
    try:
        folder().mkdir(0o700, parents=True, exist_ok=True)
        name = f"{now:%Y%m%dT%H%M%S.%fZ}-{secrets.token_hex(4)}.improv"
        with replacing(folder() / name, private=True) as kept:
            kept.write((header + text).encode())
        for old in _files()[MAX_VERSIONS:]:
            old.unlink(missing_ok=True)  # another process may have done so
    except (OSError, ValueError) as error:
        reason = why(error) if isinstance(error, OSError) else "it is not text"
        raise HistoryError(f"this program was not kept in the history: {folder()}: {reason}") from None


def read() -> History:
    """Read all programs that are kept. Files that can't be read are counted, and left as they are."""
    found = list(_programs(_files()))
    programs = [each for each in found if each]
    return History(programs, len(found) - len(programs))


def folder() -> Path:
    """Return the folder of the history, in the system's usual place for the state of programs."""
    if sys.platform == "win32":
        state = os.environ.get("LOCALAPPDATA") or Path.home() / "AppData" / "Local"
    elif sys.platform == "darwin":
        state = Path.home() / "Library" / "Application Support"
    else:
        given = os.environ.get("XDG_STATE_HOME", "")
        # By its specification, a relative path is not valid: it would be in the workspace.
        state = given if Path(given).is_absolute() else Path.home() / ".local" / "state"
    return Path(state, "improv", "history")


def _files() -> Sequence[Path]:
    """List the files, the latest first."""
    return sorted(folder().glob("[0-9]*.improv"), reverse=True)


def _programs(files: Sequence[Path]) -> Iterator[Played | None]:
    for path in files:
        try:
            whole = read_program(path)
            header = _HEADER.match(whole)
            file = json.loads(header[2]) if header else None
            at = datetime.fromisoformat(header[1]) if header else None
        except (ReadError, ValueError):
            file = at = header = None
        if header and at and file:
            yield Played(path.stem, at, file, whole[header.end() :])
        elif path.exists():  # otherwise another process has removed it
            yield None
