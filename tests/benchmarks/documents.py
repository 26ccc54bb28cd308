"""Programs of any length without an error, in Improv and in Python, and edits of their lines; the same every time."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from itertools import islice
from random import Random
from typing import Literal, TypeAlias

SHARED = "motif"
"""Name that a third of the lines use in a document with a shared name; its definition is on line `SHARED_LINE`."""
SHARED_LINE = 3

DEEPEST = 6
"""Names within names: enough to be realistic, and every movement's fractions stay short."""

_MOVES = ("forward", "backward", "left", "right", "halfleft", "halfright", "rest", "strafeleft", "straferight")
_CHANGES = (
    *("reverse", "retrograde", "reflect YZ", "reflect sagittal", "reflect frontal", "fast 2", "slow 3/2"),
    *("scale 1/2", "scale 1/3", "repeat 2", "repeat 3", "repeat 4"),
)
_NOUNS = ("wave", "spiral", "step", "turn", "bow", "sway", "leap", "circle", "phrase", "answer", "drift", "pulse")
_ROBOTS = ("turtle1", "turtle2", "anna", "bruno", "clara", "drummer", "shaker", "walker")
_PHRASES = (
    "poly n = repeat n (forward fast n left)",
    "spiral n k = repeat n (scale k forward left)",
    "answer (m) = m reflect YZ m",
    "times n (m) = repeat n (m halfleft)",
    "there_and_back (m) = m retrograde m",
    "sway n = repeat n [left right]",
)
_FUNCTIONS = (
    "def poly(n): return n * math.pi",
    "def spiral(n, k): return sum(range(n)) * k",
    "def answer(m): return m, -m",
    "def times(n, m): return n * (m + 1)",
    "def there_and_back(m): return m, m",
)
_FORMS = ("{} * 2 + {}", "max({}, {}, 1)", "math.hypot({}, {})", "sum([{}, {}]) / 2", "({} - {}) ** 2")


Uses: TypeAlias = Literal["", "name", "phrase"]
"""Things that a third of the lines of a document use: nothing in particular, `SHARED`, or phrases with parameters."""


@dataclass(frozen=True, slots=True)
class Edit:
    """One line of `length` characters is replaced by `text`; `wrong` is true if the document then has an error."""

    line: int
    length: int
    text: str
    wrong: bool


@dataclass(frozen=True, slots=True)
class Language:
    """Functions that write a document of so many lines in a language, and changes of its lines."""

    name: str
    write: Callable[[int, Uses], str]
    more: str
    mistakes: tuple[str, ...]


def improv(lines: int, uses: Uses = "", seed: int = 1) -> str:
    """Write an Improv program of so many lines (100 or more give no hint either)."""
    dance = _Dance(Random(seed))
    made = ["# A dance for eight robots.", "beat 30", "", f"{SHARED} = forward [left right] scale 1/2 backward"]
    if uses == "phrase":
        made += _PHRASES
    made += _thirds(lines - len(made), uses, dance.lines, _phrase_user if uses == "phrase" else _improv_user)
    return "".join(f"{line}\n" for line in made)


def python(lines: int, uses: Uses = "", seed: int = 1) -> str:
    """Write a Python module of so many lines; phrases are functions."""
    random = Random(seed)
    names: list[str] = []
    made = ['"""Measures of a dance."""', "import math", "", f"{SHARED} = math.sqrt(2)"]
    if uses == "phrase":
        made += _FUNCTIONS
    user = _function_user if uses == "phrase" else _python_user
    made += _thirds(lines - len(made), uses, lambda _, room: _python_lines(random, names, room), user)
    return "".join(f"{line}\n" for line in made)


IMPROV = Language("improv", improv, " repeat {} left", (" forwrd", " ("))
PYTHON = Language("python", python, " + {}", (" + forwrd", " +"))


