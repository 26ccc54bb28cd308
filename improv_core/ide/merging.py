"""Merge several programs into one, in which each robot plays the same part as in its own program."""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction

from improv_core import LineError
from improv_core.diagnostics import Edit, Severity, applied
from improv_core.ide.placing import line_at
from improv_core.ide.references import Symbol, plays, references
from improv_core.program.analysis import Analysis, analyze
from improv_core.program.compiler import score_of, starts_of
from improv_core.program.opening import FARTHEST
from improv_core.score.meetings import LAST_BEAT
from improv_core.score.motion import Pose
from improv_core.score.movement import Duration, Exact, Movement
from improv_core.score.primitives import rest_text
from improv_core.score.profiles import BUILT_IN
from improv_core.score.score import Part
from improv_core.score.strokes import pictured
from improv_core.score.trajectories import BLOCK, Trajectory
from improv_core.slices import checkpoint
from improv_core.syntax.formatter import format_text
from improv_core.syntax.vocabulary import WORDS
from improv_core.text import Span, free_name

GAP = 1.0
"""Meters between the places of two programs."""
REACH = 6.0
"""The meters that a robot gets around the start poses of its program if its path never ends and never repeats itself,
or is too long to follow."""
LONGEST_NAME = 30
"""The most characters of a program's name that its robots' names begin with."""
_OTHER_MEANING = WORDS.keys() | {"at", "is", "room", "bar", "beat", "circle", "line", "grid"}
_REPLACED = ("BEAT", "AT", "ROOM", "BAR_LENGTH", "SCENE")
"""The signs of lines that the merged program has once for all programs, or replaces."""


class MergeError(LineError):
    """Programs can't be merged. The message is one line that names the program and the reason."""


@dataclass(frozen=True, slots=True)
class Dance:
    """A program to merge, and the name for its robots."""

    name: str
    analysis: Analysis


@dataclass(frozen=True, slots=True)
class Merged:
    """The merged program: its text, for each source the new names of its robots by the old ones, and a line about each
    loss."""

    text: str
    robots: Sequence[Mapping[str, str]]
    notes: Sequence[str]


def merge(sources: Sequence[Dance]) -> Merged:
    """Return one program in which the robots of all sources play their own parts, placed side by side.

    The tempo is the first program's; the parts of the others are slowed down or sped up, so that robots keep their
    speeds. Scenes become rests. A bar or a floor is kept if all agree. Raises MergeError.
    """
    for each in sources:
        _check(each)
    robots = _renamed_robots(sources)
    bodies = _bodies(sources, robots)
    notes: list[str] = []
    opening = _opening(sources, robots, notes)
    text = format_text("\n\n".join([opening, *bodies]) + "\n")
    _check_result(text, sources, robots)
    return Merged(text, robots, notes)


def renamed(analysis: Analysis, robots: Mapping[str, str]) -> str:
    """Give the robots of a program other names, by the old ones."""
    return applied(analysis.text, [Edit(span, new) for old, new in robots.items() for _, span in plays(analysis, old)])


def _check(source: Dance) -> None:
    """Raise MergeError if a program can't be merged with any other."""
    name, analysis = source.name, source.analysis
    if not analysis.ok:
        raise MergeError(f"{name}: it has errors: fix them first")
    if not analysis.all_robots:
        raise MergeError(f"{name}: it has no robots: add a line such as `ada $ forward`")
    world = analysis.opening.config.world
    if world.walls or world.circles or world.boxes:
        raise MergeError(f"{name}: its improv.toml has obstacles, which can't be moved: remove them first")
    begins = [begin for scene in range(analysis.scene_count) if (begin := analysis.scene_begin(scene))]
    if any(begin.shortest != begin.longest for begin in begins):
        raise MergeError(f"{name}: senses decide when its scenes begin, so others can't play at the same time")


