"""The definitions and uses of names by the indices of statements. Reused from one version of a program to the next."""

from __future__ import annotations

import unicodedata
from bisect import bisect_left, bisect_right
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cache
from itertools import chain, islice

from improv_core.slices import checkpoint
from improv_core.syntax.nodes import Statement
from improv_core.syntax.slips import closest
from improv_core.syntax.vocabulary import TRANSFORMERS, of_kind
from improv_core.syntax.word import Kind

_MOVEMENTS = of_kind(Kind.PRIMITIVE, *TRANSFORMERS, Kind.IF)
MAX_NAMES, MAX_COMPARED = 2_000, 20
"""The most names that are searched for one like an unknown name, and the most that are fully compared with it."""
_Table = dict[str, tuple[int, ...]]


@dataclass(frozen=True, slots=True)
class Bindings:
    """The statements that define and use each name, and the definitions that nothing uses.

    `nearest` returns the known word that is most similar to a name, if there is one: a defined name itself. `spellings`
    maps names that look alike to their common composed form: one has a letter, and the other a sign like it.
    """

    defined: _Table
    used: _Table
    unused: frozenset[int]
    nearest: Callable[[str], str | None]
    spellings: Mapping[str, str] = field(default_factory=dict)

    def definer(self, name: str, before: int) -> int | None:
        """Return the statement whose definition of a name applies in the statement `before`."""
        definers = self.defined.get(name, ())
        count = bisect_left(definers, before)
        return definers[count - 1] if count else None

    def users(self, name: str, definer: int) -> Sequence[int]:
        """Return the statements that use the definition of a name in the statement `definer` (-1: no definition)."""
        users, definers = self.used.get(name, ()), self.defined.get(name, ())
        following = bisect_right(definers, definer)
        end = bisect_right(users, definers[following]) if following < len(definers) else len(users)
        return users[bisect_right(users, definer) : end]

    def edited(self, before: Mapping[int, Statement], now: Mapping[int, Statement]) -> Bindings:
        """Return the bindings after some statements have been replaced by others at the same indices."""
        if all(_names(before[index]) == _names(statement) for index, statement in now.items()):
            return self  # true after most keys
        is_renamed = any(before[index].defines != statement.defines for index, statement in now.items())
        defined, used = dict(self.defined) if is_renamed else self.defined, dict(self.used)
        names: set[str] = set()  # names whose definitions or uses have changed
        for index, statement in now.items():
            names |= _moved(defined, index, _defines(before[index]), _defines(statement))
            names |= _moved(used, index, before[index].uses, statement.uses)
        unused = self.unused.difference(*(self.defined.get(name, ()) for name in names))
        unused = unused.union(*(_unused(name, defined, used) for name in names if name in defined))
        nearest = _nearest(defined) if is_renamed else self.nearest
        return Bindings(defined, used, unused, nearest, _spellings(defined, used))


def bind(statements: Iterable[Statement]) -> Bindings:
    """Return the bindings of a whole program."""
    definers: dict[str, list[int]] = {}
    users: dict[str, list[int]] = {}
    for index, statement in enumerate(statements):
        for name in statement.uses:
            users.setdefault(name, []).append(index)
        if statement.defines:
            definers.setdefault(statement.defines, []).append(index)
    defined, used = _tuples(definers), _tuples(users)
    unused: set[int] = set()
    for name in defined:
        checkpoint()
        unused.update(_unused(name, defined, used))
    return Bindings(defined, used, frozenset(unused), _nearest(defined), _spellings(defined, used))


def _tuples(table: Mapping[str, Sequence[int]]) -> _Table:
    return {name: tuple(indices) for name, indices in table.items()}  # a list with one item takes twice the memory


def _names(statement: Statement) -> tuple[str | None, tuple[str, ...]]:
    return statement.defines, statement.uses


def _defines(statement: Statement) -> tuple[str, ...]:
    return (statement.defines,) if statement.defines else ()


def _moved(table: dict[str, tuple[int, ...]], index: int, before: Sequence[str], now: Sequence[str]) -> set[str]:
    """Move a statement from its old names to its new ones. Return the names that changed."""
    for name in set(before) - set(now):
        indices = tuple([each for each in table[name] if each != index])
        if indices:
            table[name] = indices
        else:
            del table[name]
    for name in set(now) - set(before):
        table[name] = tuple(sorted((*table.get(name, ()), index)))
    return set(before) ^ set(now)


def _unused(name: str, defined: _Table, used: _Table) -> Iterator[int]:
    """Yield the definitions of a name that nothing uses before its next definition (which may use it itself)."""
    definers, users = defined[name], used.get(name, ())
    if users and users[0] <= definers[0]:
        return  # it is used before it is defined, and that is reported
    for place, definer in enumerate(definers):
        user = bisect_right(users, definer)
        if user == len(users) or (place + 1 < len(definers) and users[user] > definers[place + 1]):
            yield definer


def _spellings(defined: _Table, used: _Table) -> Mapping[str, str]:
    """Return the names that look like others, each with its composed form."""
    found: dict[str, set[str]] = {}
    for name in chain(defined, used):
        if not name.isascii():
            composed = unicodedata.normalize("NFC", name)
            found.setdefault(composed, set()).add(name)
            if composed in defined or composed in used:
                found[composed].add(composed)
    return {name: composed for composed, names in found.items() if len(names) > 1 for name in names}


def _nearest(names: Collection[str]) -> Callable[[str], str | None]:
    @cache
    def nearest(name: str) -> str | None:
        if name in names:
            return name
        # A full comparison with thousands of names, for hundreds of unknown ones, would delay every key noticeably.
        letters = set(name)
        alike = (each for each in islice(names, MAX_NAMES) if len(letters.symmetric_difference(each)) < 4)
        known = [*_MOVEMENTS, *islice(alike, MAX_COMPARED)]
        return closest(name, known)

    return nearest
