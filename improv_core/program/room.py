"""Check whether robots meet or hit something in a dance, mark the words that move them there, and find fixes.

A fix keeps two robots apart: one of them rests first, or their formation is larger. Each is tried out.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Container, Iterator, Mapping
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property, partial
from typing import NamedTuple

from improv_core.diagnostics import Diagnostic, Edit, Fix, Related
from improv_core.program.analysis import Analysis
from improv_core.program.compiler import score_of
from improv_core.program.misuse import conditions
from improv_core.program.numbers import product
from improv_core.program.timing import decimal, end_after, moment
from improv_core.score.approach import Encounters
from improv_core.score.encounters import RoomResults
from improv_core.score.meetings import Hit, Meeting, check_room, would_meet
from improv_core.score.movement import STILL, Source, near
from improv_core.score.obstacles import EDGE, GROUND
from improv_core.score.prediction import Predict, Prediction
from improv_core.score.primitives import rest_text
from improv_core.score.score import Part, Score
from improv_core.score.strokes import pictured
from improv_core.score.walk import walk
from improv_core.slices import checkpoint
from improv_core.syntax.nodes import InFormation
from improv_core.syntax.vocabulary import WORDS
from improv_core.syntax.word import Kind
from improv_core.text import Span

MAX_MARKED = 100
"""The most meetings, and hits, that are marked: people fix a few at a time."""
MAX_FIXED = 150
"""With more robots than this, the search for fixes is skipped, because each fix is tried on the whole program; with
fewer, it covers more meetings."""
MAX_TRIED = 10
"""The most meetings for which fixes are searched."""
MAX_RESTS, MAX_PREDICTED = 16, 3
"""The most beats of `rest` that are tried, and the most with a prediction of their own."""
MAX_SIZES = 15
LARGER = 1.25
"""The number of larger formations that are tried, and the factor from each to the next."""
FREES_IT = "start it farther from what it senses, or give it a larger room"


class RoomReport(NamedTuple):
    """The problems of a program that has no errors, and the last beat that was checked.

    If `is_all`, nothing else comes after that beat. If it `predicts`, simulated robots have been asked what they sense;
    if it `assumes`, other senses may decide otherwise. `known` is for the next check.
    """

    diagnostics: tuple[Diagnostic, ...]
    end: float
    is_all: bool
    predicts: bool
    assumes: bool
    known: RoomResults

    def as_json(self) -> Mapping[str, float | bool]:
        """Return the range of the check as JSON values."""
        return {"beat": self.end, "all": self.is_all, "assumes": self.assumes}

    def __str__(self) -> str:
        """`checked to beat 1,000`"""
        end = "after which everything has ended or repeats" if self.is_all else ""
        sensed = "with what robots sense in the simulator" if self.predicts else ""
        assumed = f"assuming that no {'other ' if self.predicts else ''}sense is ever true" if self.assumes else ""
        return ", ".join(filter(None, (f"checked to {end_after(self.end)}", end, sensed, assumed)))


def check(
    analysis: Analysis, before: RoomResults | None = None, predict: Predict = lambda score: None
) -> RoomReport | None:
    """Check whether the robots of a program meet or hit something. None if it has errors, or just one robot and nothing
    around it.

    `before` is the knowledge of the report on an earlier version: only pairs with a changed robot are checked again.
    Senses are as `predict` says, or else as in pictures without a world. Each fix for robots whose meeting depends on
    senses needs another prediction, so few are tried, only for the first meeting, and only if the dance ends.
    """
    if not needs_check(analysis):
        return None
    score = score_of(analysis)
    prediction = prediction_of(analysis, score, predict)
    found = check_room(prediction.score if prediction else score, before=before)
    drawn = prediction.score if prediction else pictured(score)
    room = _Room(analysis, drawn, _assumed(score, prediction), predict if prediction else None, found.known)
    meetings, hits = found.meetings[:MAX_MARKED], found.hits[:MAX_MARKED]
    most = min(MAX_FIXED // len(score.parts), MAX_TRIED)
    most_predicted = 1 if prediction and prediction.cut is None else 0
    reported = [
        room.meeting(each, number < (most_predicted if room.senses(each) else most))
        for number, each in enumerate(meetings)
    ]
    reported += map(room.hit, hits)
    if hidden := len(found.meetings) + len(found.hits) - len(reported):
        message = f"fix what is marked first: {hidden:,} more problem{_s(hidden)} of this kind aren't marked yet"
        reported.append(Diagnostic("more-hints", reported[-1].span, message))
    reported += room.stuck(score, prediction) if prediction else ()
    return RoomReport(
        tuple(sorted(reported, key=lambda each: each.span)),
        found.end,
        found.is_all and (prediction is None or prediction.cut is None),
        prediction is not None,
        bool(room.assumed),
        found.known,
    )


def prediction_of(analysis: Analysis, score: Score, predict: Predict) -> Prediction | None:
    """Return what simulated robots sense in a program without errors, which has this score. None if neither the program
    nor `improv.toml` places anything, or if they sense nothing."""
    opening = analysis.opening
    placed = bool(opening.places or opening.config.formation or opening.config.world.has_obstacles)
    placed = placed or any(opening.config.robot(robot).start for robot in analysis.all_robots)
    return predict(score) if placed else None


def _assumed(score: Score, prediction: Prediction | None) -> str:
    """Return what has been assumed about senses, in words behind a beat."""
    if prediction:
        return " if no other sense holds" if prediction.assuming else ""
    return " if no sense holds" if score.open else ""


def needs_check(analysis: Analysis) -> bool:
    """Return whether a program has no errors, and two robots, or one that flies or has something around it."""
    if not analysis.ok:
        return False
    robots = len(analysis.all_robots)
    return robots > 1 or (robots == 1 and (analysis.opening.config.world.has_obstacles or _flies(analysis)))


def _flies(analysis: Analysis) -> bool:
    return any(part.bounds.peak.z for line in analysis.played.values() for _, part in line.parts)


@dataclass(frozen=True)
class _Room:
    """The reports about a program. The score is the one for pictures, for which something was `assumed`, or its senses
    were predicted. What is `known` about robots saves tries of fixes."""

    analysis: Analysis
    score: Score
    assumed: str
    predict: Predict | None
    known: RoomResults

    def senses(self, meeting: Meeting) -> bool:
        """Return whether something that was predicted decides about a meeting."""
        parts = self.score.parts
        return self.predict is not None and (
            self.score.scenes > 1 or any(parts[robot].senses for robot in meeting.robots)
        )

    def meeting(self, meeting: Meeting, fixed: bool) -> Diagnostic:
        """Return the diagnostic about a meeting, with fixes if `fixed`."""
        checkpoint()
        one, other = meeting.robots
        needed = sum(self.score.parts[name].profile.radius for name in meeting.robots) + self.score.world.margin
        again = f", and {meeting.more:,} more time{_s(meeting.more)}" if meeting.more else ""
        doubtful = not (self._is_placed(one) and self._is_placed(other))
        if meeting.beat == 0:
            span, elsewhere = self._places(one, other)
            places = [(pose.x, pose.y) for pose in meeting.poses]
            message = (
                f"`{one}` and `{other}` start {decimal(math.dist(*places), 3)} m apart{again}: place them at least "
                f"{decimal(needed)} m apart"
            )
            related = Related(elsewhere, "the other one starts here")
        else:
            words = self._word(one, meeting.beat), self._word(other, meeting.beat)
            span = words[1] or words[0] or self._place(other)
            mine, who = (words[0], one) if words[1] else (None, other if words[0] else one)
            related = Related(mine or self._place(who), f"`{who}` {'does this' if mine else 'stands'} then")
            message = (
                f"`{one}` and `{other}` meet at {moment(meeting.beat)}{self.assumed}, as near as"
                f" {decimal(meeting.distance, 3)} m{again}: keep them {decimal(needed)} m apart"
            )
        found = self._fixes(meeting, self.predict if self.senses(meeting) else None) if fixed else ()
        return Diagnostic("meets", span, message, found, () if related.span == span else (related,), doubtful)

    def hit(self, hit: Hit) -> Diagnostic:
        checkpoint()
        robot, world = hit.robot, self.score.world
        needed = f"{decimal(self.score.parts[robot].profile.radius + world.margin)} m"
        doubtful = not self._is_placed(robot)
        if hit.thing == GROUND:
            message = f"`{robot}` is on the ground at {moment(hit.beat)}{self.assumed}: let it go up first"
            return Diagnostic("hits", self._word(robot, hit.beat) or self._place(robot), message)
        thing = f"the {hit.thing} of the floor" if hit.thing == EDGE else hit.thing
        if hit.beat == 0:
            if hit.thing == EDGE and not world.holds(hit.pose.x, hit.pose.y):
                message = f"`{robot}` starts outside the floor: place it at least {needed} inside"
            else:
                message = f"`{robot}` starts too near to {thing}: place it at least {needed} away"
            return Diagnostic("hits", self._place(robot), message, doubtful=doubtful)
        message = f"`{robot}` hits {thing} at {moment(hit.beat)}{self.assumed}: keep it {needed} away"
        return Diagnostic("hits", self._word(robot, hit.beat) or self._place(robot), message, doubtful=doubtful)

    def stuck(self, score: Score, prediction: Prediction) -> Iterator[Diagnostic]:
        """Yield the diagnostic about each robot that never leaves its place, since a sense keeps it there."""
        for robot, part in score.parts.items():
            senses = {each.sense for each in prediction.held if each.robot == robot}
            if senses and _leaves(part) and not _leaves(prediction.score.parts[robot]):
                sense = self._condition(robot, senses)
                message = f"`{self.analysis.text[slice(*sense)]}` keeps `{robot}` in its place all the time: {FREES_IT}"
                yield Diagnostic("may-stall", sense, message)

    def _condition(self, robot: str, senses: Container[str]) -> Span:
        """Return the first word for one of these senses in a robot's own lines or, if there is none, in the others."""
        analysis = self.analysis
        lines = zip(analysis.statements, analysis.meanings, analysis.offsets, strict=True)
        return min(
            (robot not in meaning.robots, each.sense.span.shifted(offset))
            for statement, meaning, offset in lines
            if statement.has_senses and meaning.body
            for _, each in conditions(meaning.body)
            if each.sense.text in senses
        )[1]

    def _is_placed(self, robot: str) -> bool:
        """Return whether the program or `improv.toml` sets a robot's start."""
        opening = self.analysis.opening
        return robot in opening.places or bool(opening.config.robot(robot).start or opening.config.formation)

    def _places(self, one: str, other: str) -> tuple[Span, Span]:
        """Return the place of the robot that is placed later, and that of the other one."""
        places = [self._place(one), self._place(other)]
        placed = [name in self.analysis.opening.places for name in (one, other)]
        if placed == [True, False] or (all(placed) and places[0] > places[1]):
            places.reverse()
        return places[1], places[0]

    def _place(self, robot: str) -> Span:
        """Return the line that places a robot, or its name in the first line that it plays."""
        analysis = self.analysis
        for index in analysis.openings:
            said = analysis.meanings[index].said
            if said and said.poses and robot in said.robots:
                return analysis.placed(index).span
        first = next(index for index, line in analysis.played.items() if robot in dict(line.parts))
        head = next(head for head in analysis.statements[first].heads if head.text == robot)
        return head.span.shifted(analysis.offsets[first])

    def _word(self, robot: str, beat: float) -> Span | None:
        """Return the first word in a robot's own line that moves it just after a beat; None if it stands then."""
        part = self.score.parts[robot]
        passed = near(beat) - part.begins
        if not 0 <= passed < part.movement.duration:
            return None
        moment = next(walk(part.movement, passed))
        if moment.velocity == STILL or not moment.sources:
            return None
        line = moment.sources[0].statement
        found: dict[Span, bool] = {}
        word = moment.sources[0].span
        for source in moment.sources:
            if source.statement == line:
                word = source.span
            found[word] = found.get(word, False) or self._moves(source)
        moving = [span for span, moves in found.items() if moves] or list(found)
        return min(moving).shifted(self.analysis.offsets[self._indices[line]])

    def _moves(self, source: Source) -> bool:
        """Return whether a source is a word that moves robots by itself."""
        text = self.analysis.statements[self._indices[source.statement]].text[slice(*source.span)]
        word = WORDS.get(text.split()[0])  # without its measure
        return word is not None and word.kind is Kind.PRIMITIVE and word.velocity != STILL

    @cached_property
    def _indices(self) -> Mapping[int, int]:
        return {statement: index for index, statement in enumerate(self.analysis.statement_ids)}

    def _fixes(self, meeting: Meeting, predict: Predict | None) -> tuple[Fix, ...]:
        """Return the fixes that keep two robots apart that meet. If senses decide about them, `predict` says how after
        a fix."""
        return (*self._rests(meeting, predict), *(() if predict else self._distances(meeting.robots)))

    def _rests(self, meeting: Meeting, predict: Predict | None) -> Iterator[Fix]:
        """Have one of the two rest first: the one that needs fewer beats, or if both need the same, the one named
        later."""
        scene, _ = self.score.scene_at(near(meeting.beat))
        pair = Encounters() if predict else self.known.pairs.get(meeting.robots, Encounters())
        while pair.rests <= (MAX_PREDICTED if predict else MAX_RESTS):
            for robot in reversed(meeting.robots):
                fix = _rest(self.analysis, robot, scene, pair.rests)
                if fix and self._clears(meeting.robots, fix.edits[0], predict):
                    yield fix
                    return
            pair.rests += 1

    def _distances(self, pair: tuple[str, str]) -> Iterator[Fix]:
        """Enlarge the formation in which both stand a little."""
        analysis = self.analysis
        for index in analysis.openings:
            said, node = analysis.meanings[index].said, analysis.statements[index].opening
            if said and isinstance(node, InFormation) and said.poses and set(pair) <= set(said.robots):
                span = node.size.span.shifted(analysis.offsets[index])
                size = product(node.size.tokens, {})
                assert isinstance(size, Fraction)
                tenths = _least(math.ceil(size * 10), partial(self._clears_sized, pair, span))
                if tenths:
                    edit = _sized(span, tenths)
                    yield Fix(f"Change to {node.shape.text} {edit.text}", (edit,))

    def _clears_sized(self, pair: tuple[str, str], span: Span, tenths: int) -> bool:
        return self._clears(pair, _sized(span, tenths))

    def _clears(self, pair: tuple[str, str], edit: Edit, predict: Predict | None = None) -> bool:
        """Return whether two robots don't meet any more after an edit, which must leave all robots at their places."""
        edited = self.analysis.edited(*edit.span, edit.text)
        if not edited.ok:
            return False
        before, after = score_of(self.analysis).parts, score_of(edited)
        moved = [name for name, part in after.parts.items() if part.start != before[name].start]
        if moved and edit.span.start == edit.span.end:
            return False
        prediction = predict and prediction_of(edited, after, predict)
        return not would_meet(prediction.score if prediction else after, pair, self.known)


