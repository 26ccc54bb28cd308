"""Check whether robots have the body parts, directions, and poses that a statement uses. Spans count from its start."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from fractions import Fraction
from functools import partial

from improv_core.diagnostics import Diagnostic, Edit, Fix, unknown
from improv_core.plain import printable
from improv_core.program.meaning import Meaning, movement_of
from improv_core.program.misuse import MovementOf
from improv_core.robots.bodies import DIRECTIONS
from improv_core.robots.config import Robots
from improv_core.score.algebra import FromStatement, Parallel
from improv_core.score.body import START, Body, BodyPart
from improv_core.score.bounds import swaps_sides
from improv_core.score.joints import Limb
from improv_core.score.measured import units_in
from improv_core.score.movement import DIRECTIONS as COMPONENTS
from improv_core.score.movement import Asked, Movement
from improv_core.score.profiles import MOTIONS, PUPPET, Profile
from improv_core.score.projection import Reach, project
from improv_core.score.traversal import outer_first
from improv_core.slices import checkpoint
from improv_core.syntax import nodes
from improv_core.syntax.nodes import Node, Statement
from improv_core.syntax.slips import closest
from improv_core.text import Span

_OF_CIRCLES = ("turning", "arcs")
MAX_NAMED = 3
"""The most robots that a message names."""
_OPPOSITES = {"x": "backward", "y": "straferight", "z": "down", "yaw": "right"}
_WORDS = {component: (word, _OPPOSITES[component]) for word, component in DIRECTIONS.items()}


def check_pose_names(body: Node, robots: Robots) -> Iterator[Diagnostic]:
    """Report the poses in a statement that no body part has."""
    known = sorted({name for each in robots.profiles.values() if each.body for name in each.body.pose_names} | {START})
    for node in nodes.nodes(body):
        if isinstance(node, nodes.PoseTerm) and node.pose.text not in known:
            otherwise = "declare it in the poses of a body part in improv.toml"
            message, near = f"`{node.pose.text}` is not a pose", closest(node.pose.text, known)
            yield unknown("no-such-pose", node.pose.span, message, near, otherwise)


def check_bodies(statement: Statement, meaning: Meaning, robots: Robots) -> Iterator[Diagnostic]:
    """Report what the bodies of a line's robots lack, and poses that other voices disturb."""
    kinds: dict[Profile, list[str]] = {}
    for robot, part in meaning.parts:
        if part.body_words.asked:
            kinds.setdefault(robots.profile_of(robot), []).append(robot)
    if not meaning.body or not kinds:
        return
    asked = meaning.movement.body_words.asked
    poses = frozenset(name for each in robots.profiles.values() if each.body for name in each.body.pose_names)
    scope = dict(zip(statement.uses, meaning.scope, strict=True))
    movement = partial(movement_of, scope=scope, robots=len(meaning.robots))
    without: dict[str, list[str]] = {}
    found: dict[tuple[str, Span, str], Diagnostic] = {}
    for profile, names in kinds.items():
        body = profile.body or Body()
        for word in sorted({each.part for each in asked if each.part and each.part not in body.words}):
            without.setdefault(word, []).extend(names)
        for each in sorted(asked):
            for name in body.performers(each.part, each.mirrored):
                one = body.part[name]
                if each.direction and not one.drive(each.direction):
                    forward, backward = _WORDS[each.direction]
                    message = f"`{name}` has no direction `{forward}`, so `{forward}` and `{backward}` do nothing: use"
                    message += f" another, or declare it in the profile {profile.name}"
                    code = "part-direction"
                elif each.pose in poses and not one.has_pose(each.pose):
                    message = (
                        f"`{name}` has no pose `{each.pose}`, so it rests: declare it in the profile {profile.name}"
                    )
                    code = "no-such-pose"
                else:
                    continue
                for span in _asking(meaning.body, each, movement):
                    warns = code == "no-such-pose"
                    found.setdefault((code, span, message), Diagnostic(code, span, message, warns=warns))
        if meaning.movement.body_words.has_poses:
            for one in body.parts:
                for span, message in _disturbed(meaning.movement, one, body):
                    found.setdefault(("pose-disturbed", span, ""), Diagnostic("pose-disturbed", span, message))
    for word, names in without.items():
        words = [each for each in asked if each == Asked(word, each.mirrored)]
        for span in {span for each in words for span in _asking(meaning.body, each, movement)}:
            yield _lacking(word, names, span, robots)
    yield from found.values()


