"""Hovers: the effect of the text at the cursor, its length, its distance, and its end."""

from __future__ import annotations

import re
from base64 import b64encode
from collections.abc import Sequence
from dataclasses import dataclass, replace
from fractions import Fraction

from improv_core.ide.body_words import about_part, about_pose, moved_by
from improv_core.ide.code_action_play import scene_lasting
from improv_core.ide.cursor import Cursor, cursor
from improv_core.ide.hover_measures import about_measures, written_measures
from improv_core.ide.hover_opening import about_opening, stand_at
from improv_core.ide.phrases import comment, label, parameters
from improv_core.ide.references import performers
from improv_core.ide.senses import about as about_sense
from improv_core.ide.senses import source
from improv_core.plain import printable
from improv_core.program.analysis import Analysis
from improv_core.program.compiler import score_of
from improv_core.program.numbers import value_of
from improv_core.program.program import Placed
from improv_core.program.timing import (
    deciding,
    ends,
    fastest,
    in_beats,
    in_seconds,
    moment,
    path_length,
    times_as_fast,
    timing,
    written,
)
from improv_core.score.algebra import series
from improv_core.score.lengths import lengths
from improv_core.score.motion import Pose
from improv_core.score.movement import NORMAL, Movement
from improv_core.score.profiles import Profile
from improv_core.score.score import Part, Score
from improv_core.score.svg import picture
from improv_core.syntax import nodes
from improv_core.syntax.lexer import Token
from improv_core.syntax.nodes import Node, Parameter
from improv_core.syntax.vocabulary import WORDS
from improv_core.text import LINE_END, Span

LONGEST_SOURCE = 500
"""The most characters of a definition that are shown."""
LONGEST_NAME = 100
MAX_HEADS = 20
"""The most names before the sign of a line that are listed."""
_NOWHERE = Span(0, 0)
_BARE = re.compile(r"[\w…-]+")
MAX_MOMENTS = 150
"""The most moments of a path that is drawn: more would take too long."""
SIZE = 160.0
"""Pixels of the longer side of a picture."""


@dataclass(frozen=True, slots=True)
class Hover:
    """The hover for the text at `span`: a word, its effect, its definition, facts, and its path as SVG."""

    span: Span
    word: str
    about: str
    facts: tuple[str, ...] = ()
    source: str = ""
    picture: str = ""

    @property
    def markdown(self) -> str:
        """All of the hover, in under 90,000 characters: VS Code shows longer Markdown as plain text."""
        title = f"**{self.word}**{self.about}"
        shown = f"\n```improv\n{self.source}\n```" if self.source else ""
        facts = "  \n".join(self.facts)  # two spaces keep the line break
        return "\n\n".join(each for each in (title + shown, facts, self.picture and _image(self.picture)) if each)

    @property
    def plain(self) -> str:
        """The same for editors that show plain text, without the picture."""
        title = (self.word + self.about).replace("`", "")
        return "\n".join(each for each in (title, self.source, *self.facts) if each)


def hover(analysis: Analysis, offset: int, pictures: bool = False) -> Hover | None:
    """Return the hover at an offset, with `pictures` also a picture of the path; None if there is nothing to show.

    Anything slow is left out: long voices are not measured, and only the start of a long path is drawn.
    """
    at = cursor(analysis, offset)
    if not at:
        return None
    found = _about(analysis, at, pictures)
    return replace(found, span=found.span.shifted(at.placed.start)) if found else None


def name_at(analysis: Analysis, name: str, before: int, pictures: bool = False) -> Hover | None:
    """Return the hover for a name as it is used in the statement `before`."""
    found = analysis.definition(name, before)
    if not found:
        return None
    meaning = None if parameters(analysis, name, before) else found.movement
    return _name(analysis, Span(0, 0), name, before, meaning, (), pictures)


def robot_at(analysis: Analysis, name: str, pictures: bool = False) -> Hover | None:
    """Return the hover for everything that a robot plays; None if it plays nothing."""
    if not (part := score_of(analysis).parts.get(name)):
        return None
    placed = (f"starts at {stand_at(part.start)}",) if name in analysis.opening.places else ()
    about = f" (robot, profile {_code(part.profile.name)}): "
    lines = (index for index, line in analysis.played.items() if name in dict(line.parts))
    if lack := next((analysis.lacks[index] for index in lines if index in analysis.lacks), ""):
        return Hover(Span(0, 0), _code(name), f"{about}everything it plays", (lack, *placed))
    if name not in analysis.lengths:
        return Hover(Span(0, 0), _code(name), f"{about}only stands there", placed)
    whole = timing(analysis.lengths[name], analysis.tempo)
    why = [deciding(series(part.scenes))] if part.senses else []
    facts, drawn = (whole, *why, *placed), _drawn(part, analysis.tempo) if pictures else ""
    return Hover(Span(0, 0), _code(name), f"{about}everything it plays", facts, "", drawn)


