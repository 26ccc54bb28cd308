"""Problems of statements that depend on the whole program: names, scenes, the tempo, and limits."""

from __future__ import annotations

import dataclasses
import unicodedata
from collections.abc import Iterable, Iterator, Mapping, Sequence
from functools import partial
from itertools import count, islice
from operator import attrgetter

from improv_core.diagnostics import MAX_SHOWN, Diagnostic, Edit, Fix, Related, Severity, joining_nothing, replace
from improv_core.program.bindings import Bindings
from improv_core.program.definitions import Definition, Takes
from improv_core.program.idle import Alone, Idle
from improv_core.program.misuse import give_arguments, move_canon
from improv_core.program.naming import is_valid_robot
from improv_core.program.opening import Repeated, without
from improv_core.program.program import MAX_SCENES, Program
from improv_core.program.unknown_names import misspelled, unknown_name
from improv_core.score.body import START
from improv_core.slices import checkpoint
from improv_core.syntax import nodes
from improv_core.syntax.characters import UNSEEN, in_words, is_name
from improv_core.syntax.lexer import Token, lex
from improv_core.syntax.nodes import Statement
from improv_core.syntax.slips import (
    is_like_a_robot,
    number_first,
    without_sign,
)
from improv_core.syntax.vocabulary import WORDS
from improv_core.syntax.wrong_characters import unseen_joins
from improv_core.text import Span


def diagnose(program: Program, idle: Mapping[int, Idle], alone: Alone | None) -> tuple[Diagnostic, ...]:
    """Return all diagnostics of a program, in the order of the text."""
    faulty = program.unusual.faulty
    serious = faulty.union(_too_many(program), program.infeasible, program.too_uneven)
    unused = program.bindings.unused.difference(misspelled(program))
    hinted = unused.union(idle, [alone.line] if alone else (), program.near_named, program.alike)
    indices = [*sorted(serious), *sorted(hinted - serious)]
    hides = any(program.meanings[index].statement.diagnostics for index in faulty)  # perhaps of a definition
    reported = ((index, each) for index in indices for each in diagnose_statement(program, index, idle, alone, hides))
    found = [each.shifted(program.offsets[index]) for index, each in islice(reported, MAX_SHOWN)]
    if any(each.severity is Severity.ERROR for each in found):  # a hint may remove text that another error needs
        found = [each if each.severity is Severity.ERROR else _as_guess(each) for each in found]
    if next_one := next(reported, None):
        index, _ = next_one
        found.append(_more(program, indices[indices.index(index) :], index not in serious))
    return tuple(sorted(found, key=attrgetter("span")))


def diagnose_statement(
    program: Program, index: int, idle: Mapping[int, Idle], alone: Alone | None, hides: bool = False
) -> Iterator[Diagnostic]:
    """Yield the diagnostics of one statement of a program. Spans count from its start.

    If the statement has the wrong form, its other diagnostics may be about a statement that nobody wrote. The same
    holds for all statements if the wrong form of one `hides` something from them.
    """
    statement = program.meanings[index].statement
    form = statement.diagnostics
    for each in _diagnosed(program, index, idle, alone):
        is_other = form and each.code not in [problem.code for problem in form]
        if is_other and any(_is_about_the_same(statement.text, problem.span, each) for problem in form):
            continue
        each = joining_nothing(statement.text, each)
        yield _as_guess(each) if is_other or (hides and not form) else each


def _is_about_the_same(text: str, wrong: Span, other: Diagnostic) -> bool:
    """Return whether a diagnostic is about text that already has the wrong form: the `1` of `1,5`, or half a word."""
    touches = wrong.start <= other.span.end and other.span.start <= wrong.end and wrong != Span(0, len(text))
    return touches and (other.severity is not Severity.ERROR or not text[slice(*wrong)].isascii())


def _as_guess(problem: Diagnostic) -> Diagnostic:
    """Return a diagnostic whose fixes are all guesses, so that nobody gets one without looking at it."""
    if not problem.fixes:
        return problem
    fixes = tuple(dataclasses.replace(fix, safe=False, guess=True) for fix in problem.fixes)
    return dataclasses.replace(problem, fixes=fixes)


