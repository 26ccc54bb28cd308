"""Programs of any length without an error, Python modules as long, and edits of both; the same every time."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import islice
from random import Random

SHARED = "motif"
"""Name that a third of the lines use in a document with a shared name."""
SHARED_LINE = 3
"""Line of its definition."""

DEEPEST = 6
"""Names within names: enough to be realistic, and every movement's fractions stay short."""

_MOVES = ("forward", "backward", "left", "right", "halfleft", "halfright", "rest", "strafeleft", "straferight")
_CHANGES = (
    *("reverse", "retrograde", "reflect YZ", "reflect sagittal", "reflect frontal", "fast 2", "slow 3/2"),
    *("scale 1/2", "scale 1/3", "repeat 2", "repeat 3", "repeat 4"),
)
_NOUNS = ("wave", "spiral", "step", "turn", "bow", "sway", "leap", "circle", "phrase", "answer", "drift", "pulse")
_ROBOTS = ("turtle1", "turtle2", "anna", "bruno", "clara", "drummer", "shaker", "walker")
_FORMS = ("{} * 2 + {}", "max({}, {}, 1)", "math.hypot({}, {})", "sum([{}, {}]) / 2", "({} - {}) ** 2")
IMPROV = (" repeat {} left", " forwrd", " (")
"""Text that an edit adds to the end of a line: one with a number, and two errors."""
PYTHON = (" + {}", " + forwrd", " +")


@dataclass(frozen=True, slots=True)
class Edit:
    """One line of `length` characters is replaced by `text`; `wrong` is true if the document then has an error."""

    line: int
    length: int
    text: str
    wrong: bool


def improv(lines: int, shared: bool = False, seed: int = 1) -> str:
    """Write a program of this many lines (100 or more give no hint either). If `shared`, a third use `SHARED`."""
    dance = _Dance(Random(seed))
    made = ["# A dance for eight robots.", "beat 30", "", f"{SHARED} = forward [left right] scale 1/2 backward"]
    while len(made) < lines:
        left = lines - len(made)
        if not shared:
            made += dance.lines(left, left)
        elif len(made) % 3 == 0:
            made.append(_user(len(made)))
        else:
            made += dance.lines(left, min(left, 2))
    return "".join(f"{line}\n" for line in made)


def python(lines: int, seed: int = 1) -> str:
    """Write a Python module of this many lines."""
    random = Random(seed)
    made = ['"""Measures of a dance."""', "import math", "", f"{SHARED} = math.sqrt(2)"]
    names = [SHARED]
    while len(made) < lines:
        value = random.choice(_FORMS).format(*random.choices(names[-40:], k=2))
        names.append(f"{random.choice(_NOUNS)}{len(made)}")
        made.append(f"{names[-1]} = {value}" if random.random() < 0.85 else f"print({value})  # {names.pop()}")
    return "".join(f"{line}\n" for line in made)


def edits(text: str, only: int | None = None, seed: int = 1, added: tuple[str, str, str] = IMPROV) -> Iterator[Edit]:
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
        usual, *mistakes = added
        wrong = lines[place] + mistakes[count // 10 % len(mistakes)]
        for new in [wrong] * (count % 10 == 9) + [lines[place] + usual.format(2 + count)]:
            yield Edit(place, len(now[place]), new, new == wrong)
            now[place] = new
            count += 1


def _user(number: int) -> str:
    change = _CHANGES[number % len(_CHANGES)]
    if number % 2 == 0:
        return f"variation{number} = {_MOVES[number % len(_MOVES)]} {change} {SHARED}"
    return f"{_ROBOTS[number % len(_ROBOTS)]} $ variation{number - 3} {change} {SHARED}"


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
