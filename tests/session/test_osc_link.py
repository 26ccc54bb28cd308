"""OSC messages reach stages like requests of pages. The process is a fake that the tests control."""

from __future__ import annotations

import asyncio
import threading
from dataclasses import replace

from improv_core.music.osc_link import HearOsc, OscLink, Reach
from improv_core.protocol.commands import PageRequest
from improv_core.protocol.helper_messages import ToOsc
from improv_core.score.osc import Osc, Peer
from improv_core.score.score import Score
from improv_core.session.acts import Now
from improv_core.session.on_request import on_request
from improv_core.session.state import PlayScore
from tests.session.fakes import Fake, Fakes, performed
from tests.session.story import DANCE, at

HERE, AWAY = Osc((Peer("127.0.0.1", 4560),), Peer("127.0.0.1", 7000)), Osc(listen=Peer("0.0.0.0", 7000))


class FakeProcess:
    def __init__(self, hear: HearOsc) -> None:
        self.hear = hear
        self.told: list[ToOsc] = []
        self.is_alive = True

    def put(self, message: ToOsc) -> None:
        self.told.append(message)

    def close(self) -> None:
        self.is_alive = False

    @property
    def kinds(self) -> list[str]:
        return [message["type"] for message in self.told]


class Linked:
    def __init__(self, fakes: Fakes, reach: Reach = "here") -> None:
        self.fakes = fakes
        self.processes: list[FakeProcess] = []
        playback = fakes.playback
        playback._osc = OscLink(reach, fakes.stops, playback.ask, playback._warn, self._start)  # type: ignore[arg-type]

    def _start(self, hear: HearOsc) -> FakeProcess:
        self.processes.append(FakeProcess(hear))
        hear({"type": "alive"})
        return self.processes[-1]

    async def play(self, osc: Osc | None = HERE) -> Fake:
        """Have a score played that needs this. Returns the stage that plays it."""
        score: Score = replace(DANCE, osc=osc)
        assert await self.fakes.playback.play(PlayScore(score, "dance.improv", self.fakes.stops.count))
        leader = self.fakes.latest("ros")
        leader.tell("playing")
        return leader

    async def ask(self, command: PageRequest) -> None:
        """Take a command from an OSC message: on a thread, then on the event loop."""
        hear = self.processes[-1].hear
        thread = threading.Thread(target=hear, args=({"type": "request", "command": command},))
        thread.start()
        await asyncio.to_thread(thread.join)
        await asyncio.sleep(0)


@performed
async def test_the_process_runs_while_a_score_needs_it_and_gets_the_leaders_messages(fakes: Fakes) -> None:
    linked = Linked(fakes)
    leader = await linked.play(None)
    assert linked.processes == []
    await linked.play()
    (process,) = linked.processes
    assert process.kinds == ["exchange", "plays", "transport"]
    assert process.told[0] == {
        "type": "exchange",
        "send": [{"host": "127.0.0.1", "port": 4560}],
        "listen": {"host": "127.0.0.1", "port": 7000},
        "time_tags": True,
    }
    fakes.latest("simulator").tell("playing", beat=1.0)
    leader.say({"type": "armed", "generation": 2, "armed": False, "begins": None})
    await linked.play()
    assert process.kinds[3:] == ["armed", "plays", "transport"]
    await linked.play(None)
    assert not process.is_alive


@performed
async def test_other_machines_are_reached_only_with_permission(fakes: Fakes) -> None:
    linked = Linked(fakes)
    await linked.play(AWAY)
    await linked.play(AWAY)
    assert linked.processes == []
    assert fakes.lines == [
        "OSC is off: 0.0.0.0:7000 in improv.toml reaches other machines. Allow that with --osc-network, or the setting"
        " osc.network"
    ]
    allowed = Linked(fakes, "network")
    await allowed.play(AWAY)
    assert len(allowed.processes) == 1
    nowhere = Linked(fakes, "nowhere")
    await nowhere.play(HERE)
    assert nowhere.processes == []


@performed
async def test_a_stop_is_obeyed_on_the_thread_that_hears_it(fakes: Fakes) -> None:
    linked = Linked(fakes)
    leader = await linked.play()
    linked.processes[0].hear({"type": "request", "command": {"type": "stop"}})  # the event loop is busy here
    assert leader.kinds == ["load", "stop"]
    assert (fakes.stops.count, fakes.stops.stopped) == (1, 1)
    linked.processes[0].hear({"type": "request", "command": {"type": "pause"}})
    assert leader.kinds == ["load", "stop", "pause"]


@performed
async def test_a_play_that_came_before_a_stop_does_not_play_after_it(fakes: Fakes) -> None:
    linked = Linked(fakes)
    leader = await linked.play()
    leader.tell("ended")
    linked.processes[0].hear({"type": "request", "command": {"type": "restart"}})
    fakes.stops.stop()
    await asyncio.sleep(0)
    assert leader.kinds == ["load", "stop"]


@performed
async def test_the_stages_know_requests_that_came_by_osc(fakes: Fakes) -> None:
    """They decide whether it may move robots: see tests/session/test_stays_stopped.py."""
    linked = Linked(fakes)
    leader, twin = await linked.play(), fakes.latest("simulator")
    await linked.ask({"type": "resume", "by": "osc"})
    await linked.ask({"type": "stop", "by": "osc"})
    leader.say(at("stopped", 1, startable_by=["osc"]))
    assert [message.get("by") for message in leader.sent[1:]] == ["osc", "osc"]
    assert [(each["type"], each.get("by")) for each in twin.sent[-2:]] == [("stop", "osc"), ("stop", "osc")]
    await linked.ask({"type": "restart", "by": "osc"})
    assert leader.loads[-1]["by"] == "osc"
    await linked.play()
    fakes.playback._do(on_request(fakes.playback.state, {"type": "restart"}, Now(stops=fakes.stops.count)))
    assert ["by" in load for load in leader.loads] == [False, True, False, False]
    leader.tell("playing")
    assert "by" not in twin.loads[-1]  # the leader has decided


@performed
async def test_a_process_that_has_ended_is_started_again_by_the_next_play(fakes: Fakes) -> None:
    linked = Linked(fakes)
    await linked.play()
    linked.processes[0].hear({"type": "warning", "message": "OSC can't be heard"})
    linked.processes[0].is_alive = False
    linked.processes[0].hear(None)
    await asyncio.sleep(0)
    assert fakes.lines == [
        "OSC can't be heard",
        "the process that speaks OSC has ended: the next play starts another one",
    ]
    await linked.play()
    assert [process.kinds for process in linked.processes][1] == ["exchange", "plays", "transport"]