def _diagnosed(program: Program, index: int, idle: Mapping[int, Idle], alone: Alone | None) -> Iterator[Diagnostic]:
    checkpoint()
    meaning = program.meanings[index]
    statement, kind = meaning.statement, meaning.statement.kind
    for each in meaning.diagnostics:
        yield _in_context(program, index, each)
    yield from program.infeasible.get(index, ())
    if kind == "SCENE" and len(program.breaks) >= MAX_SCENES and index >= program.breaks[MAX_SCENES - 1]:
        message = f"this program has more than {MAX_SCENES} scenes: remove some"
        yield Diagnostic("too-large", Span(0, len(statement.text)), message)
    if index in idle and index not in program.repeated:
        yield _idle(program, index, idle[index])
    if alone and index == alone.line:
        yield _nothing_near(program, alone)
    for head, others in program.near_named.get(index, {}).items():
        yield _near_named(program, head, others)
    for name, other in program.alike.get(index, {}).items():
        yield _alike(statement, name, other)
    is_unused = index in program.bindings.unused and is_name(statement.heads[0].text)
    if is_unused and "unused-name" not in [each.code for each in meaning.diagnostics]:  # it is a parameter's
        yield _unused(program, index)
    if kind == "BEAT" and index != program.tempos[0]:
        first = program.offsets[program.tempos[0]]
        message = f"line {program.line_number(program.tempos[0])} already sets the tempo: remove this `beat`"
        related = Related(_relative(program, Span(first, first + len("beat")), index), "the first `beat`")
        repeats = meaning.tempo == program.meanings[program.tempos[0]].tempo
        fixes = replace("Remove it", _whole_line(program, index), "", safe=repeats, guess=not repeats)
        yield Diagnostic("duplicate-beat", Span(0, len(statement.text)), message, fixes, (related,))
    for again in program.repeated.get(index, ()):
        yield _repeated(program, index, again)
    if index in program.too_uneven and statement.body:
        message = "use simpler numbers: with the lines above, they make a fraction too long to compute exactly"
        yield Diagnostic("bad-number", statement.body.span, message)
    if meaning.unresolved:
        tokens = statement.tokens
        places = {token.start: at for at, token in enumerate(tokens)}
        for node in meaning.unresolved:
            yield _unresolved(program, index, node, tokens, places.get(node.span.start, 0))
    for use in meaning.misused:
        yield _misused(program, index, use)


def _too_many(program: Program) -> Iterable[int]:
    """Return the statements that repeat an earlier one, and the scenes over the limit."""
    return [*program.tempos[1:], *program.breaks[MAX_SCENES - 1 :], *program.repeated]


def _repeated(program: Program, index: int, again: Repeated) -> Diagnostic:
    """Return the diagnostic about a repetition in a line of the opening."""
    statement, line = program.statements[index], program.line_number(again.first)
    what = _EFFECTS[again.sign].format(name=again.name)
    where = "this line" if again.first == index else f"line {line}"
    first = again.first_span.shifted(program.offsets[again.first])
    related = Related(_relative(program, first, index), "here, for the first time")
    if again.sign == "SCENE":
        names = {head.text for each in program.scenes for head in program.statements[each].heads}
        base = again.name.rstrip("0123456789")
        free = next(name for number in count(2) if (name := f"{base}{number}") not in names)
        message = f"{where} already {what}: choose another name, such as `{free}`"
        gone = Span(len(statement.text[: again.span.start].rstrip()), again.span.end)
        fixes = replace(f"Change to {free}", again.span, free) + replace("Remove the name", gone, "")
        return Diagnostic("duplicate-line", again.span, message, fixes, (related,))
    is_whole = len(statement.heads) < 2
    gone = _whole_line(program, index) if is_whole else without(statement, again.span)
    span = Span(0, len(statement.text)) if is_whole else again.span
    message = f"{where} already {what}: remove {'this line' if is_whole else 'it here'}"
    fixes = replace("Remove it", gone, "", guess=True)
    return Diagnostic("duplicate-line", span, message, fixes, (related,))