def _check_result(text: str, sources: Sequence[Dance], robots: Sequence[Mapping[str, str]]) -> None:
    """Raise MergeError if a robot has another profile in the merged program, or if the program has errors."""
    merged = analyze(text)
    config = merged.opening.config
    for source, names in zip(sources, robots, strict=True):
        before = source.analysis.opening.config
        for old, new in names.items():
            if before.profile_of(old) != config.profile_of(new):
                raise MergeError(
                    f"{source.name}: `{old}` is described in its improv.toml: remove it there, or play it alone"
                )
    if not merged.ok:
        error = next(each for each in merged.diagnostics if each.severity is Severity.ERROR)
        line = merged.lines.number(error.span.start)
        raise MergeError(f"these can't be merged: line {line} of the merged program would be wrong: {error.message}")


def _renamed_robots(sources: Sequence[Dance]) -> Sequence[Mapping[str, str]]:
    """Return the new names of robots: those of their programs, each followed by the robot's own if there are
    several."""
    taken: set[str] = set()
    found = []
    for source in sources:
        prefix, robots = as_robot(source.name), source.analysis.all_robots
        names = {robot: f"{prefix}_{robot}" if len(robots) > 1 else prefix for robot in robots}
        number = 2
        while not taken.isdisjoint(names.values()):
            names = {old: f"{prefix}_{number}" + (f"_{old}" if len(robots) > 1 else "") for old in robots}
            number += 1
        taken.update(names.values())
        found.append(names)
    return found


def as_robot(name: str) -> str:
    """Return a valid name for robots, as near as possible to any other name."""
    from anyascii import anyascii  # only here: it takes 30 ms, and the website has no use for it

    plain = anyascii(name)
    robot = re.sub(r"[^A-Za-z0-9]+", "_", plain).strip("_")[:LONGEST_NAME].rstrip("_")
    robot = robot if robot[:1].isalpha() else f"dancer_{robot}".rstrip("_")
    return f"{robot}_1" if robot in _OTHER_MEANING else robot


def _bodies(sources: Sequence[Dance], robots: Sequence[Mapping[str, str]]) -> Sequence[str]:
    """Return the texts of the programs without their openings, which fit into one program."""
    tempo = sources[0].analysis.tempo
    defined = [{line.defines for line in each.analysis.statements if line.defines} for each in sources]
    foreign = [
        {name for statement in each.analysis.statements for name in statement.uses} - own
        for each, own in zip(sources, defined, strict=True)
    ]
    taken = {token.text for each in sources for statement in each.analysis.statements for token in statement.tokens}
    bodies, above = [], set[str]()
    for place, (source, names) in enumerate(zip(sources, robots, strict=True)):
        checkpoint()
        hides = above.union(*foreign[:place], *foreign[place + 1 :])
        suffix = as_robot(source.name)
        renamed: dict[str, str] = {}
        for name in sorted(defined[place] & hides):
            renamed[name] = free_name(f"{name}_{suffix}", {*taken, *_OTHER_MEANING, *renamed.values()})
        taken |= {*renamed.values()}
        above |= defined[place] - renamed.keys()
        head = f"# {' '.join(source.name.split())}\n"
        bodies.append(head + _body(source.analysis, names, renamed, tempo / source.analysis.tempo).strip("\r\n"))
    return bodies


