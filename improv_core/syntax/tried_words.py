"""Words that newcomers try, and what to write instead: other words, a figure, or advice."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from typing import TypeVar

from improv_core.diagnostics import Edit, Fix, replace
from improv_core.syntax.characters import continues_name
from improv_core.syntax.lexer import Token
from improv_core.syntax.units import unit_meant
from improv_core.text import Span

_T = TypeVar("_T")


def _table(*rows: tuple[str, _T]) -> Mapping[str, _T]:
    """Return a value for each of the words in a row."""
    return {word: value for words, value in rows for word in words.split()}


TRIED: Mapping[str, tuple[str, ...]] = _table(
    ("wait stop stay stand hold halt sleep", ("rest",)),
    ("turn rotate spin", ("left", "right")),
    ("turnleft leftturn turn_left lt", ("left",)),
    ("turnright rightturn turn_right rt", ("right",)),
    ("turnaround uturn", ("left 180deg",)),
    ("go move walk step ahead straight fd fwd", ("forward",)),
    ("back bk", ("backward",)),
    ("loop times forever", ("repeat",)),
    ("mirror flip", ("reflect sagittal",)),
    ("strafe sideways sidestep", ("strafeleft", "straferight")),
    ("climb rise lift jump", ("up",)),
    ("random pick rand dice", ("choose",)),
    ("accelerate speedup", ("ramp 1/2 2",)),
    ("decelerate brake", ("ramp 2 1/2",)),
    ("faster speed", ("fast 2", "ramp 1/2 2")),
    ("slower", ("slow 2", "ramp 2 1/2")),
    ("quick quickly", ("fast 2",)),
    ("slowly", ("slow 2",)),
    ("gently smooth smoothly", ("ease",)),
    ("twice", ("repeat 2",)),
    ("double big bigger large larger", ("scale 2",)),
    ("half small smaller little tiny", ("scale 1/2",)),
    ("while with together", ("||",)),
    *((word, (str(number),)) for number, word in enumerate(("two", "three", "four", "five", "six", "seven"), 2)),
)
"""Words that people try, in lowercase, and the words of the language that mean the same."""
SENSES_TRIED = _table(
    ("wall obstacle close blocked", "near"), ("hit touch crash collision", "bump"), ("signal key clap button", "cue")
)
"""Senses that people try, and those that every robot has."""
DURATIONS = ("beats", "seconds", "secs", "sec")
"""Units of time that people write behind a number."""
ADVICE = _table(
    (
        "follow follows leader copy same imitate",
        "name a movement that all play, and have each follow the one before it: `ada bo $ canon 2 name`",
    ),
    (
        "face toward towards look",
        "turn by an angle, such as `left 45deg`, or start the robot that way: `ada at 0 0 facing 90`",
    ),
    (
        " ".join(("for over lasting", *DURATIONS)),
        "write the time first: `slow 4 forward` is one step in 4 beats, and `fit 4 ( … )` plays anything in 4 beats",
    ),
    ("pen penup pendown pu pd", "robots have no pen: the page draws the path of each"),
    ("or either", "dice choose one of several movements in `choose ( … )`"),
    (
        "after later before behind delay at",
        "write rests before the movement, such as `repeat 2 rest`, or `canon 2` after `$`",
    ),
)
"""Words for which the language has no other word, in lowercase, and how to write what they ask for."""
_TIMED = {"rest": "repeat {}", "ramp": "fit {}"}
"""Words before a word of `TRIED` that set its beats."""
_FILLERS = frozenset({"then", "a", "an", "the", "please", "in", "out"})

_FIGURES: Mapping[str, str] = {
    "arc": "left 90deg radius 1m",
    "curve": "left 90deg radius 1m",
    "bow": "ease (scale 1/4 (forward backward))",
    "circle": "left 360deg radius 50cm",
    "eight": "left 360deg radius 50cm right 360deg radius 50cm",
    "heart": "forward 70cm left 180deg radius 35cm right 90deg left 180deg radius 35cm forward 70cm",
    "spiral": "ramp 1/4 2 repeat 12 forward || repeat left",
    "square": "repeat 4 (forward left)",
    "star": "repeat 5 (forward left 144deg)",
    "triangle": "repeat 3 (forward left 120deg)",
    "zigzag": "halfleft repeat 2 (forward right forward left)",
}
"""Figures that people name before they define them, each with a movement that draws it."""
_SIZES = re.compile(r"(radius|forward)( \d+\w+)?")

TURNING = ("left", "right", "halfleft", "halfright")
_GOING = ("forward", "backward", "strafeleft", "straferight", "up", "down")
_REDUNDANT_WITH = _table(("turn rotate spin", TURNING), ("go move walk step ahead straight", _GOING))
"""Words of `TRIED` that add nothing before or after one of these words of the language."""


def figure(name: str, size: str = "") -> str | None:
    """Return a movement that draws a figure, perhaps of a size; None if it can't."""
    drawn = _FIGURES.get(name.lower())
    if not drawn or not size:
        return drawn
    is_one = len({match[2] for match in _SIZES.finditer(drawn)}) == 1
    return _SIZES.sub(rf"\1 {size}", drawn) if is_one else None


