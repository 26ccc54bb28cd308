"""Completion: the words that may come at the cursor, according to the grammar and the names in scope."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import islice, pairwise

from improv_core.ide import body_words
from improv_core.ide.completion_item import Item
from improv_core.ide.completion_opening import after_robots, first_words, offers, usual_numbers
from improv_core.ide.cursor import BeforeCursor, before
from improv_core.ide.hover import Hover, name_at, robot_at, sense_at
from improv_core.ide.phrases import label, movements, parameters
from improv_core.ide.references import by_profile, performers
from improv_core.ide.senses import source
from improv_core.plain import printable
from improv_core.program.analysis import Analysis
from improv_core.program.definitions import Definition, Takes
from improv_core.program.feasibility import impossible
from improv_core.program.timing import in_beats
from improv_core.score.algebra import hold
from improv_core.score.body import Body
from improv_core.score.lengths import lengths
from improv_core.score.profiles import MOTIONS, Profile
from improv_core.syntax.derivation import may_come_next
from improv_core.syntax.lexer import Token
from improv_core.syntax.nodes import Parameter
from improv_core.syntax.vocabulary import RADIUS, UNITS, WORDS
from improv_core.syntax.word import A_NUMBER, Kind, Word
from improv_core.text import Span, has_in_order

MAX_NAMES = 300
"""If there are more names, completion offers only those that match the typed letters."""

_NUMBERS = frozenset({"NUMBER", "PARAM"})
_KINDS = ("movement", "number")

_A_RADIUS = Item(RADIUS, "keyword", "Drives along a circle with this radius.", f"{RADIUS} ${{1:1m}}")

_DECIMAL_BEGUN = re.compile(r"\d\.$")
_NOTHING_AFTER = re.compile(r"\w*[ \t\ufeff]*(?:[)\]|#\r\n]|$)")


@dataclass(frozen=True, slots=True)
class Completion:
    """The words that can replace the text at `span`, best first.

    `statement` is the index of the statement being written, which determines the meanings of names. `whole` is false if
    some names were left out.
    """

    span: Span
    items: Sequence[Item]
    statement: int
    whole: bool


def complete(analysis: Analysis, offset: int) -> Completion | None:
    """Return the words that may come at the cursor; None in comments and in numbers."""
    found = before(analysis, offset)
    if not found or _DECIMAL_BEGUN.search(analysis.text, max(offset - 2, 0), offset):
        return None
    if found.in_number:
        units = list(_units_offered(found))
        return Completion(Span(offset - len(found.unit), offset), units, found.statement, True) if units else None
    if found.sign is None:
        items, whole = list(_heads(analysis, found)), True
    else:
        items, whole = _movement(analysis, found, bare=not _NOTHING_AFTER.match(analysis.text, offset))
        items = _possible_first(analysis, found, items)
    return Completion(Span(offset - len(found.begun), offset), items, found.statement, whole)


def _movement(analysis: Analysis, found: BeforeCursor, bare: bool) -> tuple[list[Item], bool]:
    """Return the words that may come in a movement, and whether all names are among them. `bare` if the operand of a
    word already follows the cursor."""
    assert found.sign
    bodies = _bodies(analysis, found)
    last = found.tokens[-1] if found.tokens else None
    if last and last.type == "NAME" and body_words.takes(analysis, last.text, found.statement) is Takes.POSE:
        return list(body_words.poses_offered(bodies)), True
    heads = 1 if found.sign.type == "EQUAL" else max(len(found.heads), 1)
    accepted = may_come_next(["HEAD"] * heads + [found.sign.type, *(token.type for token in found.tokens)])
    if (wanted := _number_wanted(analysis, found)) is not None:
        accepted = accepted - _NUMBERS if not wanted else _NUMBERS
    names, whole = _names_in(analysis, found) if "NAME" in accepted else ([], True)
    offered = (_name(each, analysis.statements[index].parameters, bare) for index, each in names)
    unit = _default_unit(last) if last and found.measures is last else ""
    parameters = (
        Item(f"{each.name}*1{unit}" if unit and each.is_number else each.name, "parameter", _KINDS[each.is_number])
        for each in found.parameters
        if ("PARAM" if each.is_number else "NAME") in accepted
    )
    senses = [Item(name, "sense", source(analysis.config, name)) for name in analysis.config.sense_names]
    own = [each.name for each in found.parameters]
    hidden = [*own, *(name for name in analysis.predefined if analysis.definition(name, found.statement))]
    parts = body_words.offered(bodies, hidden) if "NAME" in accepted else ()
    numbers, words = _numbers_offered(accepted, found), _words(accepted, bare)
    others = [*(senses if "SENSE" in accepted else ()), *parts, *words]
    # Behind a word such as `forward`, another word is likelier than its measure; behind `left 90deg`, a radius is.
    words_first = found.measures == (found.tokens[-1] if found.tokens else None)
    return [*parameters, *offered, *([*others, *numbers] if words_first else [*numbers, *others])], whole


def _bodies(analysis: Analysis, found: BeforeCursor) -> list[Body]:
    """Return the bodies of the robots that perform the statement being written."""
    return [profile.body for profile in _players(analysis, found) if profile.body]


def _players(analysis: Analysis, found: BeforeCursor) -> Mapping[Profile, str]:
    """Return the profiles of the robots that perform the statement being written, and the first robot of each."""
    if found.sign and found.sign.type == "EQUAL":
        return performers(analysis, found.statement) if found.statement < len(analysis.statements) else {}
    return by_profile(analysis.opening.config, [head.text for head in found.heads])


def _possible_first(analysis: Analysis, found: BeforeCursor, items: list[Item]) -> list[Item]:
    """Move the words that a robot here can't perform to the end, with the reason."""
    players = _players(analysis, found)
    limited = {profile: robot for profile, robot in players.items() if len(profile.motions) < len(MOTIONS)}
    if not limited:
        return items
    why = [_impossible(analysis, found, item, limited) for item in items]
    last = [replace(item, detail=each) for item, each in zip(items, why, strict=True) if each]
    return [*(item for item, each in zip(items, why, strict=True) if not each), *last]


