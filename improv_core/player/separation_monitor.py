"""Watches the measured poses of real robots while they play: they must keep apart, and some must be seen at all.

It decides nothing, and never reads a clock. Standard library only.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping

from improv_core.player.events import TooNear
from improv_core.player.run import Run
from improv_core.protocol.fields import to_pose_json
from improv_core.protocol.messages import RobotsSeen, SeenRobot
from improv_core.protocol.output import RawPose, Sink
from improv_core.safety.fault_texts import different_frames, in_one_phrase
from improv_core.safety.odometry import FROM_ELSEWHERE, Odometry
from improv_core.safety.separation import LOOK_PERIOD, Proximity
from improv_core.safety.stopping_distance import Base, braking_of
from improv_core.score.following import OLDEST
from improv_core.score.motion import Pose, Twist
from improv_core.score.score import Part, Score

FRAMES_PERIOD = 1.0
"""Seconds between two messages about poses to stages elsewhere if only their frames matter."""
QUIET = 10.0
"""Seconds for which a robot's poses from elsewhere must come in time before people read again that they don't: on a bad
link, that changes all the time."""


class SeparationMonitor:
    """The latest poses of robots, and the unguarded robots that people know about. Only real robots are guarded."""

    def __init__(self, sink: Sink) -> None:
        self._sink = sink
        self._proximity = Proximity()
        self._looked = self._shared = -math.inf
        self.due = math.inf
        """The time on the clock of the next check if no pose comes."""
        self._told: set[str] = set()  # robots that people know are not guarded
        self._lost: dict[str, float] = {}  # robots without poses now, and the time when that was so last
        self._delayed: set[str] = set()  # robots whose poses come too late
        self._misdated: set[str] = set()  # robots whose poses have stamps of another time
        self._strays: frozenset[str] = frozenset()  # robots whose poses have another frame than those of the others

    def forget(self) -> None:
        """Report all unguarded robots again, since somebody has restarted everything."""
        self._told, self._lost, self._delayed, self._misdated = set(), {}, set(), set()
        self._strays = frozenset()

    def hear(self, run: Run, poses: Iterable[RawPose]) -> None:
        self._proximity = self._proximity.heard(poses, _guarded(run))

    def tell(self, run: Run, robot: str, twist: Twist, at: float) -> None:
        """Take the velocity that a robot has from a time on the clock on."""
        part = run.score.parts.get(robot)
        if not part or run.score.world.keep_apart is None:
            return
        before = self._proximity
        self._proximity = before.sent(robot, part.profile.limited(twist), at)
        if self._proximity is not before:
            self.due = min(self.due, max(at, self._looked + LOOK_PERIOD))

    def shared(self, run: Run, poses: Iterable[RawPose]) -> RobotsSeen | None:
        """Return the message about these poses, by which stages elsewhere keep robots apart and compare frames."""
        parts = run.score.parts
        if run.mode in ("stopped", "ended"):
            return None
        if not any(part.elsewhere for part in parts.values()):
            return None
        ours = _guarded(run).keys() & _ours(run)
        robots = {raw.robot: self._seen(raw) for raw in poses if raw.robot in ours}
        latest = max((each["at"] for each in robots.values()), default=-math.inf)
        if run.score.world.keep_apart is None and latest < self._shared + FRAMES_PERIOD:
            return None
        self._shared = latest
        return {"type": "seen", "robots": robots} if robots else None

    def _seen(self, raw: RawPose) -> SeenRobot:
        seen: SeenRobot = {"at": raw.at, "pose": to_pose_json(raw.pose)}
        if raw.frame:
            seen["frame"] = raw.frame
        if (track := self._proximity.tracks.get(raw.robot)) and track.sent:
            twist = track.sent[-1].twist
            seen["told"] = twist.x, twist.y, twist.z, twist.yaw
        return seen

    def unseen(self, run: Run, now: float) -> list[str]:
        """Return the robots that aren't seen at a time on the clock, if all must be."""
        return [robot for robot in _ours(run) if now >= self._proximity.seen_until([robot])]

    def poses(self, run: Run, now: float) -> dict[str, Pose]:
        """Return the poses of robots that are guarded and seen at a time on the clock."""
        proximity = self._proximity
        return {robot: proximity.pose(robot) for robot in _guarded(run) if proximity.is_fresh(robot, now)}

    def look(self, run: Run, now: float) -> TooNear | None:
        """Return the robots that are too near to each other at a time on the clock, if there are any."""
        if not self._sink.real or (keep_apart := run.score.world.keep_apart) is None:
            self.due = math.inf
            return None
        self._looked = now
        self._proximity, found, self.due = self._proximity.looked(
            run.mode == "playing", _guarded(run), keep_apart, now, {*_ours(run)}
        )
        return TooNear(found) if found else None

    def deadline(self, run: Run) -> float:
        """Return the time on the clock at which a robot that must be seen isn't; infinite if none must be."""
        must_be_seen = self._sink.real and run.mode == "playing" and run.score.safety.sight
        return self._proximity.seen_until(_ours(run)) if must_be_seen else math.inf

    def lines(self, run: Run, odometry: Odometry, now: float) -> Iterator[str]:
        """Yield lines about poses and the checks that need them, each once."""
        ages = odometry.ages()
        strays, self._strays = self._strays, odometry.strays
        if self._sink.real and run.mode == "playing":
            # If the first of them is elsewhere, its stage has the line.
            if odometry.strays - strays and min(odometry.strays) in _ours(run):
                yield different_frames(odometry.frames, odometry.strays)
            yield from self._unguarded(run, now)
            yield from self._other_clocks(run, odometry.clocks())
            yield from self._delays(run, ages)

    def _unguarded(self, run: Run, now: float) -> Iterator[str]:
        """Yield lines about robots that aren't guarded, each once."""
        if run.score.world.keep_apart is None or not _ours(run):
            return
        parts, guarded = run.score.parts, _guarded(run)
        if unknown := sorted(parts.keys() - guarded.keys() - self._told):
            self._told |= {*unknown}
            yield f'`keep_apart` doesn\'t guard {", ".join(unknown)}: that needs poses with `odom_frame = "world"`'
        lost = {robot for robot, base in guarded.items() if not self._proximity.is_guarded(robot, base, now)}
        new = lost - self._lost.keys()
        for oldest in sorted({guarded[robot].oldest for robot in new}):
            which = in_one_phrase(sorted(robot for robot in new if guarded[robot].oldest == oldest))
            yield f"`keep_apart` doesn't guard {which} now: no pose came for {oldest} s"
        far = {robot: at for robot, at in self._lost.items() if robot in guarded and parts[robot].elsewhere}
        self._lost = {robot: at for robot, at in far.items() if now < at + QUIET} | dict.fromkeys(lost, now)

    def _other_clocks(self, run: Run, ahead: Mapping[str, float]) -> Iterator[str]:
        """Yield lines about robots whose poses are stamped by a clock that doesn't agree with ours, each once. Their
        stamps are this many seconds `ahead`."""
        parts = run.score.parts
        # Robots in the world must not begin by what was true long ago.
        for robot in dict.fromkeys((*_dependent(run), *_guarded(run))):
            if robot not in ahead or robot in self._misdated or parts[robot].use_sim_time:
                continue
            self._misdated.add(robot)
            seconds = ahead[robot]
            off = f"{abs(seconds):.1f} s {'ahead of' if seconds > 0 else 'behind'}"
            yield (
                f"the clock that stamps poses of {robot} is {off} this machine's, so nobody knows how old they are: "
                "they count from when they come; synchronize the clocks, such as with chrony"
            )

    def _delays(self, run: Run, ages: Mapping[str, float]) -> Iterator[str]:
        """Yield lines about robots whose poses are too old to be of use. `ages` are the lowest, in seconds."""
        late = {robot for robot in _dependent(run) if ages.get(robot, 0.0) > OLDEST}
        if new := late - self._delayed:
            seconds = max(ages[robot] for robot in new)
            yield (
                f"poses of {in_one_phrase(sorted(new))} come {seconds:.1f} s after they were measured: those "
                f"older than {OLDEST} s correct no path and keep nobody apart; check the network, or the clock that "
                "stamps them"
            )
        if over := (self._delayed - late) & ages.keys():
            yield f"poses of {in_one_phrase(sorted(over))} come in time again"
        self._delayed = (self._delayed | late) - over