def edits(language: Language, text: str, only: int | None = None, seed: int = 1) -> Iterator[Edit]:
    """Yield edits without end, at any line with `=` or `$` or only at one; one in ten is an error, and the next fixes
    it."""
    random = Random(seed)
    lines = text.splitlines()
    signs = (" = ", " $ ")
    places = [place for place, line in enumerate(lines) if any(sign in line for sign in signs)]
    now = dict(enumerate(lines))
    count = 0
    while True:
        place = only if only is not None else random.choice(places)
        wrong = lines[place] + language.mistakes[count // 10 % len(language.mistakes)]
        for new in [wrong] * (count % 10 == 9) + [lines[place] + language.more.format(2 + count)]:
            yield Edit(place, len(now[place]), new, new == wrong)
            now[place] = new
            count += 1


def _thirds(
    lines: int, uses: Uses, write: Callable[[int, int], list[str]], user: Callable[[int], str]
) -> Iterator[str]:
    """Yield so many lines from `write`, which gets the number of lines left and the most to return at once. If the
    lines use something, every third is a `user` instead."""
    number = 0
    while number < lines:
        left = lines - number
        piece = [user(number)] if uses and number % 3 == 0 else write(left, min(left, 2) if uses else left)
        number += len(piece)
        yield from piece


def _improv_user(number: int) -> str:
    change = _CHANGES[number % len(_CHANGES)]
    if number % 2 == 0:
        return f"variation{number} = {_MOVES[number % len(_MOVES)]} {change} {SHARED}"
    return f"{_ROBOTS[number % len(_ROBOTS)]} $ variation{number - 3} {change} {SHARED}"


def _phrase_user(number: int) -> str:
    count, move = 2 + number % 11, _MOVES[number % len(_MOVES)]
    forms = (
        f"poly {count}",
        f"{move} spiral {count} 3/2",
        f"answer ({move} left) {move}",
        f"times {count} {SHARED}",
        f"there_and_back answer poly {count}",
        f"sway {count} {move}",
    )
    movement = forms[number // 3 % len(forms)]
    if number % 2 == 0:
        return f"variation{number} = {movement}"
    return f"{_ROBOTS[number % len(_ROBOTS)]} $ variation{number - 3} {movement}"


class _Dance:
    """Writes a program line by line: people use names that are near, and in the end use every name that they have
    defined."""

    def __init__(self, random: Random) -> None:
        self.random = random
        self.depths = {SHARED: 1}
        self.unused = {SHARED: None}

    def lines(self, left: int, room: int) -> list[str]:
        """Return one to `room` lines that may come next, with `left` of them to the end."""
        kind = self.random.random()
        robots = " ".join(self.random.sample(_ROBOTS, self.random.choice((1, 1, 1, 2))))
        if len(self.unused) + 3 >= left:
            return [f"{robots} $ {' '.join(self.name(DEEPEST)[0] for _ in range(3))}"]
        if kind < 0.16:
            return [f"{robots} $ {' '.join(self.term(DEEPEST)[0] for _ in range(self.random.randrange(2, 5)))}"]
        if kind < 0.24:
            return [""]
        if kind < 0.30:
            return [f"# {self.random.choice(_NOUNS).capitalize()}, then {self.random.choice(_NOUNS)}."]
        movement, depth = self.voices() if kind < 0.36 else self.series()
        name = f"{self.random.choice(_NOUNS)}{len(self.depths)}"
        self.depths[name] = depth + 1
        self.unused[name] = None
        if kind > 0.95 and room >= 3:
            return [f"{name} = repeat {self.random.randrange(2, 9)} (", f"  {movement}", ")"]
        return [f"{name} = {movement}"]

    def voices(self) -> tuple[str, int]:
        """Return two voices that end together."""
        first, second = (" ".join(self.random.choices(_MOVES, k=4)) for _ in range(2))
        return f"{first} || {second}", 0

    def series(self) -> tuple[str, int]:
        terms = [self.term(DEEPEST - 1) for _ in range(self.random.randrange(2, 5))]
        return " ".join(text for text, _ in terms), max(depth for _, depth in terms)

    def term(self, deepest: int) -> tuple[str, int]:
        """Return a movement that takes one term, and the depth of the names in it, `deepest` at most."""
        kind = self.random.random()
        if kind < 0.2:
            return f"[{' '.join(self.random.choices(_MOVES, k=self.random.randrange(2, 5)))}]", 0
        body, depth = self.name(deepest) if kind < 0.8 else (self.random.choice(_MOVES), 0)
        if kind < 0.6:
            return body, depth
        return f"{self.random.choice(_CHANGES)} ({body} {self.random.choice(_MOVES)})", depth

    def name(self, deepest: int) -> tuple[str, int]:
        """Return a name that nothing uses yet, or else one of the latest."""
        fitting = [name for name in self.unused if self.depths[name] <= deepest]
        latest = [name for name in islice(reversed(self.depths), 40) if self.depths[name] <= deepest]
        name = fitting[0] if fitting else self.random.choice(latest)
        self.unused.pop(name, None)
        return name, self.depths[name]


def _python_user(number: int) -> str:
    return f"variation{number} = {_FORMS[number % len(_FORMS)].format(SHARED, number)}"


def _function_user(number: int) -> str:
    count = 2 + number % 11
    forms = (f"poly({count})", f"spiral({count}, 1.5)", f"answer({count})", f"times({count}, {SHARED})")
    return f"variation{number} = {forms[number // 3 % len(forms)]}"


def _python_lines(random: Random, names: list[str], room: int) -> list[str]:
    """Return one to three lines that may come next; `names` are those so far, and grows."""
    kind = random.random()
    if kind < 0.08:
        return [""]
    if kind < 0.14:
        return [f"# {random.choice(_NOUNS).capitalize()}, then {random.choice(_NOUNS)}: part {random.randrange(1000)}"]
    used = random.choice(names[-40:]) if names else SHARED
    other = random.choice(names[-40:]) if names else SHARED
    if kind < 0.30:
        return [f'print("{random.choice(_ROBOTS)}", {used}, round({other}, {random.randrange(9)}))']
    name = f"{random.choice(_NOUNS)}{len(names)}"
    names.append(name)
    if kind < 0.35 and room >= 3:
        return [
            f"def make_{name}(width, height={used}):",
            "    return width * height",
            f"{name} = make_{name}({other})",
        ]
    forms = (
        "{} * 2 + {}",
        "max({}, {}, 1)",
        "math.hypot({}, {})",
        "sum([{}, {}]) / 2",
        "({} - {}) ** 2",
        "abs({} % {})",
    )
    return [f"{name} = {random.choice(forms).format(used, other)}"]