def _impossible(analysis: Analysis, found: BeforeCursor, item: Item, players: Mapping[Profile, str]) -> str:
    """Explain why a robot can't perform a word: `anna can't move sideways`; empty if all robots can."""
    part = None
    if item.kind == "movement":
        part = hold(WORDS[item.label].velocity)
    elif item.kind == "name":
        named = analysis.definition(item.label, found.statement)
        part = named.movement if named else None
    for profile, robot in players.items() if part else ():
        if part and (doing := impossible(part, profile)):
            return f"{printable(robot)} can't {doing}"
    return ""


def _number_wanted(analysis: Analysis, found: BeforeCursor) -> bool | None:
    """Return whether the name before the cursor, which may have numbers, needs another one; None without a name."""
    last = len(found.tokens) - 1
    while last >= 0 and found.tokens[last].type in ("NUMBER", "PARAM", "OPERATOR"):
        last -= 1
    if last < 0 or found.tokens[last].type != "NAME" or found.tokens[-1].type == "OPERATOR":
        return None
    given = sum(
        token.type != "OPERATOR" and before.type != "OPERATOR" for before, token in pairwise(found.tokens[last:])
    )
    taken = parameters(analysis, found.tokens[last].text, found.statement)
    own = {each.name for each in found.parameters}
    return found.tokens[last].text not in own and given < len(taken) - movements(taken)


def document(analysis: Analysis, item: Item, statement: int, pictures: bool) -> Hover | None:
    """Return the documentation of a word that is offered in a statement, made when a person looks at it."""
    if item.kind in ("name", "phrase"):
        return name_at(analysis, item.label, min(statement, len(analysis.statements) - 1), pictures)
    if item.kind == "robot":
        return robot_at(analysis, item.label, pictures)
    if item.kind == "sense":
        return sense_at(analysis, item.label)
    word = WORDS.get(item.label)
    return Hover(Span(0, 0), word.usage, f": {word.about}") if word else None


def _heads(analysis: Analysis, found: BeforeCursor) -> Iterator[Item]:
    """Yield the words that a statement may start with, and more robots if it starts with robots."""
    heads = [token.text for token in found.heads]
    if found.opening:
        yield from offers(analysis, found.opening, [*found.heads])
        return
    if heads == ["beat"]:
        yield from _numbers("beat")
        return
    if not heads:
        yield Item("beat", "keyword", WORDS["beat"].about, "beat ${1:60}")
    if heads in (["room"], ["bar"]):
        yield from usual_numbers(heads[0])
    if all(token.type == "NAME" for token in found.heads):
        plays = analysis.lengths
        for robot in dict.fromkeys([*analysis.config.robots, *plays, *analysis.opening.places]):
            if robot not in heads:
                where = "in improv.toml" if robot in analysis.config.robots else "only stands there"
                yield Item(robot, "robot", in_beats(plays[robot]) if robot in plays else where)
        yield from after_robots() if heads else first_words(analysis)


def _words(accepted: frozenset[str], bare: bool) -> Iterator[Item]:
    """Yield the words of these terminals; `bare` if their operand already follows the cursor."""
    for word in WORDS.values():
        if word.kind.value in accepted and word.kind is not Kind.BEAT:
            kind = {Kind.PRIMITIVE: "movement", Kind.PLANE: "plane"}.get(word.kind, "keyword")
            yield Item(word.text, kind, word.about, _snippet(word, bare))