_EFFECTS = {
    "AT": "places `{name}`",
    "IS": "gives `{name}` a profile",
    "ROOM": "sets the floor",
    "BAR_LENGTH": "sets the bar",
    "SCENE": "begins a scene called `{name}`",
}


def _idle(program: Program, index: int, idle: Idle) -> Diagnostic:
    statement = program.statements[index]
    whole = Span(0, len(statement.text))
    if idle.scene is not None:
        message = f"scene {idle.scene} above never ends, so this is never performed: give its `repeat` a number"
        return Diagnostic("never-performed", whole, message)
    if idle.line is not None:
        head = next(head for head in statement.heads if head.text == idle.robots[0])
        is_all = len(idle.robots) == len(program.meanings[index].robots)
        what = "this is never performed" if is_all else f"`{head.text}` never performs this"
        message = f"line {program.line_number(idle.line)} never ends, so {what}: give its `repeat` a number"
        related = Related(_relative(program, program.placed(idle.line).span, index), "this never ends")
        return Diagnostic("never-performed", whole if is_all else head.span, message, (), (related,))
    where = "above this line: remove it" if idle.is_first else "in this scene: remove this line"
    fixes = replace("Remove it", _whole_line(program, index), "", safe=True)
    return Diagnostic("no-effect", whole, f"no robot plays {where}", fixes)


def _nothing_near(program: Program, alone: Alone) -> Diagnostic:
    message = (
        f"`{alone.robot}` is alone and there are no walls, so in the simulator nothing is ever near it: add `{_ROOM}`"
    )
    start = program.offsets[0]
    above = _relative(program, Span(start, start), alone.line)
    return Diagnostic("nothing-near", alone.span, message, replace(f"Add {_ROOM}", above, f"{_ROOM}\n"))


_ROOM = "room 6 4"


def _near_named(program: Program, head: Token, others: Sequence[str]) -> Diagnostic:
    """Return the diagnostic about a robot with a place that never plays, while one with nearly the same name does."""
    shown = " and ".join(f"`{each}`" for each in others)
    message = f"`{head.text}` never plays, but {shown} {'does' if len(others) == 1 else 'do'}: if they are one robot, "
    message += f"write `{others[0]}` here"
    free = [each for each in others if each not in program.opening.places]
    fixes = tuple(fix for each in free for fix in replace(f"Change to {each}", head.span, each))
    return Diagnostic("near-name", head.span, message, fixes)


def _alike(statement: Statement, name: str, other: str) -> Diagnostic:
    """Return the diagnostic about a name that looks like a name above."""
    token = next(each for each in statement.tokens if each.text == name)
    strange = next((char for char in name + other if unicodedata.normalize("NFC", char) != char), name[0])
    message = f"`{name}` is another name than the `{other}` above, which looks alike: one has {in_words(strange)}"
    return Diagnostic("two-spellings", token.span, message)


def _more(program: Program, hidden: Sequence[int], only_hints: bool) -> Diagnostic:
    """Return the diagnostic that stands for those of statements that are not shown."""
    wrong = program.too_uneven.union(_too_many(program))
    has_errors = any(
        not program.meanings[index].ok
        or index in wrong
        or any(each.severity is Severity.ERROR for each in program.infeasible.get(index, ()))
        for index in hidden
    )
    kind = "hints" if only_hints else "problems"
    lines = "line has" if len(hidden) == 1 else "lines have"
    message = f"fix what is marked first: {len(hidden):,} more {lines} {kind} that aren't marked yet"
    return Diagnostic("more-errors" if has_errors else "more-hints", program.placed(hidden[0]).span, message)


