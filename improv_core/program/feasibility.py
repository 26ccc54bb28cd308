"""Check whether the robots of a program, as `improv.toml` describes them, can do what they play, and find movements
that they can make instead."""

from __future__ import annotations

import math
from collections.abc import Collection, Iterator, Mapping
from fractions import Fraction
from functools import lru_cache
from itertools import groupby, islice

from improv_core.diagnostics import Diagnostic, Edit, Fix, replace, unknown
from improv_core.program.meaning import Meaning
from improv_core.robots.config import Robots
from improv_core.robots.limits import Excess, Rush, excess, rush, too_tight, unsupported
from improv_core.score.algebra import Gain
from improv_core.score.measured import in_si, largest
from improv_core.score.motion import STILL
from improv_core.score.movement import Movement, Peak, Velocity
from improv_core.score.profiles import Profile
from improv_core.score.projection import base_of
from improv_core.score.ramps import FASTEST_EASE
from improv_core.score.score import in_axes, twist
from improv_core.score.smoothing import smoothed
from improv_core.score.suppositions import with_all_sides
from improv_core.score.traversal import inner_first
from improv_core.score.walk import Moment, walk
from improv_core.slices import checkpoint
from improv_core.syntax import nodes
from improv_core.syntax.nodes import Node, Primitive, Statement
from improv_core.syntax.slips import closest, is_between
from improv_core.syntax.vocabulary import WORDS
from improv_core.text import Span

MAX_MOMENTS = 1_000
"""The most moments of a movement that are searched for the item that asks too much."""
_FIRST_MOMENTS = 200
"""The moments of a movement that are searched for one that drives too far backward."""
_ROOM_SLACK = 1e-9
"""Meters."""
FOR_CHANGES = 4
"""The factor by which the change of velocity in an item may exceed its highest velocity: `ease` gets to it, and back
from it, in a quarter of the time each. To reverse takes 2."""
_EVERYBODY = frozenset({"all", "both", "everybody", "everyone"})
SLACK = 1 + 1e-9
"""Bounds are floats. Values that rounding could push over a limit are checked exactly."""


def check_casting(statement: Statement, meaning: Meaning, robots: Robots, tempo: Fraction) -> tuple[Diagnostic, ...]:
    """Return what the robots of a statement can't do at `tempo` beats per minute. Spans count from its start."""
    found = check_names(statement, meaning.robots, robots)
    wrong = {span for _, span in found}
    parts = dict(meaning.parts)
    for head in statement.heads:
        if head.text not in parts or (wrong and head.span in wrong):
            continue
        profile = robots.profile_of(head.text)
        if _may_be_too_much(parts[head.text].bounds.peak, profile, tempo):
            for diagnostic in _too_much(head.text, meaning.body, parts[head.text], profile, tempo):
                found.setdefault((diagnostic.code, diagnostic.span), diagnostic)
        for diagnostic in _too_far_back(head.text, parts[head.text], profile):
            found.setdefault((diagnostic.code, diagnostic.span), diagnostic)
    return tuple(found.values())


def check_names(statement: Statement, named: Collection[str], robots: Robots) -> dict[tuple[str, Span], Diagnostic]:
    """Return diagnostics, by code and span, of the names before the sign that are no robots of `improv.toml`.

    Names that aren't in `named` are skipped: they are invalid anyway.
    """
    found: dict[tuple[str, Span], Diagnostic] = {}
    for head in statement.heads:
        if head.text not in named:
            continue
        if is_between(statement.heads, head) and head.text not in robots.robots:
            code = "unknown-robot" if robots.robots else "robot-named-and"
            fixes = replace("Remove and", Span(head.start, head.end + 1), "")
            message = "this makes a robot called `and`: separate robots with spaces only"
            found[code, head.span] = Diagnostic(code, head.span, message, fixes)
            continue
        if head.text in _EVERYBODY and not robots.robots:
            message = f"this makes a robot called `{head.text}`: list the names of all robots instead"
            found["robot-named-and", head.span] = Diagnostic("robot-named-and", head.span, message)
        if robots.robots and head.text not in robots.robots:
            found["unknown-robot", head.span] = _unknown(head.text, head.span, robots)
    return found


