"""Random dances and the meetings in them, found by moving all robots a millisecond at a time.

Nothing here computes an arc or a distance as the check does: the poses come from the segments of `improv compile`, and
between two milliseconds each robot moves straight in the direction that it has halfway.

`python -m tests.score.brute_force 200` compares the check with it, and prints the dances that it tried.
"""

from __future__ import annotations

import math
import sys
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import combinations
from random import Random
from typing import Any, NamedTuple

from improv_core.program.analysis import Analysis, analyze
from improv_core.program.compiler import compiled, score_of
from improv_core.robots.config import read_robots
from improv_core.score.meetings import RoomCheck, check_room
from improv_core.score.score import Score

STEP = 0.001
"""Seconds."""
TOLERANCE = 0.001
"""Meters: the law's."""
TOO_CLOSE_TO_CALL = 0.002
"""Meters from the bound within which two may be found to meet or not."""
SAME_BEAT = 0.01
MAX_BEATS = 24
_WORDS = (
    *("forward", "forward", "backward", "left", "right", "halfleft", "halfright"),
    *("strafeleft", "straferight", "rest"),
)


def disagreements(seed: int, beats: int = MAX_BEATS) -> list[str]:
    """Return the differences between the check and brute force about the first beats of a random dance."""
    program, toml = random_dance(seed)
    analysis = analyze(program, read_robots(toml))
    assert analysis.ok, (program, toml, analysis.diagnostics, analysis.config.diagnostics)
    score = score_of(analysis)
    checked = check_room(score)
    found = {each.robots: each.beat for each in checked.meetings}
    found |= {(each.robot, each.thing): each.beat for each in checked.hits}
    last = beats if checked.is_all else min(checked.end, beats)
    wrong = []
    for who, approach in brute_force(analysis, score, last).items():
        beat = found.get(who, math.inf)
        beat = beat if beat <= last else math.inf
        if abs(beat - approach.first) > SAME_BEAT and beat != approach.first and not approach.is_close:
            wrong.append(f"seed {seed}: {who} at {beat}, not {approach.first}")
    return wrong


@dataclass(slots=True)
class Approach:
    """The first beat at which two were too near, and whether they ever turned around within 2 mm of the bound."""

    first: float = math.inf
    is_close: bool = False
    latest: tuple[float, float] = (math.inf, math.inf)

    def add(self, beat: float, over: float) -> None:
        """Add the next distance, by its excess over the bound."""
        before, last = self.latest
        if last < before and last <= over and abs(last) < TOO_CLOSE_TO_CALL:
            self.is_close = True
        self.latest = last, over
        if over < 0 and self.first == math.inf:
            self.first = beat


def brute_force(analysis: Analysis, score: Score, beats: float) -> Mapping[tuple[str, str], Approach]:
    """Return the approach of each pair, and of each robot to each thing in the world."""
    data = compiled(analysis, most_segments=100_000)
    seconds_per_beat = 60 / data["beat"]
    tracks = {name: _track(score, name, data["robots"][name], beats * seconds_per_beat) for name in score.parts}
    found: dict[tuple[str, str], Approach] = {}
    margin = score.world.margin
    for one, other in combinations(tracks, 2):
        near = score.parts[one].profile.radius + score.parts[other].profile.radius
        approach = found[one, other] = Approach()
        for number, (mine, others) in enumerate(zip(tracks[one], tracks[other], strict=True)):
            is_above = abs(mine[2] - others[2]) > near
            far = math.inf if is_above else math.dist(mine[:2], others[:2])
            approach.add(number * STEP / seconds_per_beat, far - near - margin + TOLERANCE)
    for name, track in tracks.items():
        for thing, distance in _things(score):
            approach = found[name, thing] = Approach()
            near = score.parts[name].profile.radius + margin
            for number, (x, y, _) in enumerate(track):
                approach.add(number * STEP / seconds_per_beat, distance(x, y) - near + TOLERANCE)
    return found


def _track(score: Score, name: str, robot: Mapping[str, Any], seconds: float) -> Sequence[tuple[float, float, float]]:
    pose = score.parts[name].start
    x, y, z, heading = pose.x, pose.y, pose.z, pose.heading
    places = [(x, y, z)]
    segments = iter([*robot["segments"], (math.inf, math.inf, 0.0, 0.0, 0.0, 0.0)])
    start, lasts, *velocity = next(segments)
    now = 0.0
    for number in range(1, int(seconds / STEP) + 1):
        until = number * STEP
        while now < until:
            while start + lasts <= now + 1e-12:
                start, lasts, *velocity = next(segments)
            end = min(until, start + lasts if start <= now else start)
            ahead, left, up, turn = velocity if start <= now else (0.0, 0.0, 0.0, 0.0)
            passed, halfway = end - now, heading + turn * (end - now) / 2
            x += (math.cos(halfway) * ahead - math.sin(halfway) * left) * passed
            y += (math.sin(halfway) * ahead + math.cos(halfway) * left) * passed
            z, heading, now = z + up * passed, heading + turn * passed, end
        places.append((x, y, z))
    return places


