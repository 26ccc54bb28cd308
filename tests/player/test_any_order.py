"""Requests in any order: robots that are not edited play as if nothing had been saved, and a stop lasts.

The edited stage prepares its changes, and the other one doesn't.
"""

from __future__ import annotations

import math
import random
from dataclasses import replace

import pytest
from hypothesis import settings

from improv_core.protocol.messages import When
from improv_core.protocol.output import Edge, StopButton
from improv_core.safety.pending_zeros import LAST_ZEROS
from improv_core.score.motion import STILL
from improv_core.score.score import Safety, Score
from tests.player.test_continuing import ANNA, BERT, Continuing
from tests.player.test_player import DEADMAN, STOP, score

SAFETY = Safety(stop=STOP, deadman=DEADMAN)
OTHERS = (BERT, "bert $ slow 3 right\n", "bert $ left\ncleo $ repeat forward\n", "cleo $ repeat (forward right)\n", "")
WHENS: tuple[When, ...] = ("now", "beat", "bar", "end")
STEPS = 150


class Walk:
    """A stage that is edited, and one that is not: both get the same requests, except for edits of other lines."""

    def __init__(self, seed: int, *, real: bool) -> None:
        self.dice = random.Random(seed)
        self.edited, self.alone = self.both = Continuing(), Continuing()
        self.tempo, self.beat, self.restarted = 60, 0.0, 0
        self.held = self.stopped = False
        self.edited.prepares = True
        for stage in self.both:
            stage.sink.real = real
        self.hold()
        self.restart()

    def program(self, others: str) -> Score:
        return replace(score(f"beat {self.tempo}\n{ANNA}{others}"), safety=SAFETY)

    def restart(self) -> None:
        self.beat = 0.0
        self.edited.save(self.program(self.dice.choice(OTHERS)), "restart")
        self.alone.save(self.program(BERT), "restart")

    def edit(self) -> None:
        state = self.alone.player.run.mode
        self.edited.save(self.program(self.dice.choice(OTHERS)), self.dice.choice(WHENS))
        if state == "paused" and not self.stopped:
            self.alone.ask("resume")
        elif state == "stopped":
            self.beat = 0.0
            self.alone.save(self.program(BERT), "now")

    def change_tempo(self) -> None:
        if self.stopped:
            return  # the stage would refuse it
        if self.alone.player.run.mode == "stopped":
            self.beat = 0.0
        self.tempo = self.dice.choice((40, 60, 97))
        self.edited.save(self.program(self.dice.choice(OTHERS)), "now")
        self.alone.save(self.program(BERT), "now")

    def ask(self, kind: str, **given: object) -> None:
        for stage in self.both:
            stage.ask(kind, **given)

    def pause(self) -> None:
        self.ask("pause")

    def resume(self) -> None:
        self.ask("resume")

    def stop(self) -> None:
        self.ask("stop")

    def seek(self) -> None:
        self.beat = self.dice.choice((0.0, 3.0, 7.3))
        self.ask("seek", beat=self.beat)

    def set_speed(self) -> None:
        self.ask("speed", factor=self.dice.choice((0.5, 1.0, 2.0)))

    def silence(self) -> None:
        muted, soloed = self.dice.choice(((), ("anna",), ("bert",))), self.dice.choice(((), (), ("anna",), ("cleo",)))
        self.ask("silence", muted=muted, soloed=soloed)

    def hold(self) -> None:
        self.held = not self.held
        for stage in self.both:
            stage.player.sense(Edge(str(DEADMAN), self.held, stage.now), stage.now)

    def press_stop(self) -> None:
        self.stopped = not self.stopped
        for stage in self.both:
            stage.player.sense(Edge(StopButton(STOP), self.stopped, stage.now), stage.now)

    def run(self, seconds: float) -> None:
        for stage in self.both:
            told, sent = len(stage.told), len(stage.sink.sent)
            stage.run(seconds)
            for message in stage.told[told:]:
                assert message["type"] != "error", message
            if stage.player.run.mode in ("paused", "stopped"):
                assert all(twist == STILL for _, _, twist in stage.sink.sent[sent:])
        alone, edited = (
            stage.player.run.beat(stage.now, stage.player._tracks.active_parts.over) for stage in self.both
        )
        assert self.edited.player.run.mode == self.alone.player.run.mode
        assert float(edited) == pytest.approx(float(alone))
        assert alone >= self.beat - 1e-9
        self.beat = float(alone)
        queued = [due.mover for due in self.edited.player._tracks.queue._queue]
        assert len(queued) == len(set(queued))

    def check(self) -> None:
        assert self.edited.sent_to("anna") == self.alone.sent_to("anna")
        self.stop()
        self.run(1)
        for stage in self.both:
            assert stage.player.deadline(stage.now) == math.inf
            for robot in {robot for robot, _, _ in stage.sink.sent}:
                last = [twist for _, _, twist in stage.sent_to(robot)[-LAST_ZEROS:]]
                assert last == [STILL] * LAST_ZEROS, robot


@pytest.mark.parametrize("real", [False, True])
@pytest.mark.parametrize("seed", [*range(settings().max_examples // 20), 42])
def test_requests_in_any_order(seed: int, real: bool) -> None:
    walk = Walk(seed, real=real)
    often = [walk.edit] * 10
    rarely = [walk.pause, walk.resume, walk.resume, walk.stop, walk.seek, walk.set_speed, walk.silence, walk.restart]
    edges = [walk.hold, walk.hold, walk.press_stop, walk.press_stop] if real else []
    for _ in range(STEPS):
        walk.dice.choice([*often, *rarely, walk.change_tempo, *edges])()
        walk.run(walk.dice.choice((0.0, 0.013, 0.2, 0.5, 1.7)))
    walk.check()
