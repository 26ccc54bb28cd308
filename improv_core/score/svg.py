"""Draws a dance as SVG: each robot's ideal path from above, also from the side if one climbs, and a timeline.

Standard library only.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from html import escape
from typing import NamedTuple

from improv_core.score.joint_charts import MIN_WIDTH, charts, curves
from improv_core.score.meetings import Meeting
from improv_core.score.moment_bars import bars, drawn_beats
from improv_core.score.motion import Pose
from improv_core.score.prediction import Prediction
from improv_core.score.score import Score
from improv_core.score.strokes import ENDLESS_BEATS, MAX_MOMENTS, Path, Stroke, apex, outermost, paths, pictured
from improv_core.score.world import Box, World

COLORS = ("#e8590c", "#1c7ed6", "#2f9e44", "#9c36b5", "#c78100", "#d6336c", "#0c8599", "#8d6e58")
"""The robots' colors, in order. All are easy to tell apart on white and on near-black."""
SIZE = 240.0
"""The longer side of a small picture, in pixels."""
LARGE = 720.0
"""The longer side of a plot, in pixels."""
_MARGIN = 26.0  # room for names


def picture(
    score: Score, size: float = SIZE, most_moments: int = MAX_MOMENTS, prediction: Prediction | None = None
) -> str:
    """Return an SVG of only the paths, their starts, and ends; under 20 KB for one robot. Senses are as predicted."""
    drawn = paths(score, most_moments, prediction)
    frame = _Frame.around((point for path in drawn for point in outermost(path)), size, _heights(drawn))
    below, height = _from_the_side(drawn, frame)
    return _svg(frame.width, height, "The ideal path", [*_paths(drawn, frame), *below])


def plot(
    score: Score,
    timeline: bool = False,
    most_moments: int = MAX_MOMENTS,
    size: float = LARGE,
    meetings: Sequence[Meeting] = (),
    prediction: Prediction | None = None,
) -> str:
    """Return a large SVG of the paths, the world, names, and a scale on white, with two discs wherever robots meet.
    Below it are a chart of each joint that moves, and the timeline if asked for. Senses are as the prediction says."""
    drawn = paths(score, most_moments, prediction, _STROKES_OF_A_PLOT)
    points = [point for path in drawn for point in outermost(path)]
    beats = drawn_beats(prediction.score if prediction else score)
    joints = curves(pictured(score), beats, most_moments)
    wide = size - 2 * _MARGIN if timeline else MIN_WIDTH if joints else 0.0  # beats and names of scenes need room
    frame = _Frame.around([*points, *_outline(score.world)], size, _heights(drawn), wide)
    below, height = _from_the_side(drawn, frame)
    parts = [*_obstacles(score.world, frame), *_paths(drawn, frame), *_named(drawn, frame)]
    parts += [*_discs(score, meetings, frame), *below]
    parts.append(_scale(frame, height))
    if extent := _extent(drawn, prediction):
        right = _number(frame.width - _MARGIN)
        parts.append(f'<text x="{right}" y="{_number(height + 24)}" text-anchor="end" fill="{_QUIET}">{extent}</text>')
    height += 28
    colors = {name: _color(place) for place, name in enumerate(score.parts)}
    if joints:
        drawings, charts_height = charts(joints, colors, beats, _MARGIN, height + 8, frame.width - 2 * _MARGIN)
        parts += drawings
        height += charts_height + 8
    if timeline:
        shown = prediction.score if prediction else score
        rows, rows_height = bars(shown, colors, _MARGIN, height + 8, frame.width - 2 * _MARGIN)
        parts.append(rows)
        height += rows_height + 8
    ground = f'<path d="M0 0H{_number(frame.width)}V{_number(height)}H0Z" fill="{_GROUND}"/>'
    return _svg(frame.width, height, "The ideal paths", [ground, *parts])


