"""Simulated robots: discs that follow their velocities exactly and push each other apart (pymunk, imported lazily)."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from improv_core.motion import STILL, Pose, Twist
from improv_core.score import Part

if TYPE_CHECKING:
    import pymunk

STEPS_PER_SECOND = 240
OVERLAP = 0.001
"""How deep two robots in contact may rest in each other, in metres; pymunk needs some to keep the contact."""


@dataclass(frozen=True, slots=True)
class Snapshot:
    """What a page draws: poses at `at` seconds of performance, radii in metres. Safe to read from any thread."""

    at: float = 0.0
    poses: Mapping[str, Pose] = field(default_factory=dict)
    radii: Mapping[str, float] = field(default_factory=dict)


@dataclass(slots=True)
class _Robot:
    """A body as the last whole step left it, the height that pymunk lacks, and the twists from then on."""

    body: pymunk.Body
    shape: pymunk.Circle
    z: float
    twists: list[tuple[float, Twist]]
    pushed: bool = False

    def pose(self) -> Pose:
        x, y = self.body.position
        return Pose(x, y, self.z, self.body.angle)

    def driven(self, start: float, end: float) -> Pose:
        """Where its twists alone take it from `start`, where it is now, to `end`."""
        pose, since, held = self.pose(), start, STILL
        for at, twist in self.twists:
            if at >= end:
                break
            if at > since:
                pose, since = pose.after(held, at - since), at
            held = twist
        return pose.after(held, end - since)

    def forget_before(self, time: float) -> None:
        while len(self.twists) > 1 and self.twists[1][0] <= time:
            del self.twists[0]


class Simulator:
    """A sink that moves discs in a plane, in whole steps of 1/240 s counted from beat 0.

    The grid of steps makes the same program give bit-equal poses, however often `advance` is called. In every step a
    body's velocity is the displacement its twists ask for, so a robot that nobody pushes is exactly on its path.
    """

    name: str = "simulator"
    live: bool = False
    period: float | None = 1 / 60

    def __init__(self) -> None:
        self._clear()

    def _clear(self) -> None:
        import pymunk

        self._space = pymunk.Space()
        self._space.collision_slop = OVERLAP
        self._robots: dict[str, _Robot] = {}
        self._steps = 0
        self._now = 0.0
        self._snapshot = Snapshot()

    def prepare(self, parts: Mapping[str, Part], restart: bool) -> None:
        """Put new robots at their starts; with `restart`, start everything afresh at time 0.

        Without `restart`, robots that are already there go on from where they are, also those without a part: whoever
        sends twists stops them, and knows at which exact time.
        """
        if restart:
            self._clear()
        for name, part in parts.items():
            known = self._robots.get(name)
            if known is None:
                self._robots[name] = self._place(part.start, part.profile.radius, [])
            elif known.shape.radius != part.profile.radius:
                self._space.remove(known.body, known.shape)
                self._robots[name] = self._place(known.pose(), part.profile.radius, known.twists)
        self._look()

    def resetting(self) -> bool:
        return False

    def missing(self, robots: Collection[str] | None = None) -> dict[str, str]:
        return {}

    def warnings(self, robots: Collection[str] | None = None) -> dict[str, str]:
        return {}

    def send(self, robot: str, twist: Twist, at: float) -> None:
        """Robots that have left with a restart are told to stop once more; they are no longer there."""
        if robot in self._robots:
            self._robots[robot].twists.append((at, twist))

    def place(self, poses: Mapping[str, Pose]) -> None:
        for name, pose in poses.items():
            robot = self._robots[name]
            robot.body.position, robot.body.angle, robot.z = (pose.x, pose.y), pose.heading, pose.z
            robot.body.velocity, robot.body.angular_velocity = (0.0, 0.0), 0.0
            robot.twists = []  # what it was told elsewhere no longer moves it, not even for the rest of this step
            self._space.reindex_shapes_for_body(robot.body)
        self._look()

    def advance(self, to: float) -> None:
        """Do every whole step that ends by `to`; the rest of the way only shows in `poses`."""
        while (self._steps + 1) / STEPS_PER_SECOND <= to:
            self._step()
        self._now = to
        self._look()

    def poses(self) -> dict[str, Pose]:
        """The poses at exactly the time of the latest `advance`."""
        return dict(self._snapshot.poses)

    def snapshot(self) -> Snapshot:
        """The state after the latest `advance` or `prepare`; may be called from any thread."""
        return self._snapshot

    def close(self) -> None:
        """Nothing to let go of; a page still sees the last poses."""

    def _place(self, pose: Pose, radius: float, twists: list[tuple[float, Twist]]) -> _Robot:
        import pymunk

        body = pymunk.Body(mass=1.0, moment=pymunk.moment_for_circle(1.0, 0.0, radius))
        body.position = (pose.x, pose.y)
        body.angle = pose.heading
        # pymunk moves bodies first and solves contacts after; `_step` moves them after, so that the velocities it
        # sets are solved before they are used, and nobody drives into a robot that is in the way.
        body.position_func = _stay
        shape = pymunk.Circle(body, radius)  # pymunk's defaults: no friction, no bounce, so a push never turns
        self._space.add(body, shape)
        return _Robot(body, shape, pose.z, twists)

    def _step(self) -> None:
        start, end, dt = self._steps / STEPS_PER_SECOND, (self._steps + 1) / STEPS_PER_SECOND, 1 / STEPS_PER_SECOND
        wanted = {}
        for name, robot in self._robots.items():
            before, after = robot.pose(), robot.driven(start, end)
            wanted[name] = ((after.x - before.x) / dt, (after.y - before.y) / dt)
            robot.body.velocity = wanted[name]
            robot.body.angular_velocity = (after.heading - before.heading) / dt
            robot.z = after.z
        self._space.step(dt)
        for name, robot in self._robots.items():
            robot.pushed = tuple(robot.body.velocity) != wanted[name]
            robot.body.update_position(robot.body, dt)
            robot.forget_before(end)
        self._steps += 1

    def _look(self) -> None:
        """Swap in a new snapshot: one assignment, so another thread sees the old one or the new one."""
        self._snapshot = Snapshot(
            self._now,
            {name: self._partly(robot) for name, robot in self._robots.items()},
            {name: robot.shape.radius for name, robot in self._robots.items()},
        )

    def _partly(self, robot: _Robot) -> Pose:
        """The pose at the present moment, which lies between the last whole step and the next."""
        start = self._steps / STEPS_PER_SECOND
        pose = robot.driven(start, self._now)
        if not robot.pushed:
            return pose
        # Its own twists would take it into the robot it touches: it goes on as in the last step.
        at, velocity = robot.body.position, robot.body.velocity
        seconds = self._now - start
        return Pose(at.x + velocity.x * seconds, at.y + velocity.y * seconds, pose.z, pose.heading)


def _stay(body: pymunk.Body, dt: float) -> None:
    """A position function that leaves the body where it is."""
