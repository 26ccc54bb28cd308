"""Measures: the velocities that they give to words, and errors in writing them. Spans count from the statement's
start."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Sequence
from fractions import Fraction

from improv_core.diagnostics import Diagnostic, Edit, Fix, replace
from improv_core.program.numbers import product
from improv_core.score.measured import Component, Measure
from improv_core.score.movement import DIRECTIONS, Velocity, exact
from improv_core.syntax import nodes
from improv_core.syntax.characters import continues_name
from improv_core.syntax.lexer import Token
from improv_core.syntax.nodes import MeasuredWord, Node, Number
from improv_core.syntax.slips import FEWEST_DEGREES, OPPOSITES, nearest_word
from improv_core.syntax.tried_words import DURATIONS, TRIED, is_count
from improv_core.syntax.units import misplaced_unit, unit_meant
from improv_core.syntax.vocabulary import UNITS
from improv_core.syntax.word import Word
from improv_core.syntax.wrong_characters import number_meant
from improv_core.text import Span

_MAX_TIMES = 9


def unit_of(number: Number) -> str:
    """Return the field of `Measure` that a measure measures; "" if it has no unit, or several."""
    return UNITS[number.units[0].text].field if len(number.units) == 1 else ""


def in_its_unit(number: Number, value: Fraction) -> Component:
    """Return a measure with this value, in meters or degrees."""
    unit = UNITS[number.units[0].text]
    component: Component = Measure(**{unit.field: exact(value * unit.size)}) * 1
    return component


def velocity_of(word: Word, measure: Component | None, radius: Component | None) -> Velocity:
    """Return the velocity of a word with a measure, along a circle with a radius.

    Its speed is that of the turn times the radius, always forward.
    """
    direction = next((each for each in DIRECTIONS if getattr(word.velocity, each)), "")
    if not direction:
        return word.velocity
    own = getattr(word.velocity, direction)
    turn = own if measure is None else measure * (1 if own > 0 else -1)
    velocity = word.velocity._replace(**{direction: turn})
    if not isinstance(radius, Measure) or direction != "yaw":
        return velocity
    by = turn if isinstance(turn, Measure) else Measure(turn)
    around = Measure(turning=radius.meters * by.steps, arcs=radius.meters * by.degrees)
    forward = around * (1 if own > 0 else -1)
    return velocity._replace(x=forward)


def wrong_measures(body: Node, tokens: Sequence[Token], known: Collection[str]) -> Iterator[Diagnostic]:
    """Yield what is wrong with the measures in a movement, wherever it is performed.

    `tokens` are those of the statement, and `known` the names that have a meaning in it: they are no units.
    """
    inside = list(nodes.nodes(body))
    applied = (each for each in inside if isinstance(each, nodes.Apply) and not each.numbers)
    counted = {id(each.body) for each in applied if each.word.text == "repeat"}
    for node in inside:
        if isinstance(node, MeasuredWord):
            for number in (node.measure, node.radius):
                if number and number.tokens[-1].text:
                    bare = () if number.units else enumerate(tokens)
                    at, after = next((each for each in bare if each[1].start >= number.span.end), (0, None))
                    if after and not unit_meant(after.text) and number_meant(tokens, at):
                        continue  # it is one number with what follows: `1½`
                    if wrong := _Written(node, number, after, id(node) in counted).wrong(known):
                        yield wrong


def without_units(
    wrong: Sequence[Diagnostic], names: Sequence[nodes.Name], tokens: Sequence[Token]
) -> list[nodes.Name]:
    """Return the names that nothing defines, without those that are units: apart from their numbers, about which these
    diagnostics are, or behind numbers that are wrong (`1,5m`) or follow a name meant as a word (`turn 90deg`)."""
    spans = [each.span for each in wrong if each.code == "missing-unit"]
    undefined = {each.span.start for each in names}
    for before, number, unit in zip(tokens, tokens[1:], tokens[2:], strict=False):
        if number.type in ("NUMBER", "STRAY") and unit.type == "NAME" and unit_meant(unit.text):
            is_word = before.start in undefined and (before.text.lower() in TRIED or nearest_word(before.text))
            spans += [unit.span] if is_word or before.type == "STRAY" else []
    return [name for name in names if not any(span.start <= name.span.start < span.end for span in spans)]


class _Written:
    """A number behind a word, or behind its `radius`, and the token `after` it. `is_counted` if the word follows a
    `repeat` that lacks its number."""

    def __init__(self, node: MeasuredWord, number: Number, after: Token | None, is_counted: bool) -> None:
        self.node, self.number, self.after, self.is_counted = node, number, after, is_counted
        self.is_joined = after is not None and after.start == number.span.end and continues_name(after.text[0])
        self.word, self.is_radius = node.word.text, number is node.radius
        self.turns = bool(node.word.velocity.yaw)
        self.is_half = self.word.startswith("half")
        self.usual = "deg" if self.turns and not self.is_radius else "m"
        value = None if any(number.parameters) else product(number.tokens, {})
        self.value = value if isinstance(value, Fraction) else None

    def wrong(self, known: Collection[str]) -> Diagnostic | None:
        """Return what is wrong with it. The names that are `known` are no units."""
        wrong = self._wrong_place() or self._wrong_number()
        if wrong or self.number.units:
            return wrong
        if self.after and self.after.type == "NAME" and self.after.text not in known and unit_meant(self.after.text):
            return self._apart(self.after)
        return (self._counted(self.after) if self.after and self.after.text not in known else None) or self._missing()

    def _counted(self, after: Token) -> Diagnostic | None:
        """Return the error about `forward 4 times` or `forward 4 beats`."""
        is_long = after.text.lower() in (*DURATIONS, "s")
        times = self._times("repeat", after.end) if is_long or is_count(after) else ()
        if not times:
            return None
        longer = self._times("slow", after.end) if is_long and self.word != "rest" else ()
        shown = " or ".join(f"`{fix.title.removeprefix('Change to ')}`" for fix in (*longer, *times))
        span = Span(self.number.span.start, after.end)
        return Diagnostic("missing-unit", span, f"each movement lasts one beat: write {shown}", (*longer, *times))

    def _wrong_place(self) -> Diagnostic | None:
        """Return the error about a measure of a word that takes none, or with the wrong unit anywhere."""
        span, units, field = self.number.span, self.number.units, unit_of(self.number)
        if self.is_radius and not self.turns:
            message = f"`radius` needs a turn: write it behind `left` or `right`, not `{self.word}`"
            return Diagnostic("wrong-measure", self.node.span, message)
        if len(units) > 1:
            message = f"a measure has one unit: remove `{units[-1].text}`"
            return Diagnostic("wrong-measure", span, message, replace(f"Remove {units[-1].text}", units[-1].span, ""))
        if not units:
            return None
        if self.is_radius and field != "meters":
            return Diagnostic("wrong-measure", span, "`radius` takes a length, such as `radius 1m`")
        if self.is_radius or not (self.is_half or self.word == "rest"):
            return None
        if self.is_half and field == "degrees":
            return self._of_a_half(f"`{self.word}` takes no measure", "wrong-measure", "")
        advice = "it is an eighth of a turn" if self.is_half else "it lasts one beat"
        return Diagnostic("wrong-measure", span, f"`{self.word}` takes no measure: {advice}")

    def _of_a_half(self, what: str, code: str, unit: str) -> Diagnostic:
        """Return the error about `halfleft 30deg`, which is meant as `left 30deg`."""
        whole = self.word.removeprefix("half")
        title = f"{whole} {self._with(unit)}"
        edits = (Edit(self.node.primitive.span, whole), *self._insertion(unit))
        return Diagnostic(code, self.node.span, f"{what}: write `{title}`", (Fix(f"Change to {title}", edits),))

    def _wrong_number(self) -> Diagnostic | None:
        """Return the error about a measure with a sign, or of 0."""
        if self.number.is_signed:
            return self._signed()
        if self.value != 0:
            return None
        if self.is_radius:
            return Diagnostic("bad-number", self.number.span, "write this radius as a number above 0")
        fixes = replace("Change to rest", self.node.span, "rest", guess=True)
        message = "write this measure as a number above 0, or write `rest` to stand still"
        return Diagnostic("bad-number", self.number.span, message, fixes)

    def _signed(self) -> Diagnostic:
        first, *rest = self.number.tokens
        opposite = self.word if first.text[0] == "+" else OPPOSITES.get(self.word, "")
        message = "write this measure without a sign"
        if self.is_radius or self.word == "rest" or any(token.text[0] in "+-" for token in rest):
            return Diagnostic("bad-number", self.number.span, message)
        word = opposite.removeprefix("half")
        unit = "" if self.number.units or (self.after and unit_meant(self.after.text)) else self.usual
        plain = f"{word} {self._with(unit)[1:]}"
        other = (Edit(self.node.primitive.span, word),) if word != self.word else ()
        edits = (*other, Edit(Span(first.start, first.start + 1), ""), *self._insertion(unit))
        fix = Fix(f"Change to {plain}", edits, guess=unit == "m")
        return Diagnostic("bad-number", self.number.span, f"{message}: `{plain}`", (fix,))

    def _missing(self) -> Diagnostic:
        """Return the error about a number without a unit."""
        number, word, usual = self.number, self.word, self.usual
        times = self._times()
        if word == "rest" and not self.is_radius:
            advice = f"write `{times[0].title.removeprefix('Change to ')}`" if times else "remove it"
            return Diagnostic("missing-unit", number.span, f"`rest` takes no measure: {advice}", times)
        is_large = self.value is not None and self.value >= FEWEST_DEGREES
        if self.is_half and not self.is_radius:
            if is_large or self.value is None:
                return self._of_a_half(f"`{word}` takes no measure", "missing-unit", usual)
            return Diagnostic("missing-unit", number.span, f"`{word}` takes no measure", times)
        example, before = self._with(usual), self._before
        message = f"`{before} {number.text}` needs a unit, such as `{example}`"
        is_only = usual == "deg" and is_large
        units = (usual, "cm") if usual == "m" and is_large and not self.is_radius else (usual,)
        fixes = tuple(
            Fix(f"Change to {before} {self._with(unit)}", self._insertion(unit), guess=not is_only) for unit in units
        )
        return Diagnostic("missing-unit", number.span, message, (*fixes, *times))

    def _times(self, by: str = "repeat", end: int | None = None) -> tuple[Fix, ...]:
        """Return the fix that repeats the word so often, in place of the number and what follows it up to an `end`."""
        number, value = self.number, self.value
        if (
            self.is_radius
            or self.node.radius
            or value is None
            or value.denominator > 1
            or (not end and value > _MAX_TIMES)
        ):
            return ()
        start = self.node.span.start
        written = f"{number.text} " if self.is_counted and by == "repeat" else f"{by} {number.text} "
        word = self.node.primitive.span.end
        gone = Span(word if number.span.start == word + 1 else number.span.start, end or number.span.end)  # no comment
        edits = (Edit(Span(start, start), written), Edit(gone, ""))
        return (Fix(f"Change to {by} {number.text} {self.word}", edits, guess=True),)

    @property
    def _before(self) -> str:
        return "radius" if self.is_radius else self.word

    def _apart(self, unit: Token) -> Diagnostic:
        """Return the error about a unit apart from its number, or about one that isn't ours."""
        message, title, edit = misplaced_unit(self.number, self.value, unit, self._before)
        span = Span(self.number.span.start, unit.end)
        return Diagnostic("missing-unit", span, message, (Fix(title, (edit,)),))

    def _with(self, unit: str) -> str:
        """Return the number with a unit: behind its first literal number, or else in another factor."""
        tokens = self.number.tokens
        first = next((place for place, token in enumerate(tokens) if token.type == "NUMBER"), None)
        if not unit or first is None:
            return self.number.text + (f"*1{unit}" if unit else "")
        return "".join([token.text + unit * (place == first) for place, token in enumerate(tokens)])

    def _insertion(self, unit: str) -> tuple[Edit, ...]:
        first = next((token for token in self.number.tokens if token.type == "NUMBER"), None)
        end = first.end if first else self.number.span.end
        gap = " " if self.is_joined and end == self.number.span.end else ""
        return (Edit(Span(end, end), (unit if first else f"*1{unit}") + gap),) if unit else ()
