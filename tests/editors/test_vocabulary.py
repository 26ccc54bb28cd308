"""The editors color the words that the language has: no more, no fewer, and each as what it is."""

from __future__ import annotations

import json
import re
from pathlib import Path

from improv_core.syntax.vocabulary import Kind, of_kind

EDITORS = Path(__file__).parents[2] / "editors"
WORDS = {
    "beat": of_kind(Kind.BEAT),
    "primitive": of_kind(Kind.PRIMITIVE),
    "transformer": of_kind(Kind.MIRROR, Kind.REPEAT, Kind.REFLECT, Kind.FACTOR),
    "plane": of_kind(Kind.PLANE),
}


def test_visual_studio_code() -> None:
    grammar = json.loads((EDITORS / "vscode/syntaxes/improv.tmLanguage.json").read_text(encoding="utf-8"))
    matches = {name: rule["match"] for name, rule in grammar["repository"].items()}
    lists = {name: re.fullmatch(r"\\b\(\?:([\w|]+)\)\\b", match) for name, match in matches.items()}
    assert {name: found[1].split("|") for name, found in lists.items() if found} == WORDS


def test_vim() -> None:
    syntax = (EDITORS / "neovim/syntax/improv.vim").read_text(encoding="utf-8")
    lists = re.findall(r"^syntax keyword improv(\w+) (.+)$", syntax, re.MULTILINE)
    assert {name.lower(): words.split() for name, words in lists} == WORDS
