"""Writes start poses, robots, and calibration into the text of an `improv.toml` without changing the rest."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from itertools import count
from typing import Any

from improv_core.diagnostics import Edit
from improv_core.robots.toml_text import TomlText, read_toml
from improv_core.score.profiles import BUILT_IN, DEFAULT
from improv_core.text import Span

Start = tuple[float, float, float]
"""x and y in meters, the heading in degrees."""


def place(text: str, starts: Mapping[str, Start], played: Iterable[str]) -> str | None:
    """Return the text with these start poses, rounded to thousandths.

    If the file lists no robots yet, all that are `played` are added, since a list must be complete. None if the file
    can't be read, or if it writes robots or start poses in an unusual form.
    """
    toml = read_toml(text)
    robots = toml.data.get("robots", {})
    if toml.diagnostics or not isinstance(robots, dict):
        return None
    line_end = "\r\n" if "\r\n" in text else "\n"
    edits = [_edit(text, toml, name, start, line_end) for name, start in starts.items() if name in robots]
    made = _applied(text, filter(None, edits))
    missing = [name for name in dict.fromkeys([*(() if robots else played), *starts]) if name not in robots]
    if missing:
        made += _gap(made, line_end)
        made += line_end.join(_section(name, starts.get(name), line_end) for name in missing)
    # TOML has many ways to write the same thing, so check that the new text means what it should.
    return made if read_toml(made).data == _expected(toml.data, robots, missing, starts) else None


def add(text: str, robot: str) -> Edit | None:
    """Return the edit that adds a robot at the end, with the profile that all listed robots share, if there is one.

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
    # The section may be invalid after the existing text, such as `robots = {}`.
    if read_toml(text + written).diagnostics:
        return None
    return Edit(Span(len(text), len(text)), written)


def calibrate(text: str, robot: str, values: Mapping[str, float]) -> str | None:
    """Return the text in which the profile of a listed robot has these values.

    If other robots or profiles use its profile too, or it is a built-in one, the robot gets its own profile, based on
    that one. None if the file can't be read or has no such robot, or if it writes them in an unusual form.
    """
    toml = read_toml(text)
    robots, profiles = (toml.data.get(section, {}) for section in ("robots", "profiles"))
    if toml.diagnostics or not isinstance(robots, dict) or not isinstance(profiles, dict):
        return None
    table = robots.get(robot)
    if not isinstance(table, dict) or not all(
        isinstance(each, dict) for each in (*robots.values(), *profiles.values())
    ):
        return None
    line_end = "\r\n" if "\r\n" in text else "\n"
    profile = table.get("profile")
    if not isinstance(profile, str | None):
        return None
    users = [each for each in robots.values() if each.get("profile") == profile]
    heirs = [each for each in profiles.values() if each.get("base") == profile]
    if profile and profile in profiles and len(users) == 1 and not heirs:
        made = _applied(text, _settings(text, toml, ("profiles", profile), values, line_end))
        expected = {**profiles, profile: {**profiles[profile], **values}}
        return made if read_toml(made).data == {**toml.data, "profiles": expected} else None
    own = next(name for name in _names(robot) if name not in profiles and name not in BUILT_IN)
    contents: dict[str, float | str] = {**({"step": DEFAULT.step} if profile is None else {"base": profile}), **values}
    made = _applied(text, _settings(text, toml, ("robots", robot), {"profile": own}, line_end))
    lines = [f"[profiles.{own}]", *(f"{key} = {_value(value)}" for key, value in contents.items())]
    made += _gap(made, line_end) + "".join(line + line_end for line in lines)
    expected = {"robots": {**robots, robot: {**table, "profile": own}}, "profiles": {**profiles, own: contents}}
    return made if read_toml(made).data == {**toml.data, **expected} else None


def set_first_beat(text: str, seconds: float) -> str | None:
    """Return the text in which beat 0 is this many seconds after the beginning of the song.

    None if the file can't be read or has no section `[music]`, or if it writes it in an unusual form.
    """
    toml = read_toml(text)
    music = toml.data.get("music")
    if toml.diagnostics or not isinstance(music, dict):
        return None
    values = {"first_beat": round(seconds, 3) + 0.0}
    made = _applied(text, _settings(text, toml, ("music",), values, "\r\n" if "\r\n" in text else "\n"))
    return made if read_toml(made).data == {**toml.data, "music": {**music, **values}} else None


def _names(robot: str) -> Iterator[str]:
    """Yield names for a robot's own profile."""
    yield robot
    yield f"{robot}_calibrated"
    yield from (f"{robot}_calibrated_{number}" for number in count(2))


def _inline(start: Start) -> str:
    """Format a start pose as in improv.toml."""
    x, y, heading = (f"{value:.10g}" for value in _rounded(start).values())
    return f"{{ x = {x}, y = {y}, heading = {heading} }}"


def _applied(text: str, edits: Iterable[Edit]) -> str:
    for edit in sorted(edits, key=lambda edit: edit.span, reverse=True):
        text = text[: edit.span.start] + edit.text + text[edit.span.end :]
    return text


def _settings(
    text: str, toml: TomlText, table: tuple[str, ...], values: Mapping[str, float | str], line_end: str
) -> Iterator[Edit]:
    """Yield the edits that give these values to keys of an existing table."""
    new = []
    for key, value in values.items():
        if known := toml.positions.entries.get((*table, key)):
            yield Edit(known.value, _value(value))
        else:
            new.append(f"{key} = {_value(value)}")
    if new:
        inside = [entry for keys, entry in toml.positions.entries.items() if keys[:-1] == table]
        last = max((each.value.end for each in inside if each.value != each.key), default=0)  # not a table in a header
        yield _below(text, max(last, toml.positions.entries[table].key.end), new, line_end)


def _value(value: float | str) -> str:
    return f'"{value}"' if isinstance(value, str) else f"{value:.10g}"


def _below(text: str, offset: int, lines: Iterable[str], line_end: str) -> Edit:
    """Return the edit that adds lines below the one at an offset."""
    end = text.find("\n", offset) + 1
    written = "".join(f"{line}{line_end}" for line in lines)
    return Edit(Span(end, end), written) if end else Edit(Span(len(text), len(text)), line_end + written)


def _edit(text: str, toml: TomlText, robot: str, start: Start, line_end: str) -> Edit | None:
    """Return the edit that sets the start pose of a listed robot."""
    if known := toml.positions.entries.get(("robots", robot, "start")):
        return Edit(known.value, _inline(start)) if text[known.value.start] == "{" else None
    return _below(text, toml.positions.entries["robots", robot].key.end, [f"start = {_inline(start)}"], line_end)


def _gap(text: str, line_end: str) -> str:
    """Return the separator between a new section and the text before it."""
    return "" if not text else line_end if text.endswith("\n") else 2 * line_end


def _section(robot: str, start: Start | None, line_end: str) -> str:
    return f"[robots.{robot}]{line_end}" + (f"start = {_inline(start)}{line_end}" if start else "")


def _expected(
    data: Mapping[str, Any], robots: Mapping[str, Any], missing: Iterable[str], starts: Mapping[str, Start]
) -> Mapping[str, Any]:
    """Return the data that the new text must contain."""
    listed = {**robots, **{name: {} for name in missing}}
    for name, start in starts.items():
        listed[name] = {**(listed[name] if isinstance(listed[name], dict) else {}), "start": _rounded(start)}
    return {**data, "robots": listed}


def _rounded(start: Start) -> Mapping[str, float]:
    """Return the rounded numbers by name, without -0."""
    return {name: round(value, 3) + 0.0 for name, value in zip(("x", "y", "heading"), start, strict=True)}
