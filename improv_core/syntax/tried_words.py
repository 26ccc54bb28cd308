"""Words that newcomers try, and what to write instead: other words, a figure, or advice."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence

from improv_core.diagnostics import Edit, Fix, replace
from improv_core.syntax.characters import continues_name
from improv_core.syntax.lexer import Token
from improv_core.syntax.units import unit_meant
from improv_core.text import Span

TRIED: Mapping[str, tuple[str, ...]] = {
    **dict.fromkeys(("wait", "stop", "stay", "stand", "hold", "halt", "sleep"), ("rest",)),
    **dict.fromkeys(("turn", "rotate", "spin"), ("left", "right")),
    **dict.fromkeys(("turnleft", "leftturn", "turn_left", "lt"), ("left",)),
    **dict.fromkeys(("turnright", "rightturn", "turn_right", "rt"), ("right",)),
    **dict.fromkeys(("turnaround", "uturn"), ("left 180deg",)),
    **dict.fromkeys(("go", "move", "walk", "step", "ahead", "straight", "fd", "fwd"), ("forward",)),
    **dict.fromkeys(("back", "bk"), ("backward",)),
    **dict.fromkeys(("loop", "times", "forever"), ("repeat",)),
    **dict.fromkeys(("mirror", "flip"), ("reflect sagittal",)),
    **dict.fromkeys(("strafe", "sideways", "sidestep"), ("strafeleft", "straferight")),
    **dict.fromkeys(("climb", "rise", "lift", "jump"), ("up",)),
    **dict.fromkeys(("random", "pick", "rand", "dice"), ("choose",)),
    **dict.fromkeys(("accelerate", "speedup"), ("ramp 1/2 2",)),
    **dict.fromkeys(("decelerate", "brake"), ("ramp 2 1/2",)),
    **dict.fromkeys(("faster", "speed"), ("fast 2", "ramp 1/2 2")),
    "slower": ("slow 2", "ramp 2 1/2"),
    **dict.fromkeys(("quick", "quickly"), ("fast 2",)),
    "slowly": ("slow 2",),
    **dict.fromkeys(("gently", "smooth", "smoothly"), ("ease",)),
    "twice": ("repeat 2",),
    **dict.fromkeys(("double", "big", "bigger", "large", "larger"), ("scale 2",)),
    **dict.fromkeys(("half", "small", "smaller", "little", "tiny"), ("scale 1/2",)),
    **dict.fromkeys(("while", "with", "together"), ("||",)),
    **{word: (str(n),) for n, word in enumerate(("two", "three", "four", "five", "six", "seven", "eight"), 2)},
}
"""Words that people try, in lowercase, and the words of the language that mean the same."""

SENSES_TRIED: Mapping[str, str] = {
    **dict.fromkeys(("wall", "obstacle", "close", "blocked"), "near"),
    **dict.fromkeys(("hit", "touch", "crash", "collision"), "bump"),
    **dict.fromkeys(("signal", "key", "clap", "button"), "cue"),
}
"""Senses that people try, and those that every robot has."""
DURATIONS = ("beats", "seconds", "secs", "sec")
"""Units of time that people write behind a number."""
ADVICE: Mapping[str, str] = {
    **dict.fromkeys(
        ("follow", "follows", "leader", "copy", "same", "imitate"),
        "name a movement that all play, and have each follow the one before it: `ada bo $ canon 2 name`",
    ),
    **dict.fromkeys(
        ("face", "toward", "towards", "look"),
        "turn by an angle, such as `left 45deg`, or start the robot that way: `ada at 0 0 facing 90`",
    ),
    **dict.fromkeys(
        ("for", "over", "lasting", *DURATIONS),
        "write the time first: `slow 4 forward` is one step in 4 beats, and `fit 4 ( … )` plays anything in 4 beats",
    ),
    **dict.fromkeys(("pen", "penup", "pendown", "pu", "pd"), "robots have no pen: the page draws the path of each"),
    **dict.fromkeys(("or", "either"), "dice choose one of several movements in `choose ( … )`"),
    **dict.fromkeys(
        ("after", "later", "before", "behind", "delay", "at"),
        "write rests before the movement, such as `repeat 2 rest`, or `canon 2` after `$`",
    ),
}
"""Words for which the language has no other word, in lowercase, and how to write what they ask for."""
BOTH = "a space plays one movement after another, `||` both at the same time"
_TIMED = {"rest": "repeat {}", "ramp": "fit {}"}
"""Words before a word of `TRIED` that give it so many beats."""
_FILLERS = frozenset({"then", "a", "an", "the", "please", "in", "out"})

_FIGURES: Mapping[str, str] = {
    **dict.fromkeys(("arc", "curve"), "left 90deg radius 1m"),
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
_REDUNDANT_WITH: Mapping[str, tuple[str, ...]] = {
    **dict.fromkeys(("turn", "rotate", "spin"), TURNING),
    **dict.fromkeys(("go", "move", "walk", "step", "ahead", "straight"), _GOING),
}
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
    name, word = tokens[at].text, tokens[at].text.lower()
    pair = " ".join(each.text for each in tokens[at : at + 2])
    is_pair = word not in _REDUNDANT_WITH or any(each.type == "NAME" for each in tokens[at + 1 : at + 2])
    if is_pair and pair != name and _one(pair) in TRIED:  # `speed up`
        joined = Token("NAME", pair, tokens[at].start, tokens[at + 1].end)
        return _meant([*tokens[:at], joined, *tokens[at + 2 :]], at)
    if is_times(tokens, at):
        return _without(tokens, at - 1, tokens[at], tokens[at - 2].text)
    if at and is_count(tokens[at]) and (counts := [each for each in tokens[at + 1 : at + 2] if each.type == "NUMBER"]):
        return f"write `repeat {counts[0].text}` before the movement, instead of `{name} {counts[0].text}`", ()
    if word in TRIED:
        return _meant(tokens, at)
    if word in _FILLERS and tokens[at + 1 :]:
        gone = Span(tokens[at].start, tokens[at + 1].start)
        return f"remove `{name}`: a space plays one movement after another", replace(f"Remove {name}", gone, "")
    if word == "and":
        return either(tokens[at])
    return (f"`{name}` is not defined: {ADVICE[word]}", ()) if word in ADVICE else logo_repeat(tokens, at)


def _one(name: str) -> str:
    return name.lower().replace(" ", "")


def either(token: Token) -> tuple[str, tuple[Fix, ...]]:
    """Return the message about `and` or a sign like it between movements, and its fixes."""
    words = ((f"Remove {token.text}", ""), ("Change to ||", "||"))
    fixes = [fix for title, text in words for fix in replace(title, token.span, text, guess=True)]
    return f"remove `{token.text}`: {BOTH}", tuple(fixes)


def is_times(tokens: Sequence[Token], at: int) -> bool:
    """Return whether a word only says that a `repeat` before it counts: `repeat 4 times`, `repeat 4x`."""
    return is_count(tokens[at]) and [each.type for each in tokens[max(at - 2, 0) : at]] == ["REPEAT", "NUMBER"]


def is_count(token: Token) -> bool:
    """Return whether a word behind a number counts, as in `4 times`."""
    return token.text.lower() in ("x", "times", "time", "steps")


def _without(tokens: Sequence[Token], last: int, gone: Token, word: str) -> tuple[str, tuple[Fix, ...]]:
    """Return the message about a word after the token at the index `last` that adds nothing to another, and its fix."""
    span = Span(tokens[last].end, gone.end)
    return f"remove `{gone.text}`: `{word}` is enough", replace(f"Remove {gone.text}", span, "")


def _meant(tokens: Sequence[Token], at: int) -> tuple[str, tuple[Fix, ...]]:
    """Return the message about one of the words of `TRIED`, and its fixes."""
    token, name = tokens[at], tokens[at].text
    before, after = (tokens[at - 1] if at else None), (tokens[at + 1] if at + 1 < len(tokens) else None)
    meant = TRIED[_one(name)]
    same = {*meant, *_REDUNDANT_WITH.get(_one(name), ())}
    is_aside = after is not None and after.text in ("left", "right") and name.lower() == "step"
    if not is_aside and after and same.issuperset(TRIED.get(after.text.lower(), (after.text,))):
        gone = Span(token.start, after.start)
        return f"remove `{name}`: `{after.text}` is enough", replace(f"Remove {name}", gone, "")
    if before and before.text in same and (before.text == "repeat" or before.text in TURNING):
        return _without(tokens, at - 1, token, before.text)
    if after and (is_aside or ("strafeleft" in meant and after.text in ("left", "right"))):
        word = f"strafe{after.text}"
        fixes = replace(f"Change to {word}", Span(token.start, after.end), word)
        return f"`{name}` is not defined: did you mean `{word}`?", fixes
    behind = tokens[at + 2 : at + 3]
    is_product = any(each.type == "OPERATOR" for each in behind)
    if after and after.type == "NUMBER" and not is_product and (form := _TIMED.get(meant[0].split()[0])):
        end = next((each.end for each in behind if each.text in (*DURATIONS, "s")), after.end)
        text = f"{form.format(after.text)} {meant[0]}"  # `wait 2 beats`
        return f"write `{text}`", replace(f"Change to {text}", Span(token.start, end), text)
    has_unit = after is not None and any(
        unit_meant(each.text) or (each.start == after.end and continues_name(each.text[0])) for each in behind
    )
    if after and after.type == "NUMBER" and meant[0] in (*TURNING, *_GOING) and not has_unit:
        return _measured(token, after, meant)
    if after and after.type == "NUMBER" and meant[0] in ("fast 2", "slow 2"):
        meant = (meant[0].split()[0],)  # `faster 3`
    message = f"`{name}` is not defined: did you mean {' or '.join(f'`{word}`' for word in meant)}?"
    beside = [each.type for each in (before, after) if each]
    # A count without `repeat` is no loop, and a word beside a movement may only describe it.
    guess = after is None or after.type != "NUMBER" if meant == ("repeat",) else "PRIMITIVE" in beside
    guess = guess and meant != ("rest",)
    return message, tuple(fix for word in meant for fix in replace(f"Change to {word}", token.span, word, guess=guess))


def _measured(token: Token, number: Token, meant: Sequence[str]) -> tuple[str, tuple[Fix, ...]]:
    """Return the message about a word that people try with a number, as in Logo's `fd 100`, and its fixes."""
    unit = "deg" if meant[0] in TURNING else "cm"
    put = Edit(Span(number.end, number.end), unit)
    shown = {f"{word} {number.text}{unit}": (Edit(token.span, word), put) for word in meant}
    fixes = tuple(Fix(f"Change to {text}", edits, guess=unit == "cm") for text, edits in shown.items())
    return f"`{token.text}` is not defined: write {' or '.join(f'`{text}`' for text in shown)}", fixes


def logo_repeat(tokens: Sequence[Token], at: int) -> tuple[str, tuple[Fix, ...]] | None:
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