def from_elsewhere(seen: RobotsSeen, score: Score, now: float) -> list[RawPose]:
    """Return the poses and velocities of robots as other stages report them, none measured later than now."""
    return [
        RawPose(robot, FROM_ELSEWHERE, Pose(**each["pose"]), min(each["at"], now), each.get("frame", ""), told=told)
        for robot, each in seen["robots"].items()
        if robot in score.parts and score.parts[robot].elsewhere
        for told in [Twist(*each["told"]) if "told" in each else None]
    ]


def _ours(run: Run) -> list[str]:
    """Return the robots that this stage moves."""
    return [robot for robot, part in run.score.parts.items() if not part.elsewhere]


def _dependent(run: Run) -> list[str]:
    """Return the robots for which the age of poses matters."""
    keeps = run.score.world.keep_apart is not None or run.score.safety.sight
    guarded = _guarded(run) if keeps else {}
    return [robot for robot, part in run.score.parts.items() if part.follow or robot in guarded]


def _guarded(run: Run) -> Mapping[str, Base]:
    """Return the robots whose poses are in the world that all share."""
    return {
        robot: _base(part)
        for robot, part in run.score.parts.items()
        if (part.odom or part.elsewhere) and part.odom_frame == "world"
    }


def _base(part: Part) -> Base:
    profile = part.profile
    return Base(profile.radius, profile.max_linear, braking_of(profile), part.elsewhere)
