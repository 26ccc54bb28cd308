"""Select some scenes to play alone, with robots at their places when the first of them begins."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from fractions import Fraction

from improv_core.diagnostics import likely
from improv_core.ide.selection import Selection, UnplayableError, require_no_errors
from improv_core.program.analysis import Analysis
from improv_core.program.compiler import score_of
from improv_core.robots.config import Robots
from improv_core.score.motion import Pose
from improv_core.score.movement import Exact
from improv_core.score.path import MAX_MEASURED_THROWS, pose_at
from improv_core.score.score import Score
from improv_core.score.suppositions import as_passed
from improv_core.slices import checkpoint

SENSED = "senses decide where robots are then: they begin as if no sense were ever true and no robot had to wait"
UNKNOWN = "robots begin at their starts, since {}"


@dataclass(frozen=True, slots=True)
class Scenes:
    """The scenes from `first` to `last`, counted from 0."""

    first: int
    last: int


def scenes_named(analysis: Analysis, first: str | int | None, last: str | int | None) -> Scenes:
    """Return the scenes from one to another, by their names or their numbers, counted from 1. None stands for the first
    or the last one. Raises UnplayableError."""
    begin = 0 if first is None else _scene(analysis, first)
    end = analysis.scene_count - 1 if last is None else _scene(analysis, last)
    if end < begin:
        raise UnplayableError(
            f"{scene_called(analysis, end)} is above {scene_called(analysis, begin)}: write the upper scene first"
        )
    return Scenes(begin, end)


def rehearse(analysis: Analysis, scenes: Scenes) -> Selection:
    """Return the lines of these scenes, with robots at their places when the first of them begins in the whole program,
    as dice and senses decide it there (`as_passed`). Raises UnplayableError."""
    whole = replace(analysis.cast_with(analysis.config), selected=None)
    lines = {index: line for index, line in whole.played.items() if scenes.first <= line.scene <= scenes.last}
    name = _called(whole, scenes)
    if not lines:
        raise UnplayableError(f"nothing plays in {name}: write a line such as `{whole.any_robot} $ forward` there")
    require_no_errors(whole, [*lines])
    places, begin, note = _places(whole, scenes.first) if scenes.first else ({}, 0, "")
    config = _in_song(whole.opening.config, begin, whole.tempo)
    opening = replace(whole.opening, config=config, places={**whole.opening.places, **places})
    return Selection(name, replace(whole, selected=[*lines.values()], opening=opening), note=note, moved=bool(places))


def scene_called(analysis: Analysis, scene: int) -> str:
    """Return a name for a scene, counted from 0: `scene 2`, or `scene bow` if that is its name."""
    names = analysis.scene_names
    return f"scene {(names[scene] if scene < len(names) else '') or scene + 1}"


def _scene(analysis: Analysis, wanted: str | int) -> int:
    """Return the number of a scene, from 0."""
    names = list(analysis.scene_names)
    if isinstance(wanted, int):
        if not 1 <= wanted <= analysis.scene_count:
            raise UnplayableError(f"there is no scene {wanted:,}: this program has {analysis.scene_count:,}")
        return wanted - 1
    if wanted in names:
        return names.index(wanted)
    known = [name for name in names if name]
    if near := likely(wanted, known):
        hint = f"did you mean `{near}`?"
    elif known:
        hint = f"write one of {', '.join(f'`{name}`' for name in known[:10])}"
    else:
        hint = f"write `--- {wanted}` above its lines"
    raise UnplayableError(f"no scene is called `{wanted}`: {hint}")


def _called(analysis: Analysis, scenes: Scenes) -> str:
    """`scene bow`, `from scene bow on`, `scenes walk to bow`."""
    first, last = (scene_called(analysis, scene) for scene in (scenes.first, scenes.last))
    if scenes.first == scenes.last:
        return first
    if scenes.last == analysis.scene_count - 1:
        return f"from {first} on" if scenes.first else "all scenes"
    return f"{first} to {last}"


def _in_song(config: Robots, begin: Exact, tempo: Fraction) -> Robots:
    """Return the robots with a song that is at the beat at which these scenes begin."""
    if not config.music:
        return config
    first_beat = config.music.first_beat + float(begin * 60 / tempo)
    return replace(config, music=replace(config.music, first_beat=first_beat))


def _places(analysis: Analysis, scene: int) -> tuple[Mapping[str, Pose], Exact, str]:
    """Return the poses of all robots when a scene begins, its first beat, and one line about both for people."""
    above = [index for index, line in analysis.played.items() if line.scene < scene]
    try:
        require_no_errors(analysis, above)
    except UnplayableError as error:
        return {}, 0, UNKNOWN.format(f"there is an error above: {error}")
    score = score_of(analysis)
    passed = _passed(score)
    if scene >= len(passed.scene_begins):
        return {}, 0, UNKNOWN.format(f"{scene_called(analysis, len(passed.scene_begins) - 1)} never ends")
    begin = passed.scene_begins[scene]
    places = {}
    for robot, part in passed.parts.items():
        checkpoint()
        if (place := pose_at(part, begin, MAX_MEASURED_THROWS)) is None:
            return {}, begin, UNKNOWN.format(f"it takes too long to find out where {robot} is then")
        places[robot] = place
    decided = any(each.open for part in score.parts.values() for each in part.scenes[:scene])
    return places, begin, SENSED if decided else ""


def _passed(score: Score) -> Score:
    """Return the score with assumed senses, so that its scenes begin at known beats."""
    parts = {
        robot: replace(part, scenes=tuple(as_passed(each) for each in part.scenes), scene_begins=())
        for robot, part in score.parts.items()
        if score.open
    }
    return replace(score, parts={**score.parts, **parts})
