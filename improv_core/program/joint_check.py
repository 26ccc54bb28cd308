"""Check whether joints can do what a program asks of them: find those beyond their limits, or too fast."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import islice

from improv_core.diagnostics import Diagnostic
from improv_core.program.analysis import Analysis
from improv_core.program.compiler import score_of
from improv_core.program.timing import end_after
from improv_core.robots.limits import fitting_by, rush
from improv_core.score.body import Drive
from improv_core.score.joints import JointMoment, Limb, joint_moments, limbs_of
from improv_core.score.movement import Source
from improv_core.score.primitives import PRIMITIVES
from improv_core.score.strokes import pictured
from improv_core.score.walk import Moment
from improv_core.slices import checkpoint
from improv_core.text import Span

MAX_MOMENTS = 10_000
LAST_BEAT = 1_000
"""The most moments, and beats, of a body part that are checked."""
MAX_MARKED = 100
_SLACK = 1e-9


def needs_check(analysis: Analysis) -> bool:
    """Return whether a program has no errors and moves joints."""
    words = analysis.predefined
    return analysis.ok and any(name in analysis.bindings.used for name in words)


def check_joints(analysis: Analysis) -> tuple[Diagnostic, ...]:
    """Return the joints' limits that a program exceeds; none if it has errors.

    As in pictures, senses are never true. Each word is marked once for each joint and code.
    """
    if not needs_check(analysis):
        return ()
    score = pictured(score_of(analysis))
    indices = {statement: index for index, statement in enumerate(analysis.statement_ids)}
    found: dict[tuple[str, str, Span], Diagnostic] = {}
    for part in score.parts.values():
        for limb in limbs_of(part, score.tempo):
            turns, changes = Counter[tuple[Source, ...]](), {drive.joint: _Change() for drive in limb.part.drives}
            moments = islice(joint_moments(part.movement, limb, merge=False), MAX_MOMENTS)
            for each in moments:
                checkpoint()
                if each.moment.start > LAST_BEAT or len(found) >= MAX_MARKED:
                    break
                turns[each.moment.sources] += 1
                wrong = [(each.moment, *one) for one in _wrong(each, limb, turns[each.moment.sources])]
                for moment, code, drive, message in [*wrong, *_sudden(each, limb, changes)]:
                    spans = [
                        source.span.shifted(analysis.offsets[indices[source.statement]]) for source in moment.sources
                    ]
                    span = _cause(spans, drive, analysis.text)
                    found.setdefault((code, drive.joint, span), Diagnostic(code, span, message))
    return tuple(sorted(found.values(), key=lambda each: each.span))


def _cause(spans: Sequence[Span], drive: Drive, text: str) -> Span:
    """Return the first of the words that play at once that moves a joint; if none does, as with a pose, the first."""
    words = ((span, PRIMITIVES.get(text[span.start : span.end].split()[0])) for span in spans)
    return next((span for span, velocity in words if velocity and getattr(velocity, drive.direction)), spans[0])


def _wrong(each: JointMoment, limb: Limb, turn: int) -> Iterator[tuple[str, Drive, str]]:
    """Yield what joints can't do in a moment: codes, the drives of the joints, and messages."""
    if not each.moment.sources:
        return
    end = each.moment.start + each.moment.duration
    seconds = float(each.moment.duration * 60 / limb.tempo)
    for drive in limb.part.drives:
        name, velocity = drive.joint, each.velocities[drive.joint]
        joint = limb.body.joint[name]
        wanted = each.begin[name] + velocity * seconds
        reached = joint.within(wanted)
        if velocity and abs(wanted - reached) > _SLACK:
            in_turn = f", in round {turn}" if turn > 1 else ""
            goes = "slides" if joint.slides else "turns"
            message = f"at {end_after(float(end))}{in_turn}, {name} would be at {joint.shown(wanted)}"
            advice = "go less far"
            yield "joint-limit", drive, f"{message}; it {goes} to {joint.shown(reached)} at most: {advice}"
        if joint.max_velocity is not None and abs(velocity) > joint.max_velocity * (1 + _SLACK):
            limit = f"{joint.shown(joint.max_velocity)}/s"
            fitting = fitting_by(abs(velocity) / joint.max_velocity, limb.tempo).advice()
            message = f"{joint.shown(abs(velocity))}/s is over the limit of {name}, {limit}: {fitting}"
            yield "too-fast", drive, message


@dataclass(slots=True)
class _Change:
    """The latest change of a joint's velocity: both velocities, the moment in which it began, and the seconds since."""

    before: float = 0.0
    after: float = 0.0
    moment: Moment | None = None
    seconds: float = 0.0


def _sudden(each: JointMoment, limb: Limb, changes: Mapping[str, _Change]) -> Iterator[tuple[Moment, str, Drive, str]]:
    """Take a moment, and yield the changes of velocity that it ends before joints could make them."""
    for drive in limb.part.drives:
        joint, last, velocity = limb.body.joint[drive.joint], changes[drive.joint], each.velocities[drive.joint]
        if joint.max_acceleration and velocity != last.after:
            needs = abs(last.after - last.before) / joint.max_acceleration
            over = rush(needs, last.seconds, limb.tempo) if last.moment else None
            if over and last.moment and last.moment.sources:
                to = f"to get from {joint.shown(last.before)}/s to {joint.shown(last.after)}/s"
                message = f"this lasts {over.lasts:.3g} s, but {joint.name} needs {over.needs:.3g} s {to}"
                yield last.moment, "too-sudden", drive, f"{message}: {over.advice()}"
            last.before, last.after, last.moment, last.seconds = last.after, velocity, each.moment, 0.0
        last.seconds += float(each.moment.duration * 60 / limb.tempo)
