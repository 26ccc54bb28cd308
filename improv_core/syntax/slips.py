"""The likeliest slips of newcomers, each with a message that says what to write and a fix that writes it."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from difflib import get_close_matches

from improv_core.diagnostics import Diagnostic, Edit, Fix, replace
from improv_core.syntax.lexer import Token
from improv_core.syntax.vocabulary import TRANSFORMERS, Kind, of_kind
from improv_core.text import Span

MEANT: Mapping[str, tuple[str, ...]] = {
    **dict.fromkeys(("wait", "stop", "stay", "stand", "hold", "halt", "sleep"), ("rest",)),
    **dict.fromkeys(("turn", "rotate", "spin"), ("left", "right")),
    **dict.fromkeys(("turnleft", "leftturn", "turn_left"), ("left",)),
    **dict.fromkeys(("turnright", "rightturn", "turn_right"), ("right",)),
    **dict.fromkeys(("go", "move", "walk", "step", "ahead", "straight", "fd"), ("forward",)),
    **dict.fromkeys(("back", "bk"), ("backward",)),
    **dict.fromkeys(("loop", "times", "forever"), ("repeat",)),
    **dict.fromkeys(("mirror", "flip"), ("reflect",)),
    **dict.fromkeys(("strafe", "sideways"), ("strafeleft", "straferight")),
    **dict.fromkeys(("climb", "rise"), ("up",)),
    **dict.fromkeys(("random", "pick"), ("choose",)),
}
"""Words that people try, in lowercase, and the words of the language that do what they want."""

_DASHES = "-–—"
_MOVEMENTS = of_kind(Kind.PRIMITIVE, *TRANSFORMERS)
_SIMILAR = 0.7
"""How similar to a word of the language a line's first word must be to be taken for it, from 0 to 1."""
_TEMPO = frozenset({"beat", "tempo", "bpm"})
_WORDS = ("PRIMITIVE", "NAME")
_OPENERS = {"RPAR": "LPAR", "RSQB": "LSQB"}
_TURNS = {"left": 90, "right": 90, "halfleft": 45, "halfright": 45}


def without_sign(tokens: Sequence[Token]) -> Diagnostic:
    """What is wrong with a statement that has neither `=` nor `$` and sets no tempo."""
    if not tokens:
        return Diagnostic("syntax", Span(0, 0), _FORMS)
    first, second = tokens[0], tokens[1] if tokens[1:] else None
    if second and first.type == "NAME" and first.text.lower() in _TEMPO and second.type == "NUMBER":
        message = f"write `beat {second.text}` to set the tempo"
        return Diagnostic("syntax", first.span, message, replace("Change to beat", first.span, "beat", safe=True))
    if all(token.text in _DASHES for token in tokens):
        span = Span(first.start, tokens[-1].end)
        fixes = replace("Change to ---", span, "---", safe=True)
        return Diagnostic("syntax", span, "write `---` to begin a new scene", fixes)
    colon = next((token for token in tokens if token.type != "NAME"), first)
    if colon.text == ":" and colon is not first:
        fixes = replace("Change to $", colon.span, " $", safe=True)
        return Diagnostic("syntax", colon.span, "write `$` instead of `:`", fixes)
    whole = Span(first.start, tokens[-1].end)
    plays = Fix("Play it: turtle1 $ …", (Edit(Span(first.start, first.start), "turtle1 $ "),))
    if first.type in ("STRAY", "NUMBER"):
        return Diagnostic("syntax", whole, _FORMS)
    if first.type != "NAME":
        message = "write a robot or a name before the movement: `turtle1 $ …` or `name = …`"
        return Diagnostic("syntax", whole, message, (plays,))
    insert = Fix("Insert $", (Edit(Span(first.end, first.end), " $"),))
    forgot = second is not None and second.type not in ("NAME", "STRAY", "NUMBER")
    if similar := get_close_matches(first.text.lower(), _MOVEMENTS, n=1, cutoff=_SIMILAR):
        form = f"turtle1 $ {similar[0]}{' …' if second else ''}"
        meant = Fix(f"Play it: {form}", (Edit(first.span, f"turtle1 $ {similar[0]}"),))
        return Diagnostic("syntax", whole, f"write a robot first: `{form}`", (meant, insert) if forgot else (meant,))
    if not forgot:
        return Diagnostic("syntax", whole, _FORMS, (plays,))
    message = f"write `$` after the robot's name: `{first.text} $ …`"
    return Diagnostic("syntax", first.span, message, (insert, plays))


def without_commas(heads: Sequence[Token]) -> tuple[list[Token], list[Diagnostic]]:
    """The tokens before `$` without commas, and the error if there are any."""
    commas = [token for token in heads if token.text == ","]
    if not commas:
        return list(heads), []
    touched = {token.start for token in heads}
    fix = Fix(
        "Remove the comma" if len(commas) == 1 else "Remove the commas",
        tuple(Edit(comma.span, " " if comma.end in touched else "") for comma in commas),
        safe=True,
    )
    message = "separate robots with spaces, without `,`"
    kept = [token for token in heads if token.text != ","]
    return kept, [Diagnostic("syntax", commas[0].span, message, (fix,))]


