"""Find movements that never play: those that the shorter side of `||` cuts off, and those after an endless movement."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import NamedTuple

from improv_core.diagnostics import Diagnostic, Edit, Fix, replace
from improv_core.program.definitions import ReadNodes
from improv_core.program.reader import items_written
from improv_core.program.timing import in_beats, written
from improv_core.score.lengths import lengths
from improv_core.score.movement import ENDLESS, Duration, Movement
from improv_core.slices import checkpoint
from improv_core.syntax import nodes
from improv_core.syntax.nodes import Node
from improv_core.syntax.vocabulary import WORDS
from improv_core.syntax.words import Timing
from improv_core.text import Span

MOST_VISITED = 10_000
"""The most nodes to search inside nested phrases. Each use is searched again, because it plays other parts."""


@dataclass(frozen=True, slots=True)
class _Window:
    """The part of a movement that plays, in its own beats: from `start` up to `end`.

    If `is_aligned`, the voices around it stay in time only if everything before `end` keeps its length.
    """

    start: Duration
    end: Duration
    is_aligned: bool = False

    def part(self, start: Duration, end: Duration) -> _Window:
        return _Window(start, end, self.is_aligned)

    def times(self, rate: Fraction) -> _Window:
        return self.part(self.start * rate, self.end * rate)


class _Cut(NamedTuple):
    """A span that is never reached. If it `is_removable`, its removal leaves the timing of the rest unchanged.

    It comes after `endless`, an item that never ends, or something shorter plays alongside: of `whole` beats of the
    series, `lost` are never performed.
    """

    span: Span
    is_removable: bool
    endless: Node | None
    lost: Duration
    whole: Duration


def unperformed(body: Node, reader: ReadNodes) -> Iterator[Diagnostic]:
    """Yield a diagnostic for each stretch that is never reached in a movement that has been read."""
    for cut in _cut(body, _Window(0, ENDLESS), reader, _Budget(MOST_VISITED)):
        fixes = replace("Remove it", cut.span, "") if cut.is_removable else ()
        if cut.endless:
            yield _after_endless(cut.span, cut.endless, fixes)
            continue
        message = "this is never reached"
        if cut.lost < cut.whole < ENDLESS:
            are = "is" if cut.lost == 1 else "are"
            message = f"{written(Fraction(cut.lost))} of these {in_beats(cut.whole)} {are} never performed"
        advice = "make the movement alongside longer" + (", or remove this" if fixes else "")
        yield Diagnostic("never-performed", cut.span, f"{message}: {advice}", fixes)


def _after_endless(span: Span, endless: Node, fixes: tuple[Fix, ...]) -> Diagnostic:
    """Return the diagnostic about a span after an item that never ends."""
    if not isinstance(endless, nodes.Apply) or endless.word.text != "repeat" or isinstance(endless.body, nodes.Bracket):
        advice = "give its `repeat` a number" + (", or remove this" if fixes else "")
        return Diagnostic("never-performed", span, f"the movement before this never ends: {advice}", fixes)
    body = endless.body
    one = body.text if isinstance(body, nodes.Name) else ""
    one = body.word.text if isinstance(body, nodes.Primitive | nodes.MeasuredWord) else one
    repeated = f"only `{one}`" if one else "only one movement"
    message = f"`repeat` repeats {repeated}, forever: put everything that it should repeat in `( )`"
    brackets = (Edit(Span(body.span.start, body.span.start), "("), Edit(Span(span.end, span.end), ")"))
    return Diagnostic("never-performed", span, message, (Fix("Repeat this too", brackets), *fixes))


@dataclass(slots=True)
class _Budget:
    nodes: int


def _cut(node: Node, window: _Window, reader: ReadNodes, budget: _Budget, is_counted: bool = False) -> Iterator[_Cut]:
    if isinstance(node, nodes.Series):
        whole = _latest(node, reader)
        lost = whole - min(window.end, whole) + window.start if whole < ENDLESS else ENDLESS
        for items, endless in _lost(node, window, reader):
            # Removing a word of dice changes the throws after it. Removing one of senses may give the movement around
            # it a fixed length, and `until` stands still for another time.
            made = [reader.movement_made(item) for item in items]
            decides = any(each.dice or each.bounds.open for each in made)
            span = Span(items[0].span.start, items[-1].span.end)
            yield _Cut(span, not (is_counted or window.is_aligned or decides), endless, lost, whole)
    elif isinstance(node, nodes.Call):
        yield from _cut_arguments(node, window, reader, budget)
        return
    for child, inside, counts_items in _reached(node, window, reader):
        yield from _cut(child, inside, reader, budget, counts_items)


def _reached(node: Node, window: _Window, reader: ReadNodes) -> Iterator[tuple[Node, _Window, bool]]:
    """Yield the reached nodes directly in a node, the part of each that plays, and whether its items are counted."""
    checkpoint()
    if window.start and reader.movement_made(node).bounds.open:
        window = window.part(0, window.end)  # the part that is over at its start is unknown
    if isinstance(node, nodes.Series):
        for item, begin, end in _timed(node, reader):
            if end > begin and not _is_lost(begin, end, window):
                yield item, window.part(max(window.start - begin, 0), min(window.end, end) - begin), False
    elif isinstance(node, nodes.Choice):
        yield node.then, window, False
        yield node.otherwise, window, False
    elif isinstance(node, nodes.Parallel):
        inside = _Window(window.start, min(window.end, _latest(node, reader)), window.is_aligned or window.start > 0)
        for voice in node.voices:
            yield voice, inside, False
    elif isinstance(node, nodes.Bracket) and node.body:
        if not node.squeezes:
            yield node.body, window, False
            return
        inside = window.part(window.start, min(window.end, _latest(node, reader)))
        for voice in nodes.voices(node.body):
            # A bracket counts its items. If one were removed, the others would last longer.
            yield voice, inside.times(Fraction(nodes.items(voice))), True
    elif isinstance(node, nodes.PartTerm):
        yield node.body, window, False
    elif isinstance(node, nodes.Apply) and WORDS[node.word.text].timing is Timing.DRAWN:
        for item in items_written(node.body) or (node.body,):  # dice decide when each begins, if at all
            yield item, _Window(0, _latest(item, reader), True), False
    elif isinstance(node, nodes.Apply):
        performed = _inside(node, window, reader)
        if performed:
            yield node.body, performed, False


def _cut_arguments(call: nodes.Call, window: _Window, reader: ReadNodes, budget: _Budget) -> Iterator[_Cut]:
    """Yield the cuts in the arguments of a phrase: spans that play in none of the places that use the argument."""
    expansion = reader.expansion(call)
    definition = reader.scope.get(call.name.text)
    if not expansion or expansion.reader.faults or not definition or not definition.phrase:
        return
    for parameter, argument in zip(definition.phrase.movements, call.movements, strict=True):
        played = list(_played(parameter.name, expansion.body, window, expansion.reader, budget))
        if budget.nodes <= 0:
            return
        if played:
            whole = _Window(min(part.start for part in played), max(part.end for part in played), True)
            yield from _cut(argument, whole, reader, budget)
        elif whole_argument := _latest(argument, reader):
            yield _Cut(argument.span, False, None, whole_argument, whole_argument)


def _played(name: str, node: Node, window: _Window, reader: ReadNodes, budget: _Budget) -> Iterator[_Window]:
    """Yield the parts of the argument with this name that play, in each place that is reached."""
    budget.nodes -= 1
    if budget.nodes <= 0:
        return
    if isinstance(node, nodes.Name):
        if node.text == name:
            yield window
    elif isinstance(node, nodes.Call):
        expansion = reader.expansion(node)
        definition = reader.scope.get(node.name.text)
        if expansion and definition and definition.phrase:
            for parameter, argument in zip(definition.phrase.movements, node.movements, strict=True):
                for inside in _played(parameter.name, expansion.body, window, expansion.reader, budget):
                    yield from _played(name, argument, inside, reader, budget)
    for child, inside, _ in _reached(node, window, reader):
        yield from _played(name, child, inside, reader, budget)


def _lost(node: nodes.Series, window: _Window, reader: ReadNodes) -> Iterator[tuple[Sequence[Node], Node | None]]:
    """Yield the longest stretches of items that are not reached, and the endless item before each, if any."""
    lost: list[Node] = []
    endless: Node | None = None
    before: Node | None = None
    for item, begin, end in _timed(node, reader):
        if _is_lost(begin, end, window):
            if not lost:
                endless = before
            lost.append(item)
        elif lost and end > begin:
            yield lost, endless
            lost = []
        if before is None and _lasting(reader.movement_made(item))[0] == ENDLESS:
            before = item
    if lost:
        yield lost, endless


def _timed(node: nodes.Series, reader: ReadNodes) -> Iterator[tuple[Node, Duration, Duration]]:
    """Yield the items with the beats at which they begin and end: the earliest and the latest, if senses decide."""
    begin: Duration = 0
    latest: Duration = 0
    for item in node.items:
        checkpoint()
        made = reader.movement_made(item)
        earliest, longest = _lasting(made)
        end = latest + longest
        yield item, begin, end
        begin, latest = end if begin is latest and earliest is longest else begin + earliest, end


def _lasting(made: Movement) -> tuple[Duration, Duration]:
    """Return the least and the most beats that a movement lasts."""
    return lengths(made)[:2] if made.bounds.open else (made.duration, made.duration)


def _latest(node: Node, reader: ReadNodes) -> Duration:
    """Return the most beats that a node lasts."""
    return _lasting(reader.movement_made(node))[1]


def _is_lost(begin: Duration, end: Duration, window: _Window) -> bool:
    return begin == ENDLESS or (end > begin and (begin >= window.end or end <= window.start))


def _inside(node: nodes.Apply, window: _Window, reader: ReadNodes) -> _Window | None:
    """Return the window in the time of the body; None if nothing plays."""
    whole, body = _latest(node, reader), _latest(node.body, reader)
    if not whole or not body:
        return None
    end = min(window.end, whole)
    timing = WORDS[node.word.text].timing
    if reader.movement_made(node).bounds.open:
        return window if node.condition else window.part(0, ENDLESS)
    if timing is Timing.BACKWARD:
        return window.part(whole - end, whole - window.start)
    if timing is Timing.TURNS and body != ENDLESS:
        into = window.start % body
        until = into + end - window.start
        # A window that extends into the next repetition shows all of the body, or both of its ends.
        return window.part(into, until) if until <= body else window.part(0, body)
    if timing is Timing.ELSEWHERE:
        return _Window(0, body, True)
    if timing is Timing.PACED or timing is Timing.FITTED:
        if whole == ENDLESS:
            return window.part(0, ENDLESS)  # computing the exact part that is reached is not worth it
        inside = _Window(window.start, end, window.is_aligned or timing is Timing.FITTED)
        return inside.times(Fraction(body) / Fraction(whole))
    return window.part(window.start, end)