def sense_at(analysis: Analysis, name: str, span: Span = _NOWHERE) -> Hover | None:
    """Return the hover for a sense; None if there is no such sense."""
    if name not in analysis.config.sense_names:
        return None
    return Hover(span, _code(name), f" (sense): {about_sense(name)}", (source(analysis.config, name),))


def _about(analysis: Analysis, at: Cursor, pictures: bool) -> Hover | None:
    """Return the hover at a cursor, with a span that counts from the statement's start."""
    placed, statement, token, node = at.placed, at.placed.statement, at.token, at.node
    if token.type == "BEAT" or (statement.number and token in statement.number.tokens):
        lasts = f"1 beat lasts {in_seconds(1, analysis.tempo)}"
        return Hover(token.span, f"beat {written(analysis.tempo)}", f": {WORDS['beat'].about}", (lasts,))
    if token.type == "SCENE":
        return _scene(analysis, placed) if token == statement.sign else None
    if statement.sign and placed.meaning.said and token in statement.heads:
        is_scene = statement.kind == "SCENE"
        found = _scene(analysis, placed) if is_scene else robot_at(analysis, token.text, pictures)
        return found and replace(found, span=token.span)
    if opening := about_opening(analysis, placed, token):
        return Hover(opening.span, opening.word, opening.about, opening.facts)
    condition = node.condition if isinstance(node, nodes.Apply | nodes.Choice) else None
    if condition and token.span == condition.sense.span:
        return sense_at(analysis, token.text, token.span)
    if parameter := _parameter(at):
        kind = "a number" if parameter.is_number else "a movement"
        head, _ = label(statement.heads[0].text, statement.parameters)
        return Hover(token.span, _code(parameter.name), f" (parameter of {_code(head)}): {kind}")
    if node is None:
        return _head_or_sign(analysis, placed, token, pictures)
    around = at.around
    if len(around) > 1 and isinstance(around[-2], nodes.Call) and node is around[-2].name:
        around, node = around[:-1], around[-2]
    meaning = None if _depends(node, statement.parameters) else analysis.movement(placed, node)
    here = _here(around, meaning, analysis.tempo) if placed.meaning.ok and meaning else ()
    lack = _lack(analysis, placed, node)
    if isinstance(node, nodes.Name | nodes.Call):
        name = nodes.use_name(node)
        found = _name(analysis, node.span, name.text, placed.index, meaning, here, pictures)
        if analysis.bindings.definer(name.text, placed.index) is None:
            return None
        given = [each.text for each in nodes.numbers(node)]
        found = replace(found, facts=(lack,), picture="") if lack else found
        return replace(found, word=" ".join([found.word, *given]))
    if isinstance(node, nodes.PoseTerm):
        facts = about_pose(analysis, placed, node.pose.text)
        word = _code(f"{node.word.text} {node.pose.text}")
        return Hover(node.span, word, ": brings the body part around it to this pose, in one beat", (*facts, *here))
    if not (described := _described(node)):
        return None
    word, about = described
    if lack:
        return Hover(node.span, word, about, (lack,))
    if isinstance(node, nodes.PartTerm):
        here = (*about_part(analysis, placed, node.name.text), *here)
    elif meaning and any(isinstance(each, nodes.PartTerm) for each in around):
        return Hover(node.span, word, about, (timing(lengths(meaning), analysis.tempo), *here))
    if not meaning:
        return Hover(node.span, word, about)
    facts = (*_measures(analysis, placed, meaning, isinstance(node, nodes.Primitive | nodes.MeasuredWord)), *here)
    return Hover(node.span, word, about, facts, "", _shape(analysis, placed, meaning) if pictures else "")


def _described(node: nodes.Node) -> tuple[str, str] | None:
    """Describe a word or a bracket with its arguments, and its effect."""
    if isinstance(node, nodes.Bracket):
        return _bracket(node)
    if isinstance(node, nodes.Parallel):
        return "||", ": these movements play at the same time, until the shortest one ends"
    if isinstance(node, nodes.Primitive):
        return node.word.text, f": {node.word.about}"
    if isinstance(node, nodes.MeasuredWord):
        return written_measures(node), f": {about_measures(node)}"
    if isinstance(node, nodes.PartTerm):
        return _code(node.name.text), " (body part): performs the term after it, while the base stands"
    if not isinstance(node, nodes.Apply | nodes.Choice):
        return None
    arguments = [each.text for each in (*node.numbers, node.across) if each] if isinstance(node, nodes.Apply) else []
    word = " ".join([node.word.text, *arguments, *(_condition(node.condition) if node.condition else ())])
    plane = node.plane if isinstance(node, nodes.Apply) else None
    return word, f": {(plane or WORDS[node.word.text]).about}"


