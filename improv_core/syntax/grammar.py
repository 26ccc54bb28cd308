"""The grammar of one statement, and the terminals that may come next in it.

The terminals come from `lexer`: built-in words by their kind, and HEAD for the names before `=` or `$`. `heads` turns
names into PARAM (a number that the statement's own head declares), SENSE (in a condition), UNIT and RADIUS (behind a
primitive). `opening` reads the lines of the opening: `at`, `is`, `room`, `bar`, and the name of a scene. MISSING stands
for a missing movement; only the parser inserts it.

How many movements a name takes is known only from its definition. So its movements are parsed as the terms that follow
it, and `gather` gives them to the name.
"""

from __future__ import annotations

from functools import cache

_RULES = """
statement: BEAT number | HEAD head | SCENE | movement
head: EQUAL movement | DOLLAR movement | HEAD heads
heads: DOLLAR movement | HEAD heads
movement: voice voices
voices: BAR movement |
voice: term terms
terms: voice |
term: PRIMITIVE measures | NAME numbers | MISSING | LPAR body RPAR | LSQB body RSQB | PLAIN term | REPEAT times term
term: REFLECT PLANE term | FACTOR number term | RAMP number number term
term: GUARD condition term | IF condition voice ELSE term
body: movement |
measures: measure radius | RADIUS measure |
radius: RADIUS measure |
measure: NUMBER unit factors | PARAM factors
unit: UNIT |
factors: OPERATOR measure |
numbers: number numbers |
times: number |
number: NUMBER product | PARAM product
product: OPERATOR number |
condition: NOT SENSE | SENSE
"""
"""Each rule, with its alternatives. The next terminal decides which one applies; an empty one applies to all others."""
_ALTERNATIVES: dict[str, list[list[str]]] = {}
for _line in _RULES.strip().splitlines():
    _name, _, _written = _line.partition(":")
    _ALTERNATIVES.setdefault(_name, []).extend(each.split() for each in _written.split("|"))

Rest = tuple[str, "Rest"] | tuple[()]
"""The rules and terminals that have to follow: the next one, and the rest after it."""
START: Rest = ("statement", ("$END", ()))


def after(rest: Rest, terminal: str) -> Rest | None:
    """Return the rest after a terminal; None if it can't come next."""
    while rest:
        name, rest = rest
        if name == terminal:
            return rest
        fitting = [each for each in _ALTERNATIVES.get(name, ()) if each and terminal in _first(each[0])]
        if not fitting and not _may_be_empty(name):
            return None
        for each in reversed(fitting[0] if fitting else ()):
            rest = (each, rest)
    return None


def may_come_next(rest: Rest) -> frozenset[str]:
    """Return the terminals that can come next."""
    found: frozenset[str] = frozenset()
    while rest and _may_be_empty(rest[0]):
        name, rest = rest
        found |= _first(name)
    return found | must_come_next(rest)


def must_come_next(rest: Rest) -> frozenset[str]:
    """Return the terminals one of which has to come, after others that can be left out."""
    while rest and _may_be_empty(rest[0]):
        _, rest = rest
    return _first(rest[0]) if rest else frozenset()


@cache
def _first(name: str) -> frozenset[str]:
    """Return the terminals with which a rule can begin: a terminal itself."""
    rules = [each for each in _ALTERNATIVES.get(name, ()) if each]
    return frozenset().union(*(_first(each[0]) for each in rules)) if rules else frozenset({name})


def _may_be_empty(name: str) -> bool:
    return [] in _ALTERNATIVES.get(name, ())
