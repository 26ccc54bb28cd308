"""The open pages, and the state that they share."""

from __future__ import annotations

import asyncio
import json
import sys
import time
from collections.abc import Callable

from improv_core.page.outbox import Audience, PageOutbox, bumps_message
from improv_core.protocol.drawn import Bump, Lengthening, Snapshot
from improv_core.protocol.fields import PoseJson
from improv_core.protocol.messages import SIMULATED
from improv_core.protocol.page_messages import DrawnPoses, DrawnRobot, DrawnRobots, ServerTime
from improv_core.protocol.robot_messages import Measured, MeasuredRobot
from improv_core.score.motion import Pose

FRAME = 1 / 60
MAX_PLACES = 20_000
"""Places kept for each robot: a quarter of an hour."""


class Pages(Audience):
    """The pages that show a performance."""

    def __init__(self, snapshot: Callable[[], Snapshot]) -> None:
        super().__init__()
        self._latest["time"] = ""  # pages get it first; `join` writes it
        self._snapshot = snapshot
        self._watched = asyncio.Event()
        self._drawn: dict[str, object] = {}
        self._bumps: tuple[Bump, ...] = ()
        self._trails: dict[str, tuple[Lengthening, int]] = {}  # with their lengths
        self._placed = 0
        self._measured: dict[str, _MeasuredTrail] = {}
        self._problem = ""

    def join(self) -> PageOutbox:
        """Return a new page's outbox, filled with everything that the other pages know."""
        self._draw()
        now: ServerTime = {"type": "time", "wall": time.time()}
        self._latest["time"] = json.dumps(now)
        outbox = super().join()
        if self._bumps:
            outbox.put("past", bumps_message(self._bumps, past=True))
        if self._trails:
            outbox.lengthen("trails", {name: trail for name, (trail, _) in self._trails.items()}, self._placed)
        if self._measured:
            outbox.lengthen("measured", self._measured)
        self._watched.set()
        return outbox

    def leave(self, outbox: PageOutbox) -> None:
        super().leave(outbox)
        if not self._outboxes:
            self._watched.clear()

    def measure(self, message: Measured) -> None:
        """Show measured places of robots. Measured poses of a robot replace simulated ones."""
        for name, each in message["robots"].items():
            trail, simulated = self._measured.get(name), each["source"] == SIMULATED
            if not trail or trail.simulated > simulated:
                trail = _MeasuredTrail(simulated)
            elif trail.simulated < simulated:
                continue
            trail.places.append(_measured_place(each))
            self._measured[name] = trail.renewed()
        for outbox in self._outboxes:
            outbox.lengthen("measured", self._measured)

    def forget_measured(self) -> None:
        """Drop the measured poses, because another performance begins."""
        self._measured = {}
        self._latest = {kind: text for kind, text in self._latest.items() if not kind.startswith("fault ")}

    def answer(self, page: int, kind: str, text: str) -> None:
        """Send a message to one page, unless it has been closed."""
        for outbox in self._outboxes:
            if outbox.number == page:
                outbox.put(kind, text)

    async def watch(self) -> None:
        """Send new poses 60 times a second while a page is open, forever."""
        while True:
            await self._watched.wait()
            self._draw()
            await asyncio.sleep(FRAME)

    async def emptied(self) -> None:
        """Wait until every page has received everything."""
        await asyncio.gather(*(outbox.emptied() for outbox in self._outboxes))

    def _draw(self) -> None:
        """Send the latest snapshot; report a failure once, and try again with the next frame."""
        try:
            self._send(self._snapshot())
            self._problem = ""
        except Exception as problem:
            if repr(problem) != self._problem:
                print(f"the page: {problem!r}", file=sys.stderr)
            self._problem = repr(problem)

    def _send(self, snapshot: Snapshot) -> None:
        """Send the robots, their poses in the same order, trails, and bumps, if any of these is new."""
        robots: dict[str, DrawnRobot] = {
            name: {"radius": radius, "joints": list(snapshot.joints.get(name, ()))}
            for name, radius in snapshot.radii.items()
        }
        poses = [
            [round(pose.x, 4), round(pose.y, 4), round(pose.z, 4), round(pose.heading, 4)]
            for pose in map(snapshot.poses.__getitem__, robots)
        ]
        joints = {
            name: [round(position, 4) for position in each.values()] for name, each in snapshot.joints.items() if each
        }
        if robots != self._drawn.get("robots"):
            listed: DrawnRobots = {"type": "robots", "robots": robots}
            self.put("robots", json.dumps(listed))
        drawn: dict[str, object] = {"robots": robots, "poses": poses, "joints": joints}
        if drawn != self._drawn:
            message: DrawnPoses = {
                "type": "poses",
                "at": round(snapshot.at, 4),
                "placed": snapshot.placed,
                "poses": poses,
                "joints": joints,
            }
            self.put("poses", json.dumps(message, separators=(",", ":")))
        self._drawn = drawn
        trails = {name: (trail, len(trail.places)) for name, trail in snapshot.trails.items()}
        if (trails, snapshot.placed) != (self._trails, self._placed):
            self._trails, self._placed = trails, snapshot.placed
            for outbox in self._outboxes:
                outbox.lengthen("trails", snapshot.trails, snapshot.placed)
        known = set(map(id, self._bumps))  # a dance that is played again may have equal bumps
        new = [bump for bump in snapshot.bumps if id(bump) not in known]
        self._bumps = snapshot.bumps
        for outbox in self._outboxes if new else ():
            outbox.add_bumps(new)


class _MeasuredTrail:
    """Measured or simulated places of one robot, oldest first. The trail only grows, at its end."""

    def __init__(self, simulated: bool) -> None:
        self.simulated = simulated
        self.places: list[list[float]] = []

    def renewed(self) -> _MeasuredTrail:
        """The trail without its older half, once it has too many places."""
        if len(self.places) <= MAX_PLACES:
            return self
        trail = _MeasuredTrail(self.simulated)
        trail.places = self.places[MAX_PLACES // 2 :]
        return trail


def _measured_place(robot: MeasuredRobot) -> list[float]:
    """Convert a place to the form that the message to the page uses (`DrawnTrail`)."""
    pose, ideal = robot["pose"], robot["ideal"]
    off, turned = Pose(**pose).apart(Pose(**ideal))
    flags = float(robot["source"] == SIMULATED), float(robot["follows"])
    return [robot["performed"], robot["beat"], *_plane(pose), *_plane(ideal), off, turned, robot["aligned"], *flags]


def _plane(pose: PoseJson) -> tuple[float, float, float]:
    return pose["x"], pose["y"], pose["heading"]
