"""Scenes: movements that begin on one beat for all robots. Standard library only."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from itertools import zip_longest

from improv_core.score.movement import ENDLESS, Duration, Movement, series, stand

NOTHING = series(())


def scene_begins(parts: Iterable[Sequence[Movement]]) -> tuple[int, ...]:
    """The beats at which scenes begin, given the scenes of each robot: the first whole beat at which all above is over.

    A scene below one that never ends does not begin.
    """
    begins = []
    end: Duration = 0
    for scene in zip_longest(*parts, fillvalue=NOTHING):
        if end == ENDLESS:
            break
        begins.append(math.ceil(end))
        end = begins[-1] + max(movement.duration for movement in scene)
    return tuple(begins)


def performance(scenes: Sequence[Movement], begins: Sequence[int]) -> Movement:
    """All scenes of one robot as one movement, in which it stands still until each of them begins."""
    if len(scenes) == 1:
        return scenes[0]
    items = []
    end: Duration = 0
    for scene, begin in zip(scenes, begins, strict=False):
        if scene.duration and begin > end:
            assert not isinstance(end, float)
            items.append(stand(begin - end))
            end = begin
        items.append(scene)
        end += scene.duration
    return series(items)