def _condition(condition: nodes.Condition) -> Sequence[str]:
    return ["not"] * condition.is_negated + [condition.sense.text]


def _scene(analysis: Analysis, placed: Placed) -> Hover:
    number, about, facts = 0, ": the name of the first scene", list[str]()
    if placed.index in analysis.breaks:
        number, facts = analysis.breaks.index(placed.index) + 1, ["never begins"]
        about = ": a new scene, for all robots, when everything above has ended"
    if number and (begin := analysis.scene_begin(number)):
        passed = in_seconds(begin.shortest, analysis.tempo) + ("" if begin.is_fixed else " or later")
        facts = [f"begins at {moment(float(begin.shortest))}, after {passed}"]
    facts += [f"this scene: {each}" for each in [scene_lasting(analysis, number)] if each]
    return Hover(Span(0, len(placed.statement.text)), "---", about, tuple(facts))


def _parameter(at: Cursor) -> Parameter | None:
    """Return the parameter of its own statement that the cursor touches."""
    own = at.placed.statement.parameters
    if at.node is None:
        return next((each for each in own if each.token.span == at.token.span), None)
    return next((each for each in own if each.name == at.token.text), None)


def _lack(analysis: Analysis, placed: Placed, node: Node) -> str:
    """Return the error because of which nobody knows what a node of a statement moves; empty if there is none."""
    unknown = {each.span for each in placed.meaning.unresolved}
    for name in nodes.names(node) if analysis.lacks else ():
        definer = analysis.bindings.definer(name.text, placed.index)
        if why := analysis.lacks.get(placed.index if name.span in unknown else -1 if definer is None else definer):
            return why
    return ""


def _depends(node: Node, own: Sequence[Parameter]) -> bool:
    """Return whether the meaning of a node depends on the arguments of its phrase."""
    names = {each.name for each in own}
    return any(
        (isinstance(each, nodes.Name) and each.text in names)
        or any(token.text in names for number in nodes.numbers(each) for token in number.parameters)
        for each in (nodes.nodes(node) if names else ())
    )


def _head_or_sign(analysis: Analysis, placed: Placed, token: Token, pictures: bool) -> Hover | None:
    statement, sign = placed.statement, placed.statement.sign
    if not (statement.body and sign and (token == sign or token in statement.heads)):
        return None
    meaning = placed.meaning.movement
    if statement.parameters:
        head, _ = label(statement.heads[0].text, statement.parameters)
        return Hover(token.span, _code(head), " (phrase)")
    lack = analysis.lacks.get(placed.index)
    facts = (lack,) if lack else _measures(analysis, placed, meaning)
    plays = sign.type == "DOLLAR"
    if plays and token != sign:
        whole = robot_at(analysis, token.text, pictures)
        if not whole or lack:
            return whole and replace(whole, span=token.span)
        facts = (*whole.facts, f"this line: {facts[0]}", *facts[1:], *_speeds(analysis, (token.text,), meaning))
        return Hover(token.span, whole.word, whole.about, facts, "", whole.picture)
    drawn = _shape(analysis, placed, meaning) if pictures and not lack else ""
    if not plays and token != sign:
        return Hover(token.span, _code(token.text), " (name)", facts, "", drawn)
    heads = _short(", ".join(_code(head.text) for head in statement.heads[:MAX_HEADS]))
    if plays and not lack:
        facts = (*facts, *_speeds(analysis, placed.meaning.robots, meaning))
    one = len(statement.heads) == 1
    about = (
        f": {heads} play{'s' if one else ''} what follows"
        if plays
        else f": `{heads.strip('`')}` is the name for what follows"
    )
    return Hover(token.span, token.text, about, facts, "", drawn)


def _name(
    analysis: Analysis,
    span: Span,
    name: str,
    before: int,
    meaning: Movement | None,
    here: Sequence[str],
    pictures: bool,
) -> Hover:
    """Return the hover for a use of a name or a phrase; without a meaning if the phrase's arguments are not known."""
    placed, definer = analysis.placed(before), analysis.bindings.definer(name, before)
    line, source, kind = "", "", "name"
    if definer is not None:
        statement = analysis.statements[definer]
        kind = "phrase" if statement.parameters else kind
        line = f", line {analysis.line_number(definer)}"
        above = "".join(f"# {each}\n" for each in comment(analysis, definer).splitlines())
        shown = _short(above + statement.text, LONGEST_SOURCE).expandtabs(4)
        source = "\n".join(map(printable, LINE_END.split(shown)))
    facts = (*_measures(analysis, placed, meaning), *here) if meaning else ()
    drawn = _shape(analysis, placed, meaning) if pictures and meaning else ""
    # Don't show a source that would end the code block early.
    return Hover(span, _code(name), f" ({kind}{line})", facts, "" if "```" in source else source, drawn)


