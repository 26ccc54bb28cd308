"""A save as an edit: a score takes over from the one that plays, and parts that stay the same play on."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from itertools import zip_longest
from typing import TypedDict

from improv_core.score.json_types import Monotonic
from improv_core.score.lengths import lengths
from improv_core.score.motion import Pose
from improv_core.score.movement import ENDLESS, Exact, Movement, near
from improv_core.score.path import pose_at
from improv_core.score.score import NOTHING, UNNUMBERED, Part, Score
from improv_core.score.transport import Switch, Transport

SAME_MOMENT = 0.001
"""Seconds by which the time of a beat may differ between two stages."""


class SceneJson(TypedDict):
    """The scene of a score that plays, counted from 0, and the beat at which it began."""

    index: int
    begins: float


class Begins(TypedDict, total=False):
    """The beats at which parts began, by robot, except those that began at beat 0. They began with `scene`, or with the
    first scene if it isn't given."""

    begins: Mapping[str, float]
    scene: SceneJson


class Paced(TypedDict, total=False):
    """The factor by which the tempo and the speed are multiplied to follow a clock from outside."""

    pace: float


class Trailing(TypedDict, total=False):
    """The seconds by which this stage plays behind the leading one, whose senses have to arrive first."""

    behind: float


class Takeover(Begins, Paced, Trailing):
    """A score took over at this beat, at this monotonic time."""

    beat: float
    monotonic: Monotonic


@dataclass(frozen=True, slots=True)
class PendingTakeover:
    """A score that waits to take over: `when` is now, beat, bar, or end, and `at` the resulting performance time.

    `entry` is set if another stage has decided when it takes over.
    """

    score: Score
    generation: int
    when: Switch
    beats_per_bar: int
    at: float
    entry: Takeover | None

    def beat(self, transport: Transport) -> Exact:
        """The beat at which it takes over from a score that plays."""
        return near(self.entry["beat"]) if self.entry else transport.beat(transport.clock(self.at), ENDLESS)

    def shifts(self, transport: Transport) -> bool:
        """Return whether the leading stage counts its beats from another moment than this transport does."""
        if not self.entry:
            return False
        ours = transport.clock(transport.end(near(self.entry["beat"])))
        return abs(ours - self.entry["monotonic"]) > SAME_MOMENT


@dataclass(frozen=True, slots=True)
class OutgoingScore:
    """The score that plays when another one takes over, and its scene. If it `is_over`, so is its last scene.

    `poses` are those of simulated robots that senses have moved; None for real robots.
    """

    score: Score
    scene: int
    is_over: bool
    poses: Mapping[str, Pose] | None


def edited(swap: PendingTakeover, beat: Exact, before: OutgoingScore) -> Score:
    """Return the score that takes over at a beat, with the beats at which its parts of this scene began."""
    scene, since = _scene_after(swap, beat, before)
    parts = {
        robot: _edited_part(replace(part, begins=_begins(part, swap, scene, beat, before), scene=scene), beat, before)
        for robot, part in swap.score.parts.items()
    }
    return replace(swap.score, parts=parts, scene=scene, since=since)


def entering(score: Score, before: OutgoingScore) -> set[str]:
    """Return the robots of an edited score whose parts begin. The others play on as they do."""
    return {robot for robot, part in score.parts.items() if not _plays_on(part, before)}


def joined(score: Score, entry: Begins) -> Score:
    """Return a score as another stage already plays it."""
    begins = entry.get("begins", {})
    scene, since = _scene_of(entry)
    parts = {name: replace(part, begins=near(begins.get(name, 0))) for name, part in score.parts.items()}
    return replace(score, parts=parts, scene=scene, since=since)


def amid(score: Score, before: Score) -> Score:
    """Return a score with the parts of another one added, except for robots and scenes that it already has."""
    both = (replace(part, scenes=_filled(part, before.parts.get(name))) for name, part in score.parts.items())
    return replace(score, parts={**before.parts, **{part.robot: part for part in both}})


def never_ends(score: Score) -> bool:
    """Return whether a score never ends, no matter what robots sense."""
    return any(lengths(part.scenes[-1]).shortest == ENDLESS for part in score.parts.values() if part.scenes)


def _filled(part: Part, before: Part | None) -> tuple[Movement, ...]:
    """Return the scenes of a part, and those of the one before, for the same kind of robot, where it has none."""
    if not before or before.profile != part.profile:
        return part.scenes
    return tuple(
        scene if scene.duration or scene.open else old
        for scene, old in zip_longest(part.scenes, before.scenes, fillvalue=NOTHING)
    )


def _scene_of(entry: Begins) -> tuple[int, Exact]:
    """Return the scene with which a score took over, and the beat at which it began."""
    scene = entry.get("scene")
    return (scene["index"], near(scene["begins"])) if scene else (0, 0)


def _scene_after(swap: PendingTakeover, beat: Exact, before: OutgoingScore) -> tuple[int, Exact]:
    """The scene with which a score takes over, and the beat at which it began. After the end, all begins again."""
    if swap.entry:
        return _scene_of(swap.entry)
    if before.is_over or not before.score.scene_begins:
        return 0, beat
    scene = min(before.scene, max(swap.score.scenes - 1, 0))
    return scene, before.score.scene_begins[scene - before.score.scene] if scene == before.scene else beat


def _begins(part: Part, swap: PendingTakeover, scene: int, beat: Exact, before: OutgoingScore) -> Exact:
    """Return the beat at which a part began, in a score that takes over with a scene at a beat."""
    if swap.entry:
        return near(swap.entry.get("begins", {}).get(part.robot, 0))
    return before.score.begins(part.robot, scene) if not before.is_over and _is_alike(part, scene, before) else beat


def _edited_part(part: Part, beat: Exact, before: OutgoingScore) -> Part:
    """Return a part with the pose at which its robot entered this scene."""
    old = before.score.parts.get(part.robot)
    entered = None
    if old and _plays_on(part, before):
        if old.scene == part.scene:
            entered = old.entered or old.start
        elif before.poses is not None:
            entered = pose_at(old, part.begins)
    elif old and before.poses is not None:
        entered = before.poses.get(part.robot) or pose_at(old, beat)
    return replace(part, entered=entered)


def _plays_on(part: Part, before: OutgoingScore) -> bool:
    """Return whether a part of an edited score is the one that its robot already plays."""
    return _is_alike(part, part.scene, before) and before.score.begins(part.robot, before.scene) == part.begins


def _is_alike(part: Part, scene: int, before: OutgoingScore) -> bool:
    """Return whether a part moves its robot in a scene in the same way as the one that it already plays."""
    old = before.score.parts.get(part.robot)
    return old is not None and scene == before.scene and old.edition(scene) == part.edition(scene) != UNNUMBERED