@dataclass(frozen=True, slots=True)
class _Frame:
    """A conversion from meters to pixels: x to the right, and y up or, seen `from_the_side`, z."""

    left: float
    top: float
    scale: float
    width: float
    height: float
    from_the_side: bool = False

    @classmethod
    def around(
        cls, points: Iterable[tuple[float, float]], size: float, heights: tuple[float, float], wide: float = 0.0
    ) -> _Frame:
        """Return a frame for points seen from above, at least so wide: paths between two heights must fit, too."""
        (left, right), (bottom, top) = (
            (min(axis), max(axis)) for axis in zip(*(list(points) or [(0.0, 0.0)]), strict=True)
        )
        longer = max(right - left, top - bottom, heights[1] - heights[0], 0.5)
        scale = (size - 2 * _MARGIN) / longer
        width, height = (max(span * scale, size / 4) + 2 * _MARGIN for span in (right - left, top - bottom))
        width = max(width, wide + 2 * _MARGIN)
        # Center the drawing if it is narrow.
        return cls(
            left - ((width - 2 * _MARGIN) / scale - (right - left)) / 2,
            top + ((height - 2 * _MARGIN) / scale - (top - bottom)) / 2,
            scale,
            width,
            height,
        )

    def below(self, bottom: float, top: float) -> _Frame:
        """Return the frame for the same paths from the side, between two heights in meters."""
        return replace(self, top=top, height=(top - bottom) * self.scale + 2 * _MARGIN, from_the_side=True)

    def pixel(self, x: float, y: float) -> tuple[float, float]:
        return (x - self.left) * self.scale + _MARGIN, (self.top - y) * self.scale + _MARGIN

    def place(self, x: float, y: float) -> str:
        return " ".join(map(_number, self.pixel(x, y)))

    def place_of(self, pose: Pose) -> str:
        return self.place(pose.x, pose.z if self.from_the_side else pose.y)


def _outline(world: World) -> Iterator[tuple[float, float]]:
    """Yield points that mark the extent of a world."""
    for x1, y1, x2, y2 in world.all_walls():
        yield from ((x1, y1), (x2, y2))
    for x, y, radius in world.circles:
        yield from ((x - radius, y - radius), (x + radius, y + radius))
    for box in world.boxes:
        yield from _corners(box)


def _corners(box: Box) -> Iterator[tuple[float, float]]:
    cos, sin = math.cos(box.heading), math.sin(box.heading)
    for along, across in ((-1, -1), (1, -1), (1, 1), (-1, 1)):
        x, y = along * box.width / 2, across * box.height / 2
        yield box.x + cos * x - sin * y, box.y + sin * x + cos * y


def _obstacles(world: World, frame: _Frame) -> list[str]:
    parts = []
    if walls := "".join(f"M{frame.place(x1, y1)}L{frame.place(x2, y2)}" for x1, y1, x2, y2 in world.all_walls()):
        parts.append(f'<path d="{walls}" stroke="{_QUIET}" stroke-width="3" stroke-linecap="round"/>')
    for x, y, radius in world.circles:
        across, down = frame.place(x, y).split()
        parts.append(f'<circle cx="{across}" cy="{down}" r="{_number(radius * frame.scale)}" fill="{_QUIET}"/>')
    boxes = ("L".join(frame.place(*corner) for corner in _corners(box)) for box in world.boxes)
    return parts + [f'<path d="M{corners}Z" fill="{_QUIET}"/>' for corners in boxes]


def _discs(score: Score, meetings: Sequence[Meeting], frame: _Frame) -> Iterator[str]:
    """Yield the discs of robots that meet, as they stand then, with the beat in a tooltip."""
    colors = {name: _color(place) for place, name in enumerate(score.parts)}
    for meeting in meetings:
        shapes = [f"<title>{escape(' and '.join(meeting.robots))} meet at beat {meeting.beat + 1:.2f}</title>"]
        for name, pose in zip(meeting.robots, meeting.poses, strict=True):
            across, down = frame.place(pose.x, pose.y).split()
            radius = _number(score.parts[name].profile.radius * frame.scale)
            shapes.append(f'<circle cx="{across}" cy="{down}" r="{radius}" fill="{colors[name]}" fill-opacity="0.3"/>')
        yield f'<g stroke="#e03131" stroke-width="1.5">{"".join(shapes)}</g>'


