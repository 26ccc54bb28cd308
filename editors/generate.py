"""Write the language's words into the files that color them without a server: `python editors/generate.py`.

The words come from `improv_core/syntax/vocabulary.py`. It also writes the JSON schema of `improv.toml`, for TOML tools,
from `improv_core/robots/schema.py`. `--check` writes nothing, and fails if a file is out of date.
"""

from __future__ import annotations

import json
import re
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

EDITORS = Path(__file__).resolve().parent
sys.path.insert(0, str(EDITORS.parent))

from improv_core.robots.schema import SCHEMA  # noqa: E402
from improv_core.robots.schema_key import Key  # noqa: E402
from improv_core.syntax.vocabulary import TRANSFORMERS, UNITS, of_kind  # noqa: E402
from improv_core.syntax.word import Kind  # noqa: E402

GROUPS = {
    "beat": of_kind(Kind.BEAT),
    "primitive": of_kind(Kind.PRIMITIVE),
    "transformer": of_kind(*TRANSFORMERS),
    "conditional": of_kind(Kind.IF, Kind.ELSE, Kind.NOT),
    "plane": of_kind(Kind.PLANE),
}
"""Words that have the same color."""


def main() -> None:
    """Write the files that are out of date, or with `--check` only list them."""
    check = sys.argv[1:] == ["--check"]
    if sys.argv[1:] and not check:
        sys.exit("usage: python editors/generate.py [--check]")
    stale = [(path, text) for path, text in files() if not path.exists() or path.read_text(encoding="utf-8") != text]
    for path, text in stale:
        print(path.relative_to(EDITORS.parent), "is out of date" if check else "written")
        if not check:
            path.parent.mkdir(exist_ok=True)
            path.write_text(text, encoding="utf-8")
    if check and stale:
        sys.exit("run `python editors/generate.py`")


def files() -> Iterator[tuple[Path, str]]:
    """Yield each generated file and its text."""
    yield EDITORS / "tree-sitter-improv" / "words.json", _tree_sitter()
    yield EDITORS.parent / "docs" / "improv.schema.json", _schema()
    yield EDITORS / "emacs" / "improv-words.el", _emacs()
    yield _rewritten("vscode/syntaxes/improv.tmLanguage.json", _text_mate())
    yield _rewritten("neovim/syntax/improv.vim", _vim())
    yield _rewritten("kate/improv.xml", _kate())


def _schema() -> str:
    """Return the JSON schema of `improv.toml`, for TOML tools such as Taplo."""
    head = {"$schema": "http://json-schema.org/draft-07/schema#", "title": "improv.toml"}
    return json.dumps({**head, **_json(SCHEMA)}, indent=2, ensure_ascii=False) + "\n"


def _json(key: Key) -> dict[str, Any]:
    about = f"{key.about}; in {key.unit}" if key.unit else key.about
    made: dict[str, Any] = {"type": key.type.split() if " " in key.type else key.type, "description": about}
    if key.choices:
        made["enum"] = list(key.choices)
    if key.least < key.most and key.type != "array":
        made |= {"minimum": key.least, "maximum": key.most}
        if key.least > 0 and key.unit == "seconds":  # 0 means something else there
            made["minimum"] = 0
    if key.type == "object":
        made["properties"] = {name: _json(inner) for name, inner in key.keys.items()}
        made["additionalProperties"] = _json(key.named) if key.named else False
    if key.required:
        made["required"] = list(key.required)
    if key.items:
        made["items"] = _json(key.items)
    if key.count:
        made |= {"minItems": key.count, "maxItems": key.count}
    return made


def _tree_sitter() -> str:
    lists = [f"  {json.dumps(kind.value.lower())}: {json.dumps(of_kind(kind))}" for kind in Kind]
    lists.append(f'  "unit": {json.dumps([*UNITS], ensure_ascii=False)}')
    return "{\n" + ",\n".join(lists) + "\n}\n"


def _emacs() -> str:
    names = {"beat": "statement-words"} | {group: f"{group}s" for group in GROUPS if group != "beat"}
    lists = [
        f"(defconst improv-{names[group]}\n  '({' '.join(json.dumps(word) for word in words)})\n"
        f'  "Words colored as a {group}.")\n'
        for group, words in GROUPS.items()
    ]
    head = ";;; improv-words.el --- The words of Improv, from editors/generate.py  -*- lexical-binding: t; -*-\n"
    about = ";;; Commentary:\n\n;; For `improv-mode'.  The words come from improv_core/syntax/vocabulary.py.\n"
    return "\n".join([head, about, ";;; Code:\n", *lists, "(provide 'improv-words)", ";;; improv-words.el ends here\n"])


def _text_mate() -> Iterator[tuple[str, str]]:
    for group, words in GROUPS.items():
        yield rf'("{group}": \{{[^{{}}]*"match": "\\\\b\(\?:)[\w|]+', "|".join(words)


def _vim() -> Iterator[tuple[str, str]]:
    for group, words in GROUPS.items():
        yield rf"(syntax keyword improv{group.capitalize()} )[^\n]+", " ".join(words)


def _kate() -> Iterator[tuple[str, str]]:
    for group, words in GROUPS.items():
        yield rf'(<list name="{group}">)(?:<item>\w+</item>)*', "".join(f"<item>{word}</item>" for word in words)


def _rewritten(file: str, lists: Iterator[tuple[str, str]]) -> tuple[Path, str]:
    """Return a file with generated word lists: each list follows the text that its pattern matches."""
    path = EDITORS / file
    text = path.read_text(encoding="utf-8")
    for pattern, words in lists:
        text, found = re.subn(pattern, rf"\g<1>{words}", text)
        if found != 1:
            sys.exit(f"{path}: expected one match of {pattern}, found {found}")
    return path, text


if __name__ == "__main__":
    main()