def _things(score: Score) -> list[Any]:
    world = score.world
    found: list[Any] = []
    for number, circle in enumerate(world.circles, 1):
        found.append((f"circle {number}", lambda x, y, c=circle: math.dist((x, y), (c.x, c.y)) - c.radius))
    for number, wall in enumerate(world.walls, 1):
        ends = [complex(wall.x1, wall.y1), complex(wall.x2, wall.y2)]
        found.append((f"wall {number}", lambda x, y, ends=ends: _to_polygon(complex(x, y), ends)))
    for number, box in enumerate(world.boxes, 1):
        turned = complex(math.cos(box.heading), math.sin(box.heading))
        corners = [
            complex(box.x, box.y) + turned * complex(side * box.width / 2, end * box.height / 2)
            for side, end in ((-1, -1), (1, -1), (1, 1), (-1, 1))
        ]
        found.append((f"box {number}", lambda x, y, corners=corners: _to_polygon(complex(x, y), corners)))
    if size := world.size:
        found.append(("edge", lambda x, y: min(size[0] / 2 - abs(x), size[1] / 2 - abs(y))))
    return found


def _to_polygon(point: complex, corners: Sequence[complex]) -> float:
    """Return the distance of a point from a convex polygon, whose corners are counterclockwise."""
    sides = [(one, corners[(place + 1) % len(corners)]) for place, one in enumerate(corners)]
    if len(corners) > 2 and all(((other - one).conjugate() * (point - one)).imag >= 0 for one, other in sides):
        return 0.0
    nearest = math.inf
    for one, other in sides:
        along = ((point - one) * (other - one).conjugate()).real / abs(other - one) ** 2
        nearest = min(nearest, abs(point - one - min(max(along, 0), 1) * (other - one)))
    return nearest


class Dance(NamedTuple):
    program: str
    toml: str


def random_dance(seed: int) -> Dance:
    """A dance of two to eight robots with a random tempo, at random places or in a formation."""
    random = Random(seed)
    names = [f"r{number}" for number in range(random.randint(2, 8))]
    lines = [f"beat {random.choice((30, 60, 90, 120, 200))}", f"y = {_series(random, 2)}"]
    waiting = list(names)
    while waiting:
        count = random.choice((1, 1, 2))
        robots, waiting = waiting[:count], waiting[count:]
        canon = random.choice(("", "", "canon 1 ")) if count > 1 else ""
        lines.append(f"{' '.join(robots)} $ {canon}({_series(random, 3)})")
        if random.random() < 0.15:
            lines.append("---")
    lines += [f"{name} $ repeat ({_series(random, 2)})" for name in names if random.random() < 0.2]
    text = ["[profiles.p]", f"step = {random.uniform(0.2, 1):.3f}", f"radius = {random.uniform(0.05, 0.3):.3f}"]
    text += ["[profiles.q]", f"step = {random.uniform(0.2, 1):.3f}", f"quarter_turn = {random.uniform(80, 100):.2f}"]
    shape = random.choice(("line", "circle", "grid", None, None))
    for name in names:
        text += [f"[robots.{name}]", f'profile = "{random.choice("ppq")}"']
        if not shape:
            x, y, heading = random.uniform(-2, 2), random.uniform(-2, 2), random.uniform(-180, 180)
            text.append(f"start = {{ x = {x:.3f}, y = {y:.3f}, heading = {heading:.1f} }}")
    if shape:
        text += ["[formation]", f'shape = "{shape}"', f"distance = {random.uniform(0.6, 1.5):.3f}"]
    text += ["[world]", f"margin = {random.choice((0, 0, 0.1))}"]
    if random.random() < 0.5:
        text += ["circles = [{ x = 1, y = 0.5, radius = 0.2 }]", "walls = [[-2, 1, 0, 3]]"]
        text.append("boxes = [{ x = -1, y = -1, width = 0.5, height = 1, heading = 30 }]")
    if random.random() < 0.3:
        text.append("size = [40, 30]" if shape else "size = [9, 8]")
    return Dance("\n".join(lines) + "\n", "\n".join(text) + "\n")


def _series(random: Random, depth: int) -> str:
    return " ".join(_term(random, depth) for _ in range(random.randint(2, 5)))


def _term(random: Random, depth: int) -> str:
    if not depth or random.random() < 0.5:
        return random.choice(_WORDS) if random.random() < 0.95 else random.choice(("up", "down"))
    inner = f"({_series(random, depth - 1)})"
    around = (
        *("repeat 2", "reverse", "retrograde", "reflect YZ", "ease", "fast 3/2", "slow 2", "scale 1/2", "ramp 1/2 2"),
        *("choose", "shuffle", "chance 1/2", "seed 3 shuffle", "fit 3", "accumulate"),
    )
    kind = random.choice(("around", "voices", "voices", "bracket"))
    if kind == "around":
        word = random.choice(around)
        return f"{word} ({' '.join(random.choices(_WORDS, k=3))})" if word == "choose" else f"{word} {inner}"
    if kind == "voices":
        return f"({_series(random, depth - 1)} || {_series(random, depth - 1)})"
    return f"[{_series(random, depth - 1)}]"


def main() -> None:
    """Try this many dances, and print the differences."""
    count = int(sys.argv[1])
    meetings, hits, dances = 0, 0, 0
    for seed in range(count):
        wrong = disagreements(seed)
        checked = _checked(seed)
        meetings, hits = meetings + len(checked.meetings), hits + len(checked.hits)
        dances += bool(wrong)
        for line in wrong:
            print(line, flush=True)
    print(f"{count} dances, {meetings} pairs that meet, {hits} hits, {dances} dances with differences")


def _checked(seed: int) -> RoomCheck:
    program, toml = random_dance(seed)
    return check_room(score_of(analyze(program, read_robots(toml))))


if __name__ == "__main__":
    main()