def _bracket(node: nodes.Bracket) -> tuple[str, str]:
    if not node.squeezes:
        return "( )", ": a group"
    counts = [nodes.items(voice) for voice in nodes.voices(node.body)] if node.body else []
    each = " and ".join(
        "1 item, at its normal speed" if count == 1 else f"{count} items, {count} times as fast" for count in counts
    )
    return "[ ]", f": squeezed: {each}"


def _measures(analysis: Analysis, placed: Placed, meaning: Movement, plain: bool = False) -> tuple[str, ...]:
    """Describe the length, the distance, and (unless `plain`) the end of a movement."""
    lasts, paths = timing(lengths(meaning), analysis.tempo), {}
    if meaning.open:
        return lasts, deciding(meaning)
    if moved := moved_by(analysis, placed, meaning):
        return (lasts, *moved)
    for profile, robot in performers(analysis, placed.index).items():
        paths[printable(robot)] = path_length(meaning, profile), "" if plain else ends(meaning, profile)
    if len(set(paths.values())) == 1:
        far, leads = next(iter(paths.values()))
        return (f"{lasts} · {far}", leads) if leads else (f"{lasts} · {far}",)
    return (lasts, *(f"{robot}: {', '.join(filter(None, way))}" for robot, way in paths.items()))


def _speeds(analysis: Analysis, robots: Sequence[str], meaning: Movement) -> tuple[str, ...]:
    """Describe the top speeds of robots, once for each profile."""
    by_profile = {analysis.opening.config.profile_of(robot): robot for robot in reversed(robots)}
    by_robot = {robot: fastest(meaning, profile, analysis.tempo) for profile, robot in reversed(by_profile.items())}
    if len(by_robot) == 1:
        return tuple(speed for speed in by_robot.values() if speed)
    return tuple(f"{robot}: {speed}" for robot, speed in by_robot.items() if speed)


def _here(around: Sequence[Node], meaning: Movement, tempo: Fraction) -> tuple[str, ...]:
    """Describe the duration of a node that brackets and transformers around it change."""
    rate, brackets, others = pace_in(around)
    if rate == 1:
        return ()
    where = "in this bracket" if brackets == 1 and not others else "here"
    lasts = lengths(meaning, rate)
    return (f"{times_as_fast(rate)} {where}: {in_beats(lasts)}, {in_seconds(lasts, tempo)}",)


def pace_in(around: Sequence[Node]) -> tuple[Fraction, int, int]:
    """Return the rate of the innermost node, and the numbers of brackets and of words that cause it."""
    rate, brackets, others = NORMAL, 0, 0
    for place, node in enumerate(around[:-1]):
        if isinstance(node, nodes.Bracket) and node.squeezes:
            voices = nodes.voices(node.body) if node.body else ()
            inside = [nodes.items(voice) for voice in voices if voice in around[place + 1 : place + 3]]
            counts = set(inside or map(nodes.items, voices))
            count = counts.pop() if len(counts) == 1 else 1
            rate, brackets = rate * count, brackets + (count != 1)
        elif isinstance(node, nodes.Apply) and (rate_by := WORDS[node.word.text].rate):
            number = node.numbers[0]
            factor = value_of(number.text) if number.text and not any(number.parameters) else NORMAL
            if isinstance(factor, Fraction):
                rate, others = rate * rate_by(factor), others + 1
    return rate, brackets, others


def _profile(analysis: Analysis, placed: Placed) -> Profile:
    """Return the profile of the first robot that plays a statement."""
    return next(iter(performers(analysis, placed.index)))


def _shape(analysis: Analysis, placed: Placed, meaning: Movement) -> str:
    return _drawn(Part("", (meaning,), _profile(analysis, placed), Pose(), ""), analysis.tempo)


def _drawn(part: Part, tempo: Fraction) -> str:
    """Return the path of a part as SVG; empty if the robot stays in place."""
    peak = part.movement.bounds.peak
    return picture(Score(tempo, {part.robot: part}), SIZE, MAX_MOMENTS) if peak.x or peak.y else ""


def _image(svg: str) -> str:
    width, height = (round(float(size)) for size in re.findall(r'(?:width|height)="([\d.]+)"', svg)[:2])
    return f"![path](data:image/svg+xml;base64,{b64encode(svg.encode()).decode()}|width={width},height={height})"


def _code(name: str) -> str:
    """Return a name in Markdown. One that the language or TOML would quote becomes code, which can hold no links."""
    name = printable(_short(name))
    return name if _BARE.fullmatch(name) else f"`{name.replace('`', chr(39))}`"


def _short(text: str, most: int = LONGEST_NAME) -> str:
    return text if len(text) <= most else text[: most - 1] + "…"
