"""Hovers in `improv.toml`: a key's meaning, unit, and range, and a profile's summary and source."""

from __future__ import annotations

from collections.abc import Iterator

from improv_core.ide.hover import Hover
from improv_core.plain import printable
from improv_core.robots.config import Robots, read_robots
from improv_core.robots.profiles import SOURCES
from improv_core.robots.schema import find
from improv_core.robots.schema_key import Key
from improv_core.robots.toml_positions import Keys
from improv_core.robots.toml_text import read_toml
from improv_core.score.profiles import Profile
from improv_core.text import Span


def hover(text: str, offset: int) -> Hover | None:
    """Return the hover for the name, key, or value at an offset; None if nothing is known about it."""
    toml = read_toml(text)
    named = [(span, keys, True) for keys, spans in toml.positions.named.items() for span in spans]
    values = [(entry.value, keys, False) for keys, entry in toml.positions.entries.items() if find(keys)]
    touched = [each for each in (*named, *values) if each[0].holds(offset)]
    if not touched:
        return None
    span, keys, is_name = min(touched, key=lambda each: (each[0].end - each[0].start, not each[2]))
    key = find(keys)
    robots = read_robots(text)
    if not key:
        return None
    if not is_name and key.profile:
        name = text[slice(*span)].strip("\"'")
        if name in robots.profiles:
            return _profile(robots, name, span)
    if len(keys) == 2 and keys[0] == "profiles" and keys[1] in robots.profiles:
        return _profile(robots, str(keys[1]), span)
    if len(keys) == 2 and keys[0] == "robots" and keys[1] in robots.robots:
        return _robot(robots, str(keys[1]), span)
    return Hover(span, _code(_written(keys)), f": {key.about}", (*_facts(key), *_inherited(robots, keys)))


def _written(keys: Keys) -> str:
    """Return the last name that leads to a value."""
    return str(next(name for name in reversed(keys) if isinstance(name, str)))


def _facts(key: Key) -> Iterator[str]:
    if key.unit and key.range:
        yield f"in {key.unit}, from {key.least:g} to {key.most:g}"
    elif key.range:
        yield f"from {key.least:g} to {key.most:g}"
    if key.default:
        yield f"default: {key.default}"


def _inherited(robots: Robots, keys: Keys) -> Iterator[str]:
    """Yield the value of a profile's key without this line, if the profile has a base, and the source of that value."""
    data = read_toml(robots.text).data.get("profiles", {})
    table = data.get(keys[1]) if len(keys) == 3 and keys[0] == "profiles" and isinstance(data, dict) else None
    base = table.get("base") if isinstance(table, dict) else None
    profile = robots.profiles.get(base) if isinstance(base, str) else None
    value = getattr(profile, str(keys[-1]), None) if profile else None
    if profile and isinstance(value, float) and keys[-1] != "quarter_turn":
        key = find(keys)
        yield f"in the base {_code(profile.name)}: {value:g} {key.unit if key else ''}".rstrip()
        yield from _source(robots, profile.name)


def _profile(robots: Robots, name: str, span: Span) -> Hover:
    about = f" (profile): {_summary(robots.profiles[name])}"
    return Hover(span, _code(name), about, tuple(_source(robots, name)))


def _robot(robots: Robots, name: str, span: Span) -> Hover:
    robot = robots.robots[name]
    facts = (f"listens on {_code(robot.topic)}", *_source(robots, robot.profile.name))
    return Hover(span, _code(name), f" (robot, profile {_code(robot.profile.name)}): {_summary(robot.profile)}", facts)


def _summary(profile: Profile) -> str:
    """Summarize a profile in one line."""
    speeds = ((profile.max_linear, "m/s"), (profile.max_angular, "rad/s"))
    limits = " and ".join(f"{limit:g} {unit}" for limit, unit in speeds if limit is not None)
    moves = ", ".join(profile.motions)
    runs_on = "; never stops by itself" if profile.stops_after == 0 else ""
    return f"a step of {profile.step:g} m, {f'at most {limits}' if limits else 'no limits'}; {moves}{runs_on}"


def _source(robots: Robots, name: str) -> Iterator[str]:
    """Yield the source of a profile's numbers, or of those of the built-in one that it is based on."""
    data = read_toml(robots.text).data.get("profiles", {})
    seen: list[str] = []
    while name not in SOURCES and name not in seen and isinstance(data, dict):
        seen.append(name)
        table = data.get(name)
        base = table.get("base") if isinstance(table, dict) else None
        name = base if isinstance(base, str) else name
    if name in SOURCES:
        yield f"source of the limits of {_code(name)}: {SOURCES[name]}"


def _code(text: str) -> str:
    return f"`{printable(text).replace('`', '')}`"
