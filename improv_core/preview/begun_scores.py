"""The score that plays, with the beats and poses at which its parts began, by a stage's reports. Standard library
only."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

from improv_core.protocol.messages import TransportMessage
from improv_core.score.motion import Pose
from improv_core.score.movement import Exact, near
from improv_core.score.path import pose_at
from improv_core.score.score import Score
from improv_core.score.takeover import OutgoingScore, PendingTakeover, SceneJson, Takeover, edited, joined

PoseAt = Callable[[str, Exact], Pose | None]
"""Returns a robot's ideal pose at a beat of the score that plays; None if it is unknown."""


class BegunScores:
    """Follows a stage: `add_score` gets each score before it plays, and `take` each message about the playback position
    of a score that it `knows`.

    `pose` is asked where a real robot entered a scene. The reports of a stage with simulated robots say that.
    """

    def __init__(self, pose: PoseAt = lambda robot, beat: None) -> None:
        self._pose = pose
        self._scores: dict[int, Score] = {}
        self._begun: Score | None = None  # as it took over, before scenes began at beats unknown in advance
        self._transport: TransportMessage | None = None
        self._score: Score | None = None

    def add_score(self, score: Score, generation: int) -> None:
        """Add a score that may play from now on."""
        self._scores[generation] = score

    def knows(self, generation: int) -> bool:
        """Return whether a score has this generation."""
        return generation in self._scores

    def take(self, message: TransportMessage) -> Score:
        """Return the score of a message. It is another object once other parts have begun."""
        self._score, self._transport = self._score_of(message), message
        self._scores = {number: each for number, each in self._scores.items() if number >= message["generation"]}
        return self._score

    def _score_of(self, message: TransportMessage) -> Score:
        generation, before, old = message["generation"], self._transport, self._score
        poses = {robot: Pose(**pose) for robot, pose in message.get("poses", {}).items()}
        if before and old and self._begun and before["generation"] == generation:
            scene = message.get("scene", _FIRST_SCENE)
            if scene["index"] == old.scene:
                return old
            return self._next_scene(old, scene, poses) if scene["index"] > old.scene else self._begun
        entry: Takeover = {"beat": message["beat"], "monotonic": message["monotonic"]}
        if "begins" in message:
            entry["begins"] = message["begins"]
        if "scene" in message:
            entry["scene"] = message["scene"]
        score = self._scores[generation]
        if before and old and message["restarted"] == before["restarted"]:
            beat = near(message["beat"])
            index, _ = old.scene_at(beat)
            swap = PendingTakeover(score, generation, "now", 1, 0.0, entry)
            moved = poses if old.open else {}
            self._begun = edited(swap, beat, OutgoingScore(old, index, before["state"] == "ended", moved))
        else:
            self._begun = joined(score, entry)
        return self._begun

    def _next_scene(self, old: Score, scene: SceneJson, poses: dict[str, Pose]) -> Score:
        """The score from its next scene on, which begins where the robots are then."""
        beat = near(scene["begins"])
        parts = {
            robot: replace(
                part,
                begins=beat,
                scene=scene["index"],
                scene_begins=(),
                entered=poses.get(robot) or self._pose(robot, beat) or pose_at(part, beat),
            )
            for robot, part in old.parts.items()
        }
        return replace(old, parts=parts, scene=scene["index"], since=beat)


_FIRST_SCENE: SceneJson = {"index": 0, "begins": 0.0}
