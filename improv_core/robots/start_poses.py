"""Start poses of robots. Those without one in `improv.toml` start in a formation or in rows, inside the walls."""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping

from improv_core.robots.config import Robot
from improv_core.robots.formation import Formation, in_rows
from improv_core.score.motion import Pose

APART = 3.0
"""Meters between robots without a start pose, side by side and from row to row."""
SIDE_BY_SIDE = 8
"""Robots in a row. The others stand behind, so that a whole class can be seen."""
MAX_PLACES = 4_096
"""The most places to search for free ones: every hover needs start poses."""
_TOUCHING = 1 - 1e-9
"""Keeps robots that fill a row from wall to wall from overlapping because of rounding."""


def start_poses(
    robots: Mapping[str, Robot], size: tuple[float, float] | None, formation: Formation | None = None
) -> dict[str, Pose]:
    """Return the start poses, on a floor with walls around it, `size` meters along x and y, or on an endless floor
    (None).

    If the formation or the usual rows don't fit, all robots without a start pose stand around the origin instead, as
    far apart as there is room. They overlap only if no rows have room for all of them.
    """
    poses = {name: robot.start or _usual(place) for place, (name, robot) in enumerate(robots.items())}
    new = [name for name, robot in robots.items() if not robot.start]
    if formation:
        poses.update(zip(new, formation.poses(len(new)), strict=True))
    if not size or not new:
        return poses
    placed = [(poses[name].x, poses[name].y, robots[name].profile.radius) for name in robots.keys() - new]
    radius = max(robots[name].profile.radius for name in new)
    if (not formation and 2 * radius > APART) or not all(_is_free(poses[name], radius, size, placed) for name in new):
        poses.update(zip(new, _rows(len(new), radius, size, placed), strict=True))
    return poses


def _usual(place: int) -> Pose:
    behind, beside = divmod(place, SIDE_BY_SIDE)
    return Pose(0 - APART * behind, 0 - APART * beside)  # -0.0 would look odd


def _rows(
    robots: int, radius: float, size: tuple[float, float], placed: Collection[tuple[float, float, float]]
) -> list[Pose]:
    """Return places on a floor where the usual ones are not free. They overlap only if no rows have room for all."""
    count = robots
    while True:
        room, places = _grid(count, radius, size)
        if room < 2 * radius * _TOUCHING or count > max(MAX_PLACES, 2 * robots):
            return [_inside(pose, radius, size) for pose in _grid(robots, radius, size)[1]]
        free = [pose for pose in places if _is_free(pose, radius, size, placed)]
        if len(free) >= robots:
            return free[:robots]
        count += robots - len(free) + count // 8  # a few more than needed, to need fewer tries


def _grid(count: int, radius: float, size: tuple[float, float]) -> tuple[float, list[Pose]]:
    """Return this many places around the middle of the floor, and the largest distance between them in meters."""
    most = max(APART, 2 * radius)

    def room(columns: int) -> tuple[float, float]:
        return min(most, size[0] / math.ceil(count / columns)), min(most, size[1] / columns)

    # The most columns that don't reduce the distance, up to the usual number.
    columns = max(range(1, count + 1), key=lambda columns: (min(room(columns)), min(columns, SIDE_BY_SIDE), -columns))
    return min(room(columns)), in_rows(count, columns, *room(columns))


def _inside(pose: Pose, radius: float, size: tuple[float, float]) -> Pose:
    """Return the nearest pose whose disc is inside the walls, if the disc fits on the floor."""
    x, y = (max(length / 2 - radius, 0.0) for length in size)
    return Pose(min(max(pose.x, -x), x), min(max(pose.y, -y), y))


def _is_free(
    pose: Pose, radius: float, size: tuple[float, float], placed: Collection[tuple[float, float, float]]
) -> bool:
    """True if a disc at a pose is inside the walls and overlaps no placed disc (x, y, radius)."""
    least = radius * _TOUCHING
    return (
        abs(pose.x) + least <= size[0] / 2
        and abs(pose.y) + least <= size[1] / 2
        and all(math.dist((pose.x, pose.y), (x, y)) >= least + other * _TOUCHING for x, y, other in placed)
    )
