"""Joints perform a program through a trajectory controller whose messages may be late, by a clock of its own."""

from __future__ import annotations

import math
from bisect import bisect_right
from collections import deque
from collections.abc import Callable, Sequence
from itertools import pairwise

from improv_core.outputs.ros.joints.channels import Channel
from improv_core.outputs.ros.joints.trajectories import leaves_out, standing, trajectory, turned
from improv_core.score.joints import JointMotion
from tests.ros.controller import TrajectoryController

TICK = 0.001
"""Seconds between two looks at the controller."""
REPEAT = 0.05
"""Seconds between two messages that repeat a velocity."""
Program = Sequence[tuple[float, Sequence[float]]]
"""The velocities of joints from a time on; the last ones are zeros."""
Passed = Sequence[Sequence[tuple[float, float]]]
"""The positions and velocities of a controller's joints at each tick, from 1 s on."""


def steepest(passed: Passed, joint: int) -> float:
    """The largest acceleration of a joint."""
    return max(abs(after[joint][1] - before[joint][1]) / TICK for before, after in pairwise(passed))


def dance(
    channel: Channel,
    program: Program,
    late: Callable[[int], float] = lambda number: 0.0,
    begin: float = 0.0,
    seconds: float = 3.0,
    stop: float = math.inf,
) -> Passed:
    """Have joints at their starts perform a program until a stop; each message of a number is this many seconds late.

    Performance time is the program's, and `begin` later.
    """
    joints = channel.joints
    names, starts = [joint.name for joint in joints], [joint.start for joint in joints]
    made, now = TrajectoryController(names, [*starts]), standing(channel, dict(zip(names, starts, strict=True)))
    times, places = [at for at, _ in program], [starts]
    for (at, speeds), (end, _) in pairwise(program):
        places.append([place + speed * (end - at) for place, speed in zip(places[-1], speeds, strict=True)])

    def line(time: float) -> Sequence[JointMotion]:
        """Return the places of joints in the program at a time, and their velocities from then on."""
        number = bisect_right(times, time) - 1
        if number < 0:
            return [JointMotion(start, 0.0) for start in starts]
        pairs, passed = zip(places[number], program[number][1], strict=True), time - times[number]
        return [JointMotion(place + speed * passed, speed) for place, speed in pairs]

    commands = sorted({*times, *(each for pair in pairwise(times) for each in _repeated(*pair)), stop} - {math.inf})
    arrivals = deque(sorted((at + late(number), at) for number, at in enumerate(commands) if at <= stop))
    ticks = [1 + count * TICK for count in range(round(seconds / TICK))]
    passed = []
    for time in ticks:
        while arrivals and arrivals[0][0] <= time:
            arrived, at = arrivals.popleft()
            motions = [JointMotion(place, speed if at < stop else 0.0) for place, speed in line(at)]
            until = next((begin + each for each in times if each > at), math.inf) if at < stop else begin + at
            course = turned(channel, now, dict(zip(names, motions, strict=True)), begin + at, arrived - at, until)
            if not leaves_out(now, course, begin + arrived):
                made.take(names, [*trajectory(channel, now := course)], begin + arrived)
        passed.append(made.states(begin + time))
    assert not made.refused
    return passed


def _repeated(at: float, end: float) -> list[float]:
    """The times at which a velocity is sent again until the next one."""
    return [at + count * REPEAT for count in range(1, math.ceil((end - at) / REPEAT - 1e-9))]
