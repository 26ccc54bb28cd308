"""The table of keys, the tables of the page made from it, and a schema that a real TOML tool uses."""

from __future__ import annotations

import json
import subprocess
import sys
from collections.abc import Mapping
from pathlib import Path

import pytest

from improv_core.robots.config import read_robots
from improv_core.robots.schema import SCHEMA, find, known
from improv_core.robots.schema_key import Key
from improv_core.robots.toml_positions import Keys
from tests.needs import need
from tests.robots.test_config import BLOCKS, PAGE

ROOT = Path(__file__).parents[2]
SCHEMA_FILE = ROOT / "docs" / "improv.schema.json"
TABLES: dict[str, Keys] = {
    "A robot": ("robots", "anna"),
    "A machine of its own": ("hosts", "pi"),
    "A profile": ("profiles", "rover"),
    "A formation": ("formation",),
    "The simulator's world": ("world",),
    "Senses": ("senses", "near"),
    "Names and time": ("ros",),
    "What follows from faults": ("on",),
    "A clock from outside": ("clock",),
    "Where robots really stand": ("preflight",),
    "Music": ("music",),
    "OSC": ("osc",),
}
EXAMPLES = [*BLOCKS, *(path.read_text(encoding="utf-8") for path in sorted(ROOT.glob("examples/**/improv.toml")))]


PROFILE = {"step": "1", "dynamics": "'motors'"}


def is_valid(text: str, folder: Path) -> bool:
    """Return whether Taplo accepts a file by the schema."""
    file = folder / "improv.toml"
    file.write_text(text, encoding="utf-8")
    taplo = [
        need(str(Path(sys.executable).with_name("taplo"))),
        "lint",
        "--no-auto-config",
        "--schema",
        SCHEMA_FILE.as_uri(),
        str(file),
    ]
    return subprocess.run(taplo, capture_output=True, check=False, cwd=folder).returncode == 0


def test_the_page_has_the_tables() -> None:
    for title, keys in TABLES.items():
        section = PAGE.split(f"\n## {title}\n")[1].split("\n## ")[0]
        assert "\n".join(_rows(known(keys).keys)) in section


def test_the_schema_file_is_up_to_date() -> None:
    check = [sys.executable, str(ROOT / "editors" / "generate.py"), "--check"]
    assert subprocess.run(check, capture_output=True, text=True, check=False).stdout == ""
    assert json.loads(SCHEMA_FILE.read_text(encoding="utf-8"))["properties"].keys() == SCHEMA.keys.keys()


def test_a_real_tool_accepts_all_examples(tmp_path: Path) -> None:
    refused = [text for text in EXAMPLES if not is_valid(text, tmp_path)]
    assert refused == []


@pytest.mark.parametrize(
    "text",
    [
        "[robots.anna]\nprofil = 'turtlesim'",
        "[robots.anna]\nstart = { x = 5000 }",
        "[profiles.a]\nstep = '2'",
        "[profiles.a]\nstep = 1\nmotions = ['fly']",
        "[formation]\nfacing = 'in'",
        "[world]\nsize = [6]",
        "[ros]\nrejoin = 'later'",
        "[senses.near]\nmessage = 'std_msgs/Boll'\ntopic = 'a'",
        "[rooms]",
    ],
)
def test_the_tool_refuses_the_same_files_as_we_do(text: str, tmp_path: Path) -> None:
    assert not read_robots(text).ok
    assert not is_valid(text, tmp_path)


def keys_in(key: Key, keys: Keys = ()) -> list[tuple[Keys, Key]]:
    """Return all keys of the table, with a made-up name where people choose one."""
    found = [(keys, key)]
    for name, inner in [*key.keys.items(), *([("a", key.named)] if key.named else [])]:
        found += keys_in(inner, (*keys, name))
    return found + (keys_in(key.items, (*keys, 0)) if key.items else [])


def test_every_key_can_be_found_by_its_path() -> None:
    assert all(find(keys) is key for keys, key in keys_in(SCHEMA))
    assert find(("robots", "a", "wings")) is find(("a", "b", "c")) is find(("world", "size", "x")) is None