def impossible(part: Movement, profile: Profile) -> str | None:
    """Return a motion that a robot with this profile can't make, such as `move sideways`; None if it can make all."""
    if not _may_be_impossible(part.bounds.peak, profile):
        return None
    for moment in islice(walk(with_all_sides(part)), MAX_MOMENTS):
        if lacking := _lacking(moment.velocity, profile):
            return lacking
    return None


def _may_be_impossible(peak: Peak, profile: Profile) -> bool:
    """Check the bounds quickly."""
    return bool(unsupported(peak, profile)) or bool(profile.turning_radius and peak.yaw)


def _lacking(velocity: Velocity, profile: Profile) -> str | None:
    """Return a motion in a velocity that this profile can't make, such as `move sideways`; None if there is none."""
    if motions := unsupported(velocity, profile):
        return _DOING[motions[0]]
    radius = too_tight(velocity, profile)
    if radius is None:
        return None
    return f"drive a curve with a radius of {radius:.2g} m" if radius else "turn on the spot"


def _unknown(name: str, span: Span, robots: Robots) -> Diagnostic:
    if role := robots.role_of(name):
        message = f"`{name}` is not in improv.toml, and its namespace is that of `{role}`: write `{role}` here"
        return Diagnostic("unknown-robot", span, message, replace(f"Change to {role}", span, role))
    near, otherwise = closest(name, robots.robots), f"add `[robots.{name}]` to improv.toml"
    return unknown("unknown-robot", span, f"`{name}` is not in improv.toml", near, otherwise)


@lru_cache(maxsize=1_000)  # most lines share their bounds with others
def _may_be_too_much(peak: Peak, profile: Profile, tempo: Fraction) -> bool:
    """Check the bounds quickly: most statements are far from every limit."""
    per_second = float(tempo) / 60
    faster = float(FASTEST_EASE) if profile.smooth else 1.0
    x, y, z, yaw = in_axes(peak[:4], profile)
    linear = (x + y + z) * profile.linear_scale * per_second * faster
    angular = yaw * profile.angular_scale * per_second * faster
    return (
        (profile.max_linear is not None and linear * SLACK > profile.max_linear)
        or (profile.max_angular is not None and angular * SLACK > profile.max_angular)
        or peak.shortest / per_second < SLACK / profile.command_rate
        or linear * FOR_CHANGES > (profile.max_linear_acceleration or math.inf) * peak.shortest / per_second
        or angular * FOR_CHANGES > (profile.max_angular_acceleration or math.inf) * peak.shortest / per_second
        or _may_be_impossible(peak, profile)
    )


def _too_much(robot: str, body: Node | None, part: Movement, profile: Profile, tempo: Fraction) -> Iterator[Diagnostic]:
    reported: set[str] = set()  # report only the first item of each kind, and of those that are too fast the fastest
    fastest: tuple[Excess, Moment] | None = None
    known: set[Velocity] = set()
    for moment in islice(walk(with_all_sides(base_of(part))), MAX_MOMENTS):
        if not moment.sources:
            continue  # a robot that waits in a canon
        checkpoint()
        for diagnostic in _about(moment, robot, body, profile, tempo, reported):
            if diagnostic.code not in reported:
                reported.add(diagnostic.code)
                yield diagnostic
        if moment.velocity in known:
            continue
        known.add(moment.velocity)
        over = excess(moment.velocity, profile, tempo)
        if over and (fastest is None or over.factor > fastest[0].factor):
            fastest = over, moment
    if part.body_words.asked and "too-short" not in reported:  # a word under a body part may be too short
        short = (_too_short(moment, robot, profile, tempo) for moment in islice(walk(part), MAX_MOMENTS))
        yield from islice(filter(None, short), 1)
    if fastest:
        over, moment = fastest
        message = f"{over.speed:.3g} {over.unit} is over {robot}'s limit of {over.limit:g} {over.unit}: {over.advice()}"
        span = moment.sources[0].span
        yield _too_much_at("too-fast", span, message, over.slow, body)
        return
    if profile.smooth:
        yield from _too_fast_to_smooth(robot, body, part, profile, tempo)
    if profile.max_linear_acceleration or profile.max_angular_acceleration:
        yield from _too_sudden(robot, body, part, profile, tempo)


