"""OSC messages about the dance of a real player, and their times."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import pytest

from improv_core.music.osc_out import OscDue, Voice
from improv_core.preview.forecast import Forecast
from improv_core.protocol.messages import When
from tests.player.test_player import Stage, score


class OscStage(Stage):
    """A player of a program, and the OSC messages about it, with the seconds since the beginning at which they were
    due."""

    def __init__(self, program: str, bar: int | None = None) -> None:
        super().__init__()
        self.forecast, self.voice = Forecast(), Voice()
        self.said: list[tuple[float, str]] = []
        self._begins = self.now
        self._heard, self._looked = 0, self.now
        self.play(program, "restart", bar)

    def play(self, program: str, when: When, bar: int | None = None) -> None:
        made, generation = replace(score(program), bar=bar), len(self.told) + 1
        self.forecast.add_score(made, generation)
        self.perform(made, generation, when)
        self.listen()

    def listen(self) -> None:
        """Take the player's messages, and look ahead."""
        for message in self.told[self._heard :]:
            if message["type"] == "transport":
                self.forecast.take(message)
                self.voice, due = self.voice.after(message)
                self._note(due)
            elif message["type"] == "sensed":
                self.forecast.take(message)
        if self._heard < len(self.told) or self.now > self._looked + 1:
            self.forecast.compute(self.now, 2.0)
            self._heard, self._looked = len(self.told), self.now

    def pass_time(self, seconds: float) -> None:
        end = self.now + seconds
        while True:
            self.listen()
            at = min(max(self.voice.next(self.forecast.words()), self.now), end)
            self.run(at - self.now)
            self.voice, due = self.voice.due(self.forecast.words(), self.now)
            self._note(due)
            self.listen()
            if at == end:
                return

    def _note(self, due: Sequence[OscDue]) -> None:
        told = (f"{each.address.removeprefix('/improv/')} {' '.join(map(str, each.arguments))}" for each in due)
        self.said += [(round(each.at - self._begins, 3), line) for each, line in zip(due, told, strict=True)]

    def take(self) -> list[tuple[float, str]]:
        said, self.said = self.said, []
        return said


def test_beats_bars_and_words_are_sent_as_they_are_due() -> None:
    stage = OscStage("beat 120\nr $ slow 3 forward left\nc $ fast 2 (forward left)", bar=2)
    stage.pass_time(3.0)
    assert stage.take() == [
        (0.0, "state playing"),
        (0.0, "bar 0"),
        (0.0, "beat 0"),
        (0.0, "word c forward"),
        (0.0, "word r forward"),
        (0.25, "word c left"),
        (0.5, "beat 1"),
        (1.0, "bar 1"),
        (1.0, "beat 2"),
        (1.5, "beat 3"),
        (1.5, "word r left"),
        (2.0, "state ended"),
    ]


def test_beats_are_on_time_after_a_change_of_speed_a_seek_and_a_pause() -> None:
    stage = OscStage("beat 60\nr $ repeat forward")
    stage.pass_time(1.5)
    stage.take()
    stage.ask("speed", factor=2)
    stage.pass_time(0.5)
    assert stage.take() == [(1.75, "beat 2")]
    stage.ask("seek", beat=8)
    stage.pass_time(0.1)
    assert stage.take() == [(2.0, "beat 8")]
    stage.ask("pause")
    stage.pass_time(1)
    stage.ask("resume")
    stage.pass_time(0.5)
    assert stage.take() == [(2.1, "state paused"), (3.1, "state playing"), (3.1, "word r forward"), (3.5, "beat 9")]


def test_a_muted_robot_sends_no_words_and_a_save_sends_those_that_change() -> None:
    stage = OscStage("beat 60\na b $ repeat (forward left)")
    stage.pass_time(1.5)
    stage.ask("silence", muted=["b"], soloed=[])
    stage.take()
    stage.pass_time(1.0)
    assert stage.take() == [(2.0, "beat 2"), (2.0, "word a forward")]
    stage.play("beat 60\na $ repeat (backward right)\nb $ repeat (forward left)", "now")
    stage.pass_time(0.1)
    assert stage.take() == [(2.5, "word a backward")]


def test_after_a_long_sleep_only_the_latest_beat_is_sent() -> None:
    stage = OscStage("beat 60\nr $ repeat forward")
    stage.pass_time(0.5)
    stage.take()
    voice, due = stage.voice.due([], stage.now + 5)
    assert [each.arguments for each in due] == [[5]]
    assert voice.next([]) == pytest.approx(stage.now + 5.5)


@pytest.mark.parametrize(("value", "said"), [(True, 1), (False, 0), (None, -1)])
def test_a_sense_is_sent_once_with_its_time(value: bool | None, said: int) -> None:
    message: Any = {"robot": "anna", "sense": "near", "value": value, "wall": 1_800_000_000_250_000_000}
    voice, (due,) = Voice().sensed(message, wall=1_800_000_001.0, now=500.0)
    assert voice.sensed(message, 1_800_000_001.0, 500.0) == (voice, [])
    assert (round(due.at, 5), due.address, due.arguments) == (499.25, "/improv/sense", ["near", "anna", said])


def test_every_cue_is_sent() -> None:
    stage = OscStage("anna $ repeat (until cue (repeat left))")
    voice, told = Voice(), list[Sequence[Any]]()
    for _ in range(3):
        stage.pass_time(1.0)
        stage.ask("cue")
    for message in stage.told:
        if message["type"] == "sensed":
            voice, due = voice.sensed(message, 0.0, 0.0)
            told += [each.arguments for each in due]
    assert told == [["cue", "anna", 1]] * 3