def _leaves(part: Part) -> bool:
    """Return whether a part ever moves a robot from its place."""
    return any(any(scene.bounds.peak[:3]) for scene in part.scenes)


def _s(count: int) -> str:
    return "" if count == 1 else "s"


def _rest(analysis: Analysis, robot: str, scene: int, beats: int) -> Fix | None:
    """Return the fix that has a robot rest before its movements in a scene; None if it plays nothing there."""
    lines = (index for index, line in analysis.played.items() if line.scene == scene and robot in dict(line.parts))
    first = next(lines, None)
    body = None if first is None else analysis.statements[first].body
    if first is None or body is None:
        return None
    statement, start = analysis.statements[first], analysis.offsets[first]
    rest = rest_text(Fraction(beats))
    if len(statement.heads) == 1 and not statement.has_voices:
        edit = Edit(Span(start + body.span.start, start + body.span.start), f"{rest} ")
    else:
        edit = Edit(Span(start, start), f"{robot} $ {rest}\n")
    return Fix(f"Start {robot} {beats} beat{'' if beats == 1 else 's'} later", (edit,))


def _sized(span: Span, tenths: int) -> Edit:
    return Edit(span, f"{tenths / 10:g}")


def _least(too_small: int, is_enough: Callable[[int], bool]) -> int | None:
    """Return a number that is enough although a little less is not, if one is found among the larger ones."""
    for _ in range(MAX_SIZES):
        larger = math.ceil(too_small * LARGER)
        if is_enough(larger):
            while larger - too_small > 1:
                middle = (larger + too_small) // 2
                larger, too_small = (middle, too_small) if is_enough(middle) else (larger, middle)
            return larger
        too_small = larger
    return None