def _paths(drawn: Sequence[Path], frame: _Frame) -> list[str]:
    """Return the SVG group of each robot: path, ring at the start, arrow at the end (from the side, a dot)."""
    groups = []
    for place, path in enumerate(drawn):
        shapes = _line(path.strokes[: path.certain], frame) + _line(path.strokes[path.certain :], frame, _DASHES)
        shapes += _dot(path.start, frame, _RING)  # an arrow that ends here still shows it
        filled = f'fill="{_color(place)}" stroke="none"'
        if frame.from_the_side:
            shapes += _dot(path.end, frame, _DOT, f" {filled}")
        else:
            shapes += f'<path d="{_arrow(path.end, frame)}" {filled}/>'
        dashes = "" if path.whole else _DASHES
        joined = 'stroke-linejoin="round" stroke-linecap="round"'
        groups.append(f'<g fill="none" stroke="{_color(place)}" stroke-width="2" {joined}{dashes}>{shapes}</g>')
    return groups


def _color(place: int) -> str:
    return COLORS[place % len(COLORS)]


_DASHES = ' stroke-dasharray="6 3"'
_STROKES_OF_A_PLOT = 4_000
"""The most lines and arcs of a path in a plot."""


def _heights(drawn: Sequence[Path]) -> tuple[float, float]:
    """Return the heights of the lowest point and the highest, in meters."""
    heights = [0.0, *(pose.z for path in drawn for stroke in path.strokes for pose in (stroke.start, stroke.end))]
    return min(heights), max(heights)


def _from_the_side(drawn: Sequence[Path], above: _Frame) -> tuple[list[str], float]:
    """Return the paths from the side, below those from above, if one climbs, and the height of both in pixels."""
    lowest, highest = _heights(drawn)
    if lowest == highest:
        return [], above.height
    frame = above.below(lowest, highest)
    _, floor = frame.pixel(0, 0)
    ground = f'<path d="M0 {_number(floor)}H{_number(frame.width)}" stroke="{_QUIET}"/>'
    parts = [ground, f'<text x="4" y="12" fill="{_QUIET}">from the side</text>', *_paths(drawn, frame)]
    down = _number(above.height)
    return [f'<g transform="translate(0 {down})">{"".join(parts)}</g>'], above.height + frame.height


def _dot(pose: Pose, frame: _Frame, radius: float, style: str = "") -> str:
    x, y = frame.place_of(pose).split()
    return f'<circle cx="{x}" cy="{y}" r="{radius:g}"{style}/>'


def _line(strokes: Sequence[Stroke], frame: _Frame, style: str = "") -> str:
    """Return strokes as one SVG path, without those that coincide in this view."""
    line, at, drawn = [], None, set[tuple[str, str]]()
    for stroke in strokes:
        start, end = frame.place_of(stroke.start), frame.place_of(stroke.end)
        shape = f"L{end}"
        if stroke.radius and not frame.from_the_side:
            radius = _number(stroke.radius * frame.scale)
            shape = f"A{radius} {radius} 0 0 {0 if stroke.turn > 0 else 1} {end}"
        if (start, shape) in drawn or start == end:
            continue
        drawn.add((start, shape))
        line.append(shape if start == at else f"M{start}{shape}")
        at = end
    return f'<path d="{"".join(line)}"{style}/>' if line else ""


def _arrow(pose: Pose, frame: _Frame) -> str:
    """Return a small triangle that points in the robot's final direction. It fits into the ring at a start."""
    corners = []
    for angle, far in ((0.0, 9.0), (2.5, 7.0), (-2.5, 7.0)):
        x = pose.x + math.cos(pose.heading + angle) * far / frame.scale
        y = pose.y + math.sin(pose.heading + angle) * far / frame.scale
        corners.append(frame.place(x, y))
    return f"M{corners[0]}L{corners[1]}L{corners[2]}Z"


class _Box(NamedTuple):
    left: float
    top: float
    right: float
    bottom: float

    def overlaps(self, other: _Box) -> bool:
        beside = self.right < other.left or other.right < self.left
        return not beside and not (self.bottom < other.top or other.bottom < self.top)


def _named(drawn: Sequence[Path], frame: _Frame) -> list[str]:
    """The name of each robot near its start: inside the picture, off the paths and the other names if possible."""
    marks = [_Box(x - 2, y - 2, x + 2, y + 2) for path in drawn for x, y in _pixels(path, frame)]
    names = []
    for place, path in enumerate(drawn):
        x, y = frame.pixel(path.start.x, path.start.y)
        wide = _LETTER * len(path.robot)
        boxes = [box for far in _DISTANCES for box in _around(x, y, wide, far)]
        inside = [box for box in boxes if box.left >= 0 and box.top >= 0 and box.right <= frame.width]
        best = min(inside or boxes, key=lambda box: sum(map(box.overlaps, marks)))
        marks += [best] * _OF_A_NAME
        at = f'x="{_number(best.left)}" y="{_number(best.bottom - 3)}"'
        names.append(f'<text {at} fill="{_color(place)}">{escape(path.robot)}</text>')
    return names


