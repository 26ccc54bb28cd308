"""Reads tables of poses: columns by their names, with units. Standard library only."""

from __future__ import annotations

import csv
import math
import re
from collections.abc import Iterator, Mapping, Sequence
from itertools import pairwise
from pathlib import Path
from typing import NamedTuple

from improv_core.transcription.sources import LARGEST, Recording, SourceError, robot_name
from improv_core.transcription.track import TimedPlace

_UNITS = {"m": 1.0, "cm": 0.01, "mm": 0.001, "s": 1.0, "sec": 1.0, "ms": 0.001, "msec": 0.001, "us": 1e-6, "ns": 1e-9}
_ANGLES = {"deg": math.pi / 180, "degrees": math.pi / 180, "rad": 1.0, "radians": 1.0}
_NAMES = {
    "time": ("t", "time", "timestamp", "stamp", "seconds", "secs"),
    "x": ("x", "px", "pos_x", "x_pos", "position_x", "easting", "east"),
    "y": ("y", "py", "pos_y", "y_pos", "position_y", "northing", "north"),
    "z": ("z", "pz", "pos_z", "z_pos", "position_z", "altitude", "alt", "up"),
    "heading": ("heading", "yaw", "theta", "angle", "facing", "orientation"),
    "robot": ("robot", "name", "id", "drone", "agent", "dancer"),
}
_HEAD = re.compile(r"\s*([^\[(]*?)\s*(?:[\[(]\s*([A-Za-z°]+)\s*[\])])?\s*")
_MAX_METERS = 200.0
"""Coordinates without a unit that are farther from one another are taken to be millimeters."""
_LONGEST_STEP = 5.0
"""Times without a unit whose usual step is longer are taken to be milliseconds."""


class _Column(NamedTuple):
    place: int
    title: str
    unit: float | None


def read_csv(path: Path) -> Recording:
    """Read a table with a line of names: time, x, y, and perhaps z, heading, and robot. Raises SourceError.

    Names may carry units (`x_mm`, `t [ms]`); guesses are reported.
    """
    rows = _rows(path)
    if not rows:
        raise SourceError(f"{path}: it is empty")
    columns = _columns(path, rows[0][1])
    robot = columns.pop("robot", None)
    tables: dict[str, dict[int, dict[str, float]]] = {}
    for number, row in rows[1:]:
        name = row[robot.place].strip() if robot and robot.place < len(row) else path.stem
        tables.setdefault(name, {})[number] = {
            meaning: _number(path, number, row, column) for meaning, column in columns.items()
        }
    guesses: list[str] = []
    units = _units(columns, [row for table in tables.values() for row in table.values()], guesses)
    places: dict[str, Sequence[TimedPlace]] = {}
    for name, table in tables.items():
        made = robot_name(name, list(places))
        places[made] = list(_places(path, table, units))
        if len(places[made]) < 2:
            raise SourceError(f"{path}, {name}: it has fewer than two places, so nothing moves")
        if made != name:
            guesses.append(f"`{name}` is called {made}")
    if "heading" not in columns:
        guesses.append("no heading: robots look along their paths")
    return Recording(places, guesses)


def _rows(path: Path) -> list[tuple[int, list[str]]]:
    """Return the rows of a table that are neither blank nor comments, with their numbers in the file."""
    try:
        text = path.read_text("utf-8-sig")
    except UnicodeDecodeError as error:
        raise SourceError(f"{path}: it is no text in UTF-8 (byte {error.start})") from None
    lines = text.splitlines()
    head = next((line for line in lines if line.strip() and line[0] != "#"), "")
    comma = max(",;\t", key=head.count)
    reader = csv.reader(lines, delimiter=comma)
    try:
        return [(number, row) for number, row in enumerate(reader, 1) if "".join(row).strip() and row[0][:1] != "#"]
    except csv.Error as error:
        raise SourceError(f"{path}: {error}") from None


def _columns(path: Path, head: Sequence[str]) -> dict[str, _Column]:
    found: dict[str, _Column] = {}
    for place, title in enumerate(head):
        name, unit = _HEAD.fullmatch(title.lower().strip()).groups()  # type: ignore[union-attr]
        name = re.sub(r"\W+", "_", name).strip("_")
        stem, _, ending = name.rpartition("_")
        if unit is None and stem and (ending in _UNITS or ending in _ANGLES):
            name, unit = stem, ending
        meaning = next((meaning for meaning, names in _NAMES.items() if name in names), None)
        if meaning and meaning not in found:
            scale = (_ANGLES if meaning == "heading" else _UNITS).get((unit or "").replace("°", "deg"))
            if unit and scale is None and meaning != "robot":
                raise SourceError(
                    f"{path}, column {title.strip()}: the unit {unit} is not known: use m, cm, mm, s, ms, deg, or rad"
                )
            found[meaning] = _Column(place, title.strip(), scale)
    for meaning in ("time", "x", "y"):
        if meaning not in found:
            names = ", ".join(title.strip() for title in head) or "none"
            raise SourceError(f"{path}: no column is named {meaning}: its columns are {names}")
    return found


def _number(path: Path, number: int, row: Sequence[str], column: _Column) -> float:
    text = row[column.place].strip() if column.place < len(row) else ""
    try:
        value = float(text.replace(",", "."))
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        raise SourceError(f"{path}, row {number}, column {column.title}: `{text}` is no number")
    return value


def _units(columns: Mapping[str, _Column], rows: Sequence[Mapping[str, float]], guesses: list[str]) -> dict[str, float]:
    """Return the factors to seconds, meters, and radians. Units that no title has are guessed, and that is reported."""
    units: dict[str, float] = {}
    steps = sorted(after["time"] - here["time"] for here, after in pairwise(rows) if after["time"] > here["time"])
    slow = bool(steps) and steps[len(steps) // 2] > _LONGEST_STEP
    ways = [abs(row[axis]) for row in rows for axis in ("x", "y")]
    far = max(ways, default=0.0) > _MAX_METERS
    turned = max((abs(row["heading"]) for row in rows if "heading" in row), default=0.0) > 2 * math.tau
    likely = {
        "time": (0.001, "milliseconds") if slow else (1.0, "seconds"),
        "heading": (math.pi / 180, "degrees") if turned else (1.0, "radians"),
    }
    for meaning, column in columns.items():
        factor, name = likely.get(meaning, (0.001, "millimeters") if far else (1.0, "meters"))
        units[meaning] = factor if column.unit is None else column.unit
        if column.unit is None:
            guesses.append(f"column {column.title} is in {name}")
    return units


def _places(path: Path, table: Mapping[int, Mapping[str, float]], units: Mapping[str, float]) -> Iterator[TimedPlace]:
    """Yield the places in numbered rows, except those that only repeat the one before."""
    before = None
    for number, row in table.items():
        values = {meaning: value * units[meaning] for meaning, value in row.items()}
        place = TimedPlace(values["time"], values["x"], values["y"], values.get("z", 0.0), values.get("heading"))
        if max(map(abs, place[:4])) > LARGEST:
            raise SourceError(f"{path}, row {number}: a number is too large")
        if before and before != place and place.time <= before.time:
            raise SourceError(f"{path}, row {number}: its time is not after that of the row before")
        if place != before:
            yield place
        before = place
