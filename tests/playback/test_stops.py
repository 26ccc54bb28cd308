"""Nothing that was asked for before a stop plays after it, whichever threads both come from."""

from __future__ import annotations

import threading

from improv_core.playback.stops import Stops
from improv_core.stage.protocol import Load, ToStage


class Stage:
    """Remembers what it is sent."""

    def __init__(self) -> None:
        self.sent: list[ToStage] = []

    def send(self, message: ToStage) -> None:
        self.sent.append(message)

    @property
    def kinds(self) -> list[str]:
        return [message["type"] for message in self.sent]


def load(asked: int) -> Load:
    """What was asked for after so many stops."""
    return {"type": "load", "generation": asked, "score": {}, "when": "restart", "backend": "fake"}


def test_what_was_asked_for_before_a_stop_is_not_sent_after_it() -> None:
    stops, stage = Stops(), Stage()
    asked = stops.count
    stops.stop()  # also if no stage is there yet
    stops.add(stage)
    assert not stops.send(load(asked), [stage], asked)
    assert stage.sent == []
    assert stops.send(load(1), [stage], stops.count)
    assert stage.kinds == ["load"]


def test_requests_of_a_page_carry_the_count_and_stops_among_them_are_obeyed_at_once() -> None:
    stops, stage = Stops(), Stage()
    stops.add(stage)
    assert stops.arrive({"type": "restart"}) == 0
    assert stops.arrive({"type": "hush"}) == 1
    assert stops.arrive({"type": "restart"}) == 1
    assert stops.arrive({"type": "pause"}) == 2
    assert stops.arrive({"type": "resume"}) == 2
    assert stage.kinds == ["hush", "pause"]
    stops.discard(stage)
    stops.stop()
    assert stage.kinds == ["hush", "pause"]


def test_it_does_not_matter_how_threads_take_turns() -> None:
    stops, stage = Stops(), Stage()
    stops.add(stage)
    rounds = 20_000

    def stop() -> None:
        for _ in range(rounds):
            stops.stop()

    stopping = threading.Thread(target=stop)
    stopping.start()
    sent = sum(stops.send(load(asked := stops.count), [stage], asked) for _ in range(rounds))
    stopping.join()
    assert len(stage.sent) == rounds + sent
    stopped = 0
    for message in stage.sent:
        if message["type"] == "hush":
            stopped += 1
        elif message["type"] == "load":
            assert message["generation"] == stopped
