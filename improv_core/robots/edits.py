"""Writes start poses and robots into the text of an `improv.toml` and leaves everything else unchanged."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

from improv_core.diagnostics import Edit
from improv_core.robots.toml_text import TomlText, read_toml
from improv_core.text import Span

Start = tuple[float, float, float]
"""x and y in meters, the heading in degrees."""


def place(text: str, starts: Mapping[str, Start], cast: Iterable[str]) -> str | None:
    """The text with these start poses, rounded to thousandths.

    If the file lists no robots yet, all of the `cast` are added, since a list must be complete. None if the file can't
    be read, or if it writes robots or start poses in an unusual form.
    """
    toml = read_toml(text)
    robots = toml.data.get("robots", {})
    if toml.diagnostics or not isinstance(robots, dict):
        return None
    line_end = "\r\n" if "\r\n" in text else "\n"
    edits = [_edit(text, toml, name, start, line_end) for name, start in starts.items() if name in robots]
    made = text
    for edit in sorted((edit for edit in edits if edit), key=lambda edit: edit.span, reverse=True):
        made = made[: edit.span.start] + edit.text + made[edit.span.end :]
    missing = [name for name in dict.fromkeys([*(() if robots else cast), *starts]) if name not in robots]
    if missing:
        made += _gap(made, line_end)
        made += line_end.join(_section(name, starts.get(name), line_end) for name in missing)
    # TOML has many ways to write the same thing, so check that the new text means what it should.
    return made if read_toml(made).data == _expected(toml.data, robots, missing, starts) else None


def add(text: str, robot: str) -> Edit | None:
    """The edit that adds a robot at the end, of the profile that all listed ones have, if they have one.

    None if the file can't be read or has the robot already.
    """
    toml = read_toml(text)
    robots = toml.data.get("robots", {})
    if toml.diagnostics or not isinstance(robots, dict) or robot in robots:
        return None
    line_end = "\r\n" if "\r\n" in text else "\n"
    kinds = {table.get("profile") if isinstance(table, dict) else None for table in robots.values()}
    profile = kinds.pop() if len(kinds) == 1 else None
    line = f'profile = "{profile}"{line_end}' if isinstance(profile, str) and profile.isidentifier() else ""
    written = _gap(text, line_end) + _section(robot, None, line_end) + line
    # The section may not be possible after what is there, such as `robots = {}`.
    if read_toml(text + written).diagnostics:
        return None
    return Edit(Span(len(text), len(text)), written)


def inline(start: Start) -> str:
    """A start pose as written in improv.toml."""
    x, y, heading = (f"{value:.10g}" for value in _rounded(start).values())
    return f"{{ x = {x}, y = {y}, heading = {heading} }}"


def _edit(text: str, toml: TomlText, robot: str, start: Start, line_end: str) -> Edit | None:
    """The edit that sets the start pose of a listed robot."""
    if known := toml.positions.entries.get(("robots", robot, "start")):
        return Edit(known.value, inline(start)) if text[known.value.start] == "{" else None
    end = text.find("\n", toml.positions.entries["robots", robot].key.end)
    line = f"start = {inline(start)}{line_end}"
    return Edit(Span(end + 1, end + 1), line) if end >= 0 else Edit(Span(len(text), len(text)), f"{line_end}{line}")


def _gap(text: str, line_end: str) -> str:
    """What separates a new section from the text before it."""
    return "" if not text else line_end if text.endswith("\n") else 2 * line_end


def _section(robot: str, start: Start | None, line_end: str) -> str:
    return f"[robots.{robot}]{line_end}" + (f"start = {inline(start)}{line_end}" if start else "")


def _expected(
    data: Mapping[str, Any], robots: Mapping[str, Any], missing: Iterable[str], starts: Mapping[str, Start]
) -> Mapping[str, Any]:
    """The data that the new text must contain."""
    listed = {**robots, **{name: {} for name in missing}}
    for name, start in starts.items():
        listed[name] = {**(listed[name] if isinstance(listed[name], dict) else {}), "start": _rounded(start)}
    return {**data, "robots": listed}


def _rounded(start: Start) -> Mapping[str, float]:
    """The rounded numbers by name, without -0."""
    return {name: round(value, 3) + 0.0 for name, value in zip(("x", "y", "heading"), start, strict=True)}
