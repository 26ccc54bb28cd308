"""The folder of a class: all that children have sent, so that neither a crash nor the next lesson loses any of it."""

from __future__ import annotations

import json
import os
import re
import sys
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any, NamedTuple

from improv_core.classroom.roster import MAX_CHILDREN, Member, Room
from improv_core.program.files import ENDING
from improv_core.storage.atomic_write import replacing, why

ROSTER = "class.json"
"""The file that lists the children. It marks the folder as one of a class."""
SAME_LESSON = 3 * 3600.0
"""Seconds after which a class that starts again is another lesson, with another code, and children join again."""
BLOCK = 4096
"""The least bytes that a file takes on a disk."""


class Limits(NamedTuple):
    """The most dances and the most bytes of a child that are kept, and the most bytes of all dances. The latest dance
    of a child that the teacher sees, and the latest one that can be played, stay in any case."""

    dances: int = 200
    bytes: int = 2_000_000
    all_bytes: int = 100_000_000


@dataclass(frozen=True, slots=True, order=True)
class KeptDance:
    """A dance that is kept: its number among those of its child, its bytes, and the second at which it was sent."""

    count: int
    size: int
    sent: float
    path: Path


class FolderError(Exception):
    """The folder can't be used. The message is one line that says what to do."""


class Folder:
    """A folder of a class, which is new, empty, or of an earlier class. Raises FolderError."""

    def __init__(self, path: Path, limits: Limits | None = None) -> None:
        self.path, self._limits = path, limits or Limits()
        self._dances: dict[int, list[KeptDance]] = {}
        self._shown: Mapping[int, int] = {}  # the latest dance of each child that can be played
        try:
            path.mkdir(mode=0o700, parents=True, exist_ok=True)
            if any(path.iterdir()) and not (path / ROSTER).is_file():
                raise FolderError(f"{path} has other files in it: name a new folder with --folder")
            self._lock = _locked(path)
            for number, dance in _dances_in(path):
                self._dances.setdefault(number, []).append(dance)
        except OSError as error:
            raise FolderError(f"{path} can't keep the dances: {why(error)}") from None
        for own in self._dances.values():
            own.sort()
        self._bytes = sum(dance.size for own in self._dances.values() for dance in own)

    def room(self, fresh: str, now: float) -> Room:
        """Return the class as it was kept: with the same code if it continues, or with a fresh one and all children
        away. `now` is in seconds since 1970. Raises FolderError."""
        try:
            known = json.loads((self.path / ROSTER).read_text(encoding="utf-8"))
            members = {each.pop("secret"): self._member(each) for each in known["members"]}
            away = [self._member(each) for each in known["away"]]
            code, joined, at = str(known["code"]), int(known["joined"]), float(known["at"])
        except FileNotFoundError:
            return Room(fresh)
        except (OSError, ValueError, KeyError, TypeError, AttributeError):
            raise FolderError(f"{self.path / ROSTER} can't be read: name another folder with --folder") from None
        if now - max([at, *(own[-1].sent for own in self._dances.values())]) < SAME_LESSON:
            return Room(code, members, away, joined)
        left = [each for each in (*away, *members.values()) if each.count]
        return Room(fresh, away=left[-MAX_CHILDREN:], joined=joined)

    def keep(self, room: Room, now: float) -> None:
        """Write the list of children. Raises OSError."""
        members = [{"secret": secret, **asdict(each)} for secret, each in room.members.items()]
        away = [asdict(each) for each in room.away]
        known = {"code": room.code, "at": now, "joined": room.joined, "members": members, "away": away}
        with replacing(self.path / ROSTER, private=True) as file:
            file.write(json.dumps(known, ensure_ascii=False, indent=1).encode())
        self._shown = {each.number: each.good for each in (*room.members.values(), *room.away)}

    def add(self, member: Member, text: str, now: float) -> None:
        """Keep a dance that a child has sent, and forget the oldest ones if there are too many. Raises OSError."""
        data, path = text.encode(), self._place(member)
        path.mkdir(mode=0o700, exist_ok=True)
        with replacing(path / f"{member.count:05}{ENDING}", private=True) as file:
            file.write(data)
        own = self._dances.setdefault(member.number, [])
        own.append(KeptDance(member.count, max(len(data), BLOCK), now, path / f"{member.count:05}{ENDING}"))
        self._bytes += own[-1].size
        while len(own) > self._limits.dances or sum(each.size for each in own) > self._limits.bytes:
            if not self._forget(member.number):
                break
        while self._bytes > self._limits.all_bytes and self._forget(max(self._dances, key=self._forgettable)):
            pass

    def latest(self, member: Member) -> Iterator[tuple[int, float, str]]:
        """Yield the dances of a child that the teacher sees: the number, the second at which it was sent, and the text
        of the latest one that can be played, and of the latest one."""
        own = self._dances.get(member.number, [])
        for each in own:
            if each.count == member.good or each is own[-1]:
                try:
                    yield each.count, each.sent, each.path.read_bytes().decode()
                except (OSError, ValueError):
                    continue  # somebody has removed or changed it

    def _member(self, known: Mapping[str, Any]) -> Member:
        member = Member(**{name: kind(known[name]) for name, kind in _FIELDS.items()})
        own = self._dances.get(member.number)
        return member if not own else Member(member.number, member.name, member.browser, own[-1].count, member.good)

    def _place(self, member: Member) -> Path:
        """Return the folder of a child's dances: its number, and what is harmless of its name."""
        if own := self._dances.get(member.number):
            return own[-1].path.parent
        return self.path / f"{member.number:03}-{harmless(member.name)}"

    def _old(self, number: int) -> Sequence[KeptDance]:
        """The dances of a child that may be forgotten, the oldest first."""
        own = self._dances[number]
        return [each for each in own[:-1] if each.count != self._shown[number]] if number in self._shown else own

    def _forgettable(self, number: int) -> int:
        return sum(each.size for each in self._old(number))

    def _forget(self, number: int) -> bool:
        """Forget the oldest dance of a child. Return whether there was one."""
        for dance in self._old(number)[:1]:
            dance.path.unlink(missing_ok=True)
            self._dances[number].remove(dance)
            self._bytes -= dance.size
            if not self._dances[number]:
                del self._dances[number]
                dance.path.parent.rmdir()
            return True
        return False


def harmless(name: str) -> str:
    """Return a child's name as a part of a file's name: its letters and digits."""
    return re.sub(r"\W+", "_", name).strip("_") or "dance"


_FIELDS: Mapping[str, Callable[[Any], Any]] = {"number": int, "name": str, "browser": str, "count": int, "good": int}


def _dances_in(folder: Path) -> Iterator[tuple[int, KeptDance]]:
    for path in folder.glob(f"*/*{ENDING}"):
        number, count = path.parent.name.partition("-")[0], path.name.removesuffix(ENDING)
        if number.isdecimal() and count.isdecimal() and path.is_file():
            known = path.stat()
            yield int(number), KeptDance(int(count), max(known.st_size, BLOCK), known.st_mtime, path)


def _locked(folder: Path) -> int | None:
    """Lock a folder for as long as this process runs. Raises FolderError if another class has locked it. None if this
    system has no such locks."""
    if sys.platform == "win32":
        return None
    import fcntl

    opened = os.open(folder, os.O_RDONLY)
    try:
        fcntl.flock(opened, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        os.close(opened)
        raise FolderError(f"another class keeps its dances in {folder}: name another folder with --folder") from None
    return opened
