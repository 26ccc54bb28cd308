"""Find movements that a robot can make instead of a motion that it can't."""

from __future__ import annotations

import math
from collections.abc import Iterator
from fractions import Fraction

from improv_core.diagnostics import Fix, replace
from improv_core.robots.limits import excess, too_tight
from improv_core.score.movement import Velocity
from improv_core.score.profiles import Profile
from improv_core.syntax import nodes
from improv_core.syntax.nodes import Node, Primitive
from improv_core.syntax.vocabulary import WORDS

_SIDEWAYS = {"strafeleft": "left forward right", "straferight": "right forward left"}


def substitutes(body: Node, word: Primitive, velocity: Velocity, profile: Profile, tempo: Fraction) -> Iterator[Fix]:
    """Yield fixes that replace a word that asks for a velocity that the robot can't have.

    A step sideways can become a turn, a step, and a turn back: in one beat, or in three if one would be too fast.
    """
    detour = _SIDEWAYS.get(word.word.text)
    spins = {"forward", "turn"} <= {*profile.motions} and profile.turning_radius is None
    turns = spins and math.isclose(profile.quarter_turn, math.pi / 2)
    if detour and turns and all(map(_keeps_paths, _around(body, word))):
        rate = abs(Fraction(velocity.y)) * 3
        hurries = any(excess(each, profile, tempo) for each in (Velocity(x=rate), Velocity(yaw=rate)))
        text = f"({detour})" if hurries else f"[{detour}]"
        yield from replace(f"Change to {text}{', which takes 3 beats' if hurries else ''}", word.span, text)
    if too_tight(velocity, profile) is not None:
        yield from _wider(body, word, velocity, profile)
    yield from replace("Change to rest", word.span, "rest", guess=True)


def curve(turn: str, profile: Profile) -> str:
    """Return the same turn as this word for a car that drives forward: on the tightest curve of whole steps that its
    profile allows."""
    asked = (
        abs(Fraction(WORDS[turn].velocity.yaw)) * Fraction(profile.quarter_turn) * Fraction(profile.turning_radius or 0)
    )
    steps = max(math.ceil(asked / Fraction(profile.step) - _ROUNDING), 1)
    return f"forward || {turn}" if steps == 1 else f"repeat {steps} forward || slow {steps} {turn}"


_ROUNDING = Fraction(1, 10**9)


def _wider(body: Node, word: Primitive, velocity: Velocity, profile: Profile) -> Iterator[Fix]:
    """Yield half of a turn that is too tight; for a turn on the spot, curves with half of it and all of it."""
    turns = [turn for turn in (f"half{word.word.text}", word.word.text) if turn in WORDS]
    if velocity.x:
        slower = velocity._replace(yaw=Fraction(velocity.yaw) / 2)
        if len(turns) > 1 and too_tight(slower, profile) is None:
            yield from replace(f"Change to {turns[0]}", word.span, turns[0])
    elif all(map(_keeps_paths, _around(body, word))):
        for text in (f"({curve(turn, profile)})" for turn in turns):
            yield from replace(f"Change to {text}", word.span, text)


def _around(body: Node, word: Primitive) -> Iterator[Node]:
    """Yield the nodes around a word of a movement, outermost first."""
    node = body
    while node is not word:
        yield node
        node = next(each for each in nodes.children(node) if each.span.end >= word.span.end)


def _keeps_paths(node: Node) -> bool:
    if isinstance(node, nodes.Apply):
        return WORDS[node.word.text].keeps_path
    return isinstance(node, nodes.Series | nodes.Bracket | nodes.Choice)
