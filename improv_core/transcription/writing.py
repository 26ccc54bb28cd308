"""Writes motions as words, each correcting the roundings before it. Standard library only."""

from __future__ import annotations

import math
from bisect import bisect_right
from collections.abc import Iterator, Sequence
from typing import NamedTuple

from improv_core.score.motion import Pose
from improv_core.score.profiles import Profile
from improv_core.transcription.amounts import amounts_between
from improv_core.transcription.folding import bracketed, folded
from improv_core.transcription.performing import differences
from improv_core.transcription.rhythm import TimedItem, TimedMotion
from improv_core.transcription.track import Track
from improv_core.transcription.wording import Node, Rounding, Shaped, amounts_of, moves_for

_EXACT = Rounding(1e-6, 1e-6)
"""Nearly nothing: amounts that are rounded already stay as they are."""


class Guide(NamedTuple):
    """A track that words are to stay near: each motion that would end too far from it aims at it.

    `window` is the number of samples whose mean counts.
    """

    track: Track
    tempo: int
    window: int
    near: Rounding

    def aimed(self, item: TimedItem, pose: Pose, beat: float) -> TimedItem:
        """Return an item of one motion that begins at a beat from a pose, or one that ends nearer to the track."""
        (motion,) = item.motions
        origin, seconds = self.track[0].time, 60 / self.tempo
        first, past = (
            bisect_right(self.track, origin + at * seconds + 1e-6, key=lambda each: each.time)
            for at in (beat, beat + float(motion.beats))
        )
        samples = self.track[max(first, past - self.window) : past]
        if not samples:
            return item
        misses = []
        for sample in samples:
            share = ((sample.time - origin) / seconds - beat) / float(motion.beats)
            misses.append(differences(pose.then(motion.amounts.pose(share)), sample.pose))
        x, y, z, turn = (math.fsum(each) / len(samples) for each in zip(*misses, strict=True))
        if math.hypot(x, y, z) <= self.near.meters and abs(turn) <= self.near.radians:
            return item
        end = pose.then(motion.amounts.pose())
        wanted = Pose(end.x + x, end.y + y, end.z + z, end.heading + turn)
        return TimedItem((TimedMotion(motion.beats, amounts_between(pose, wanted, wanted.heading - pose.heading)),))


def written(
    start: Pose, items: Sequence[TimedItem], profile: Profile, guide: Guide | None = None, exact: Rounding = _EXACT
) -> Iterator[tuple[Node, TimedItem]]:
    """Yield the nodes for items that a robot performs from a pose, before anything is folded, and what each makes."""
    pose, beat = start, 0.0
    for item in items:
        aimed = guide.aimed(item, pose, beat) if guide and not item.curve else item
        near = exact if aimed is item or not guide else guide.near
        moves = [move for each in aimed.motions for move in moves_for(each.beats, each.amounts, profile, near)]
        made = tuple(TimedMotion(move.beats, amounts_of(move, profile)) for move in moves)
        for each in made:
            pose = pose.then(each.amounts.pose())
        beat += float(item.beats)
        if item.curve:
            yield Shaped(*item.curve, folded(bracketed(moves))), TimedItem(made, item.curve)
        else:
            yield from zip(moves, (TimedItem((each,)) for each in made), strict=True)
