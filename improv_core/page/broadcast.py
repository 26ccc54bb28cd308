"""Messages about a performance that all pages get."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING

from improv_core.page.answers import Answers
from improv_core.page.meetings import Meetings
from improv_core.page.open_pages import Pages
from improv_core.preview.begun_scores import BegunScores
from improv_core.preview.window import about
from improv_core.protocol.messages import FromStage, TransportMessage
from improv_core.protocol.page_messages import ForPages, MeetingsMessage, ShownScore
from improv_core.score.music import Music
from improv_core.score.score import Score

if TYPE_CHECKING:
    from improv_core.page.ideal_floor import IdealFloor

Soon = Callable[..., None]
"""Has the thread of the pages call a function with these values."""


class Broadcast:
    """Passes news of the performance on to the pages. Its methods may be called from any thread.

    `confirm` gets the identity of each stop that stages have obeyed. With `takes_start_poses`, pages may ask for
    other start poses. `scores` finds out when parts of a score begin.
    """

    def __init__(
        self,
        pages: Pages,
        answers: Answers,
        soon: Soon,
        confirm: Callable[[str], None],
        *,
        takes_start_poses: bool,
        scores: IdealFloor | None = None,
    ) -> None:
        self._pages = pages
        self._answers = answers
        self._soon = soon
        self._confirm = confirm
        self._scores: BegunScores | IdealFloor = scores or BegunScores()
        self._takes_start_poses = takes_start_poses
        self._shown = 0, 0  # the generation and scene that pages show with the beats at which their parts begin
        self._restarted = 0
        self.meetings: Meetings | None = None
        """Finds out which robots meet; None if nothing does."""
        self.music: Music | None = None
        """The song of the latest score."""
        self._names: Mapping[str, str] = {}

    def publish(self, message: ForPages | ShownScore | MeetingsMessage) -> None:
        """Send a message to every page, and to later pages until another of its type, about the same subject, replaces
        it.

        The page that asked gets the answer, and the page that sent a stop gets its confirmation.
        """
        about: tuple[str, ...] = ()
        match message["type"]:
            case "obeyed":
                self._soon(self._confirm, message["direct"])
                return
            case "answer":
                answer = message["answer"]
                self._soon(self._pages.answer, message["page"], answer["type"], json.dumps(answer))
                return
            case "measured":
                self._soon(self._pages.measure, message)
                return
            case "transport":
                self._follow(message)
                self._answers.take(message)
            case "sensed":
                self._answers.take(message)
                about = message["robot"], message["sense"]
            case "fault":
                about = message["robot"], message["fault"]
            case "program":
                self._names = message.get("names", {})
            case "decided" | "joints":
                about = (message["robot"],)
        self._soon(self._pages.put, " ".join((message["type"], *about)), json.dumps(message))

    def report(self, message: FromStage) -> None:
        """Show a report of the stage that plays in this process, unless it is of no interest for pages."""
        match message["type"]:
            case "transport" | "stopped" | "sensed" | "decided" | "measured" | "armed" | "fault":
                self.publish(message)

    def label(self, robot: str) -> str:
        """Return the name that people read for a robot: in a class, that of its child."""
        return self._names.get(robot, robot)

    def show(self, score: Score, generation: int) -> None:
        """Show the score that will play, once the player's messages have this generation."""
        self._scores.add_score(score, generation)
        self._present(score, generation)

    def _follow(self, message: TransportMessage) -> None:
        """Show the score again once the beats at which its parts begin are known, or are others."""
        if message["restarted"] != self._restarted:
            self._restarted = message["restarted"]
            self._soon(self._pages.forget_measured)
        generation, scene = message["generation"], message.get("scene", {"index": 0})["index"]
        if self._scores.knows(generation):
            score = self._scores.take(message)
            if (generation, scene) != self._shown and ("begins" in message or generation == self._shown[0]):
                self._shown = generation, scene
                self._present(score, generation)

    def _present(self, score: Score, generation: int) -> None:
        self.music = score.music
        self._answers.show(score, generation)
        self.publish(about(score, generation, takes_start_poses=self._takes_start_poses))
        if self.meetings:
            self.meetings.show(score, generation)