def test_every_example_is_valid() -> None:
    alone = [
        (keys, key) for keys, key in keys_in(SCHEMA) if keys[2:3] not in (("body",), ("joints",), ("controllers",))
    ]
    texts = [written(keys, key.example) for keys, key in alone if key.example]  # a body is valid only as a whole
    assert {text: found for text in texts if (found := read_robots(text).diagnostics)} == {}


def wrong_values(key: Key) -> list[str]:
    """Return values of other types than a key's, and values next to its range."""
    if key.type in ("number", "integer"):
        beyond = (key.least - 1, key.most + 1) if key.range else ()
        return ["true", '"1"', "nan", *(f"{each:g}" for each in beyond)]
    if key.type == "boolean":
        return ["1", '"true"']
    if key.type == "string":
        return ["3", "[]", *(['"x y"'] if key.choices or key.profile or key.form else [])]
    return ["3"] if key.items or key.keys else []


def test_every_key_refuses_what_the_schema_does_not_allow() -> None:
    tried = 0
    for keys, key in keys_in(SCHEMA):
        if len(keys) < 2 or keys[-1] == "a" or 0 in keys or keys[2:3] in (("body",), ("joints",), ("controllers",)):
            continue
        for value in wrong_values(key):
            text, tried = written(keys, value), tried + 1
            marked = [each for each in read_robots(text).diagnostics if text[slice(*each.span)] == value]
            assert len(marked) == 1, text
    assert tried > 300


def written(keys: Keys, value: str) -> str:
    """Return a file in which this key has this value, with the other keys that it needs."""
    assert value.strip()
    profile = "".join(f"{name} = {usual}\n" for name, usual in PROFILE.items() if name != keys[-1])
    needed = {"profiles": profile, "formation": "shape = 'circle'\n"}.get(str(keys[0]), "") * (keys[-1] != "shape")
    if keys[0] == "senses":
        scan, both = "topic = 'a'\nmessage = 'sensor_msgs/LaserScan'\n", "topic = 'a'\nmessage = 'std_msgs/Bool'\n"
        joy = scan.replace("LaserScan", "Joy")
        needed = {
            "topic": "message = 'std_msgs/Bool'\n",
            "message": "topic = 'a'\n",
            "timeout": both,
            "button": joy,
            "below": scan,
            "above": scan,
            "from": f"{scan}below = 1\n",
            "to": f"{scan}below = 1\n",
        }.get(str(keys[-1]), "")
    if keys[0] == "robots" and keys[-1] == "follow":
        needed = "profile = 'turtlebot4'\nodom = 'pose'\n"
    if keys == ("clock", "port"):
        needed = "follow = 'midi'\n"
    names = [str(name) for name in keys if isinstance(name, str)]
    if keys[-1] == 0:
        value = f"[{value}]"
    table = names[:-1] if names[-2:-1] != ["deadman"] else names[:-2]
    if names[-2:-1] == ["deadman"]:
        other_key = "button = 1" if names[-1] == "topic" else "topic = '/a'"
        names, value = [*names[:-2], "deadman"], f"{{ {names[-1]} = {value}, {other_key} }}"
    return f"[{'.'.join(table)}]\n{needed}{names[-1]} = {value}\n"


def _rows(keys: Mapping[str, Key]) -> list[str]:
    """Format the keys of a table as lines of a Markdown table, without columns that would be empty."""
    cells = [[f"`{name}`", key.about, key.unit, key.range, key.default] for name, key in keys.items()]
    heads = ["key", "what it sets", "unit", "min, max", "default"]
    used = [column for column in range(len(heads)) if any(row[column] for row in cells)]
    lines = [[heads[column] for column in used], *([row[column] for column in used] for row in cells)]
    made = [f"| {' | '.join(line)} |".replace("  ", " ") for line in lines]
    return [made[0], "|" + "---|" * len(used), *made[1:]]
