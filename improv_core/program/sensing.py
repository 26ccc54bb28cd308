"""Check the senses that a program reads against `improv.toml`: that they exist, and that something senses them."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import islice

from improv_core.diagnostics import Diagnostic, unknown
from improv_core.program.meaning import Meaning, movement_of
from improv_core.program.misuse import conditions
from improv_core.robots.config import Robots
from improv_core.score.algebra import FromStatement, Repeat
from improv_core.score.measured import largest
from improv_core.score.movement import Movement
from improv_core.score.reactions import senses_read
from improv_core.score.senses import NEAR
from improv_core.score.walk import walk
from improv_core.syntax.nodes import Apply, Condition, Statement
from improv_core.syntax.slips import closest
from improv_core.syntax.tried_words import SENSES_TRIED
from improv_core.text import Span

MAX_MOMENTS = 1_000
"""The most moments of a movement that are searched for one that goes forward."""


def check_senses(statement: Statement, meaning: Meaning, robots: Robots) -> Iterator[Diagnostic]:
    """Report problems of the senses that a statement reads, also through names. Spans count from its start."""
    written: dict[str, Span] = {}
    for node, condition in conditions(meaning.body) if statement.has_senses and meaning.body else ():
        name = condition.sense.text
        written.setdefault(name, condition.sense.span)
        if name not in robots.sense_names:
            message, otherwise = f"`{name}` is not a sense", f"add `[senses.{name}]` to improv.toml"
            near = closest(name, robots.sense_names) or SENSES_TRIED.get(name)
            yield unknown("unknown-sense", condition.sense.span, message, near, otherwise)
        elif isinstance(node, Apply) and name == NEAR and name not in robots.senses and not statement.parameters:
            scope = dict(zip(statement.uses, meaning.scope, strict=True))
            yield from _looks_ahead(condition, movement_of(node.body, scope, len(meaning.robots)))
    lacking: dict[str, list[str]] = {}
    for robot, part in meaning.parts if robots.robots else ():
        for name in sorted(senses_read(part)):
            if name in robots.sense_names and robots.lacks(robot, name):
                lacking.setdefault(name, []).append(robot)
    heads = {head.text: head.span for head in statement.heads}
    for name, without in lacking.items():
        yield _missing(name, without, written.get(name, heads[without[0]]))


def _missing(name: str, without: list[str], span: Span) -> Diagnostic:
    who = f"`{without[0]}`" if len(without) == 1 else f"`{without[0]}` and {len(without) - 1} more"
    advice = f"add `[senses.{name}]` to improv.toml" + (", or set `near` in its profile" if name == NEAR else "")
    return Diagnostic("missing-sense", span, f"outside the simulator, nothing senses `{name}` for {who}: {advice}")


def _looks_ahead(condition: Condition, body: Movement) -> Iterator[Diagnostic]:
    """Report a robot that relies on `near`, which looks ahead, while it only goes backward or sideways, whatever dice
    choose."""
    if condition.is_negated or body.open or body.dice or not (body.bounds.peak.x or body.bounds.peak.y):
        return
    while isinstance(body, (Repeat, FromStatement)):
        body = body.body  # each round is like the first
    way = "sideways"
    for place, moment in enumerate(islice(walk(body, merge=True), MAX_MOMENTS), 1):
        is_last = place == MAX_MOMENTS and not isinstance(body.duration, float)
        ahead = largest(moment.velocity.x)
        if ahead > 0 or is_last:  # later moments may go forward
            return
        way = "backward" if moment.velocity.x else way
    message = f"`near` looks only ahead, and this goes {way}: declare a sense that looks there in improv.toml"
    yield Diagnostic("looks-ahead", condition.span, message)