def _body(analysis: Analysis, robots: Mapping[str, str], renamed: Mapping[str, str], slower: Fraction) -> str:
    """Return a program without its opening and its scenes, with other names and `slower` by that factor."""
    edits = [Edit(span, new) for old, new in robots.items() for _, span in plays(analysis, old)]
    gone: list[Span] = []
    waiting = _Waiting(analysis.begins)
    for index, statement in enumerate(analysis.statements):
        checkpoint()
        start = analysis.offsets[index]
        whole = Span(start, start + len(statement.text))
        if statement.defines and statement.defines in renamed:
            symbol = Symbol(statement.defines, statement.heads[0].span.shifted(start), "name", index)
            edits += [Edit(each.span, renamed[symbol.text]) for each in references(analysis, symbol)]
        if statement.kind in _REPLACED:
            gone.append(_with_line(analysis.text, whole))
        line = analysis.played.get(index)
        if line is None:
            continue
        if line.scene >= len(analysis.begins):
            gone.append(_with_line(analysis.text, whole))  # it is never performed
            continue
        assert statement.sign
        rests = [
            f"{robots[robot]} $ {rest_text(beats * slower)}\n" for robot, beats in waiting.rests(line.scene, line.parts)
        ]
        edits.append(Edit(Span(start, start), "".join(rests)))
        if slower != 1:
            after, end = start + statement.sign.end, start + statement.tokens[-1].end
            edits += [Edit(Span(after, after), f" slow {slower} ("), Edit(Span(end, end), ")")]
    kept = [each for each in edits if not any(span.start <= each.span.start < span.end for span in gone)]
    return applied(analysis.text, [*kept, *(Edit(span, "") for span in gone)])


class _Waiting:
    """The rests of robots until their scenes begin."""

    def __init__(self, begins: Sequence[Exact]) -> None:
        self._begins = begins
        self._ends: dict[str, Duration] = {}

    def rests(self, scene: int, parts: Sequence[tuple[str, Movement]]) -> Iterator[tuple[str, Fraction]]:
        """Yield the beats that robots rest before they play a line of a scene, if they do."""
        for robot, part in parts:
            end, begin = self._ends.get(robot, 0), self._begins[scene]
            if end < begin:
                assert not isinstance(end, float)
                yield robot, Fraction(begin - end)
            self._ends[robot] = math.inf if part.open else max(end, begin) + part.duration


def _with_line(text: str, span: Span) -> Span:
    """Return the span, and all of its line if nothing else is there."""
    before = re.search(r"[ \t]*\Z", text[: span.start])
    after = re.compile(r"[ \t]*(\r\n|\r|\n|\Z)").match(text, span.end)
    start = before.start() if before else span.start
    is_alone = after and (start == 0 or text[start - 1] in "\r\n")
    return Span(start, after.end()) if after and is_alone else span


def _opening(sources: Sequence[Dance], robots: Sequence[Mapping[str, str]], notes: list[str]) -> str:
    """Return the lines that all programs have in common, and those that place their robots."""
    tempo = sources[0].analysis.tempo
    lines = [f"beat {tempo}"] if any(each.analysis.tempos for each in sources) else []
    changed = [each.name for each in sources if each.analysis.tempo != tempo]
    if changed:
        keep = "keeps its" if len(changed) == 1 else "keep their"
        notes.append(f"the tempo is {float(tempo):g}: {', '.join(changed)} {keep} speed with `slow`")
    bars = {each.analysis.opening.bar for each in sources}
    if len(bars) == 1 and not changed and (bar := bars.pop()):
        lines.append(f"bar {bar}")
    elif any(bars):
        notes.append("no bar: the programs don't agree on its length")
    if any(each.analysis.breaks for each in sources):
        notes.append("no scenes: robots rest until theirs begin")
    areas = [_area(each.analysis) for each in sources]
    middles, size = _side_by_side(areas)
    if max(size) > 2 * FARTHEST:
        largest = max(zip(areas, sources, strict=True), key=lambda each: max(each[0].width, each[0].height))[1].name
        need = f"these need {max(size):,.0f} m side by side, and {2 * FARTHEST:,} m is the most"
        raise MergeError(f"{need}: merge fewer, or leave out {largest}")
    has_room = [each.analysis.opening.config.world.size is not None for each in sources]
    if all(has_room):
        lines.append(f"room {size[0]:.10g} {size[1]:.10g}")
    elif any(has_room):
        notes.append("no room: only some of the programs have one")
    for source, names, area, (x, y) in zip(sources, robots, areas, middles, strict=True):
        starts, config = starts_of(source.analysis), source.analysis.opening.config
        for old, new in names.items():
            pose = area.moved(starts[old], x, y)
            lines.append(line_at(new, (pose.x, pose.y, math.degrees(pose.heading))))
            profile = config.profile_of(old)
            if old in config.robots and BUILT_IN.get(profile.name) == profile:
                lines.append(f"{new} is {profile.name}")
    return "\n".join(lines)


