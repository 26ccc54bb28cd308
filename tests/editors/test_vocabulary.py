"""The editors color exactly the words of the language, each by its kind."""

from __future__ import annotations

import json
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from editors.generate import GROUPS
from improv_core.program.analysis import analyze
from improv_core.syntax.opening import FACINGS
from improv_core.syntax.vocabulary import WORDS
from tests.editors.editors import ROOT

GENERATED = {
    "vscode/syntaxes/improv.tmLanguage.json": ("|up|down", "|up|down|spin"),
    "neovim/syntax/improv.vim": (" up down", " up down spin"),
    "kate/improv.xml": ("<item>down</item>", "<item>down</item><item>spin</item>"),
    "emacs/improv-words.el": (' "up" "down"', ' "up" "down" "spin"'),
    "tree-sitter-improv/words.json": (', "up", "down"', ', "up", "down", "spin"'),
}
"""A file with words, and the change of a list in it when the language gets a word."""
SNIPPETS = sorted((ROOT / "editors").glob("*/snippets/*.json"))


def test_the_editors_have_the_words_of_the_language() -> None:
    assert generate(ROOT, "--check") == ""


def test_each_word_has_one_color() -> None:
    assert sorted(word for words in GROUPS.values() for word in words) == sorted(WORDS)


def test_a_word_added_in_one_place_reaches_all_and_changes_nothing_else(tmp_path: Path) -> None:
    shutil.copytree(ROOT / "improv_core", tmp_path / "improv_core", ignore=shutil.ignore_patterns("__pycache__"))
    for file in ("generate.py", *GENERATED):
        (tmp_path / "editors" / file).parent.mkdir(parents=True, exist_ok=True)
        shutil.copy(ROOT / "editors" / file, tmp_path / "editors" / file)
    schema = Path("docs", "improv.schema.json")
    (tmp_path / "docs").mkdir()
    shutil.copy(ROOT / schema, tmp_path / schema)
    before = {file: (tmp_path / "editors" / file).read_text(encoding="utf-8") for file in GENERATED}

    for module, down, spin in (
        ("syntax/vocabulary.py", '_primitive("down", "One step down."),\n', '_primitive("spin", "A full turn."),\n'),
        ("score/primitives.py", '"down": Velocity(z=-1),\n', '"spin": Velocity(yaw=4),\n'),
    ):
        source = tmp_path / "improv_core" / module
        source.write_text(source.read_text(encoding="utf-8").replace(down, down + spin), encoding="utf-8")
    assert sorted(generate(tmp_path, "--check", code=1).splitlines()) == sorted(
        f"editors/{file} is out of date" for file in GENERATED
    )

    generate(tmp_path)
    for file, (words, more) in GENERATED.items():
        assert (tmp_path / "editors" / file).read_text(encoding="utf-8") == before[file].replace(words, more)
    assert generate(tmp_path, "--check") == ""


@pytest.mark.parametrize("snippets", SNIPPETS, ids=lambda path: path.parents[1].name)
def test_snippets_are_right_as_they_are(snippets: Path) -> None:
    for name, snippet in json.loads(snippets.read_text(encoding="utf-8")).items():
        body = "\n".join(snippet["body"])
        for choices in re.findall(r"\$\{\d+\|(.*?)\|\}", body):
            assert set(choices.split(",")) <= {*WORDS, *FACINGS}, name
        text = re.sub(r"\$\{\d+(?::|\|)([^},|]*)[^}]*\}", r"\1", body).replace("\\$", "$")
        program = text if re.search(r"[$=]|^beat |^room | at ", text) else f"r $ {text}"
        if program.startswith("---"):
            program = f"r $ left\n{program}"
        assert {each.code for each in analyze(program).diagnostics} <= {"unused-name"}, program


def generate(root: Path, *options: str, code: int = 0) -> str:
    command = [sys.executable, str(root / "editors" / "generate.py"), *options]
    done = subprocess.run(command, capture_output=True, text=True, timeout=60)
    assert done.returncode == code, done.stdout + done.stderr
    return done.stdout