def _lacking(word: str, names: Sequence[str], span: Span, robots: Robots) -> Diagnostic:
    shown = ", ".join(f"`{printable(each)}`" for each in names[:MAX_NAMED])
    more = f" and {len(names) - MAX_NAMED} more" if len(names) > MAX_NAMED else ""
    verb = "has" if len(names) == 1 else "have"
    assert PUPPET.body
    is_puppets = word in PUPPET.body.words and robots.profiles.get(PUPPET.name) == PUPPET
    kindless = [each for each in names if not robots.robot(each).has_profile]
    advice, fixes = "give a profile with it in improv.toml", tuple[Fix, ...]()
    if is_puppets and kindless:
        line = f"{' '.join(kindless)} is puppet"
        advice = f"add `{line}`, or {advice}"
        fixes = (Fix(f"Add {line}", (Edit(Span(0, 0), f"{line}\n"),)),)
    return Diagnostic("no-such-part", span, f"{shown}{more} {verb} no `{word}`, so this rests: {advice}", fixes)


def _asking(node: Node, asked: Asked, movement: MovementOf, inside: bool = False) -> Iterator[Span]:
    """Yield each word or name that asks this. `inside` is true in the term of the word for the body part."""
    checkpoint()
    if isinstance(node, nodes.Primitive | nodes.MeasuredWord):
        if inside and _asks(movement(node), asked):
            yield node.span
    elif isinstance(node, nodes.PoseTerm):
        if inside and asked.pose == node.pose.text:
            yield node.pose.span
    elif isinstance(node, nodes.PartTerm):
        performs = node.name.text == asked.part and not asked.mirrored
        if performs and asked == Asked(asked.part):
            yield node.name.span
        yield from _asking(node.body, asked, movement, performs)
    elif isinstance(node, (nodes.Name, nodes.Call)):
        made = movement(node)
        if asked in made.body_words.asked or (inside and _asks(made, asked)):
            arguments = node.movements if isinstance(node, nodes.Call) else ()
            found = [span for each in arguments for span in _asking(each, asked, movement, inside)]
            yield from found or [nodes.use_name(node).span]
    elif isinstance(node, nodes.Apply) and node.plane and swaps_sides(node.plane.gain) and not inside:
        yield from _asking(node.body, asked._replace(mirrored=not asked.mirrored), movement)
    else:
        for child in nodes.children(node):
            yield from _asking(child, asked, movement, inside)


def _asks(made: Movement, asked: Asked) -> bool:
    """Return whether a movement asks this of whichever body part performs it."""
    if asked.pose:
        return asked.pose in made.body_words.loose_poses
    bound = getattr(made.bounds.peak, asked.direction) if asked.direction else 0
    return asked.unit in units_in(bound) if asked.unit else bool(bound)


def check_units(statement: Statement, meaning: Meaning, robots: Robots) -> Iterator[Diagnostic]:
    """Report measures with units that the directions of the robots, or of their joints, don't take."""
    if not meaning.body:
        return
    profiles = {robots.robot(robot).profile for robot in meaning.robots}
    scope = dict(zip(statement.uses, meaning.scope, strict=True))
    movement = partial(movement_of, scope=scope, robots=len(meaning.robots))
    found = dict[Span, Diagnostic]()
    for asked, takes in sorted(_wrong_units(meaning.movement, profiles).items()):
        for span in _asking(meaning.body, asked, movement, not asked.part):
            word, _, _ = statement.text[slice(*span)].partition(" ")
            found.setdefault(span, _wrong_unit(asked, takes, span, word))
    yield from found.values()


