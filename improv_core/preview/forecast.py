"""The robots' ideal poses, their words, and their next seconds, computed from a stage's reports.

It never reads a clock: `now` is the monotonic time, in seconds.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

from improv_core.preview.begun_scores import BegunScores
from improv_core.preview.replaying import followed, note
from improv_core.preview.window import window
from improv_core.protocol.commands import is_muted
from improv_core.protocol.messages import Sensed, TransportMessage
from improv_core.protocol.page_messages import RobotWindow
from improv_core.protocol.robot_messages import FaultMessage, Measured
from improv_core.protocol.transport import beat_at
from improv_core.score.faults import Fault
from improv_core.score.motion import Pose, Twist
from improv_core.score.movement import Exact, near
from improv_core.score.replay import Replay
from improv_core.score.score import Score

AHEAD = 30.0
"""Seconds that a path reaches ahead."""
LARGEST_TURN = math.radians(10)
"""The most radians between two poses of a path: an arc is drawn as chords."""
MAX_POSES = 1_000
"""The most poses in one path."""
WORLD = "improv"
"""The frame of start poses."""


@dataclass(frozen=True, slots=True)
class Frame:
    """A frame, and the origin of the score's world in it."""

    name: str
    origin: Pose


@dataclass(frozen=True, slots=True)
class RobotForecast:
    """A robot's ideal pose now (None if it can't be known), and the words that play, the outermost first.

    Here and in paths, poses are in the robot's `Forecast.frame`.
    """

    pose: Pose | None
    words: Sequence[str]


class WordBegins(NamedTuple):
    """The beat at which a robot begins to play a word; the word is empty if it plays none."""

    beat: float
    robot: str
    word: str


class Forecast:
    """Follows a stage: `add_score` gets each score before it plays, and `take` the stage's messages."""

    def __init__(self) -> None:
        self._scores = BegunScores(self._ideal)
        self._replay: Replay | None = None
        self._stretches: Mapping[str, RobotWindow] = {}
        self._frames: dict[str, Frame] = {}
        self.score: Score | None = None
        """The score that plays, with the beats and the poses at which its parts began."""
        self.transport: TransportMessage | None = None
        """The stage's latest transport message."""
        self.faults: dict[str, dict[Fault, str]] = {}
        """The open faults of robots since the latest restart, with a line about each."""

    def add_score(self, score: Score, generation: int) -> None:
        """Add a score that may play from now on."""
        self._scores.add_score(score, generation)

    def knows(self, generation: int) -> bool:
        """Return whether a score has this generation."""
        return self._scores.knows(generation)

    def take(self, message: TransportMessage | Sensed | Measured) -> None:
        """Take a message about the playback position, senses, or measured poses."""
        if message["type"] == "sensed":
            if self._replay:
                note(self._replay, message)
        elif message["type"] == "measured":
            for robot, each in message["robots"].items():
                if each["frame"]:
                    self._frames[robot] = Frame(each["frame"], Pose(**each["origin"]))
        elif self._scores.knows(message["generation"]):
            if self.transport and self.transport["restarted"] != message["restarted"]:
                self.faults = {}
            self.score = self._scores.take(message)
            self._replay = followed(self._replay, self.score, self.transport, message)
            self.transport = message

    def note_fault(self, message: FaultMessage) -> None:
        """Note that a fault of a robot has begun, or is over."""
        faults = self.faults.setdefault(message["robot"], {})
        faults.pop(message["fault"], None)
        if not message["over"]:
            faults[message["fault"]] = message["message"]

    def frame(self, robot: str) -> Frame:
        """The frame of a robot's odometry, if known, or else the world of the score."""
        part = self.score.parts.get(robot) if self.score else None
        return self._frames.get(robot, _IN_WORLD) if part and part.odom else _IN_WORLD

    def beat(self, now: float) -> float:
        """The beat of the performance."""
        return beat_at(self.transport, now) if self.transport else 0.0

    @property
    def is_moving(self) -> bool:
        """True while the position advances."""
        return self.transport is not None and self.transport["state"] == "playing"

    def compute(self, now: float, ahead: float = AHEAD) -> None:
        """Compute the next `ahead` seconds. `robot`, `path`, and `words` use the latest result."""
        self._stretches = {}
        if self._replay and self.transport:
            begin = self.beat(now)
            beats = ahead * self.transport["tempo"] / 60 if self.transport["state"] in _UNFINISHED else 0.0
            self._stretches = window(self._replay, begin, begin + beats)

    def words(self) -> Iterator[WordBegins]:
        """The innermost words that robots play, with the beats at which they begin."""
        for robot, stretch in self._stretches.items():
            for start, _, *_, sources in stretch["moments"]:
                yield WordBegins(start, robot, self._word(*sources[-1]) if sources else "")

    def robot(self, robot: str, now: float) -> RobotForecast:
        """A robot's pose and words now."""
        found = self.robot_in_world(robot, now)
        return replace(found, pose=self.frame(robot).origin.then(found.pose)) if found.pose else found

    def path(self, robot: str) -> Iterator[tuple[float, Pose]]:
        """A robot's next poses, with the seconds until then; none if nothing plays or the robot is muted."""
        stretch, transport, score = self._stretches.get(robot), self.transport, self.score
        if not stretch or not transport or not score or stretch["pose"] is None:
            return
        if is_muted(robot, transport["muted"], transport["soloed"]):
            return
        if transport["state"] not in _UNFINISHED:
            return
        beat_seconds, count = 60 / transport["tempo"], 1
        pose = self.frame(robot).origin.then(Pose(*stretch["pose"]))
        begin: float | None = None
        for start, beats, *velocity, _ in stretch["moments"]:
            if begin is None:
                begin = start
                yield 0.0, pose
            left = AHEAD - (start - begin) * beat_seconds
            beats, moving = min(beats, left / beat_seconds), Twist(*velocity)
            seconds = score.seconds(beats)
            chords = max(1, math.ceil(abs(moving.yaw) * seconds / LARGEST_TURN))
            for chord in range(1, chords + 1):
                if count == MAX_POSES:
                    return
                count += 1
                passed = (start - begin + beats * chord / chords) * beat_seconds
                yield passed, pose.after(moving, seconds * chord / chords).above_ground()
            pose = pose.after(moving, seconds).above_ground()

    def _ideal(self, robot: str, beat: Exact) -> Pose | None:
        return self._replay.pose(robot, beat) if self._replay and robot in self._replay.score.parts else None

    def robot_in_world(self, robot: str, now: float) -> RobotForecast:
        """A robot's pose and words now, in the world of the score."""
        stretch, beat = self._stretches.get(robot), near(self.beat(now))  # rounded as in the lookup of words
        if not stretch or not self.score or stretch["pose"] is None:
            return RobotForecast(None, ())
        pose, words = Pose(*stretch["pose"]), list[str]()
        for start, beats, *velocity, sources in stretch["moments"]:
            if start > beat:
                break
            inside = beat < start + beats
            words = [self._word(*source) for source in sources] if inside else []
            pose = pose.after(Twist(*velocity), self.score.seconds(min(beats, beat - start))).above_ground()
        return RobotForecast(pose, words)

    def _word(self, statement: int, start: int, end: int) -> str:
        """A word of the program; empty if the text was too long to send."""
        assert self.score
        offset = self.score.offsets.get(statement)
        return "" if offset is None else self.score.text[offset + start : offset + end]


_IN_WORLD = Frame(WORLD, Pose())
_UNFINISHED = ("waiting", "playing", "paused")
"""States in which more of the score may be performed."""
