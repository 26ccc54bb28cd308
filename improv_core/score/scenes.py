"""Scenes: movements that begin on one beat for all robots. Standard library only."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from itertools import repeat, zip_longest

from improv_core.score.algebra import series, stand
from improv_core.score.movement import ENDLESS, Duration, Exact, Movement

NOTHING = series(())


def scene_begins(
    parts: Iterable[Sequence[Movement]], since: Exact = 0, entered: Sequence[Exact] | None = None
) -> tuple[Exact, ...]:
    """Return the beats at which scenes begin: each on the first whole beat at which all robots' scenes above are over.

    The first scene begins at beat `since`, and each robot's part of it at a beat of `entered`, if they differ. A scene
    below one that never ends does not begin.
    """
    begins: list[Exact] = []
    begin: Duration = since
    starts: Iterable[Exact] | None = entered
    for scene in zip_longest(*parts, fillvalue=NOTHING):
        assert not isinstance(begin, float)
        begins.append(begin)
        lasting = zip(starts or repeat(begin), scene)  # noqa: B905 (endless on purpose)
        end = max(start + movement.duration for start, movement in lasting)
        if end == ENDLESS:
            break
        begin, starts = math.ceil(end), None
    return tuple(begins)


def performance(scenes: Sequence[Movement], begins: Sequence[Exact]) -> Movement:
    """All scenes of one robot as one movement, in which it stands still until each of them begins, the first at 0."""
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
