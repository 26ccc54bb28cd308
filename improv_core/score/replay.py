"""Computes what robots play of a score from what they have sensed. Standard library only.

Everything that shows what plays uses this: editors, the page, and the topics in ROS 2 that others watch. It never reads
a clock; callers pass in the beat.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Iterator, Sequence
from copy import copy
from itertools import chain, islice, takewhile
from typing import NamedTuple

from improv_core.score.algebra import FromStatement
from improv_core.score.budget import Budget, TooLongError
from improv_core.score.joints import limbs_of
from improv_core.score.motion import Pose
from improv_core.score.movement import ENDLESS, Duration, Exact, Movement
from improv_core.score.path import Paths, pose_at
from improv_core.score.performer import MAX_SKIPPED, Performer, performer_at
from improv_core.score.projection import BASE, base_of
from improv_core.score.score import Part, Score, twist
from improv_core.score.seeking import MAX_VISITED
from improv_core.score.senses import CUE, BuiltIn
from improv_core.score.traversal import outer_first
from improv_core.score.walk import Moment, walk

MAX_PAST = 500
"""The most moments of each robot that senses have decided and that are kept. Older ones are forgotten."""
MAX_AHEAD = 20_000
"""The most moments that senses decide and that are performed for one answer."""


class _Track(NamedTuple):
    """A part of a robot in a replay: its base (`BASE`), or a body part; None is all of it together."""

    robot: str
    part: str | None = None


class Replay:
    """The replay of a score: all that robots play from a beat on, and will play if no sense changes any more.

    Parts that began before that beat are performed up to it as if no sense were true, except those that play on as they
    did `before`: they keep the decisions of senses.
    """

    def __init__(self, score: Score, beat: Exact = 0, before: Replay | None = None) -> None:
        self.score = score
        self._now: dict[str, tuple[Iterator[Moment], Moment | None]] = {}
        self._open: dict[_Track, _OpenPart] = {}
        self._closed: dict[_Track, Movement] = {}  # movements that have been projected
        changes, visits = Budget(MAX_SKIPPED), Budget(MAX_VISITED)
        for robot, part in score.parts.items():
            whole = part.of_scene(score.scene)
            if not whole.open:
                continue
            for body_part in (None, BASE, *self.body_parts(robot)) if whole.body_words.asked else (None,):
                movement, track = self._performed(part, whole, body_part), _Track(robot, body_part)
                if kept := before and before._part_that_plays_on(part, track, beat):
                    kept.written_as(movement)
                self._open[track] = kept or _OpenPart(score, part, movement, beat, changes, visits)

    def body_parts(self, robot: str) -> Sequence[str]:
        return [limb.part.name for limb in limbs_of(self.score.parts[robot], self.score.tempo)]

    def sense(self, robot: str, sense: str, value: bool | None, beat: Exact) -> None:
        """Take a robot's sense that has become true, false, or silent (None). Changes come in the order of beats."""
        for track, part in self._open.items():
            if track.robot == robot:
                part.sense(sense, value, beat)
        self._now.pop(robot, None)

    def moments(self, robot: str, start: Exact, body_part: str | None = None) -> Iterator[Moment]:
        """Yield the moments that a robot plays from a beat on: all of it, with the velocities of its base, or only
        those of a body part or `BASE`. Beats are those of the performance. The speed at which a pose is reached is
        unknown here."""
        part, track = self.score.parts[robot], _Track(robot, body_part)
        if not part.movement.body_words.asked and body_part == BASE:
            track = _Track(robot)
        open_part = self._open.get(track)
        if not open_part:
            yield from _walked(part, self._projected(track, part.movement), start)
            return
        over = part.begins
        for moment in open_part.moments():
            over = moment.start + moment.duration
            if over > start:
                begin = max(moment.start, start)
                yield moment._replace(start=begin, duration=over - begin)
        for begin in self.score.scene_begins[1:2]:  # from there on, it is as if no sense ever held
            yield from _walked(part, self._projected(track, part.movement), max(begin, over, start))

    def now(self, robot: str, beat: Exact) -> Moment | None:
        """The moment that plays at a beat, or the next one; None if nothing is left. Quick if beats only rise."""
        if robot not in self._now:
            begun = self.moments(robot, beat)
            self._now[robot] = begun, next(begun, None)
        moments, moment = self._now[robot]
        while moment and moment.start + moment.duration <= beat:
            moment = next(moments, None)
        self._now[robot] = moments, moment
        return moment

    def pose(self, robot: str, beat: Exact) -> Pose | None:
        """Return a robot's ideal pose at a beat; None if that can't be known."""
        part, open_part = self.score.parts[robot], self._open.get(_Track(robot))
        return open_part.pose(beat) if open_part else pose_at(part, beat)

    def line(self, robot: str, beat: Exact) -> tuple[int, Exact] | None:
        """Return the line that a robot plays at a beat of a scene that senses decide: its statement, and the beat at
        which it began; None if nothing is left."""
        open_part = self._open[_Track(robot)]
        line = open_part.line()
        for moment in open_part.moments():
            if moment.start > beat:
                break
            line = _line(line, moment)
            if beat < moment.start + moment.duration:
                return line
        return None

    def is_open(self, robot: str) -> bool:
        """Return whether senses decide what a robot plays in this scene."""
        return _Track(robot) in self._open

    def _part_that_plays_on(self, part: Part, track: _Track, beat: Exact) -> _OpenPart | None:
        old = self.score.parts.get(part.robot)
        plays_on = old and old.begins == part.begins < beat and old.scene == part.scene
        return self._open.get(track) if plays_on else None

    def _projected(self, track: _Track, whole: Movement) -> Movement:
        if track not in self._closed:
            self._closed[track] = self._performed(self.score.parts[track.robot], whole, track.part)
        return self._closed[track]

    def _performed(self, part: Part, whole: Movement, body_part: str | None) -> Movement:
        if body_part is None:
            return whole
        if body_part == BASE:
            return base_of(whole)
        limbs = {limb.part.name: limb for limb in limbs_of(part, self.score.tempo)}
        return limbs[body_part].performs(whole)