def _wrong_units(movement: Movement, profiles: Iterable[Profile]) -> dict[Asked, str]:
    """Return what a movement measures in other units than the robots' directions take, and the units that these
    take."""
    base = [
        (direction, Asked("", False, direction, unit=unit))
        for direction in COMPONENTS
        for unit in units_in(getattr(movement.bounds.peak, direction))
    ]
    of_parts = [each for each in movement.body_words.asked if each.unit]
    found = dict[Asked, str]()
    for profile in profiles:
        can_make = dict(zip(("x", "yaw", "y", "z"), (each in profile.motions for each in MOTIONS), strict=True))
        for direction, asked in base:
            takes = "degrees" if direction == "yaw" else "meters"
            if can_make[direction] and (asked.unit == "degrees") != (takes == "degrees"):
                found[asked] = takes
        body = profile.body or Body()
        for asked in of_parts:
            for name in body.performers(asked.part, asked.mirrored):
                drive = body.part[name].drive(asked.direction)
                takes = "meters" if drive and body.joint[drive.joint].slides else "degrees"
                if asked.unit in _OF_CIRCLES or (drive and asked.unit != takes):
                    found[asked] = takes
    return found


def _wrong_unit(asked: Asked, takes: str, span: Span, word: str) -> Diagnostic:
    where = f"under `{asked.part}`, " if asked.part else ""
    if asked.unit in _OF_CIRCLES and asked.part:
        message = f"{where}nothing drives along a circle: write the turn without `radius`"
        return Diagnostic("wrong-measure", span, message)
    forward, backward = _WORDS[asked.direction]
    direction = word if word in (forward, backward) else forward
    example = f"{direction} {'90deg' if takes == 'degrees' else '1m'}"
    what = "an angle" if takes == "degrees" else "a length"
    other = "" if direction == word else f", and `{word}` gives it {'a length' if takes == 'degrees' else 'an angle'}"
    return Diagnostic("wrong-measure", span, f"{where}`{direction}` takes {what}, such as `{example}`{other}")


def _disturbed(whole: Movement, part: BodyPart, body: Body) -> Iterator[tuple[Span, str]]:
    """Yield each pose of a body part whose joints another voice moves too, as its span in the line and advice."""
    performed = project(whole, part.name, body, Limb(part, body, Fraction(60)))
    for movement, use in _within(performed, None):
        if not isinstance(movement, Parallel):
            continue
        poses = [
            [(each, span or each.span) for each, span in _within(voice, use) if isinstance(each, Reach)]
            for voice in movement.items
        ]
        moved = [
            {direction for pose, _ in own for direction in pose.moved}
            | {each for each in COMPONENTS if getattr(voice.bounds.peak, each)}
            for voice, own in zip(movement.items, poses, strict=True)
        ]
        for place, own in enumerate(poses):
            others = set[str]().union(*moved[:place], *moved[place + 1 :])
            for pose, span in own:
                joints = sorted(each.joint for each in part.drives if each.direction in others.intersection(pose.moved))
                if joints and span:
                    yield span, f"another voice moves `{joints[0]}` too, so it ends elsewhere: play one after the other"
                    break


def _within(movement: Movement, use: Span | None) -> Iterator[tuple[Movement, Span | None]]:
    """Yield a movement and all inside it, each with the `use` of a name, in the line, by which it plays."""

    def inside(at: tuple[Movement, Span | None]) -> list[tuple[Movement, Span | None]]:
        checkpoint()
        whole, use = at
        own = whole.span if isinstance(whole, FromStatement) else None
        return [(each, use or own) for each in whole.parts]

    return outer_first((movement, use), inside, lambda at: (id(at[0]), at[1]))
