"""Finds the robots that will meet in the background, so that no setpoint and no page waits for it."""

from __future__ import annotations

import math
import sys
from collections.abc import Callable, Mapping
from dataclasses import astuple, replace
from functools import partial
from typing import Any

from improv_core.ipc.asking import Answerer
from improv_core.page.background import Do
from improv_core.protocol.page_messages import MeetingsMessage
from improv_core.score.meetings import RoomCheck, check_room
from improv_core.score.score import Score
from improv_core.score.score_json import from_json, to_json
from improv_core.score.senses import is_computed

MAX_SHOWN = 100
"""The most meetings and hits that pages are sent."""
EXACT = 1024
"""Beats are rounded down to this part of a beat, to which whole beats can be added exactly."""


Predict = Answerer[tuple[Mapping[str, Any], int], MeetingsMessage]
"""Finds the meetings in a score in which robots sense something: its JSON and its generation."""


class Meetings:
    """Checks the latest score that was shown for robots that meet. `publish` gets all meetings. `tell` gets a line if a
    score has taken over from another, so that robots may meet that were apart.

    A score that begins at beat 0 and in which robots sense something is performed by a process of its own: that takes
    seconds, and the simulator must not wait.
    """

    def __init__(self, publish: Callable[[MeetingsMessage], None], tell: Callable[[str], None], do: Do) -> None:
        self._publish = publish
        self._tell = tell
        self._do = do
        self._latest = 0  # the number of scores shown so far
        self._predict: Predict | None = None  # while it predicts

    def show(self, score: Score, generation: int) -> None:
        """Check another score, or the same one once the times at which its parts began are known."""
        self._latest += 1
        self.close()
        self._do(partial(self._look, score, generation, self._latest))

    def _look(self, score: Score, generation: int, number: int) -> None:
        if number == self._latest:  # otherwise a newer score waits
            try:
                self._check(score, generation)
            except Exception as problem:
                print(f"meetings could not be checked: {problem!r}", file=sys.stderr)

    def close(self) -> None:
        """End the process that predicts, if there is one."""
        if predict := self._predict:
            predict.give_up()

    def _check(self, score: Score, generation: int) -> None:
        start = max((part.begins for part in score.parts.values()), default=score.since)
        if not start and score.open:
            number, predict = self._latest, Answerer(check_sensing)
            self._predict = predict
            try:
                found = predict.ask((to_json(score), generation))
                if number == self._latest:
                    self._publish(found)
                return
            except (EOFError, OSError):
                if number != self._latest:
                    return
            finally:
                self._predict = None
                predict.close()
        checked = check_room(score, math.floor(start * EXACT) / EXACT)
        self._publish(as_message(_decided(checked, score), generation, assumes=score.open))
        if start and (line := warning(checked, score)):
            self._tell(line)


def _decided(checked: RoomCheck, score: Score) -> RoomCheck:
    """Leave out robots whose simulated senses decide: they may turn away in time, and nobody has predicted that."""
    open_parts = {name: part for name, part in score.parts.items() if any(scene.open for scene in part.scenes)}
    sensing = {name for name, part in open_parts.items() if any(map(is_computed, part.senses.values()))}
    meetings = tuple([each for each in checked.meetings if sensing.isdisjoint(each.robots)])
    return replace(checked, meetings=meetings, hits=tuple([each for each in checked.hits if each.robot not in sensing]))


def check_sensing(asked: tuple[Mapping[str, Any], int]) -> MeetingsMessage:
    """Return the meetings in a score if senses decide as in the simulator."""
    from improv_core.stage import dry_run  # only in the process that needs the simulator for it

    score, generation = from_json(asked[0]), asked[1]
    prediction = dry_run.predict(score)
    if not prediction:
        return as_message(check_room(score, 0), generation, assumes=True)
    checked = check_room(prediction.score, 0)
    checked = replace(checked, is_all=checked.is_all and prediction.cut is None)
    return as_message(checked, generation, assumes=bool(prediction.assuming))


def as_message(checked: RoomCheck, generation: int, *, assumes: bool) -> MeetingsMessage:
    """Build the `meetings` message; with `assumes`, senses may decide otherwise."""
    return {
        "type": "meetings",
        "generation": generation,
        "from": checked.start,
        "to": checked.end,
        "all": checked.is_all,
        "assumes": assumes,
        "meetings": [
            {
                "robots": list(each.robots),
                "beat": each.beat,
                "distance": each.distance,
                "more": each.more,
                "poses": [list(astuple(pose)) for pose in each.poses],
            }
            for each in checked.meetings[:MAX_SHOWN]
        ],
        "hits": [
            {"robot": each.robot, "thing": each.thing, "beat": each.beat, "pose": list(astuple(each.pose))}
            for each in checked.hits[:MAX_SHOWN]
        ],
    }


def warning(checked: RoomCheck, score: Score) -> str | None:
    """Return a warning for people when a score takes over from another; None if no robots will meet."""
    if not checked.meetings:
        return None
    first = checked.meetings[0]
    one, other = first.robots
    seconds = score.seconds(first.beat - checked.start)
    soon = f"in {seconds:.1f} s" if seconds else "now"
    others = len(checked.meetings) - 1
    more = f", and {others} more pair{'' if others == 1 else 's'} later" if others else ""
    return f"{one} and {other} will meet {soon}{more}: change what they play, or stop them"
