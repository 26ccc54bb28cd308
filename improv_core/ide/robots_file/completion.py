"""Completion in `improv.toml`: sections, keys, and values, without those that the file already has."""

from __future__ import annotations

import re
from collections.abc import Collection, Iterator, Mapping
from itertools import chain

from improv_core.ide.completion import Completion
from improv_core.ide.completion_item import Item
from improv_core.robots.profiles import SOURCES
from improv_core.robots.schema import find
from improv_core.robots.schema_key import Key
from improv_core.robots.toml_positions import KeyAndValue, Keys, Positions, beginning
from improv_core.robots.toml_text import read_toml
from improv_core.score.installed import settings_of
from improv_core.score.profiles import BUILT_IN
from improv_core.score.senses import BUMP, NEAR
from improv_core.text import Span


def complete(text: str, offset: int, robots: Collection[str] = ()) -> Completion | None:
    """Return the words that may come at the cursor; None in comments. `robots` are the robots that programs play."""
    found = beginning(text, offset)
    if not found:
        return None
    before, begun = found
    # The entry at the cursor is being written, so it is not a duplicate.
    whole = read_toml(text).positions
    others = {keys: entry for keys, entry in whole.entries.items() if not entry.key.holds(offset)}
    rest = text[offset:].partition("\n")[0]
    end = offset + (rest.startswith(begun[:1]) if begun[:1] in ("'", '"') else 0)
    if before.expects == "header":
        closed = bool(re.match(r"[\w.\s-]*\]", rest))
        items = _sections(before.keys, others, robots, closed)
    elif before.expects == "key":
        has_value = bool(re.match(r"[\w-]*[ \t]*=", rest))
        items = chain(_keys(before, others, has_value, begun), _settings(text, before.keys, others, has_value))
    else:
        items = _values(text, before.keys, others) if before.expects == "value" else iter(())
    return Completion(Span(offset - len(begun), end), list(items), 0, True)


def _sections(table: Keys, others: Mapping[Keys, KeyAndValue], robots: Collection[str], closed: bool) -> Iterator[Item]:
    """Yield the names that may come in a header, after those in it so far. `closed` if its bracket is there."""
    key = find(table)
    end = "" if closed else "]"
    for name, inner in (key.keys if key and not table else {}).items():
        if inner.named:
            yield Item(name, "section", inner.about, f"{name}.${{1:name}}{end}")
        elif (name,) not in others:
            yield Item(name, "section", inner.about, f"{name}{end}")
    for name, inner in (key.keys if key and table else {}).items():
        if inner.named and (*table, name) not in others:
            yield Item(name, "section", inner.about, f"{name}{'.${1:name}' if inner.named.keys else ''}{end}")
    known = {"robots": dict.fromkeys(robots, "in a program"), "senses": dict.fromkeys((BUMP, NEAR), "built in")}
    for name, about in known.get(str(table[0]), {}).items() if len(table) == 1 else ():
        if (*table, name) not in others:
            yield Item(name, "robot" if table[0] == "robots" else "section", about, f"{name}{end}")


def _keys(before: Positions, others: Mapping[Keys, KeyAndValue], has_value: bool, begun: str) -> Iterator[Item]:
    key = find(before.keys)
    for name, inner in (key.keys if key and before.keys else {}).items():
        if (*before.keys, name) not in others and not inner.named:
            yield Item(name, "key", _detail(inner), "" if has_value else f"{name} = {_placeholder(inner)}")
    table = before.headers[-1][1] if before.headers else ()
    if not begun and not has_value and before.keys == table:  # between sections; not in an inline table
        for item in _sections((), others, (), False):
            yield Item(f"[{item.label}]", "section", item.detail, f"[{item.snippet}")


def _settings(text: str, table: Keys, others: Mapping[Keys, KeyAndValue], has_value: bool) -> Iterator[Item]:
    """Yield the settings that a robot's output declares and that it doesn't have yet."""
    output = others.get((*table[:-1], "output"))
    if len(table) == 3 and (table[0], table[2]) == ("robots", "settings") and output:
        for name, setting in (settings_of(text[slice(*output.value)].strip("'\"")) or {}).items():
            if (*table, name) not in others:
                value = str(setting.default).lower() if type(setting.default) is bool else repr(setting.default)
                yield Item(name, "key", setting.about, "" if has_value else f"{name} = ${{1:{value}}}")


def _values(text: str, keys: Keys, others: Mapping[Keys, KeyAndValue]) -> Iterator[Item]:
    key = find(keys)
    if not key:
        return
    if key.profile:
        own = [str(name) for section, *names in others if section == "profiles" and len(names) == 1 for name in names]
        for profile in dict.fromkeys([*own, *BUILT_IN]):
            if keys[-1] != "base" or profile != keys[-2]:
                yield Item(f'"{profile}"', "value", "in this file" if profile in own else SOURCES.get(profile, ""))
    siblings = {text[slice(*entry.value)] for each, entry in others.items() if each[:-1] == keys[:-1]}
    in_list = isinstance(keys[-1], int)
    for choice in key.choices:
        if not in_list or f'"{choice}"' not in siblings:
            yield Item(f'"{choice}"', "value", "default" if f'"{choice}"' in key.default else "")
    if key.type == "boolean":
        yield from (Item(value, "value", "default" if value == key.default else "") for value in ("true", "false"))
    elif key.example:
        yield Item(key.example, "value", "example")
    elif re.fullmatch(r"-?[\d.]+", key.default):
        yield Item(key.default, "value", f"default, in {key.unit}" if key.unit else "default")


def _detail(key: Key) -> str:
    return f"{key.about} ({key.unit})" if key.unit else key.about


def _placeholder(key: Key) -> str:
    """Return the place of a key's value in a snippet: with its choices, an example, or its default."""
    if key.choices:
        return "${1|" + ",".join(f'"{choice}"' for choice in key.choices) + "|}"
    value = key.example or (key.default if re.fullmatch(r"-?[\d.]+", key.default) else "")
    return '"$1"' if key.profile else f"${{1:{value.replace('}', chr(92) + '}')}}}" if value else "$1"
