"""Finds what comes back in a dance: repetitions, and phrases that return plain, mirrored, or retraced."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from fractions import Fraction
from itertools import groupby

from improv_core.score.primitives import pace_text
from improv_core.transcription.wording import (
    TURNS,
    Bracketed,
    Move,
    Named,
    Node,
    NodeSeries,
    Shaped,
    WordedVoice,
    around,
    cost,
    cost_of_text,
    series_text,
    turned_items,
)

_LONGEST_PERIOD = 64
"""The most nodes of a repeated body."""
_MAX_FOLDS = 200
_MAX_NAMES = 6
_MIN_SAVED = 0.5
"""The words that a fold must save: with fewer, it makes the program harder to read."""
_WORTH_A_NAME = 3.5
"""The cost that a single movement must have to get a name: `slow 2 forward` has less."""
_NAME_COST = 2.3
"""The cost of a definition besides its body: its name and the equals sign, and the line."""
_HALVES: Mapping[Node, Node] = {
    Move(Fraction(1), (WordedVoice(f"half{turn}"),)): Move(Fraction(2), (WordedVoice(turn),))
    for turn in ("left", "right")
}
"""Halves of turns, and what two of them make."""
NAMES = ("phrase", "figure", "answer", "theme", "motif", "turn", "step", "coda")


def series(items: Sequence[Node]) -> Node:
    return items[0] if len(items) == 1 else NodeSeries(tuple(items))


def bracketed(items: Sequence[Node]) -> list[Node]:
    """Put moves of an nth of a beat into brackets of n, and moves that are equally slow under one `slow`."""
    found: list[Node] = []
    for beats, group in groupby(items, key=lambda each: each.beats if isinstance(each, Move) else Fraction(1)):
        moves = list(group)
        plain = tuple(Move(Fraction(1), each.voices) for each in moves if isinstance(each, Move))
        if beats == 1 or len(moves) < 2:
            found += moves
        elif beats.numerator == 1:
            count = beats.denominator
            whole = len(moves) // count * count
            found += (Bracketed(plain[first : first + count]) for first in range(0, whole, count))
            found += moves[whole:]
        else:
            found.append(Shaped(pace_text(beats), (), folded(plain)))
    return found


def folded(items: Sequence[Node]) -> Node:
    """Return a series with repetitions folded, those first that save the most."""
    left = list(items)
    for _ in range(_MAX_FOLDS):
        best = max(_repetitions(left), default=None, key=lambda each: each[0])
        if best is None or best[0] < _MIN_SAVED:
            break
        _, first, period, times = best
        body = left[first : first + period]
        left[first : first + period * times] = [Shaped("repeat", (Fraction(times),), folded(body))]
    return series(left)


def _repetitions(items: Sequence[Node]) -> Iterator[tuple[float, int, int, int]]:
    """Yield repetitions: what each saves, its place, its period in nodes, and how many times it comes."""
    kinds: dict[Node, int] = {}
    known = [kinds.setdefault(each, len(kinds)) for each in items]
    costs = [cost(each) for each in items]
    for period in range(1, min(len(items) // 2, _LONGEST_PERIOD) + 1):
        place = 0
        while place + period < len(items):
            same = 0
            while place + same + period < len(items) and known[place + same] == known[place + same + period]:
                same += 1
            times = same // period + 1
            if times > 1:
                body = sum(costs[place : place + period])
                wrapped = cost_of_text(f"repeat {times}") + (0.6 if period > 1 else 0.0)
                # Of a run whose ends could belong to it or not, the first place counts.
                yield body * (times - 1) - wrapped, place, period, times
            place += max(same, 1) if times == 1 else same + 1


def with_names(lines: Sequence[Node], taken: Sequence[str]) -> tuple[dict[str, Node], list[Node]]:
    """Return definitions of phrases that come back in these lines, in order, and the lines that use them."""
    names: dict[str, Node] = {}
    found = list(lines)
    free = [name for name in NAMES if name not in taken]
    while len(names) < min(_MAX_NAMES, len(free)):
        best = _best_phrase([*names.values(), *found])
        if best is None:
            break
        name = free[len(names)]
        replaced = _replacing(best, name)
        bodies = [(each, replaced(body)) for each, body in names.items()]
        first = next((at for at, (each, body) in enumerate(bodies) if body != names[each]), len(bodies))
        bodies.insert(first, (name, series(best)))  # before its first use
        names = dict(bodies)
        found = [replaced(line) for line in found]
    return names, found


def with_whole_turns(node: Node) -> Node:
    """Return a node with `slow 2 left` for each `halfleft halfleft` that no phrase or repetition shares."""
    if isinstance(node, Shaped) and node.by not in ("slow", "fast"):
        return replace(node, body=with_whole_turns(node.body))
    if not isinstance(node, NodeSeries):
        return node
    found: list[Node] = []
    for each, run in groupby(node.items):
        same = list(run)
        found += [_HALVES[each]] if each in _HALVES and len(same) == 2 else map(with_whole_turns, same)
    return series(found)


Window = tuple[Node, ...]


def _best_phrase(nodes: Sequence[Node]) -> Window | None:
    """Return the phrase whose name would save the most words; None if no name saves any."""
    kinds: dict[Node, int] = {}
    lists = [items for node in nodes for items in _lists(node)]
    forms = [
        [[kinds.setdefault(each, len(kinds)) for each in turned_items(turns, items)] for turns in range(len(TURNS))]
        for items in lists
    ]
    best, saved = None, _MIN_SAVED
    for size in range(1, _LONGEST_PERIOD + 1):
        places: dict[tuple[int, ...], list[tuple[int, int, int]]] = defaultdict(list)  # of each canonical form
        for number, items in enumerate(lists):
            for place in range(len(items) - size + 1):
                back = len(items) - place - size
                firsts = (place, place, back, back, back, back, place, place)
                windows = [tuple(form[at : at + size]) for form, at in zip(forms[number], firsts, strict=True)]
                turns = min(range(len(TURNS)), key=windows.__getitem__)
                places[windows[turns]].append((number, place, turns))
        again = [found for found in places.values() if len(found) > 1]
        for apart in (_apart(found, size) for found in again):
            number, place, plain = apart[0]  # the first one is the definition
            window = lists[number][place : place + size]
            body = sum(cost(each) for each in window)
            if len(apart) < 2 or (size == 1 and body < _WORTH_A_NAME):
                continue
            uses = sum(1.0 + _TURN_COSTS[plain ^ turns] for _, _, turns in apart)
            saves = body * len(apart) - (body + _NAME_COST + uses)
            if saves > saved and _shortens(window, [plain ^ turns for _, _, turns in apart]):
                best, saved = window, saves
        if not again:  # so nothing longer comes back
            break
    return best


_TURN_COSTS = [cost_of_text(each) for each in TURNS]


def _shortens(window: Window, uses: Sequence[int]) -> bool:
    """Return whether a program has fewer characters if this phrase has a name that is used in these forms."""
    length = len(series_text(series(window)))
    return length + sum(len(f"{TURNS[each]} {NAMES[0]}") for each in (0, *uses)) + 4 < length * len(uses)


def _apart(found: Sequence[tuple[int, int, int]], size: int) -> list[tuple[int, int, int]]:
    """Return occurrences that don't overlap, from the first one on."""
    kept: list[tuple[int, int, int]] = []
    for each in found:
        if not kept or kept[-1][0] != each[0] or kept[-1][1] + size <= each[1]:
            kept.append(each)
    return kept