def _unresolved(program: Program, index: int, node: nodes.Name, tokens: Sequence[Token], at: int) -> Diagnostic:
    """Return the diagnostic about a name that nothing above defines: the token `at` of its statement."""
    name = node.text
    if name not in program.bindings.defined:
        return unknown_name(program, index, node, tokens, at)
    later = program.bindings.defined[name][0]
    head = program.statements[later].heads[0].span.shifted(program.offsets[later])
    related = Related(_relative(program, head, index), f"`{name}` is defined here")
    line = program.line_number(later)
    if later == index:
        message = f"`{name}` is used in its own definition: define it first, above line {line}"
        return Diagnostic("used-before-definition", node.span, message, (), (related,))
    message = f"`{name}` is not defined until line {line}: move its definition above this line"
    above = Edit(Span(0, 0), program.statements[later].text + program.lines.ending(program.offsets[index]))
    moved = (above, Edit(_whole_line(program, later, index), ""))
    fixes = (Fix(f"Move the definition of {name} up", moved, guess=True),)  # another definition above may be broken
    return Diagnostic("used-before-definition", node.span, message, fixes, (related,))


def _misused(program: Program, index: int, node: nodes.Name | nodes.Call) -> Diagnostic:
    """Return the diagnostic about a use whose arguments don't match the head of its definition."""
    name, numbers = nodes.use_name(node), nodes.numbers(node)
    scope = dict(zip(program.statements[index].uses, program.meanings[index].scope, strict=True))
    found = scope.get(name.text)
    if found and found.takes:
        return _incomplete(name, found, numbers)
    is_parameter = name.text in (each.name for each in program.statements[index].parameters)
    if is_parameter or not found or not found.phrase:
        span = Span(numbers[0].span.start, numbers[-1].span.end)
        if len(numbers) > 1 or any(numbers[0].parameters):
            return Diagnostic("arguments", span, f"`{name.text}` takes no number: remove it")
        term = Token("NAME", name.text, *name.span)
        message, fixes = number_first(numbers[0].text, term, True, Span(name.span.end, span.end))
        return Diagnostic("arguments", span, f"`{name.text}` takes no number: {message}", fixes)
    movements = node.movements if isinstance(node, nodes.Call) else ()
    takes = _counted(len(found.phrase.numbers), len(found.phrase.movements))
    given = f", not {_counted(len(numbers), len(movements))}" if numbers or movements else ""
    message = f"`{name.text}` takes {takes}{given}: write `{found.head}`"
    if len(numbers) > len(found.phrase.numbers) and len(movements) < len(found.phrase.movements):
        first = found.phrase.movements[0].name
        message = f"`{name.text}` takes {takes}{given}: for a number, write `{first}` without brackets in its head"
    definer = program.bindings.definer(name.text, index)
    assert definer is not None
    head = program.statements[definer].heads[0].span.shifted(program.offsets[definer])
    related = Related(_relative(program, head, index), f"`{found.head}` is defined here")
    sign = program.statements[definer].sign
    assert sign
    declared = _relative(program, Span(head.end, program.offsets[definer] + sign.start), index)
    fixes = give_arguments(node, found.phrase, declared)
    return Diagnostic("arguments", name.span, message, fixes, (related,))


def _incomplete(name: nodes.Name, word: Definition, numbers: Sequence[nodes.Number]) -> Diagnostic:
    """Return the diagnostic about a word for a body part without a term, or `to` without a pose."""
    if numbers:
        span = Span(numbers[0].span.start, numbers[-1].span.end)
        advice = "remove it" if word.takes is not Takes.POSE else "drive to a place with `forward` and turns"
        return Diagnostic("arguments", span, f"`{name.text}` takes no number: {advice}")
    if word.takes is Takes.POSE:
        return Diagnostic("arguments", name.span, f"write the name of a pose after `{name.text}`, such as `{START}`")
    message = f"write a movement after `{name.text}`, such as `{name.text} left`"
    return Diagnostic("arguments", name.span, message)


def _in_context(program: Program, index: int, problem: Diagnostic) -> Diagnostic:
    """Add to a diagnostic of a statement what other statements know."""
    statement = program.meanings[index].statement
    if problem.code == "misplaced-canon":
        return _misplaced(program, index, problem)
    if not statement.sign and statement.body and problem is statement.diagnostics[0]:
        tokens = lex(statement.text)
        is_vague = problem == without_sign(tokens)
        bindings = program.bindings
        is_used = partial(_is_used_elsewhere, bindings, index)
        return without_sign(tokens, bindings.nearest, program.any_robot, is_used) if is_vague else problem
    if problem.code == "syntax" and problem in statement.diagnostics:
        return _with_names(program, index, problem)
    return problem