def _too_sudden(
    robot: str, body: Node | None, part: Movement, profile: Profile, tempo: Fraction
) -> Iterator[Diagnostic]:
    """Report the velocity that a robot has the least time to reach: the next one follows before its accelerations allow
    it. Such a robot leaves its path; others only lag."""
    performed = base_of(part)
    if profile.smooth:
        performed = smoothed(performed, lambda velocity: excess(velocity, profile, tempo) is None)
    before, worst = STILL, list[tuple[Rush, Moment]]()
    for velocity, together in groupby(islice(walk(performed), MAX_MOMENTS), lambda moment: moment.velocity):
        checkpoint()
        moments, after = [*together], twist(velocity, profile, tempo)
        lasts = float(sum(moment.duration for moment in moments) * 60 / tempo)
        found = rush(profile.seconds_between(before, after), lasts, tempo)
        if found and moments[0].sources and (not worst or found.shortage > worst[0][0].shortage):
            worst = [(found, moments[0])]
        before = after
    for over, moment in worst:
        message = f"this lasts {over.lasts:.3g} s, but {robot} needs {over.needs:.3g} s to get to that velocity"
        span = moment.sources[0].span
        yield _too_much_at("too-sudden", span, f"{message}: {over.advice()}", over.slow, body)


def _too_fast_to_smooth(
    robot: str, body: Node | None, part: Movement, profile: Profile, tempo: Fraction
) -> Iterator[Diagnostic]:
    """Report the first stretch that plays without smoothing because its highest speed would be over a limit."""
    moments = islice(walk(with_all_sides(smoothed(part))), MAX_MOMENTS)
    for sources, together in groupby(moments, lambda moment: moment.sources):
        found = [over for moment in together if (over := excess(moment.velocity, profile, tempo))]
        if found and sources:
            over = max(found, key=lambda over: over.factor)
            reached = f"smoothed, this would reach {over.speed:.3g} {over.unit}"
            message = (
                f"{reached}, over {robot}'s limit of {over.limit:g} {over.unit}, so it is not smoothed: {over.advice()}"
            )
            span = sources[0].span
            yield _too_much_at("too-fast", span, message, over.slow, body)
            return


def _about(
    moment: Moment,
    robot: str,
    body: Node | None,
    profile: Profile,
    tempo: Fraction,
    reported: Collection[str],
) -> Iterator[Diagnostic]:
    span = moment.sources[0].span  # the word in this statement; the other sources are in definitions
    lacking = None if "unsupported-direction" in reported else _lacking(moment.velocity, profile)
    if lacking:
        word = _word_that_asks(moment, body, profile) if body else None
        fixes = tuple(substitutes(body, word, moment.velocity, profile, tempo)) if body and word else ()
        if unsupported(moment.velocity, profile):
            like = "quadrotor" if moment.velocity.z else "holonomic"
            advice = f"use another motion, or a profile other than {profile.name}, such as {like}"
        else:
            advice = f"it needs a radius of {profile.turning_radius:g} m, as in `{curve('left', profile)}`"
        message = f"`{robot}` can't {lacking}: {advice}"
        yield Diagnostic("unsupported-direction", word.span if word else span, message, fixes)
    if short := _too_short(moment, robot, profile, tempo):
        yield short


def _too_short(moment: Moment, robot: str, profile: Profile, tempo: Fraction) -> Diagnostic | None:
    lasts, period = float(moment.duration * 60 / tempo), 1 / profile.command_rate
    if lasts * SLACK >= period or not moment.sources:
        return None
    message = f"this lasts {lasts:.3g} s, but {robot} takes a command every {period:g} s: make it longer"
    return Diagnostic("too-short", moment.sources[0].span, message)


def _too_far_back(robot: str, part: Movement, profile: Profile) -> Iterator[Diagnostic]:
    """Report the first movement in which a base has driven backward so far that it stops by itself. Driving forward
    gives the distance back (create3_sim, motion_control_node)."""
    limit = profile.backward_limit
    if limit is None or not part.bounds.peak.x or not _may_go_back(part):
        return
    room = limit
    for moment in islice(walk(with_all_sides(base_of(part))), _FIRST_MOMENTS):
        ahead, *_ = in_axes(moment.velocity, profile)
        room = min(room + ahead * float(moment.duration), limit)
        if room < -_ROOM_SLACK and moment.sources:
            what = f"`{robot}` stops by itself once it has driven {limit:g} m backward"
            yield Diagnostic("too-far-back", moment.sources[0].span, f"{what}: turn it around, or lift that limit")
            return


