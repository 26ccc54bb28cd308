"""Signature help: the parameters of the transformer or phrase at the cursor, and the one being typed."""

from __future__ import annotations

from dataclasses import dataclass

from improv_core.ide.body_words import takes
from improv_core.ide.cursor import BeforeCursor, before
from improv_core.ide.phrases import comment, label, movements
from improv_core.program.analysis import Analysis
from improv_core.program.definitions import Takes
from improv_core.syntax.lexer import Token
from improv_core.syntax.vocabulary import RADIUS, WORDS
from improv_core.text import Span


@dataclass(frozen=True, slots=True)
class Signature:
    """The usage of a word, its effect, its parameters as spans of the label, and the index of the one being typed."""

    label: str
    about: str
    parameters: tuple[Span, ...]
    active: int


@dataclass(slots=True)
class _Use:
    """A transformer or phrase, and the number of its arguments that have been read."""

    token: Token
    label: str
    about: str
    parameters: tuple[Span, ...]
    numbers: int
    given: int = 0


_ABOUT = {
    Takes.MOVEMENT: "A body part performs this; the base stands meanwhile.",
    Takes.POSE: "Brings the body part around it to this pose, in one beat.",
}


def signature(analysis: Analysis, offset: int) -> Signature | None:
    """Return the innermost transformer or phrase whose argument is being typed at the cursor."""
    found = before(analysis, offset)
    if not found or not found.sign:
        return None
    if measured := _measured(found):
        return measured
    use = _open(analysis, found)
    if not use:
        return None
    active = use.given
    # `repeat` needs no number: if a word has been started, it is the movement.
    if use.token.type == "REPEAT" and found.begun and not found.in_number:
        active = max(active, use.numbers)
    return Signature(use.label, use.about, use.parameters, active)


def _measured(found: BeforeCursor) -> Signature | None:
    """Return the signature of a primitive whose measure, or radius, is being typed."""
    is_typed = found.in_number or (found.tokens and found.tokens[-1].type in ("OPERATOR", "RADIUS"))
    head = found.measures if is_typed else None
    if not head:
        return None
    place = max(at for at, token in enumerate(found.tokens) if token.type == "PRIMITIVE")
    word = WORDS[found.tokens[place].text]
    names = ["angle", RADIUS, "length"] if word.velocity.yaw else ["length"]
    shown = " ".join([word.text, *names])
    spans = tuple([Span(shown.rindex(name), shown.rindex(name) + len(name)) for name in names if name != RADIUS])
    about = "Turns by this angle" if word.velocity.yaw else "Goes this far"
    return Signature(shown, f"{about} in one beat, whatever the robot's step is.", spans, int(head.type == "RADIUS"))


def _open(analysis: Analysis, found: BeforeCursor) -> _Use | None:
    """Return the innermost use that lacks an argument at the cursor."""
    levels: list[list[_Use]] = [[]]  # one for each open bracket: the uses that wait for arguments, outermost first
    last: Token | None = None
    for token in found.tokens:
        waiting = levels[-1]
        if token.type in ("NUMBER", "PARAM", "PLANE", "SENSE"):
            if waiting and waiting[-1].given < waiting[-1].numbers and not (last and last.type == "OPERATOR"):
                waiting[-1].given += 1
        elif token.type not in ("OPERATOR", "NOT", "ELSE"):
            _settle(waiting)
            if waiting:  # `repeat` needs no number
                waiting[-1].given = max(waiting[-1].given, waiting[-1].numbers)
            if use := _use(analysis, found, token):
                waiting.append(use)
            elif token.type in ("LPAR", "LSQB"):
                levels.append([])
            elif token.type in ("RPAR", "RSQB"):
                if len(levels) > 1:
                    levels.pop()
                _take_movement(levels[-1])
            elif token.type in ("PRIMITIVE", "NAME"):
                _take_movement(waiting)
            else:
                waiting.clear()  # `||`
        last = token
    if last and last.type == "OPERATOR" and levels[-1] and levels[-1][-1].given:
        levels[-1][-1].given -= 1  # the number continues
    elif not found.in_number:
        _settle(levels[-1])
    return next((level[-1] for level in reversed(levels) if level), None)


def _settle(waiting: list[_Use]) -> None:
    """Close a phrase that takes only numbers and has them all. It is a movement itself."""
    if waiting and waiting[-1].given == len(waiting[-1].parameters):
        waiting.pop()
        _take_movement(waiting)


def _take_movement(waiting: list[_Use]) -> None:
    """Give a movement to the innermost use. A use with all its movements is a movement, too."""
    while waiting:
        use = waiting[-1]
        use.given += 1
        if use.given < len(use.parameters):
            return
        waiting.pop()


def _use(analysis: Analysis, found: BeforeCursor, token: Token) -> _Use | None:
    """Return the use that starts with a token, if it takes arguments."""
    word = WORDS.get(token.text)
    if word and word.make:
        text, spans = word.text, []
        for name in (*(each.name for each in word.arguments), *word.operands):
            if name not in WORDS:
                spans.append(Span(len(text) + 1, len(text) + 1 + len(name)))
            text = f"{text} {name}"
        return _Use(token, text, word.about, tuple(spans), len(word.arguments))
    if token.type != "NAME" or any(each.name == token.text for each in found.parameters):
        return None
    if word_takes := takes(analysis, token.text, found.statement):
        text, about = f"{token.text} {word_takes.value}", _ABOUT[word_takes]
        return _Use(token, text, about, (Span(len(token.text) + 1, len(text)),), 0)
    definer = analysis.bindings.definer(token.text, found.statement)
    taken = analysis.statements[definer].parameters if definer is not None else ()
    if definer is None or not taken:
        return None
    shown, places = label(token.text, taken)
    about = comment(analysis, definer) or analysis.statements[definer].text
    return _Use(token, shown, about, places, len(taken) - movements(taken))