def _numbers_offered(accepted: frozenset[str], found: BeforeCursor) -> Iterator[Item]:
    """Yield usual numbers and measures behind the last word, and `radius` behind a turn."""
    if "NUMBER" in accepted and found.tokens:
        last = found.tokens[-1]
        yield from _usual_measures(last) if last.type in ("PRIMITIVE", "RADIUS") else _numbers(last.text)
    if "RADIUS" in accepted and found.measures and _turns(found.measures):
        yield _A_RADIUS


def _numbers(word: str) -> Iterator[Item]:
    """Return usual numbers after a word."""
    arguments = WORDS[word].arguments if word in WORDS else ()
    wanted = arguments[0] if arguments else A_NUMBER
    return (Item(value, "number", wanted.unit) for value in wanted.usual)


def _turns(word: Token) -> bool:
    """Return whether a token is a word that turns robots."""
    return word.text in WORDS and bool(WORDS[word.text].velocity.yaw)


def _default_unit(word: Token) -> str:
    """Return the usual unit behind a primitive or `radius`; "" behind those that take no measure."""
    if word.type != "RADIUS" and (word.text == "rest" or word.text.startswith("half")):
        return ""
    return "deg" if _turns(word) else "m"


def _usual_measures(word: Token) -> Iterator[Item]:
    """Yield usual measures behind a primitive or `radius`."""
    values = {"deg": ("90deg", "45deg"), "m": ("1m", "50cm")}.get(_default_unit(word), ())
    return (Item(value, "number", "meters" if word.type == "RADIUS" else "in one beat") for value in values)


def _units_offered(found: BeforeCursor) -> Iterator[Item]:
    """Yield the units that may stand directly behind the number at the cursor, the likelier ones first: under body
    parts, each direction takes what its joint does."""
    head = found.measures
    if found.sign and head:
        if not _default_unit(head) or any(each.type == "UNIT" and each.start > head.start for each in found.tokens):
            return  # this word takes no measure, or it has its one unit
        fields = ["meters"] if head.type == "RADIUS" else ["meters", "degrees"]
        fields = fields[::-1] if _turns(head) else fields
    elif not found.sign and found.opening and found.opening.kind in ("AT", "ROOM"):
        words = [word.text for word in found.opening.words if word.type != "UNIT"]
        fields = ["degrees"] if words[-1:] == ["facing"] else ["meters"]
    else:
        return
    for field in fields:
        for name, unit in UNITS.items():
            if unit.field == field:
                yield Item(name, "value", unit.about)


def _snippet(word: Word, bare: bool) -> str:
    """Return a transformer with places for its arguments: those of its usage, such as `ramp 1/2 2 movement`."""
    if not word.make:
        return ""
    if len(word.operands) > 1:
        return "" if bare else f"{word.text} ${{1:{word.arguments[0].example}}} ($2) else ($0)"
    text = word.text
    for place, each in enumerate(word.arguments, 1):
        text += f" ${{{place}|{','.join(each.choices)}|}}" if each.choices else f" ${{{place}:{each.example}}}"
    return f"{text} ($0)" if not bare else text if text != word.text else ""


def _name(name: Definition, taken: Sequence[Parameter], bare: bool) -> Item:
    """Return a name, with places for its arguments if it is a phrase."""
    if not taken:
        return Item(name.name, "name", in_beats(lengths(name.movement)))
    last = len(taken) - 1
    text = name.name
    for place, each in enumerate(taken):
        if each.is_number:
            text += f" ${{{place + 1}:{each.name}}}"
        elif place < last:
            text += f" (${{{place + 1}:{each.name}}})"
        elif not bare:
            text += " ($0)"
    return Item(name.name, "phrase", label(name.name, taken)[0], text if text != name.name else "")


def _names_in(analysis: Analysis, found: BeforeCursor) -> tuple[list[tuple[int, Definition]], bool]:
    """Return the names to offer, the nearest first, with the statements that define them, and whether these are all."""
    own = {each.name for each in found.parameters}
    definers = _definers(analysis, found.statement)
    names: Iterable[str] = [name for name in definers if name not in own]
    whole = len(definers) <= MAX_NAMES
    if not whole:
        letters = found.begun.lower()
        names = islice((name for name in names if has_in_order(name.lower(), letters)), MAX_NAMES)
    indices = [definers[name] for name in names]
    return [(index, each) for index in indices if (each := analysis.meanings[index].definition)], whole


def _definers(analysis: Analysis, before: int) -> Mapping[str, int]:
    """Return the names in scope of a statement, the nearest first, and the statements that define them."""
    found: dict[str, int] = {}
    for index in range(min(before, len(analysis.meanings)) - 1, -1, -1):
        definition = analysis.meanings[index].definition
        if definition and definition.name not in found:
            found[definition.name] = index
    return found