def _items(node: Node) -> tuple[Node, ...]:
    """Return the items of a series; a node that is none stands for a series of one."""
    return node.items if isinstance(node, NodeSeries) else (node,)


def _lists(node: Node) -> Iterator[tuple[Node, ...]]:
    """Yield the items of all series within a node, and of what is shaped."""
    yield _items(node)
    for each in _items(node):
        if isinstance(each, Shaped) and each.by not in TURNS:
            yield from _lists(each.body)
        elif isinstance(each, NodeSeries):
            yield from _lists(each)


def _replacing(phrase: Window, name: str) -> Callable[[Node], Node]:
    """Return a function that puts a name in the place of a phrase, in each of its forms."""
    forms = {turned_items(turns, phrase): turns for turns in reversed(range(len(TURNS)))}
    size = len(phrase)

    def replaced(node: Node) -> Node:
        return series(in_items(_items(node)))

    def in_items(items: Sequence[Node]) -> list[Node]:
        found: list[Node] = []
        place = 0
        while place < len(items):
            window = tuple(items[place : place + size])
            if (turns := forms.get(window)) is not None:
                found.append(around(turns, Named(name)))
                place += size
            else:
                each = items[place]
                found.append(Shaped(each.by, each.numbers, replaced(each.body)) if isinstance(each, Shaped) else each)
                place += 1
        return found

    return replaced
