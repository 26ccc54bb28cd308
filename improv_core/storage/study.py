"""The study log: what people do and what their robots are told, one JSON object per line (docs/study.md)."""

from __future__ import annotations

import json
import math
import os
from collections import defaultdict
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import groupby
from pathlib import Path
from statistics import median
from typing import Literal, TypedDict, get_args

from improv_core.protocol.messages import Sent
from improv_core.score.fits import fits, hints_of


class Save(TypedDict):
    """Somebody saved a program that has so many errors."""

    event: Literal["save"]
    program: str
    errors: int


class ErrorEvent(TypedDict):
    """An error of a program that was saved; `line` counts from 1."""

    event: Literal["error"]
    program: str
    code: str
    line: int


class PlayEvent(TypedDict):
    """A program plays, because somebody saved it or used a command."""

    event: Literal["play"]
    program: str
    by: Literal["save", "command"]
    robots: int


class Moved(TypedDict):
    """How far robots were told to move since the event of this kind before, in meters along their paths."""

    event: Literal["moved"]
    meters: Mapping[str, float]


Event = Save | ErrorEvent | PlayEvent | Moved


@dataclass(frozen=True, slots=True)
class Noted:
    """An event, when it happened (Unix time, seconds), and in which session of an editor."""

    time: float
    session: str
    event: Event


@dataclass(frozen=True, slots=True)
class Row:
    """What happened in a session. Times are in seconds, and the distance is in meters."""

    session: str
    began: float
    lasted: float
    saves: int
    played: int
    fixed: Sequence[float]
    meters: float


class Distances:
    """How far each robot is told to move, from the velocities that a stage reports it has sent."""

    def __init__(self) -> None:
        self._meters: dict[str, float] = defaultdict(float)
        self._latest: dict[str, tuple[float, int]] = {}  # speed in meters per second, and when it was sent

    def add(self, sent: Sent) -> None:
        x, y, z, _ = sent["twist"]
        speed, since = self._latest.get(sent["robot"], (0.0, sent["wall"]))
        self._meters[sent["robot"]] += speed * max(sent["wall"] - since, 0) / 1e9
        self._latest[sent["robot"]] = math.hypot(x, y, z), sent["wall"]

    def take(self) -> Mapping[str, float]:
        """The meters since it was last called, of the robots that moved."""
        taken = {robot: round(meters, 4) for robot, meters in self._meters.items() if meters}
        self._meters.clear()
        return taken


class StudyError(Exception):
    """The study log can't be written. The message is one line that says why."""


def append(path: Path, noted: Noted) -> None:
    """Add an event to a log that several processes may write. Raises StudyError."""
    line = json.dumps({"time": round(noted.time, 3), "session": noted.session, **noted.event}) + "\n"
    try:
        handle = os.open(path, os.O_WRONLY | os.O_APPEND | os.O_CREAT | getattr(os, "O_NONBLOCK", 0), 0o600)
        try:
            os.write(handle, line.encode())  # in one step, so that no two lines mix
        finally:
            os.close(handle)
    except OSError as error:
        why = (error.strerror or "it is not a file").lower()
        raise StudyError(f"improv.study.log: {path} can't be written: {why}") from None


def read(lines: Iterable[str]) -> Iterator[Noted | None]:
    """The events of a log; None for each line that is not one."""
    for line in lines:
        try:
            given = json.loads(line)
            kind = _KINDS[given["event"]]
            noted = Noted(given["time"], given["session"], given) if fits(given, kind) else None
        except (ValueError, TypeError, KeyError, RecursionError):
            noted = None
        yield noted if noted and fits(noted.time, float) and fits(noted.session, str) else None


def rows(events: Iterable[Noted]) -> list[Row]:
    """What happened in each session, in the order in which they began."""
    by_session = groupby(sorted(events, key=lambda each: (each.session, each.time)), key=lambda each: each.session)
    return sorted((_row(session, list(its)) for session, its in by_session), key=lambda row: row.began)


def total(several: Sequence[Row]) -> Row:
    """All sessions as one, as if each began when the one before ended."""
    fixed = [seconds for row in several for seconds in row.fixed]
    saves, played = sum(row.saves for row in several), sum(row.played for row in several)
    lasted, meters = sum(row.lasted for row in several), sum(row.meters for row in several)
    return Row("all", several[0].began if several else 0.0, lasted, saves, played, fixed, meters)


HEADINGS = ("session", "minutes", "saves", "saves/minute", "played", "fixed", "seconds to fix", "meters")


def cells(row: Row) -> Sequence[str]:
    """A row of the table under `HEADINGS`. The seconds to fix are a median; what can't be computed is `-`."""
    minutes = row.lasted / 60
    return (
        row.session,
        f"{minutes:.1f}",
        str(row.saves),
        f"{row.saves / minutes:.1f}" if minutes else "-",
        f"{row.played / row.saves:.0%}" if row.saves else "-",
        str(len(row.fixed)),
        f"{median(row.fixed):.1f}" if row.fixed else "-",
        f"{row.meters:.1f}",
    )


def _row(session: str, noted: Sequence[Noted]) -> Row:
    tally = _Tally()
    for each in noted:
        tally.add(each.time, each.event)
    lasted = noted[-1].time - noted[0].time
    return Row(session, noted[0].time, lasted, tally.saves, tally.played, tally.fixed, tally.meters)


@dataclass(slots=True)
class _Tally:
    saves: int = 0
    played: int = 0
    meters: float = 0.0
    fixed: list[float] = field(default_factory=list)
    wrong: dict[str, float] = field(default_factory=dict)  # since when each program has errors

    def add(self, time: float, event: Event) -> None:
        if event["event"] == "save":
            self.saves += 1
            if event["errors"]:
                self.wrong.setdefault(event["program"], time)
            elif event["program"] in self.wrong:
                self.fixed.append(time - self.wrong.pop(event["program"]))
        elif event["event"] == "play":
            self.played += event["by"] == "save"
        elif event["event"] == "moved":
            self.meters += sum(event["meters"].values())


_KINDS = {get_args(hints_of(kind)["event"])[0]: kind for kind in get_args(Event)}