def misplaced_number(tokens: Sequence[Token], at: int) -> Diagnostic | None:
    """The error about a number without its word, as in `forward 2` or `2 forward`; None if it is another one."""
    end = at
    while end < len(tokens) and tokens[end].type in ("NUMBER", "OPERATOR"):
        end += 1
    if end == at or tokens[at].type != "NUMBER":
        return None
    number = "".join(token.text for token in tokens[at:end])
    span = Span(tokens[at].start, tokens[end - 1].end)
    before = tokens[at - 1] if at else None
    if before and before.type in ("NUMBER", "PARAM") and number[0] in "+-":
        message = "numbers can be multiplied and divided, but not added or subtracted: write the result"
        return Diagnostic("syntax", span, message)
    start = _start_of_term(tokens, at - 1)
    if start is not None:
        last = tokens[at - 1]
        gone = Span(last.end if span.start - last.end <= 1 else span.start, span.end)
        is_counted = start > 0 and tokens[start - 1].type == "REPEAT"
        return Diagnostic("syntax", span, *number_first(number, tokens[start], at - start == 1, gone, is_counted))
    if end < len(tokens) and tokens[end].type in (*_WORDS, *_OPENERS.values()):
        return Diagnostic("syntax", span, *number_first(number, tokens[end], tokens[end].type in _WORDS, span))
    return None


def bracketed_number(tokens: Sequence[Token], at: int) -> Diagnostic | None:
    """The error about a number in brackets, as in `poly (3)`; None if it is another one."""
    start = at if at < len(tokens) and tokens[at].text == "(" else at - 1
    if start < 0 or tokens[start].text != "(":
        return None
    end = start + 1
    while end < len(tokens) and tokens[end].type in ("NUMBER", "OPERATOR"):
        end += 1
    if end == start + 1 or end == len(tokens) or tokens[end].text != ")":
        return None
    number = "".join(token.text for token in tokens[start + 1 : end])
    is_apart = start > 0 and tokens[start - 1].end < tokens[start].start
    edits = (Edit(tokens[start].span, "" if is_apart else " "), Edit(tokens[end].span, ""))
    message = f"write `{number}` without brackets: only movements can stand in them"
    span = Span(tokens[start].start, tokens[end].end)
    return Diagnostic("syntax", span, message, (Fix("Remove the brackets", edits, safe=True),))


def number_first(
    number: str, term: Token, is_word: bool, gone: Span, is_counted: bool = False
) -> tuple[str, tuple[Fix, ...]]:
    """The message about a number without its word, and its fixes: they remove it at `gone` and write it before the term
    that starts with this token. If the term `is_counted`, `repeat` stands before it and lacks its number."""
    written = term.text if is_word else "( … )" if term.text == "(" else "[ … ]"
    ways = [number] if is_counted else list(_ways(term, number))
    shown = [f"{'repeat ' if is_counted else ''}{way} {written}" for way in ways]
    message = f"write {' or '.join(f'`{title}`' for title in shown)}"
    if gone.end <= term.start:
        return message, tuple(
            Fix(f"Change to {title}", (Edit(gone, way),)) for title, way in zip(shown, ways, strict=True)
        )
    return f"{message}: the number comes first", tuple(
        Fix(f"Change to {title}", (Edit(Span(term.start, term.start), f"{way} "), Edit(gone, "")))
        for title, way in zip(shown, ways, strict=True)
    )


def is_like_a_robot(name: str) -> bool:
    """Whether a name looks like that of a robot: turtlesim's are `turtle1`, `turtle2`, …"""
    return bool(_ROBOT.fullmatch(name))


_ROBOT = re.compile(r"(turtle|robot)_?[0-9]*")
_FORMS = "write `robot $ movement`, `name = movement`, or `beat 60`"


def _ways(term: Token, number: str) -> Iterator[str]:
    """The words and numbers that may be meant by a number after a term that starts with this token."""
    if term.text in _TURNS and number.isdecimal() and len(number.lstrip("0")) > 1:  # nobody means ten quarter turns
        yield f"scale {number}/{_TURNS[term.text]}"
        return
    if number.isdecimal():
        yield f"repeat {number}"
    if term.text != "rest":
        yield f"scale {number}"


def _start_of_term(tokens: Sequence[Token], last: int) -> int | None:
    """The index at which the word or bracket that ends at the index `last` starts."""
    if last < 0:
        return None
    token = tokens[last]
    if token.type in _WORDS:
        return last
    depth = 0
    for place in range(last, -1, -1) if token.type in _OPENERS else ():
        depth += (tokens[place].type in _OPENERS) - (tokens[place].type in _OPENERS.values())
        if not depth:
            return place
    return None
