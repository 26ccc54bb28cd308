"""The names of robots, and the diagnostics about invalid ones."""

from __future__ import annotations

import re
from collections.abc import Sequence

from improv_core.diagnostics import Diagnostic, replace
from improv_core.syntax.characters import JOINERS, in_words
from improv_core.syntax.lexer import Token
from improv_core.syntax.vocabulary import WORDS

_ROBOT_NAME = re.compile(r"[A-Za-z][A-Za-z0-9_]*")
_HYPHENED = re.compile(r"[A-Za-z][A-Za-z0-9_]*(?:-[A-Za-z0-9_]+)+")


def robots_named(heads: Sequence[Token], diagnostics: list[Diagnostic], otherwise: str = "") -> tuple[str, ...]:
    """Return the robots of a line, each once, without invalid names. Instead of choosing another name, people can do
    `otherwise`."""
    robots: dict[str, None] = {}
    for head in heads:
        if not head.text or is_reserved(head, diagnostics, otherwise):
            continue
        hides = head.end - head.start != len(head.text)  # a joiner, which other names ignore
        if is_valid_robot(head.text) and not hides:
            robots[head.text] = None
            continue
        message = f"`{head.text}` is not a valid robot name: use a to z, digits, and `_`, starting with a letter"
        if unseen := next((char for char in head.text if not char.isprintable()), JOINERS[0] if hides else None):
            message = f"there is {in_words(unseen)}, in this robot's name: remove it"
        legal = re.sub(r"^[^A-Za-z]+|[^A-Za-z0-9_]", lambda match: "_" if match.start() else "", head.text)
        is_new = legal and legal not in WORDS and not unseen
        guess = not _HYPHENED.fullmatch(head.text)  # the fix would lose parts of other names
        fixes = replace(f"Rename to {legal}", head.span, legal, guess=guess) if is_new else ()
        diagnostics.append(Diagnostic("bad-robot-name", head.span, message, fixes))
    return tuple(robots)


def is_valid_robot(name: str) -> bool:
    """Return whether ROS 2 accepts a robot of this name."""
    return bool(_ROBOT_NAME.fullmatch(name))


def is_reserved(token: Token, diagnostics: list[Diagnostic], otherwise: str = "") -> bool:
    """Return whether a name is a word of the language, and report it."""
    if token.text in WORDS:
        message = f"`{token.text}` is a reserved word: choose another name{otherwise}"
        fixes = replace(f"Rename to my_{token.text}", token.span, f"my_{token.text}")
        diagnostics.append(Diagnostic("reserved-name", token.span, message, fixes))
    return token.text in WORDS
