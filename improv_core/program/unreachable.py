"""Find movements that never play: those that the shorter side of `||` cuts off, and those after an endless movement."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from fractions import Fraction
from typing import NamedTuple

from improv_core.diagnostics import Diagnostic, Edit, Fix, replace
from improv_core.program.definitions import NOTHING
from improv_core.program.reader import Reader, items_written
from improv_core.program.timing import in_beats, written
from improv_core.score.algebra import FromStatement, Pace, Parallel, Repeat, Reverse, Series
from improv_core.score.dice import Choose, Shuffle
from improv_core.score.lengths import lengths
from improv_core.score.movement import ENDLESS, Duration, Movement
from improv_core.score.ramps import Stepped
from improv_core.score.reactions import Reaction
from improv_core.score.traversal import inner_first
from improv_core.slices import checkpoint
from improv_core.syntax import nodes
from improv_core.syntax.nodes import Node
from improv_core.syntax.vocabulary import WORDS
from improv_core.text import Span


class _Window(NamedTuple):
    """The part of a movement that plays, in its own beats."""

    start: Duration
    end: Duration


_Windows = Mapping[int, _Window]
"""The windows of each movement that plays, by `id`: one for each place in which it plays."""


def unperformed(body: Node, reader: Reader) -> Iterator[Diagnostic]:
    """Yield a diagnostic for each stretch that is never reached in a movement that has been read."""
    yield from _cuts(body, _played(reader.movement_made(body), reader), reader)


def _played(whole: Movement, reader: Reader) -> _Windows:
    """Return when each movement inside one plays. Movements of other statements are left out, except phrases and
    arguments."""
    expansions = reader.reading.expansions.values()
    known = {id(each.movement) for each in expansions}
    arguments = (given for each in expansions for given in each.reader.given.movements.values())
    known |= {id(each) for given in arguments for each in (given.movement, *given.items.movements)}

    def inside(part: Movement) -> Sequence[Movement]:
        return () if isinstance(part, FromStatement) and id(part.body) not in known else part.parts

    windows = {id(whole): _Window(0, ENDLESS)}
    for part in reversed(list(inner_first(whole, inside))):
        checkpoint()
        if id(part) in windows and inside(part):
            for each, window in _inside(part, windows[id(part)]):
                before = windows.get(id(each), window)
                windows[id(each)] = _Window(min(before.start, window.start), max(before.end, window.end))
    return windows


def _inside(part: Movement, window: _Window) -> Iterator[tuple[Movement, _Window]]:
    """Yield the movements directly inside one that play, and their windows, given its own."""
    latest = _latest(part)
    if not latest:
        return
    start = 0 if part.open else window.start  # if senses decide, the part that is over at its start is unknown
    end = min(window.end, latest)
    if isinstance(part, Series):
        for item, begin, until in _timed(part):
            if until > begin and not _is_lost(begin, until, window):
                yield item, _Window(max(start - begin, 0), min(end, until) - begin)
    elif isinstance(part, (Choose, Shuffle, Stepped)):  # dice or the rate decide when each begins
        yield from ((each, _Window(0, _latest(each))) for each in part.parts)
    elif part.open and not isinstance(part, (Parallel, Reaction, FromStatement)):
        yield from ((each, _Window(0, ENDLESS)) for each in part.parts)
    elif isinstance(part, Reverse):
        yield part.body, _Window(latest - end, latest - start)
    elif isinstance(part, Pace):
        yield part.body, _Window(start * part.rate, end * part.rate)
    elif isinstance(part, Repeat) and part.body.duration != ENDLESS:
        into = start % part.body.duration
        until = into + end - start
        # A window that extends into the next repetition shows all of the body, or both of its ends.
        is_once = until <= part.body.duration
        yield part.body, _Window(into, until) if is_once else _Window(0, part.body.duration)
    else:
        yield from ((each, _Window(start, end)) for each in part.parts)


def _cuts(
    node: Node, windows: _Windows, reader: Reader, *, keeps: bool = False, counts: bool = False
) -> Iterator[Diagnostic]:
    """Yield the cuts in a node. Without a length that it `keeps`, the rest of the dance would play at other times, and
    without an item that a bracket `counts`, too."""
    made = reader.movement_made(node)
    window = windows.get(id(made))
    if window is None or made is NOTHING:  # its lengths are too large to compute, which is an error
        return
    lost: set[int] = set()
    if isinstance(node, nodes.Series) and isinstance(made, Series):
        for items, endless in _lost(node, made, window):
            lost.update(map(id, items))
            # Removing a word of dice changes the throws after it. Removing one of senses may give the movement around
            # it a fixed length, and `until` stands still for another time.
            decides = any(each.dice or each.open for each in map(reader.movement_made, items))
            yield _cut(items, endless, made, window, not (keeps or counts or decides))
    if isinstance(node, nodes.Call):
        expansion = reader.expansion(node)
        names = expansion.reader.given.movements if expansion else ()
        if expansion and not expansion.reader.faults and len(names) == len(node.movements):  # no two have one name
            yield from _cut_arguments(node, windows, reader)
        return
    if isinstance(node, nodes.Parallel):
        keeps = keeps or window.start > 0
    if isinstance(node, nodes.Apply):
        word = WORDS[node.word.text]
        keeps = keeps or word.spreads or word.of_items or word.by_robot
        inside = (items_written(node.body) if word.of_items and word.throws else ()) or (node.body,)
        if word.of_items and inside == (node.body,):  # only its items play
            windows = _played(reader.movement_made(node.body), reader)
    elif isinstance(node, nodes.Bracket) and node.squeezes and node.body:
        for voice in nodes.voices(node.body):
            yield from _cuts(voice, windows, reader, keeps=keeps, counts=True)
        return
    else:
        inside = nodes.children(node)
    shortest = _shortest(node.voices, reader) if isinstance(node, nodes.Parallel) and not made.open else None
    for child in inside:
        found = list(_cuts(child, windows, reader, keeps=keeps)) if id(child) not in lost else []
        yield from found
        if shortest and not found:
            yield from _cut_short(child, shortest, reader)


def _shortest(voices: Sequence[Node], reader: Reader) -> Node | None:
    """Return the side with which `||` ends; None if nothing moves there: `|| rest` cuts on purpose."""
    lasting = [(each, reader.movement_made(each)) for each in voices if reader.movement_made(each).duration]
    shortest, made = min(lasting, key=lambda each: each[1].duration, default=(None, NOTHING))
    return shortest if any(made.bounds.peak[:4]) else None


def _cut_short(voice: Node, shortest: Node, reader: Reader) -> Iterator[Diagnostic]:
    """Yield the diagnostic about a voice that `||` ends in the middle of a word, a name, or a repetition."""
    length = reader.movement_made(voice).duration
    lost = length - reader.movement_made(shortest).duration
    if not 0 < lost < length < ENDLESS:
        return
    is_series = isinstance(shortest, nodes.Series)
    start, end = shortest.span
    edits = Edit(Span(start, start), "repeat (" if is_series else "repeat "), Edit(Span(end, end), ")" * is_series)
    what = f"{written(Fraction(lost))} of these {in_beats(length)} {'is' if lost == 1 else 'are'} never performed"
    message = f"`||` ends with its shortest side, so {what}: repeat the shorter side, or write `( )` around both"
    yield Diagnostic("cut-short", voice.span, message, (Fix("Repeat the shorter side", edits, guess=True),))


def _cut_arguments(call: nodes.Call, windows: _Windows, reader: Reader) -> Iterator[Diagnostic]:
    """Yield the cuts in the arguments of a phrase: spans that play in none of the places that use the argument."""
    for argument in call.movements:
        made = reader.movement_made(argument)
        if id(made) in windows:
            yield from _cuts(argument, windows, reader, keeps=True)
        elif _latest(made) and not any(id(each) in windows for each in reader.items(argument).movements):
            message = "this is never reached: make the movement alongside longer"
            yield Diagnostic("never-performed", argument.span, message)


def _cut(
    items: Sequence[Node], endless: Node | None, series: Series, window: _Window, is_removable: bool
) -> Diagnostic:
    """Return the diagnostic about items of a series that are never reached: they come after `endless`, an item that
    never ends, or something shorter plays alongside."""
    span = Span(items[0].span.start, items[-1].span.end)
    fixes = replace("Remove it", span, "") if is_removable else ()
    if endless:
        return _after_endless(span, endless, fixes)
    whole, message = _latest(series), "this is never reached"
    lost = whole - min(window.end, whole) + window.start if whole < ENDLESS else ENDLESS
    if lost < whole < ENDLESS:
        message = f"{written(Fraction(lost))} of these {in_beats(whole)} {'is' if lost == 1 else 'are'} never performed"
    advice = "make the movement alongside longer" + (", or remove this" if fixes else "")
    return Diagnostic("never-performed", span, f"{message}: {advice}", fixes)


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


def _lost(node: nodes.Series, made: Series, window: _Window) -> Iterator[tuple[Sequence[Node], Node | None]]:
    """Yield the longest stretches of items that are not reached, and the endless item before each, if any."""
    lost: list[Node] = []
    endless: Node | None = None
    before: Node | None = None
    for item, (movement, begin, end) in zip(node.items, _timed(made), strict=True):
        if _is_lost(begin, end, window):
            if not lost:
                endless = before
            lost.append(item)
        elif lost and end > begin:
            yield lost, endless
            lost = []
        if before is None and _lasting(movement)[0] == ENDLESS:
            before = item
    if lost:
        yield lost, endless


def _timed(series: Series) -> Iterator[tuple[Movement, Duration, Duration]]:
    """Yield the items with the beats at which they begin and end: the earliest and the latest, if senses decide."""
    begin: Duration = 0
    latest: Duration = 0
    for item in series.items:
        checkpoint()
        earliest, longest = _lasting(item)
        end = latest + longest
        yield item, begin, end
        begin, latest = end if begin is latest and earliest is longest else begin + earliest, end


def _lasting(made: Movement) -> tuple[Duration, Duration]:
    """Return the least and the most beats that a movement lasts."""
    return lengths(made)[:2] if made.bounds.open else (made.duration, made.duration)


def _latest(made: Movement) -> Duration:
    """Return the most beats that a movement lasts."""
    return _lasting(made)[1]


def _is_lost(begin: Duration, end: Duration, window: _Window) -> bool:
    return begin == ENDLESS or (end > begin and (begin >= window.end or end <= window.start))