@dataclass(frozen=True, slots=True)
class _Area:
    """The floor that a program needs, in meters."""

    left: float
    right: float
    bottom: float
    top: float

    @classmethod
    def around(cls, points: Iterable[tuple[float, float]]) -> _Area:
        xs, ys = zip(*points, strict=True)
        return cls(min(xs), max(xs), min(ys), max(ys))

    @property
    def width(self) -> float:
        return self.right - self.left

    @property
    def height(self) -> float:
        return self.top - self.bottom

    @property
    def rounded(self) -> _Area:
        """The area with borders at whole tenths of a meter, so that robots move by round numbers."""
        left, bottom = math.floor(10 * self.left), math.floor(10 * self.bottom)
        right, top = math.ceil(10 * self.right), math.ceil(10 * self.top)
        return _Area(left / 10, right / 10, bottom / 10, top / 10)

    def moved(self, pose: Pose, x: float, y: float) -> Pose:
        """Return a pose after the middle of the area has moved to a point."""
        right, up = x - (self.left + self.right) / 2, y - (self.bottom + self.top) / 2
        return replace(pose, x=pose.x + right, y=pose.y + up)


def _area(analysis: Analysis) -> _Area:
    """Measure the area of the start poses, and of the floor of the program or else all that its robots reach."""
    score = pictured(score_of(analysis))
    starts = [(part.start.x, part.start.y, part.profile.radius) for part in score.parts.values()]
    near = [(x + far, y + far) for x, y, radius in starts for far in (-radius, radius)]
    if size := score.world.size:
        return _Area.around([*near, (-size[0] / 2, -size[1] / 2), (size[0] / 2, size[1] / 2)])
    own = _Area.around(near)
    return _Area.around([*near, *(corner for part in score.parts.values() for corner in _reached(part, own))]).rounded


def _reached(part: Part, own: _Area) -> Iterator[tuple[float, float]]:
    """Yield opposite corners of boxes around everything that a robot covers."""
    trajectory, radius = Trajectory(part), part.profile.radius
    cycle = trajectory.cycle
    end = math.ceil((cycle.begins + cycle.beats) / BLOCK) if cycle else math.inf
    number = 0
    while number < min(end, LAST_BEAT / BLOCK) and (block := trajectory.block(number)):
        box = block.box.larger(radius, 0)
        is_far = box.x0 < own.left - REACH or box.x1 > own.right + REACH
        if not cycle and (is_far or box.y0 < own.bottom - REACH or box.y1 > own.top + REACH):
            break
        yield from ((box.x0, box.y0), (box.x1, box.y1))
        number += 1
    if number < end:
        yield from ((own.left - REACH, own.bottom - REACH), (own.right + REACH, own.top + REACH))


def _side_by_side(areas: Sequence[_Area]) -> tuple[Sequence[tuple[float, float]], tuple[float, float]]:
    """Return the middles of areas in rows around the origin, as many in a row as there are rows, and the size of
    all."""
    columns = math.ceil(math.sqrt(len(areas)))
    rows = [areas[first : first + columns] for first in range(0, len(areas), columns)]
    heights = [max(area.height for area in row) for row in rows]
    widths = [sum(area.width for area in row) + GAP * (len(row) - 1) for row in rows]
    top = height = sum(heights) + GAP * (len(rows) - 1)
    middles = []
    for row, high, wide in zip(rows, heights, widths, strict=True):
        left = -wide / 2
        for area in row:
            middles.append((left + area.width / 2, top - height / 2 - high / 2))
            left += area.width + GAP
        top -= high + GAP
    return middles, (max(widths), height)