class _OpenPart:
    """A part of a scene that senses decide. `past` has certainly been performed; the rest is tried out."""

    def __init__(
        self, score: Score, part: Part, movement: Movement, beat: Exact, changes: Budget, visits: Budget
    ) -> None:
        self._score = score
        self._part = part
        self._movement = movement
        self._performer = Performer(self._movement, part.begins)
        self._statements: dict[int, int] = {}  # the statements of a later version of the program in place of these
        self._edges: deque[tuple[Exact, str, bool | None]] = deque()  # edges that have not been performed
        self._past: deque[Moment] = deque()
        self._entered: Pose | None = part.entered or part.start  # where the robot is at the beginning of the past
        self._cue = isinstance(part.senses.get(CUE), BuiltIn)  # it holds for an instant
        self._values: dict[str, bool | None] = dict.fromkeys(part.senses, False)
        self._line: tuple[int, Exact] | None = None  # the line that played before the past
        if part.begins < beat:
            try:
                self._perform(beat, changes)
            except TooLongError:
                self._jump(beat, visits)
            self._performer.settle(self._values.get)
        self._values = {CUE: False} if self._cue else {}

    def written_as(self, movement: Movement) -> None:
        """Note that the part plays on, and is written in other statements now."""
        was, now = _statements(self._movement), _statements(movement)
        self._statements = dict(zip(was, now, strict=True)) if len(was) == len(now) else {}

    def line(self) -> tuple[int, Exact] | None:
        """Return the line that played before the moments that are known, and the beat at which it began."""
        return self._line and (self._statements.get(self._line[0], self._line[0]), self._line[1])

    def sense(self, sense: str, value: bool | None, beat: Exact) -> None:
        self._perform(beat)
        self._edges.append((beat, sense, value))

    def moments(self) -> Iterator[Moment]:
        """Yield all moments that are known, and those to come if no sense changes any more."""
        ahead = copy(self)
        ahead._performer = self._performer.fork()
        ahead._edges, ahead._values = self._edges.copy(), self._values.copy()
        steps = iter(lambda: ahead._step(ENDLESS), None)
        return map(self._rewritten, chain(tuple(self._past), islice(steps, MAX_AHEAD)))

    def pose(self, beat: Exact) -> Pose | None:
        known = self._past[0].start if self._past else self._performer.beat
        if beat < known and known > self._part.begins:
            return None
        pose = self._entered
        for moment in takewhile(lambda each: each.start < beat, self.moments()):
            pose = pose and self._moved(pose, moment, min(moment.duration, beat - moment.start))
        return pose

    def _jump(self, beat: Exact, visits: Budget) -> None:
        """Move to a beat without a past. If that takes too long to compute, begin there."""
        self._past.clear()
        try:
            self._performer = performer_at(self._movement, self._part.begins, beat, Budget(MAX_SKIPPED))
            self._entered = Paths().pose(self._part, self._performer.beat, visits)
        except TooLongError:
            self._performer, self._entered = Performer(self._movement, beat), None

    def _perform(self, beat: Exact, budget: Budget | None = None) -> None:
        """Perform up to a beat. Later changes can't alter that."""
        for _ in range(MAX_AHEAD):
            if self._performer.beat >= beat or not (moment := self._step(beat)):
                return
            if budget:
                budget.spend()
            self._past.append(moment)
            if len(self._past) > MAX_PAST:
                first = self._past.popleft()
                self._line = _line(self._line, first)
                self._entered = self._entered and self._moved(self._entered, first, first.duration)

    def _step(self, end: Duration) -> Moment | None:
        """Perform up to a beat, or the next change before it. Return the moment, or None if nothing is left."""
        performer, values, edges = self._performer, self._values, self._edges
        while edges and edges[0][0] <= performer.beat:
            _, sense, values[sense] = edges.popleft()
        performer.settle(values.get)
        if self._cue:
            values[CUE] = False
        until = min(performer.until, end, edges[0][0] if edges else ENDLESS) if not performer.is_over else ENDLESS
        if isinstance(until, float):
            return None
        moment = Moment(performer.beat, until - performer.beat, *performer.performed(values.get))
        performer.advance(until)
        return moment

    def _rewritten(self, moment: Moment) -> Moment:
        if not self._statements:
            return moment
        sources = (
            each._replace(statement=self._statements.get(each.statement, each.statement)) for each in moment.sources
        )
        return moment._replace(sources=tuple(sources))

    def _moved(self, pose: Pose, moment: Moment, beats: Exact) -> Pose:
        velocity = twist(moment.velocity, self._part.profile, self._score.tempo)
        return pose.after(velocity, self._score.seconds(beats)).above_ground()


def _walked(part: Part, movement: Movement, start: Exact) -> Iterator[Moment]:
    """Yield the moments of this movement from a beat on, in a part that no sense decides."""
    if start < part.ends:
        for moment in walk(movement, max(start - part.begins, 0)):
            yield moment._replace(start=part.begins + moment.start)


def _statements(movement: Movement) -> list[int]:
    """Return the statements that a movement is written in, each once, in the order in which they play."""
    parts = outer_first(movement, lambda part: part.parts)
    return list(dict.fromkeys(part.statement for part in parts if isinstance(part, FromStatement)))


def _line(line: tuple[int, Exact] | None, moment: Moment) -> tuple[int, Exact] | None:
    """Return the line that a moment belongs to, after another one. A robot that stands stays in its line."""
    if not moment.sources or (line and line[0] == moment.sources[0].statement):
        return line
    return moment.sources[0].statement, moment.start
