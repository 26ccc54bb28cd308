"""What stands at the cursor: what it does, how long it takes, how far it goes."""

from __future__ import annotations

from dataclasses import dataclass

from improv_core.analysis import Analysis, Placed
from improv_core.compiler import score_of
from improv_core.ide.cursor import Cursor, cursor
from improv_core.ide.timing import beats, lasting, number, timing, way
from improv_core.movement import Movement
from improv_core.profiles import DEFAULT, Profile
from improv_core.syntax import nodes
from improv_core.syntax.lexer import Token
from improv_core.syntax.vocabulary import WORDS
from improv_core.text import Span


@dataclass(frozen=True, slots=True)
class Hover:
    """Markdown about what stands at `span`."""

    span: Span
    text: str


def hover(analysis: Analysis, offset: int) -> Hover | None:
    """What to say about the place under the cursor; None where there is nothing to say."""
    at = cursor(analysis, offset)
    if not at:
        return None
    span, text = _about(analysis, at)
    return Hover(span.shifted(at.placed.start), text) if text else None


def _about(analysis: Analysis, at: Cursor) -> tuple[Span, str]:
    statement, token, node = at.placed.statement, at.token, at.node
    if token in statement.heads and statement.sign and statement.body:
        return token.span, _head(analysis, at.placed, token)
    if token.type == "BEAT" or (statement.number and token == statement.number):
        return token.span, f"**beat {number(analysis.tempo)}**: {WORDS['beat'].about}"
    if token == statement.sign and statement.body:
        meaning = analysis.movement(at.placed, statement.body)
        names = ", ".join(head.text for head in statement.heads)
        what = f"{names} plays what follows" if token.type == "DOLLAR" else f"`{names}` stands for what follows"
        return token.span, _said(f"**{token.text}**: {what}", meaning, analysis)
    if node is None:
        return token.span, ""
    meaning = analysis.movement(at.placed, node)
    if isinstance(node, nodes.Name):
        return node.span, _name(analysis, at.placed, node, meaning)
    if isinstance(node, nodes.Bracket):
        return node.span, _said(_bracket(node), meaning, analysis)
    if isinstance(node, nodes.Parallel):
        return node.span, _said("**||**: these movements play at once, until the shortest ends", meaning, analysis)
    if isinstance(node, nodes.Apply):
        written = f"{node.word.text} {node.argument.text}" if node.argument else node.word.text
        about = (node.plane or WORDS[node.word.text]).about
        return node.span, _said(f"**{written}**: {about}", meaning, analysis)
    if isinstance(node, nodes.Primitive):
        return node.span, _said(f"**{node.word.text}**: {node.word.about}", meaning, analysis)
    return token.span, ""


def _head(analysis: Analysis, placed: Placed, token: Token) -> str:
    if placed.statement.sign and placed.statement.sign.type == "DOLLAR":
        part = score_of(analysis).parts.get(token.text)
        if not part:
            return ""
        return _said(
            f"**{token.text}** (robot, profile {part.profile.name}): all it plays",
            part.movement,
            analysis,
            part.profile,
        )
    assert placed.statement.body
    return _said(f"**{token.text}** (name)", analysis.movement(placed, placed.statement.body), analysis)


def _name(analysis: Analysis, placed: Placed, node: nodes.Name, meaning: Movement) -> str:
    found = analysis.defining(node.text, placed.index)
    if found is None:
        return ""
    line = analysis.lines.position(analysis.starts[found]).line
    source = analysis.lines.line(line).strip()
    return _said(f"**{node.text}** (name, line {line + 1})\n```improv\n{source}\n```", meaning, analysis)


def _bracket(node: nodes.Bracket) -> str:
    if not node.squeezes:
        return "**( )**: a group"
    voices = node.body.voices if isinstance(node.body, nodes.Parallel) else (node.body,)
    counts = [len(voice.items) if isinstance(voice, nodes.Series) else 1 for voice in voices]
    each = " and ".join(
        "1 item, at its own speed" if count == 1 else f"{count} items, {count} times as fast" for count in counts
    )
    return f"**[ ]**: squeezed: {each}"


def _said(title: str, meaning: Movement, analysis: Analysis, profile: Profile = DEFAULT) -> str:
    return f"{title}\n\n{timing(meaning, analysis.tempo)} · {way(meaning, profile)}"


def summary(analysis: Analysis) -> str:
    """What plays, in one line: `turtle1 8 beats · turtle2 ∞, 16.0 s at beat 30`."""
    score = score_of(analysis)
    robots = " · ".join(f"{name} {beats(part.movement.duration)}" for name, part in score.parts.items())
    whole = max((part.movement for part in score.parts.values()), key=lambda part: part.duration, default=None)
    if whole is None:
        return "no robot plays"
    return f"{robots}, {lasting(whole, analysis.tempo)}"