def _around(x: float, y: float, wide: float, far: float) -> Iterator[_Box]:
    """Yield the boxes that a text of this width may have around a point, the most usual place first."""
    near = far * 0.7
    for left, top in (
        (x + near, y - near - _LINE),
        (x + near, y + near),
        (x - near - wide, y - near - _LINE),
        (x - near - wide, y + near),
        (x + far, y - _LINE / 2),
        (x - far - wide, y - _LINE / 2),
        (x - wide / 2, y - far - _LINE),
        (x - wide / 2, y + far),
    ):
        yield _Box(left, top, left + wide, top + _LINE)


def _pixels(path: Path, frame: _Frame) -> Iterator[tuple[float, float]]:
    """Yield points along a path, a few pixels apart."""
    yield frame.pixel(path.start.x, path.start.y)
    yield frame.pixel(path.end.x, path.end.y)
    for stroke in path.strokes:
        (x0, y0), (x1, y1) = frame.pixel(stroke.start.x, stroke.start.y), frame.pixel(stroke.end.x, stroke.end.y)
        middle = frame.pixel(*apex(stroke)) if stroke.radius else ((x0 + x1) / 2, (y0 + y1) / 2)
        count = max(math.ceil(math.dist((x0, y0), (x1, y1)) / 4), 4)
        for share in (number / count for number in range(count + 1)):
            # The parabola through both ends and the middle is close enough to the arc.
            across = 4 * share * (1 - share)
            yield (
                x0 + (x1 - x0) * share + (middle[0] - (x0 + x1) / 2) * across,
                y0 + (y1 - y0) * share + (middle[1] - (y0 + y1) / 2) * across,
            )


def _extent(drawn: Sequence[Path], prediction: Prediction | None) -> str:
    """Return which beats the paths show, if they continue after these."""
    if all(path.whole for path in drawn):
        return ""
    if prediction and prediction.cut is not None:
        return f"the first {float(prediction.cut):.0f} beats"
    lasts = all(path.whole or path.endless for path in drawn)
    return f"the first {ENDLESS_BEATS} beats" if lasts else "only the beginning"


def _scale(frame: _Frame, top: float) -> str:
    """Return a bar of a round length in meters, about a quarter of the picture's width."""
    about = frame.width / frame.scale / 4
    power = 10.0 ** math.floor(math.log10(about))
    meters = max(step * power for step in (1, 2, 5) if step * power <= about)
    y, right = _number(top + 10), _number(_MARGIN + meters * frame.scale)
    label = f'<text x="{_MARGIN:g}" y="{_number(top + 24)}" fill="{_QUIET}">{meters:g} m</text>'
    return f'<path d="M{_MARGIN:g} {y}H{right}" stroke="{_QUIET}" stroke-width="2"/>{label}'


_QUIET = "#808080"
_FONTS = "Arial, Helvetica, Liberation Sans, DejaVu Sans, Noto Sans, sans-serif"
"""Names of fonts: the PNG renderer doesn't look for another font if it has none with the name sans-serif."""
_GROUND = "#ffffff"
_RING = 9.0
"""The radius of the ring at a start, in pixels."""
_DOT = 4.0
"""The radius of the dot at an end, from the side."""
_LETTER, _LINE = 7.5, 15.0
"""The approximate width of a letter of a name, and the height of a line."""
_DISTANCES = (13.0, 19.0, 28.0)
"""Pixels between a start and a name."""
_OF_A_NAME = 50
"""The number of points of a path that count as much as a name."""


def _svg(width: float, height: float, title: str, parts: Sequence[str]) -> str:
    wide, high = _number(width), _number(height)
    head = f'<svg xmlns="http://www.w3.org/2000/svg" width="{wide}" height="{high}" viewBox="0 0 {wide} {high}"'
    return f'{head} role="img" font-family="{_FONTS}" font-size="12"><title>{title}</title>{"".join(parts)}</svg>\n'


def _number(value: float) -> str:
    return f"{value:.1f}".removesuffix(".0")
