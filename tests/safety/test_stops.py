"""Nothing that was requested before a stop plays after it, no matter which threads both come from."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable

import pytest

from improv_core.protocol.commands import Automation, Restart, Stop
from improv_core.protocol.messages import Load, ToStage
from improv_core.safety.stops import BEHIND, KNOWN, Stops


class Stage:
    """A stage that remembers its messages."""

    def __init__(self) -> None:
        self.sent: list[ToStage] = []

    def send(self, message: ToStage) -> None:
        self.sent.append(message)

    @property
    def kinds(self) -> list[str]:
        return [message["type"] for message in self.sent]


def load(asked: int) -> Load:
    """A request made after this many stops."""
    return {"type": "load", "generation": asked, "score": {}, "when": "restart", "backend": "fake"}


def test_requests_made_before_a_stop_are_not_sent_after_it() -> None:
    stops, stage = Stops(), Stage()
    asked = stops.count
    stops.stop()  # even if there is no stage yet
    stops.add(stage)
    assert not stops.send(load(asked), stage, asked)
    assert stage.sent == []
    assert stops.send(load(1), stage, stops.count)
    assert stage.kinds == ["load"]


def test_page_requests_carry_the_count_and_their_stops_are_obeyed_at_once() -> None:
    stops, stage = Stops(), Stage()
    stops.add(stage)
    assert stops.arrive({"type": "restart"}) == 0
    assert stops.arrive({"type": "stop"}) == 1
    assert stops.arrive({"type": "restart"}) == 1
    assert stops.arrive({"type": "pause"}) == 2
    assert stops.arrive({"type": "resume"}) == 2
    assert stage.kinds == ["stop", "pause"]
    stops.discard(stage)
    stops.stop()
    assert stage.kinds == ["stop", "pause"]


def test_requests_made_before_the_machine_slept_are_not_sent_after_it() -> None:
    slept = 1000.0
    stops, stage = Stops(lambda: slept), Stage()
    asked = stops.count
    assert stops.send(load(asked), stage, asked)
    slept = 1030.0
    assert not stops.send(load(asked), stage, asked)
    assert stops.send(load(2), stage, stops.count)
    assert [message.get("asleep") for message in stage.sent] == [1000.0, 1030.0]
    assert stops.count == 1, "it has slept once"


def test_threads_can_take_turns_in_any_order() -> None:
    stops, stage = Stops(), Stage()
    stops.add(stage)
    rounds = 20_000

    def stop() -> None:
        for _ in range(rounds):
            stops.stop()

    stopping = threading.Thread(target=stop)
    stopping.start()
    sent = sum(stops.send(load(asked := stops.count), stage, asked) for _ in range(rounds))
    stopping.join()
    assert len(stage.sent) == rounds + sent
    stopped = 0
    for message in stage.sent:
        if message["type"] == "stop":
            stopped += 1
        elif message["type"] == "load":
            assert message["generation"] == stopped


def test_a_stop_that_has_gone_straight_to_stages_counts_once_whoever_reports_it_first() -> None:
    stops, simulator, real = Stops(), Stage(), Stage()
    stops.add(simulator)
    stops.add(real)
    report: Stop = {"type": "stop", "direct": "page 1", "at": time.monotonic()}
    assert stops.arrive({"type": "stop", "direct": "page 1"}) == 1
    assert [stops.arrive(report), stops.arrive(report)] == [1, 1]
    assert stops.has_settled("page 1")
    stops.stop({"type": "pause"})
    stops.stop({"type": "stop", "direct": "improv stop"})
    assert stops.arrive({"type": "stop", "direct": "improv stop"}) == 3
    for stage in (simulator, real):
        assert [message.get("direct") for message in stage.sent] == ["page 1", None, "improv stop"]


@pytest.mark.parametrize("by", [None, "osc"])
def test_a_request_is_older_than_a_stop_that_overtakes_it_by_way_of_a_stage(by: Automation | None) -> None:
    stops, stage = Stops(), Stage()
    began = time.monotonic()
    stop: Stop = {"type": "stop", "direct": "x", "at": began}
    before: Restart = {"type": "restart", "at": began - 0.001}
    after: Restart = {"type": "restart", "at": began + 0.001}
    if by:
        stop["by"] = before["by"] = after["by"] = by
    stops.arrive(stop)
    assert not stops.send(load(0), stage, stops.arrive(before))
    assert stops.send(load(1), stage, stops.arrive(after))


@pytest.mark.parametrize("threads", [True, False])
def test_stages_obey_nothing_for_a_while_if_we_were_halted_when_somebody_stopped_them(
    threads: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Requests that arrive with the report may have waited since before the stop."""
    later: list[tuple[float, Callable[[], None]]] = []

    class Timer:
        def __init__(self, seconds: float, act: Callable[[Stop], None], given: list[Stop]) -> None:
            self._later = seconds, lambda: act(*given)

        def start(self) -> None:
            if not threads:
                raise RuntimeError("can't start new thread")
            later.append(self._later)

    monkeypatch.setattr(threading, "Timer", Timer)
    stops, stage = Stops(), Stage()
    stops.add(stage)
    stops.arrive({"type": "stop", "direct": "x", "by": "osc", "at": time.monotonic() - 2 * BEHIND})
    for seconds, repeat in later:
        assert (seconds, stops.has_settled("x")) == (KNOWN, False)
        assert stops.arrive({"type": "stop", "direct": "x"}) == 1
        repeat()
    assert stops.has_settled("x")
    assert [(message.get("direct"), message.get("by")) for message in stage.sent] == [(None, "osc"), ("x", "osc")]
    assert stops.count == 2, "what has arrived since is as old as the stop"


@pytest.mark.parametrize(("by", "sent"), [("osc", True), ("ros", False), (None, False)])
def test_an_automation_may_continue_at_once_after_its_own_stop(by: Automation | None, sent: bool) -> None:
    """On a busy machine, its stop may reach us late, too, but always before what it asks for next."""
    stops, stage = Stops(), Stage()
    stops.add(stage)
    stops.arrive({"type": "stop", "direct": "x", "by": "osc", "at": time.monotonic() - 2 * BEHIND})
    play: Restart = {"type": "restart", "by": by} if by else {"type": "restart"}
    asked = stops.arrive(play)
    assert stops.has_settled("x") == sent
    assert stops.send({"type": "resume"}, stage, asked) == sent, "stages would obey nothing"
    assert stops.count == 1 + sent