def instead(tokens: Sequence[Token], at: int) -> tuple[str, tuple[Fix, ...]] | None:
    """Return the message about a word that people try, and its fixes; None if it is none."""
    token, after = tokens[at], [*tokens[at + 1 : at + 2], None][0]
    name, word = token.text, token.text.lower()
    is_pair = after is not None and (word not in _REDUNDANT_WITH or after.type == "NAME")
    if after and is_pair and (word + after.text).lower() in TRIED:  # `speed up`
        return _meant([*tokens[:at], token._replace(text=f"{name} {after.text}", end=after.end), *tokens[at + 2 :]], at)
    types = [each.type for each in tokens[max(at - 2, 0) : at]]
    if (types == ["REPEAT", "NUMBER"] and is_count(token)) or (types == ["FACTOR", "NUMBER"] and word in DURATIONS):
        return _without(Span(tokens[at - 1].end, token.end), name, tokens[at - 2].text)  # `repeat 4x`, `canon 4 beats`
    if at and after and is_count(token) and after.type == "NUMBER":
        return f"write `repeat {after.text}` before the movement, instead of `{name} {after.text}`", ()
    if word in TRIED:
        return _meant(tokens, at)
    if word in _FILLERS and after:
        fixes = replace(f"Remove {name}", Span(token.start, after.start), "")
        return f"remove `{name}`: a space plays one movement after another", fixes
    if word == "and":
        return either(token)
    return (f"`{name}` is not defined: {ADVICE[word]}", ()) if word in ADVICE else _logo_repeat(tokens, at)


def either(token: Token) -> tuple[str, tuple[Fix, ...]]:
    """Return the message about `and` or a sign like it between movements, and its fixes."""
    words = ((f"Remove {token.text}", ""), ("Change to ||", "||"))
    fixes = tuple(fix for title, text in words for fix in replace(title, token.span, text, guess=True))
    return f"remove `{token.text}`: a space plays one movement after another, `||` both at the same time", fixes


def is_count(token: Token) -> bool:
    """Return whether a word behind a number counts, as in `4 times`."""
    return token.text.lower() in ("x", "times", "time", "steps")


def _without(gone: Span, name: str, word: str) -> tuple[str, tuple[Fix, ...]]:
    """Return the message about a word that adds nothing to another, and its fix."""
    return f"remove `{name}`: `{word}` is enough", replace(f"Remove {name}", gone, "")


def _meant(tokens: Sequence[Token], at: int) -> tuple[str, tuple[Fix, ...]]:
    """Return the message about one of the words of `TRIED`, and its fixes."""
    token, name, word = tokens[at], tokens[at].text, tokens[at].text.lower().replace(" ", "")
    before, after, behind = (tokens[at - 1] if at else None), *[*tokens[at + 1 : at + 3], None, None][:2]
    number = after if after and after.type == "NUMBER" else None
    meant = TRIED[word]
    same = {*meant, *_REDUNDANT_WITH.get(word, ())}
    if after and after.text in ("left", "right") and (word == "step" or "strafeleft" in meant):
        form = f"strafe{after.text}"
        fixes = replace(f"Change to {form}", Span(token.start, after.end), form)
        return f"`{name}` is not defined: did you mean `{form}`?", fixes
    if after and same.issuperset(TRIED.get(after.text.lower(), (after.text,))):
        return _without(Span(token.start, after.start), name, after.text)
    if before and before.text in same and (before.text == "repeat" or before.text in TURNING):
        return _without(Span(before.end, token.end), name, before.text)
    form = _TIMED.get(meant[0].split()[0], "")
    if number and form and not (behind and behind.type == "OPERATOR"):
        end = behind.end if behind and behind.text in (*DURATIONS, "s") else number.end  # `wait 2 beats`
        form = f"{form.format(number.text)} {meant[0]}"
        return f"write `{form}`", replace(f"Change to {form}", Span(token.start, end), form)
    if number and meant[0] in (*TURNING, *_GOING):
        is_apart = behind is None or behind.start > number.end or not continues_name(behind.text[0])
        if is_apart and not (behind and unit_meant(behind.text)):
            return _measured(token, number, meant)
    if number and meant[0] in ("fast 2", "slow 2"):
        meant = (meant[0].split()[0],)  # `faster 3`
    message = f"`{name}` is not defined: did you mean {' or '.join(f'`{each}`' for each in meant)}?"
    # A count without `repeat` is no loop, and a word beside a movement may only describe it.
    is_beside = any(each and each.type == "PRIMITIVE" for each in (before, after))
    guess = not number if meant == ("repeat",) else is_beside and meant != ("rest",)
    return message, tuple(fix for each in meant for fix in replace(f"Change to {each}", token.span, each, guess=guess))


def _measured(token: Token, number: Token, meant: Sequence[str]) -> tuple[str, tuple[Fix, ...]]:
    """Return the message about a word that people try with a number, as in Logo's `fd 100`, and its fixes."""
    unit = "deg" if meant[0] in TURNING else "cm"
    put = Edit(Span(number.end, number.end), unit)
    shown = {f"{word} {number.text}{unit}": (Edit(token.span, word), put) for word in meant}
    fixes = tuple(Fix(f"Change to {text}", edits, guess=unit == "cm") for text, edits in shown.items())
    return f"`{token.text}` is not defined: write {' or '.join(f'`{text}`' for text in shown)}", fixes


def _logo_repeat(tokens: Sequence[Token], at: int) -> tuple[str, tuple[Fix, ...]] | None:
    """Return the message about Logo's `REPEAT 4 [ … ]`, and the fix: our square brackets squeeze what is in them."""
    if [token.type for token in tokens[at + 1 : at + 3]] != ["NUMBER", "LSQB"] or tokens[at].text.lower() != "repeat":
        return None
    depth = 0
    for token in tokens[at + 2 :]:
        depth += (token.type == "LSQB") - (token.type == "RSQB")
        if not depth:
            edits = (Edit(tokens[at].span, "repeat"), Edit(tokens[at + 2].span, "("), Edit(token.span, ")"))
            shown = f"repeat {tokens[at + 1].text} ( … )"
            return f"write `{shown}`: words are in lowercase, and `[ ]` squeezes", (Fix(f"Change to {shown}", edits),)
    return None
