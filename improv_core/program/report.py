"""Report diagnostics and results outside an editor: as lines for people and as JSON."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping
from contextlib import suppress
from itertools import combinations
from pathlib import Path
from typing import Any, NamedTuple

from improv_core.diagnostics import Diagnostic, Severity
from improv_core.plain import printable
from improv_core.program.analysis import Analysis
from improv_core.program.errors import Errors, Nearness
from improv_core.program.timing import in_beats, lasting
from improv_core.score.movement import Lengths
from improv_core.score.nearest import nearest_pairs
from improv_core.score.score import Score
from improv_core.text import LineIndex


def as_lines(path: Path, analysis: Analysis) -> list[str]:
    """Return all problems of a program as lines."""
    return [as_line(*problem) for problem in problems(path, analysis)]


def problems(path: Path, analysis: Analysis) -> Iterator[tuple[Path, LineIndex, Diagnostic]]:
    """Yield the diagnostics of a program, then those of `improv.toml`, each with its file and that file's lines."""
    yield from ((path, analysis.lines, diagnostic) for diagnostic in analysis.diagnostics)
    robots = analysis.config
    if robots.path and robots.diagnostics:
        toml = LineIndex(robots.text)
        yield from ((robots.path, toml, diagnostic) for diagnostic in robots.diagnostics)


class Mistake(NamedTuple):
    """An error: its file, its line and column counted from 1, the text there, and the message."""

    file: str
    line: int
    column: int
    word: str
    message: str


NEAR = 1.0
"""Robots whose centers are less than this many meters apart are reported as near each other."""
FEW = 4
"""The most robots that play equally long and are named one by one in a summary."""
LONGEST_MISTAKE = 80
"""The most characters of the wrong text that are shown."""


def mistakes(path: Path, analysis: Analysis) -> list[Mistake]:
    """Return the errors of a program and of its `improv.toml`; none if it can be played."""
    return [_mistake(*each) for each in problems(path, analysis) if each[2].severity is Severity.ERROR]


def _mistake(path: Path, lines: LineIndex, diagnostic: Diagnostic) -> Mistake:
    at, end = lines.position(diagnostic.span.start), lines.position(diagnostic.span.end)
    word = lines.line(at.line)[at.column : end.column if end.line == at.line else None][:LONGEST_MISTAKE]
    return Mistake(path.name, at.line + 1, at.column + 1, printable(word), diagnostic.message)


def as_line(path: Path, lines: LineIndex, diagnostic: Diagnostic) -> str:
    """`path:line:column: severity[code] message`, counted from 1."""
    at = lines.position(diagnostic.span.start)
    where = f"{path}:{at.line + 1}:{at.column + 1}"
    return f"{where}: {diagnostic.severity.value}[{diagnostic.code}] {diagnostic.message}"


def as_annotation(path: Path, lines: LineIndex, diagnostic: Diagnostic) -> str:
    """Return a workflow command with which GitHub Actions shows a problem in the changes of a pull request.

    https://docs.github.com/actions/reference/workflows-and-actions/workflow-commands; only the source of
    actions/toolkit documents the escapes, and that columns are for places on one line.
    """
    start, end = lines.position(diagnostic.span.start), lines.position(diagnostic.span.end)
    with suppress(ValueError):
        path = path.absolute().relative_to(Path.cwd())
    place = {"title": diagnostic.code, "file": path.as_posix(), "line": start.line + 1, "endLine": end.line + 1}
    if start.line == end.line:
        place |= {"col": start.column + 1, "endColumn": end.column + 1}
    properties = ",".join(f"{key}={_escaped(value, '%:,')}" for key, value in place.items())
    level = diagnostic.severity.value if diagnostic.severity in (Severity.ERROR, Severity.WARNING) else "notice"
    return f"::{level} {properties}::{_escaped(as_line(path, lines, diagnostic), '%')}"


def _escaped(value: object, special: str) -> str:
    return "".join(f"%{ord(char):02X}" if char in special + "\r\n" else char for char in str(value))


def as_json(diagnostics: Iterable[Diagnostic], lines: LineIndex) -> list[Mapping[str, Any]]:
    """Return diagnostics as JSON values. Lines and characters count from 0; characters are code points."""

    def at(offset: int) -> Mapping[str, int]:
        position = lines.position(offset)
        return {"line": position.line, "character": position.column}

    return [
        {
            "code": each.code,
            "severity": each.severity.value,
            "message": each.message,
            "range": {"start": at(each.span.start), "end": at(each.span.end)},
        }
        for each in diagnostics
    ]


def summary(analysis: Analysis) -> str:
    """Return a one-line summary of a dance: `turtle1 8 beats · turtle2 ∞, 16.0 s at beat 30`.

    Of many robots that play equally long, it names the first: `r1 and 11 more 8 beats each`.
    """
    parts = analysis.lengths
    alike: dict[str, list[str]] = {}
    for name, length in parts.items():
        alike.setdefault(in_beats(length), []).append(name)
    many = {names[0]: f"{names[0]} and {len(names) - 1:,} more {beats} each" for beats, names in alike.items()}
    counted = {name for names in alike.values() if len(names) > FEW for name in names[1:]}
    robots = " · ".join(
        many[name] if len(alike[in_beats(length)]) > FEW else f"{name} {in_beats(length)}"
        for name, length in parts.items()
        if name not in counted
    )
    if not parts:
        return "no robot plays"
    shortest, longest = (max(each[place] for each in parts.values()) for place in (0, 1))
    return f"{robots}, {lasting(Lengths(shortest, longest, False), analysis.tempo)}"


def outcome(
    transport: Mapping[str, Any] | None, poses: Mapping[str, Any], errors: Errors, score: Score | None
) -> dict[str, Any]:
    """Return the results of a performance: the poses of simulated robots at beat 0 and at the end (meters, radians),
    the time between (seconds), the errors of measured robots, the faults, the timing of hosts, and the pairs of robots
    that came nearer to each other than `NEAR`.

    `transport` and `poses` come from the stage's messages (docs/protocol.md). `transport` is None if there was none.
    """
    return {
        "start": _as_plain_poses(poses.get("start", {})),
        "robots": _as_plain_poses(poses.get("poses", {})),
        "seconds": transport["beat"] * 60 / transport["tempo"] if transport else 0.0,
        **({"measured": errors.as_json()} if errors.robots else {}),
        "faults": errors.faults_as_json(),
        **({"links": errors.links} if errors.links else {}),
        "near": _near(score, transport["beat"], errors) if score and transport else [],
    }


def _near(score: Score, end: float, errors: Errors) -> list[dict[str, Any]]:
    """Return the pairs that came near each other, ideally or as measured: the least distance, its beat, its second."""
    ideal = {
        pair: Nearness(least.distance, least.beat, score.seconds(least.beat))
        for pair, least in nearest_pairs(score, end, NEAR).items()
    }
    found = []
    for pair in combinations(score.parts, 2):
        measured = errors.nearest.get((min(pair), max(pair)))
        if pair in ideal or (measured and measured.distance < NEAR):
            each = {"ideal": ideal.get(pair), "measured": measured}
            found.append({"robots": list(pair), **{name: at._asdict() for name, at in each.items() if at}})
    return found


def _as_plain_poses(poses: Mapping[str, Any]) -> dict[str, dict[str, float]]:
    return {
        robot: {"x": pose["x"], "y": pose["y"], "heading": math.remainder(pose["heading"], math.tau)}
        for robot, pose in poses.items()
    }
