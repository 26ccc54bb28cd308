"""Simulated robots: discs that follow their setpoints, push each other, and bump into things."""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Callable, Collection, Mapping
from itertools import pairwise
from threading import Lock

from improv_core.outputs.simulator.collisions import Collisions, NoCollisions, Pushed
from improv_core.outputs.simulator.robot import SimulatedJoints, SimulatedRobot, Trail
from improv_core.outputs.simulator.senses import SimulatedSenses
from improv_core.protocol.drawn import Bump, Snapshot
from improv_core.protocol.output import Edge, Sink
from improv_core.score.dynamics import STEPS_PER_SECOND, Motion, Motors, moving
from improv_core.score.joints import JointMotion
from improv_core.score.motion import STILL, Pose, Twist
from improv_core.score.score import Score
from improv_core.score.senses import RobotSense
from improv_core.score.world import World

LOOK = 24
"""Steps between two searches for what is near (0.1 s). A robot that can't touch anything until then isn't pushed."""
MARGIN = 0.05
"""Extra meters that count as near, because pushing can make robots faster."""
MAX_PARTS = 16
"""The most parts of a step. Steps are divided so that fast or small discs move at most half their radius at once."""
BUMPS_KEPT = 200


class Simulator(Sink):
    """A sink that moves discs in a world of walls and obstacles.

    Robots that are near nothing move on exact arcs, without steps. Robots that could touch something are pushed in
    whole steps of 1/240 s counted from beat 0, divided into equal parts if one is fast. Only robots that are really
    pushed leave their arcs. The search for nearby robots also runs only at whole steps. So the same program gives
    bit-identical poses, no matter how often `advance` is called.
    """

    name = "simulator"
    real = False

    def __init__(self, period: float | None = 1 / 60, collide: Callable[[World], NoCollisions] = Collisions) -> None:
        self.period = period
        self.label: Callable[[str], str] = str
        """Returns the name that people read for a robot."""
        self._collide = collide
        self._collisions = collide(World())
        self._lock = Lock()  # any thread may read poses
        self._placed = 0
        self._clear(World())

    def _clear(self, world: World) -> None:
        self._world, self._is_new_world = world, True
        self._robots: dict[str, SimulatedRobot] = {}
        self._senses = SimulatedSenses(world, self._robots)
        self._awake: list[str] = []  # robots near something
        self._fastest = 0.0  # m/s, of all setpoints so far
        self._faster: deque[tuple[float, float]] = deque()  # when that increases, and the new value
        self._steps = 0
        self._look_again = 0
        self._now = 0.0
        self._bumps: deque[Bump] = deque(maxlen=BUMPS_KEPT)
        self._met: dict[str, dict[str, None]] = {}

    def prepare(self, score: Score, restart: bool) -> None:
        """Put new robots at their start poses. With `restart`, start everything over at time 0.

        Without `restart`, existing robots continue from where they are, including those without a part: the sender of
        twists stops them at the exact time.
        """
        with self._lock:
            if restart:
                self._clear(score.world)
                self._placed += 1
            elif score.world != self._world:
                self._world, self._is_new_world = score.world, True
                self._senses = SimulatedSenses(score.world, self._robots)
            for name, part in score.parts.items():
                if known := self._robots.get(name):
                    known.become(part)
                else:
                    motion, trail = Motion(self._now, part.start), Trail(self._now, part.start)
                    self._robots[name] = SimulatedRobot(part, motion, trail, SimulatedJoints(part.profile.body))
            self._look_soon()

    def warnings(self, robots: Collection[str] | None = None) -> dict[str, str]:
        """The bumps so far, as one line per robot, under the robot whose name comes first."""
        return {
            name: f"{self.label(name)} bumped into {_listed([*map(self.label, met)])}: {_advice(met, self._robots)}"
            for name in (self._met if robots is None else robots)
            if (met := self._met.get(name))
        }

    def send(self, robot: str, twist: Twist, at: float) -> None:
        """Queue a twist. Ignore robots that a restart has removed: their stops still arrive here."""
        known = self._robots.get(robot)
        if known is None or known.commanded == twist:
            return
        speed = math.hypot(twist.x, twist.y)
        with self._lock:
            known.commanded = twist
            known.setpoints.append((at, twist))
            if speed > (self._faster[-1][1] if self._faster else self._fastest):
                self._faster.append((at, speed))

    def send_joints(
        self, robot: str, joints: Mapping[str, JointMotion], at: float, pace: float = 1.0, until: float = math.inf
    ) -> None:
        """Queue a movement of joints. Ignore robots that a restart has removed."""
        if known := self._robots.get(robot):
            with self._lock:
                known.joints.tell(joints, at)

    def place(self, poses: Mapping[str, Pose]) -> None:
        with self._lock:
            for name, pose in poses.items():
                robot = self._robots[name]
                # Setpoints from before no longer apply.
                robot.motion, robot.commanded, robot.trail = Motion(self._now, pose), STILL, Trail(self._now, pose)
                robot.pushed, robot.bumped = None, False
                robot.setpoints.clear()
            self._placed += 1
            self._look_soon()

    def advance(self, to: float, asked: Collection[RobotSense] = ()) -> list[Edge]:
        """Run every whole step that ends by `to`, unless a sense in `asked` changes before. Returns the sorted edges.
        The time since the last whole step shows only in `poses`.

        A sense that wasn't in the last call gives an edge at once. The others are computed after every whole step, so
        the same program gives the same edges, no matter how often this is called. Keys and cues are left out: they come
        from people.
        """
        with self._lock:
            if not asked and to <= self._now:  # nothing can change, and the senses of the last call stay watched
                return []
            return self._senses.ask(asked, self._now) or self._run(to)

    def coasting(self) -> bool:
        return any(robot.ahead(self._now).twist != STILL for robot in self._robots.values() if robot.motors)

    def poses(self) -> dict[str, Pose]:
        """The poses at the exact time of the latest `advance`."""
        return dict(self.snapshot().poses)

    def snapshot(self) -> Snapshot:
        """The state after the latest `advance` or `prepare`; may be called from any thread."""
        with self._lock:
            for robot in self._robots.values():
                robot.leave_trail(self._now)
            return Snapshot(
                self._now,
                self._placed,
                {name: robot.pose_at(self._now) for name, robot in self._robots.items()},
                {name: robot.disc.radius for name, robot in self._robots.items()},
                {name: robot.trail for name, robot in self._robots.items()},
                tuple(self._bumps),
                {name: robot.joints.positions(self._now) for name, robot in self._robots.items() if robot.joints.body},
            )

    def _run(self, to: float) -> list[Edge]:
        """Run whole steps until `to`, or until a watched sense changes."""
        last = _whole_steps(to)
        while self._steps < last:
            end = (self._steps + 1) / STEPS_PER_SECOND
            while self._faster and self._faster[0][0] < end:
                _, self._fastest = self._faster.popleft()
                self._look_again = self._steps
            if self._steps >= self._look_again:
                self._look()
            if self._awake:
                self._step()
            elif self._senses.could_change(self._steps / STEPS_PER_SECOND):
                self._steps += 1
            else:
                self._steps = min(last, self._look_again, self._next_rise())
            self._now = self._steps / STEPS_PER_SECOND
            if edges := self._senses.changes(self._now):
                return edges
        self._now = to
        return []

    def _next_rise(self) -> int:
        """The step in which a robot becomes faster than all robots so far."""
        if not self._faster:
            return self._steps + LOOK
        return max(_whole_steps(self._faster[0][0]), self._steps + 1)

    def _look_soon(self) -> None:
        """Search again at the next step: robots were moved, or the score changed."""
        self._look_again = self._steps
        self._senses.jump()

    def _look(self) -> None:
        """Find the robots that could touch something before the next search."""
        now = self._steps / STEPS_PER_SECOND
        if self._is_new_world:  # only now: the first velocities don't wait for it
            self._collisions, self._is_new_world = self._collide(self._world), False
        self._look_again = self._steps + LOOK
        reach = self._fastest * LOOK / STEPS_PER_SECOND + MARGIN
        self._senses.look(reach)
        circles = {}
        for name, robot in self._robots.items():
            robot.mark(now)
            robot.settle(now)
            pose = robot.pose_at(now)
            circles[name] = (pose.x, pose.y, robot.disc.radius + reach)
        near = _near(circles)
        near |= {name for name, circle in circles.items() if self._collisions.near_obstacle(*circle)}
        self._awake = [name for name in self._robots if name in near]
        self._collisions.keep({name: self._robots[name].disc for name in self._awake})
        for name in self._robots.keys() - near:
            self._robots[name].pushed, self._robots[name].bumped = None, False

    def _step(self) -> None:
        start, end = self._steps / STEPS_PER_SECOND, (self._steps + 1) / STEPS_PER_SECOND
        paths = self._paths(start, end)
        parts = self._parts(paths)
        if parts == 1:
            self._push(paths, start, end)
        else:
            times = [start, *((self._steps + part / parts) / STEPS_PER_SECOND for part in range(1, parts)), end]
            for since, until in pairwise(times):
                self._push(self._paths(since, until), since, until)
        for bump in self._collisions.take_bumps():
            self._bumps.append(bump)
            first, *others = bump.robots
            self._met.setdefault(first, {}).update(dict.fromkeys(others or [bump.thing]))
        pressed, touching = self._collisions.take_contacts()
        for name in self._awake:
            robot = self._robots[name]
            stands = robot.bumped and name in touching and robot.ahead(end).twist == STILL
            robot.bumped = name in pressed or stands
        self._steps += 1

    def _paths(self, start: float, end: float) -> dict[str, tuple[Pose, Pose]]:
        """The start and end poses that the robots near something would have if nothing pushed them."""
        robots = {name: self._robots[name] for name in self._awake}
        return {name: (robot.pose_at(start), robot.ahead(end).pose_at(end)) for name, robot in robots.items()}

    def _parts(self, paths: Mapping[str, tuple[Pose, Pose]]) -> int:
        """The number of parts to divide a step into, so that no robot moves farther than half its radius in one."""
        farthest = max(
            math.dist((before.x, before.y, before.z), (after.x, after.y, after.z)) / self._robots[name].disc.radius
            for name, (before, after) in paths.items()
        )
        return max(1, min(MAX_PARTS, math.ceil(2 * farthest)))

    def _push(self, paths: Mapping[str, tuple[Pose, Pose]], start: float, end: float) -> None:
        pushed = self._collisions.push(paths, start, end)
        for name in paths:
            robot = self._robots[name]
            before, robot.pushed = robot.pushed, pushed.get(name)
            if bool(before) != bool(robot.pushed):
                robot.trail.add(start, paths[name][0])
            if robot.pushed:
                robot.settle(end)
                robot.motion = _after_push(robot.motion, robot.pushed, end, robot.motors)


