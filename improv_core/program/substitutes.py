"""What a robot can do instead of a motion that it can't make."""

from __future__ import annotations

import math
from collections.abc import Iterator
from fractions import Fraction

from improv_core.diagnostics import Fix, replace
from improv_core.robots.limits import excess
from improv_core.score.movement import Velocity
from improv_core.score.profiles import Profile
from improv_core.syntax import nodes
from improv_core.syntax.nodes import Node, Primitive
from improv_core.syntax.vocabulary import WORDS

_SIDEWAYS = {"strafeleft": "left forward right", "straferight": "right forward left"}


def substitutes(body: Node, word: Primitive, velocity: Velocity, profile: Profile, tempo: Fraction) -> Iterator[Fix]:
    """Fixes that write something else for a word that asks for a velocity that the robot can't have.

    A step sideways can become a turn, a step, and a turn back: in one beat, or in three if one would be too fast.
    """
    detour = _SIDEWAYS.get(word.word.text)
    turns = math.isclose(profile.quarter_turn, math.pi / 2) and {"forward", "turn"} <= {*profile.motions}
    if detour and turns and all(map(_keeps_paths, _around(body, word))):
        rate = abs(Fraction(velocity.y)) * 3
        hurries = any(excess(each, profile, tempo) for each in (Velocity(x=rate), Velocity(yaw=rate)))
        text = f"({detour})" if hurries else f"[{detour}]"
        yield from replace(f"Change to {text}{', which takes 3 beats' if hurries else ''}", word.span, text)
    yield from replace("Change to rest", word.span, "rest")


def _around(body: Node, word: Primitive) -> Iterator[Node]:
    """The nodes around a word of a movement, outermost first."""
    node = body
    while node is not word:
        yield node
        node = next(each for each in nodes.children(node) if each.span.end >= word.span.end)


def _keeps_paths(node: Node) -> bool:
    if isinstance(node, nodes.Apply):
        return WORDS[node.word.text].keeps_path
    return isinstance(node, nodes.Series | nodes.Bracket | nodes.Choice)
