"""Finds movements that never play: cut off by the shorter side of `||`, or after an endless movement."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from fractions import Fraction
from typing import NamedTuple

from improv_core.diagnostics import Diagnostic, Edit, Fix, replace
from improv_core.program.timing import in_beats, written
from improv_core.score.movement import ENDLESS, Duration, Movement
from improv_core.syntax import nodes
from improv_core.syntax.nodes import Node
from improv_core.text import Span

_Lasts = Callable[[Node], Duration]


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
    """A span that is never reached, and whether removing it would leave the timing of the rest unchanged.

    It comes after `endless`, an item that never ends, or something shorter plays alongside: of `whole` beats of the
    series, `lost` are never performed.
    """

    span: Span
    is_removable: bool
    endless: Node | None
    lost: Duration
    whole: Duration


def unperformed(body: Node, movement: Callable[[Node], Movement]) -> Iterator[Diagnostic]:
    """A diagnostic for each stretch that is never reached, given the movement of each node."""
    for cut in _cut(body, _Window(0, ENDLESS), lambda node: movement(node).duration):
        fixes = replace("Remove it", cut.span, "") if cut.is_removable else ()
        if cut.endless:
            yield _after_endless(cut.span, cut.endless, fixes)
            continue
        message = "this is never reached"
        if cut.whole != ENDLESS:
            are = "is" if cut.lost == 1 else "are"
            message = f"{written(Fraction(cut.lost))} of these {in_beats(cut.whole)} {are} never performed"
        advice = "make what plays alongside longer" + (", or remove this" if fixes else "")
        yield Diagnostic("never-performed", cut.span, f"{message}: {advice}", fixes)


def _after_endless(span: Span, endless: Node, fixes: tuple[Fix, ...]) -> Diagnostic:
    """The diagnostic about what comes after an item that never ends."""
    if not isinstance(endless, nodes.Apply) or endless.word.text != "repeat" or isinstance(endless.body, nodes.Bracket):
        advice = "give its `repeat` a number" + (", or remove this" if fixes else "")
        return Diagnostic("never-performed", span, f"what comes before this never ends: {advice}", fixes)
    body = endless.body
    one = body.word.text if isinstance(body, nodes.Primitive) else body.text if isinstance(body, nodes.Name) else ""
    repeated = f"only `{one}`" if one else "only one movement"
    message = f"`repeat` repeats {repeated}, forever: put everything that it should repeat in `( )`"
    brackets = (Edit(Span(body.span.start, body.span.start), "("), Edit(Span(span.end, span.end), ")"))
    return Diagnostic("never-performed", span, message, (Fix("Repeat this too", brackets), *fixes))


def _cut(node: Node, window: _Window, lasts: _Lasts, is_counted: bool = False) -> Iterator[_Cut]:
    if isinstance(node, nodes.Series):
        whole = lasts(node)
        lost = whole - min(window.end, whole) + window.start
        for span, endless in _lost(node, window, lasts):
            yield _Cut(span, not is_counted and not window.is_aligned, endless, lost, whole)
        yield from _cut_items(node, window, lasts)
    elif isinstance(node, nodes.Parallel):
        inside = _Window(window.start, min(window.end, lasts(node)), window.is_aligned or window.start > 0)
        for voice in node.voices:
            yield from _cut(voice, inside, lasts)
    elif isinstance(node, nodes.Bracket) and node.body:
        if not node.squeezes:
            yield from _cut(node.body, window, lasts)
            return
        inside = window.part(window.start, min(window.end, lasts(node)))
        for voice in node.body.voices if isinstance(node.body, nodes.Parallel) else (node.body,):
            # A bracket counts its items. If one were removed, the others would last longer.
            yield from _cut(voice, inside.times(Fraction(nodes.items(voice))), lasts, is_counted=True)
    elif isinstance(node, nodes.Apply):
        performed = _inside(node, window, lasts)
        if performed:
            yield from _cut(node.body, performed, lasts)


def _cut_items(node: nodes.Series, window: _Window, lasts: _Lasts) -> Iterator[_Cut]:
    """The cuts inside those items of a series that are reached."""
    for item, begin, end in _timed(node, lasts):
        if end > begin and not _is_lost(begin, end, window):
            yield from _cut(item, window.part(max(window.start - begin, 0), min(window.end, end) - begin), lasts)


def _lost(node: nodes.Series, window: _Window, lasts: _Lasts) -> Iterator[tuple[Span, Node | None]]:
    """The stretches of items that are not reached, each as long as possible, and the endless item before it, if any."""
    lost: list[Node] = []
    endless: Node | None = None
    before: Node | None = None
    for item, begin, end in _timed(node, lasts):
        if _is_lost(begin, end, window):
            if not lost:
                endless = before
            lost.append(item)
        elif lost and end > begin:
            yield Span(lost[0].span.start, lost[-1].span.end), endless
            lost = []
        if end == ENDLESS and before is None:
            before = item
    if lost:
        yield Span(lost[0].span.start, lost[-1].span.end), endless


def _timed(node: nodes.Series, lasts: _Lasts) -> Iterator[tuple[Node, Duration, Duration]]:
    """The items with the beats at which they start and end."""
    begin: Duration = 0
    for item in node.items:
        end = begin + lasts(item)
        yield item, begin, end
        begin = end


def _is_lost(begin: Duration, end: Duration, window: _Window) -> bool:
    return begin == ENDLESS or (end > begin and (begin >= window.end or end <= window.start))


def _inside(node: nodes.Apply, window: _Window, lasts: _Lasts) -> _Window | None:
    """The window in the time of the body; None if nothing plays."""
    whole, body = lasts(node), lasts(node.body)
    if not whole or not body:
        return None
    end = min(window.end, whole)
    word = node.word.text
    if word in ("reverse", "retrograde"):
        return window.part(whole - end, whole - window.start)
    if word == "repeat" and body != ENDLESS:
        into = window.start % body
        until = into + end - window.start
        # A window that extends into the next repetition shows all of the body, or both of its ends.
        return window.part(into, until) if until <= body else window.part(0, body)
    if word in ("fast", "slow"):
        if whole == ENDLESS:
            return window.part(0, ENDLESS)  # not worth computing how much of it is reached
        return window.part(window.start, end).times(Fraction(body) / Fraction(whole))
    return window.part(window.start, end)
