"""A word that completion offers, in programs and in `improv.toml`."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Item:
    """A word to offer. `kind` is keyword, movement, name, phrase, parameter, robot, plane, sense, number, or value; in
    `improv.toml` section, key, value, or robot.

    `snippet` is the text to insert if the editor supports snippets, if it is more than the word.
    """

    label: str
    kind: str
    detail: str = ""
    snippet: str = ""