def _is_used_elsewhere(bindings: Bindings, index: int, name: str) -> bool:
    return any(user != index for user in bindings.used.get(name, ()))


def _with_names(program: Program, index: int, problem: Diagnostic) -> Diagnostic:
    """Adapt a diagnostic about a character to the program's names: one may be `½`, or have an invisible character."""
    statement = program.statements[index]
    written = statement.text[slice(*problem.span)]
    if written.isascii():
        return problem
    tokens = statement.tokens
    inside = [each.text for each in tokens if problem.span.start <= each.start and each.end <= problem.span.end]
    if any(name in program.bindings.defined for name in inside):
        return dataclasses.replace(problem, fixes=())
    parts = unseen_joins(tokens, problem.span) if set(written) <= set(UNSEEN) else None
    if not parts or problem.fixes:
        return problem
    known = {
        *program.bindings.defined,
        *program.config.part_words,
        *WORDS,
        *(each.name for each in statement.parameters),
    }
    *halves, whole = parts
    is_head = statement.sign is not None and problem.span.end <= statement.sign.start
    is_robot = is_head and statement.defines is None
    if is_robot:
        known = {*program.config.robots, *program.parts}
    elif whole not in known and not (is_head and known.isdisjoint(halves)):
        return problem
    fixes = replace("Remove it", problem.span, "", guess=is_robot and whole not in known)
    return dataclasses.replace(problem, fixes=fixes)


def _misplaced(program: Program, index: int, problem: Diagnostic) -> Diagnostic:
    """Return the diagnostic about a `canon` in a definition, with its fixes."""
    statement, body = program.statements[index], program.meanings[index].body
    found = (each for each in nodes.nodes(body) if isinstance(each, nodes.Apply)) if body else ()
    canon = next((each for each in found if each.word.span == problem.span and each.numbers), None)
    if not canon:
        return problem
    users = program.bindings.users(statement.defines, index) if statement.defines else ()
    uses = [
        _relative(program, name.span.shifted(program.offsets[user]), index).start
        for user in users
        for name in nodes.names(program.meanings[user].body or canon)
        if name.text == statement.defines
    ]
    movable = (
        canon is body and not any(canon.numbers[0].parameters) and all(program.meanings[user].robots for user in users)
    )
    fixes = move_canon(canon, statement.text, uses if movable else None)
    return dataclasses.replace(problem, fixes=tuple(fixes))


def _unused(program: Program, index: int) -> Diagnostic:
    statement = program.statements[index]
    head, sign = statement.heads[0], statement.sign
    assert sign
    message = f"nothing uses `{head.text}`: use it below or remove this line"
    fixes = [Fix("Remove the definition", (Edit(_whole_line(program, index), ""),))]
    robots, is_like_one = program.config.robots, is_like_a_robot(head.text)
    is_unlisted = bool(robots) and head.text not in robots and not is_like_one
    if statement.parameters or is_unlisted or not is_valid_robot(head.text):
        return Diagnostic("unused-name", head.span, message, tuple(fixes))
    fixes += replace(f"Play it: {head.text} $ …", sign.span, "$")
    if program.plays_nothing or head.text in robots or is_like_one:
        message = f"nothing uses `{head.text}`: if it is a robot, write `{head.text} $ …`"
        fixes.reverse()
    return Diagnostic("unused-name", head.span, message, tuple(fixes))


def _whole_line(program: Program, index: int, seen_from: int | None = None) -> Span:
    """Return the whole lines of a statement, for removal. Offsets count from the start of the statement `seen_from`."""
    whole = program.lines.whole(program.placed(index).span)
    return _relative(program, whole, index if seen_from is None else seen_from)


def _relative(program: Program, span: Span, index: int) -> Span:
    return span.shifted(-program.offsets[index])


def _counted(numbers: int, movements: int) -> str:
    """`1 number`, `2 numbers and 1 movement`."""
    kinds = ((numbers, "number"), (movements, "movement"))
    counts = [f"{count} {kind}{'' if count == 1 else 's'}" for count, kind in kinds if count]
    return " and ".join(counts)
