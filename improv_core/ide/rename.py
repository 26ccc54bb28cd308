"""Rename a name, a parameter, a robot, or a scene. Refuse a rename that would change the meaning of the program."""

from __future__ import annotations

import re
import unicodedata

from improv_core.diagnostics import Edit
from improv_core.ide.references import Symbol, plays, references, scenes_called, symbol_at
from improv_core.program.analysis import Analysis
from improv_core.program.definitions import TO
from improv_core.robots.config import Robots
from improv_core.robots.toml_text import read_toml
from improv_core.syntax.characters import is_name, spelled
from improv_core.syntax.vocabulary import WORDS

_ROBOT = re.compile(r"[A-Za-z][A-Za-z0-9_]*")  # a token of a ROS 2 topic


class RefusalError(Exception):
    """Something can't be renamed. The message is one line that gives the reason."""


def renamable(analysis: Analysis, offset: int) -> Symbol:
    """Return the symbol at the cursor that can be renamed. Raises RefusalError if there is none."""
    symbol = symbol_at(analysis, offset)
    if symbol is None:
        raise RefusalError("only names, parameters, robots, and scenes can be renamed: put the cursor on one")
    if symbol.kind == "name" and symbol.definer is None:
        if symbol.text in analysis.predefined:
            what = "a word of the language" if symbol.text == TO else "a body part: rename it in improv.toml"
            raise RefusalError(f"`{symbol.text}` is {what}")
        raise RefusalError(f"`{symbol.text}` is not defined above this line: define it first")
    return symbol


def rename(analysis: Analysis, symbol: Symbol, new: str) -> list[Edit]:
    """Return the edits of a program that give a symbol a new name. Raises RefusalError."""
    if symbol.kind == "robot":
        return rename_robot(analysis, symbol.text, new)
    if not is_name(new):
        raise RefusalError(f"`{new}` is not a valid name: use letters, digits, and `_`, not starting with a digit")
    new = unicodedata.normalize("NFC", new)
    _refuse_words(spelled(new))
    if spelled(new) == symbol.text:
        return []
    if symbol.kind == "scene":
        if found := next(scenes_called(analysis, spelled(new)), None):
            line = analysis.line_number(found[0])
            raise RefusalError(f"`{spelled(new)}` is already a scene, on line {line}: choose another name")
    elif symbol.kind == "parameter":
        _refuse_other_parameter(analysis, symbol, spelled(new))
    else:
        _refuse_collision(analysis, symbol, spelled(new))
    return [Edit(reference.span, new) for reference in references(analysis, symbol)]


def rename_robot(analysis: Analysis, old: str, new: str) -> list[Edit]:
    """Return the edits of a program that rename a robot. Raises RefusalError."""
    if not _ROBOT.fullmatch(new):
        raise RefusalError(f"`{new}` is not a valid robot name: use a to z, digits, and `_`, starting with a letter")
    _refuse_words(new)
    if new == old:
        return []
    places = list(plays(analysis, old))
    if places and (index := next((index for index, _ in plays(analysis, new)), None)) is not None:
        raise RefusalError(f"`{new}` is already a robot, on line {analysis.line_number(index)}: choose another name")
    return [Edit(span, new) for _, span in places]


def rename_section(robots: Robots, old: str, new: str) -> list[Edit]:
    """Return the edits of `improv.toml`; none if the robot has no section. Raises RefusalError."""
    toml = read_toml(robots.text)
    if toml.diagnostics:
        raise RefusalError("improv.toml can't be read and may have a section for this robot: fix it first")
    if new != old and ("robots", new) in toml.positions.named:
        raise RefusalError(f"`{new}` is already a robot, in improv.toml: choose another name")
    return [Edit(span, new) for span in toml.positions.named.get(("robots", old), ()) if new != old]


def _refuse_words(new: str) -> None:
    if new in WORDS:
        raise RefusalError(f"`{new}` is a reserved word: choose another name")


def _refuse_collision(analysis: Analysis, symbol: Symbol, new: str) -> None:
    """Refuse a name that is redefined between our definition and its uses, or whose own uses ours would capture."""
    assert symbol.definer is not None
    uses = analysis.bindings.users(symbol.text, symbol.definer)
    last = max(uses, default=0)
    hidden = [index for index in uses if any(each.name == new for each in analysis.statements[index].parameters)]
    if hidden:
        raise RefusalError(f"`{new}` is a parameter on line {analysis.line_number(hidden[0])}: choose another name")
    between = [index for index in analysis.bindings.defined.get(new, ()) if symbol.definer < index < last]
    if between:
        raise RefusalError(
            f"`{new}` is already defined on line {analysis.line_number(between[0])}: choose another name"
        )
    before = analysis.bindings.definer(new, symbol.definer)
    captured = [
        index for index in analysis.bindings.users(new, -1 if before is None else before) if index > symbol.definer
    ]
    if captured:
        raise RefusalError(
            f"`{new}` on line {analysis.line_number(captured[0])} would then mean this one: choose another name"
        )


def _refuse_other_parameter(analysis: Analysis, symbol: Symbol, new: str) -> None:
    """Refuse a name that is taken in the phrase of a parameter."""
    assert symbol.definer is not None
    statement = analysis.statements[symbol.definer]
    if any(each.name == new for each in statement.parameters):
        raise RefusalError(f"`{new}` is already a parameter of this phrase: choose another name")
    if new in statement.uses:
        raise RefusalError(f"this phrase uses `{new}`, which would then mean the parameter: choose another name")
