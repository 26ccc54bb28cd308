"""Writes start poses, robots, and calibration into the text of an `improv.toml` without changing the rest."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from copy import deepcopy

from improv_core.diagnostics import Edit, applied
from improv_core.robots.toml_positions import Keys, Positions
from improv_core.robots.toml_text import read_toml
from improv_core.score.profiles import BUILT_IN, DEFAULT
from improv_core.text import Span, free_name

Start = tuple[float, float, float]
"""x and y in meters, the heading in degrees."""
_Value = float | str | Mapping[str, float]


def place(text: str, starts: Mapping[str, Start], played: Iterable[str]) -> str | None:
    """Return the text with these start poses, rounded to thousandths.

    If the file lists no robots yet, all that are `played` are added, since a list must be complete. None if the file
    can't be read, or if it writes robots or start poses in an unusual form.
    """
    names = dict.fromkeys([*(() if read_toml(text).data.get("robots") else played), *starts])
    tables: dict[Keys, Mapping[str, _Value]] = {
        ("robots", name): {"start": _rounded(starts[name])} if name in starts else {} for name in names
    }
    return _changed(text, tables, first=True)


def add(text: str, robot: str) -> Edit | None:
    """Return the edit that adds a robot at the end, with the profile that all listed robots share, if there is one.

    None if the file can't be read or has the robot already.
    """
    robots = read_toml(text).data.get("robots", {})
    if not isinstance(robots, dict) or robot in robots:
        return None
    kinds = {table.get("profile") if isinstance(table, dict) else None for table in robots.values()}
    profile = kinds.pop() if len(kinds) == 1 else None
    shared = {"profile": profile} if isinstance(profile, str) and profile.isidentifier() else {}
    made = _changed(text, {("robots", robot): shared})
    return None if made is None else Edit(Span(len(text), len(text)), made[len(text) :])


def calibrate(text: str, robot: str, values: Mapping[str, float]) -> str | None:
    """Return the text in which the profile of a listed robot has these values.

    If other robots or profiles use its profile too, or it is a built-in one, the robot gets its own profile, based on
    that one. None if the file can't be read or has no such robot, or if it writes them in an unusual form.
    """
    robots, profiles = (read_toml(text).data.get(section, {}) for section in ("robots", "profiles"))
    if not isinstance(robots, dict) or not isinstance(profiles, dict) or robot not in robots:
        return None
    if not all(isinstance(each, dict) for each in (*robots.values(), *profiles.values())):
        return None
    profile = robots[robot].get("profile")
    if not isinstance(profile, str | None):
        return None
    users = [each for each in robots.values() if each.get("profile") == profile]
    heirs = [each for each in profiles.values() if each.get("base") == profile]
    if profile and profile in profiles and len(users) == 1 and not heirs:
        return _changed(text, {("profiles", profile): values})
    taken = {*profiles, *BUILT_IN}
    own = free_name(f"{robot}_calibrated", taken) if robot in taken else robot
    base: dict[str, float | str] = {"step": DEFAULT.step} if profile is None else {"base": profile}
    return _changed(text, {("robots", robot): {"profile": own}, ("profiles", own): {**base, **values}})


def set_first_beat(text: str, seconds: float) -> str | None:
    """Return the text in which beat 0 is this many seconds after the beginning of the song.

    None if the file can't be read or has no section `[music]`, or if it writes it in an unusual form.
    """
    has_music = "music" in read_toml(text).data
    return _changed(text, {("music",): {"first_beat": round(seconds, 3) + 0.0}}) if has_music else None


def _changed(text: str, tables: Mapping[Keys, Mapping[str, _Value]], *, first: bool = False) -> str | None:
    """Return the text in which these tables have these values. New tables are at the end; new values are below the
    others of their table, or above them if `first`.

    None if the file can't be read, or if it writes these tables in an unusual form.
    """
    toml = read_toml(text)
    if toml.diagnostics:
        return None
    line_end = "\r\n" if "\r\n" in text else "\n"
    expected = deepcopy(dict(toml.data))
    edits, sections = list[Edit](), list[str]()
    for keys, values in tables.items():
        table, is_new = expected, False
        for key in keys:
            is_new = key not in table
            table = table.setdefault(str(key), {})
            if not isinstance(table, dict):
                return None
        table.update(values)
        if is_new:
            lines = [
                f"[{'.'.join(map(str, keys))}]",
                *(f"{name} = {_written(value)}" for name, value in values.items()),
            ]
            sections.append("".join(line + line_end for line in lines))
        else:
            edits += _settings(text, toml.positions, keys, values, line_end, first)
    made = applied(text, edits)
    if sections:
        gap = "" if not made else line_end if made.endswith("\n") else 2 * line_end
        made += gap + line_end.join(sections)
    # TOML has many ways to write the same thing, so check that the new text means what it should.
    return made if read_toml(made).data == expected else None


def _settings(
    text: str, positions: Positions, table: Keys, values: Mapping[str, _Value], line_end: str, first: bool
) -> Iterator[Edit]:
    """Yield the edits that give these values to keys of an existing table."""
    new = ""
    for key, value in values.items():
        if known := positions.entries.get((*table, key)):
            yield Edit(known.value, _written(value))
        else:
            new += f"{key} = {_written(value)}{line_end}"
    if new:
        inside = [
            entry.value.end
            for keys, entry in positions.entries.items()
            if keys[:-1] == table and entry.value != entry.key
        ]
        last = max([positions.entries[table].key.end, *(() if first else inside)])
        end = text.find("\n", last) + 1
        yield Edit(Span(end, end), new) if end else Edit(Span(len(text), len(text)), line_end + new)


def _written(value: _Value) -> str:
    if isinstance(value, Mapping):
        return f"{{ {', '.join(f'{name} = {_written(each)}' for name, each in value.items())} }}"
    return f'"{value}"' if isinstance(value, str) else f"{value:.10g}"


def _rounded(start: Start) -> Mapping[str, float]:
    """Return the rounded numbers by name, without -0."""
    return {name: round(value, 3) + 0.0 for name, value in zip(("x", "y", "heading"), start, strict=True)}
