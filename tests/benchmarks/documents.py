"""Programs of any length without an error, Python modules as long, and edits of both; the same every time."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from random import Random

SHARED = "motif"
"""Name that a third of the lines use in a document with a shared name."""
SHARED_LINE = 3
"""Line of its definition."""

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
    """Write a program of so many lines (100 or more give no hint either); if `shared`, a third of them use `SHARED`."""
    random = Random(seed)
    made = ["# A dance for eight robots.", "beat 30", "", f"{SHARED} = forward [left right] scale 1/2 backward"]
    name = before = SHARED
    while len(made) < lines:
        moves = " ".join(random.choices(_MOVES, k=random.randrange(2, 5)))
        if name != before:  # a name is used right after its definition, and perhaps in the next one
            made.append(f"{random.choice(_ROBOTS)} $ {name} {SHARED if before == SHARED else random.choice(_MOVES)}")
            nested = "" if before == SHARED else random.choice((name, ""))
            name = before = SHARED if shared and random.random() < 0.4 else nested
        elif random.random() < 0.15:
            made.append(random.choice(("", f"# The {random.choice(_NOUNS)}.")))
        elif len(made) == lines - 1:
            made.append(f"{random.choice(_ROBOTS)} $ {moves}")
        else:
            name, term = f"{random.choice(_NOUNS)}{len(made)}", f"{random.choice(_CHANGES)} ({before} {moves})"
            made.append(f"{name} = {random.choice((f'{moves} {term}', f'[{moves}] {term}', term))}")
    return "".join(f"{line}\n" for line in made)


def python(lines: int, seed: int = 1) -> str:
    """Write a Python module of so many lines."""
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