def _whole_steps(time: float) -> int:
    """The number of steps that have ended by `time`, even if the product is rounded."""
    steps = math.floor(time * STEPS_PER_SECOND)
    if (steps + 1) / STEPS_PER_SECOND <= time:
        return steps + 1
    return steps - 1 if steps / STEPS_PER_SECOND > time else steps


def _after_push(motion: Motion, pushed: Pushed, at: float, motors: Motors | None) -> Motion:
    """The motion from the pose that it was pushed to. A robot with motors has to speed up again."""
    if not motors:
        return Motion(at, pushed.pose, motion.commanded, motion.commanded)
    cos, sin = math.cos(pushed.pose.heading), math.sin(pushed.pose.heading)
    twist = Twist(cos * pushed.x + sin * pushed.y, cos * pushed.y - sin * pushed.x, motion.twist.z, pushed.yaw)
    return moving(at, pushed.pose, twist, motion.commanded, motors)


def _near(circles: Mapping[str, tuple[float, float, float]]) -> set[str]:
    """The circles (x, y, radius) that overlap another one. Along the axis on which they spread more, each is compared
    only with those that begin between its beginning and its end."""
    near: set[str] = set()
    if not circles:
        return near
    widths = [max(each) - min(each) for each in zip(*circles.values(), strict=True)]
    axis = int(widths[1] > widths[0])
    begins = sorted((circle[axis] - circle[2], name) for name, circle in circles.items())
    for place, (_, one) in enumerate(begins):
        x, y, radius = circle = circles[one]
        end = circle[axis] + radius
        for number in range(place + 1, len(begins)):
            begin, other = begins[number]
            if begin > end:
                break
            x2, y2, radius2 = circles[other]
            if math.hypot(x - x2, y - y2) < radius + radius2:
                near |= {one, other}
    return near


def _advice(met: Collection[str], robots: Collection[str]) -> str:
    if all(name in robots for name in met):
        return "start them farther apart or change their paths"
    return "change its start or its path" if len(met) == 1 else "change their starts or their paths"


def _listed(names: Collection[str]) -> str:
    *first, last = names
    return f"{', '.join(first)} and {last}" if first else last