def _may_go_back(part: Movement) -> bool:
    """Check quickly: each movement is visited once, no matter how often it repeats."""
    return any(
        largest(-each.uniform.x) > 0 if each.uniform else isinstance(each, Gain) and each.gain.x < 0
        for each in inner_first(part, lambda each: () if each.uniform else each.parts)
    )


def _word_that_asks(moment: Moment, body: Node, profile: Profile) -> nodes.Primitive | None:
    """Return the word in this statement, of those that play at a moment, whose motion a robot can't make."""
    spans = {source.span for source in moment.sources if source.statement == moment.sources[0].statement}
    words = (node for node in nodes.nodes(body) if isinstance(node, nodes.Primitive) and node.span in spans)
    if unsupported(moment.velocity, profile):
        return next((node for node in words if unsupported(node.word.velocity, profile)), None)
    return next((node for node in words if node.word.velocity.yaw), None)


def _too_much_at(code: str, span: Span, message: str, slow: int, body: Node | None) -> Diagnostic:
    whole = body.span if body else span
    wrapped = (Edit(Span(whole.start, whole.start), f"slow {slow} ("), Edit(Span(whole.end, whole.end), ")"))
    return Diagnostic(code, span, message, (Fix(f"Wrap in slow {slow}", wrapped),))


_DOING: Mapping[str, str] = {
    "forward": "move forward or backward",
    "turn": "turn",
    "strafe": "move sideways",
    "climb": "move up or down",
}


_SIDEWAYS = {"strafeleft": "left forward right", "straferight": "right forward left"}


def substitutes(body: Node, word: Primitive, velocity: Velocity, profile: Profile, tempo: Fraction) -> Iterator[Fix]:
    """Yield fixes that replace a word that asks for a velocity that the robot can't have.

    A step sideways can become a turn, a step, and a turn back: in one beat, or in three if one would be too fast.
    """
    detour = _SIDEWAYS.get(word.word.text)
    spins = {"forward", "turn"} <= {*profile.motions} and profile.turning_radius is None
    turns = spins and math.isclose(profile.quarter_turn, math.pi / 2)
    if detour and turns and all(map(_keeps_paths, _around(body, word))):
        rate = velocity.y * 3
        hurries = any(excess(each, profile, tempo) for each in (Velocity(x=rate), Velocity(yaw=rate)))
        text = f"({detour})" if hurries else f"[{detour}]"
        yield from replace(f"Change to {text}{', which takes 3 beats' if hurries else ''}", word.span, text)
    if too_tight(velocity, profile) is not None:
        yield from _wider(body, word, velocity, profile)
    yield from replace("Change to rest", word.span, "rest", guess=True)


def curve(turn: str, profile: Profile) -> str:
    """Return the same turn as this word for a car that drives forward: on the tightest curve of whole steps that its
    profile allows."""
    quarter = Fraction(profile.quarter_turn)
    asked = abs(in_si(WORDS[turn].velocity.yaw, quarter, quarter, quarter / 90)) * Fraction(profile.turning_radius or 0)
    steps = max(math.ceil(asked / Fraction(profile.step) - _ROUNDING), 1)
    return f"forward || {turn}" if steps == 1 else f"repeat {steps} forward || slow {steps} {turn}"


_ROUNDING = Fraction(1, 10**9)


def _wider(body: Node, word: Primitive, velocity: Velocity, profile: Profile) -> Iterator[Fix]:
    """Yield half of a turn that is too tight; for a turn on the spot, curves with half of it and all of it."""
    turns = [turn for turn in (f"half{word.word.text}", word.word.text) if turn in WORDS]
    if velocity.x:
        slower = velocity._replace(yaw=velocity.yaw * Fraction(1, 2))
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
        return WORDS[node.word.text].poses and not node.across
    return isinstance(node, nodes.Series | nodes.Bracket | nodes.Choice)
