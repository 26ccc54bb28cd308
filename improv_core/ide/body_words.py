"""Describe words for body parts, and poses: the operands of the words, the joints that move, and their ranges."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from fractions import Fraction
from itertools import islice

from improv_core.ide.completion_item import Item
from improv_core.ide.references import performers
from improv_core.plain import printable
from improv_core.program.analysis import Analysis
from improv_core.program.definitions import TO, Takes
from improv_core.program.program import Placed
from improv_core.robots.bodies import DIRECTIONS
from improv_core.score.body import START, Body
from improv_core.score.joints import Limb, joint_moments
from improv_core.score.movement import Movement
from improv_core.score.projection import goal_of

MAX_MOMENTS = 500
"""The most moments of a movement that are followed to find the ranges of joints."""
_WORDS = {component: word for word, component in DIRECTIONS.items()}


def takes(analysis: Analysis, name: str, statement: int) -> Takes | None:
    """Return the operand of a name in a statement, if it is a word for a body part, or `to`, and nothing hides it."""
    word = analysis.predefined.get(name)
    own = analysis.statements[statement].parameters if statement < len(analysis.statements) else ()
    is_hidden = analysis.bindings.definer(name, statement) is not None or name in (each.name for each in own)
    return None if word is None or is_hidden else word.takes


def offered(bodies: Sequence[Body], hidden: Sequence[str]) -> Iterator[Item]:
    """Yield the words that robots with these bodies know, except the `hidden` ones."""
    words = {word: named for body in bodies for word, named in body.words.items()}
    for word, named in words.items():
        if word not in hidden:
            about = "body part" if tuple(named) == (word,) else f"body parts: {', '.join(named)}"
            yield Item(word, "keyword", about, f"{word} ($0)")
    if words and TO not in hidden:
        yield Item(TO, "keyword", "brings a body part to a pose, in one beat")


def poses_offered(bodies: Sequence[Body]) -> Iterator[Item]:
    """Yield the poses that robots with these bodies know."""
    known = {START: "all its joints at their starts"}
    for body in bodies:
        for part in body.parts:
            for pose in part.poses:
                known.setdefault(pose.name, f"a pose of {part.name}")
    return (Item(name, "plane", about) for name, about in known.items())


def about_part(analysis: Analysis, placed: Placed, word: str) -> tuple[str, ...]:
    """Describe the joints of a body part, by the profiles of the robots that perform a statement."""
    found = []
    for profile in performers(analysis, placed.index):
        body = profile.body or Body()
        for name in body.words.get(word, ()):
            joints = ", ".join(f"{_WORDS[each.direction]} moves {each.joint}" for each in body.part[name].drives)
            found.append(printable(f"{name} of {profile.name}: {joints}"))
    return tuple(found)


def about_pose(analysis: Analysis, placed: Placed, pose: str) -> tuple[str, ...]:
    """Describe the positions of each body part's joints in a pose."""
    found = []
    for profile in performers(analysis, placed.index):
        body = profile.body or Body()
        for part in body.parts:
            if part.has_pose(pose) and pose != START:
                goal = dict(goal_of(part.name, pose, body))
                positions = [
                    f"{each.joint} at {body.joint[each.joint].shown(goal[each.direction] * each.per_step)}"
                    for each in part.drives
                    if each.direction in goal
                ]
                found.append(printable(f"{part.name} of {profile.name}: {', '.join(positions)}"))
    return tuple(found)


def moved_by(analysis: Analysis, placed: Placed, meaning: Movement) -> tuple[str, ...]:
    """Describe how far a movement turns each joint from its start: `head_yaw between 0° and 30°, ends at 0°`."""
    found = []
    for profile in performers(analysis, placed.index) if meaning.body_words.asked and not meaning.open else ():
        body = profile.body or Body()
        for name in body.moved_by(meaning.body_words.asked):
            limb = Limb(body.part[name], body, Fraction(60))
            ends = {joint: [position] for joint, position in limb.positions.items()}
            moments = list(islice(joint_moments(meaning, limb), MAX_MOMENTS + 1))
            if len(moments) > MAX_MOMENTS:
                continue
            for each in moments:
                for joint, position in each.begin.items():
                    ends[joint].append(position)
            for joint, position in limb.positions.items():
                least, most = min(*ends[joint], position), max(*ends[joint], position)
                if most > least:
                    low, high, last = (body.joint[joint].shown(each) for each in (least, most, position))
                    found.append(printable(f"{joint} between {low} and {high}, ends at {last}"))
    return tuple(dict.fromkeys(found))
