"""Reactions of the process that speaks OSC to datagrams, on a clock that the tests advance; and the process itself."""

from __future__ import annotations

import socket
import struct
import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from improv_core.ipc.child import Child, Policy
from improv_core.ipc.rate_limit import MAX_MESSAGES, PERIOD
from improv_core.music.osc import OscDesk
from improv_core.music.osc_wire import Argument, OscMessage, read, written
from improv_core.protocol.decoding import dumps, loads
from improv_core.protocol.helper_messages import FromOsc, ToOsc
from improv_core.protocol.limits import helper_command
from improv_core.score.algebra import repeat
from improv_core.score.reactions import pause
from improv_core.score.score_json import RowsWritten, to_json
from improv_core.score.senses import OscName
from tests.player.test_player import score
from tests.player.test_reacting import CUE, FORWARD, open_score
from tests.safety.stages import Stages
from tests.session.story import at

WALL = 1_800_000_000.0
LIMIT = 60.0
SCORE = open_score(senses={"drop": OscName("kick")}, anna=pause(repeat(FORWARD), CUE))


def datagram(address: str, *arguments: Argument, due: float = 0.0) -> bytes:
    return written([(f"/improv/{address}", arguments)], WALL + due)


class DeskOnClock:
    def __init__(self, show: Path | None = None) -> None:
        self.now = 1000.0
        self.said: list[FromOsc] = []
        self.desk = OscDesk(self.said.append, lambda: self.now, lambda: WALL + self.now - 1000, show)
        self.desk.take({"type": "plays", "generation": 1, "score": loads(dumps(to_json(SCORE, RowsWritten())))})
        self.desk.take(at("playing", 1))

    def hear(self, *datagrams: bytes, host: str = "127.0.0.1") -> None:
        for each in datagrams:
            self.desk.read(each, host)

    def turn(self, seconds: float) -> None:
        end = self.now + seconds
        while self.desk.due <= end:
            self.now = max(self.desk.due, self.now)
            self.desk.advance(self.now)
        self.now = end

    @property
    def asked(self) -> list[Any]:
        return [each["command"]["type"] for each in self.said if each["type"] == "request"]

    @property
    def lines(self) -> list[str]:
        return [each["message"] for each in self.said if each["type"] == "warning"]


def check(datagrams: Sequence[bytes], asked: Sequence[str], lines: Sequence[str] = (), host: str = "127.0.0.1") -> None:
    desk = DeskOnClock()
    desk.hear(*datagrams, host=host)
    desk.turn(1.0)
    assert (desk.asked, desk.lines) == (asked, lines)


def test_unreadable_messages_and_strangers_move_nothing_and_are_reported_once() -> None:
    broken = b"#bundle\0\0\0\0\0\0\0\0\1\x7f\xff\xff\xff/a"
    check([broken] * 10, [], ["something that is not an OSC message was ignored"])
    check([datagram("seek", "x" * 5000)] * 3, [], ["an OSC message longer than 4,096 bytes was ignored"])
    stranger = "an OSC message from 10.0.0.7 was ignored: only this machine and those in `send` under [osc] count"
    check([datagram("stop"), datagram("cue")], [], [stranger], host="10.0.0.7")
    check([datagram("dance")] * 10, [], ["an OSC message was ignored: there is no /improv/dance"])


def test_only_stops_count_in_a_flood() -> None:
    flood = [datagram("seek", float(beat)) for beat in range(10_000)]
    line = f"more than {MAX_MESSAGES} OSC messages came within a second: only stops count"
    check([*flood, datagram("stop"), *flood, datagram("pause")], ["seek", "stop", "pause"], [line])
    bundle = written([("/improv/seek", [beat]) for beat in range(100)] + [("/improv/stop", [])], WALL)
    check([bundle] * 20, ["seek", "stop", "stop"], [line])


def test_a_stop_goes_straight_to_stages_and_a_halted_one_delays_nothing() -> None:
    with TemporaryDirectory(dir="/tmp") as folder:
        show = Path(folder, "7-abc")
        stages = Stages(show, "ros", "simulator", hangs="simulator")
        desk = DeskOnClock(show)
        desk.hear(datagram("stop"), datagram("cue"))
        desk.turn(PERIOD)
        assert desk.asked == ["stop", "cue"]
        stop = next(each["command"] for each in desk.said if each["type"] == "request")
        assert stop["type"] == "stop"
        assert stop["by"] == "osc"
        stages.wait(2)
        assert sorted(stages.stops) == [("ros", stop), ("simulator", stop)]
        stages.close()


def test_requests_are_passed_on_fifty_times_a_second_and_short_presses_are_not_lost() -> None:
    desk = DeskOnClock()
    desk.hear(datagram("cue"))
    for value in (1, 0, 1, 0):
        desk.hear(datagram("sense", "kick", "anna", value))
    desk.turn(PERIOD)
    values = [each["command"]["value"] for each in desk.said[1:] if "value" in each["command"]]  # type: ignore[typeddict-item]
    assert (desk.asked, values) == (["cue", "osc_sense", "osc_sense"], [True, False])


def test_only_senses_wait_until_they_are_due() -> None:
    desk = DeskOnClock()
    desk.hear(datagram("cue", due=0.5), datagram("seek", 8.0, due=0.5))
    desk.turn(0.45)
    assert desk.asked == ["seek"]
    desk.turn(0.1)
    assert desk.asked == ["seek", "cue"]
    desk.hear(datagram("cue", due=60))
    assert desk.asked == ["seek", "cue", "cue"]
    assert desk.lines == ["an OSC message was due more than 2 s later, and was obeyed at once: compare clocks"]


@contextmanager
def running(*messages: ToOsc) -> Iterator[Child]:
    child = Child(helper_command("music.osc"), Policy(LIMIT))
    try:
        for message in messages:
            child.write(dumps(message) + b"\n")
        yield child
    finally:
        assert child.end() == 0


def said_by(child: Child, count: int) -> list[FromOsc]:
    said: list[FromOsc] = []
    end = time.monotonic() + LIMIT
    while len(said) < count and time.monotonic() < end:
        said += map(loads, child.read(end - time.monotonic()))
    return said


def exchange(port: int) -> ToOsc:
    return {"type": "exchange", "send": [], "listen": {"host": "127.0.0.1", "port": port}, "time_tags": True}


def telling(port: int, *, time_tags: bool) -> ToOsc:
    return {"type": "exchange", "send": [{"host": "localhost", "port": port}], "listen": None, "time_tags": time_tags}


@contextmanager
def bound() -> Iterator[tuple[socket.socket, int]]:
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as made:
        made.bind(("127.0.0.1", 0))
        made.settimeout(LIMIT)
        yield made, made.getsockname()[1]


def test_a_real_datagram_is_a_request() -> None:
    with bound() as (_, port):
        pass
    with running(exchange(port)) as child, socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as other:
        end, said = time.monotonic() + LIMIT, list[Any]()
        while not said and time.monotonic() < end:  # until it listens
            other.sendto(datagram("seek", 8.0), ("127.0.0.1", port))
            said = [each for line in child.read(0.1) if (each := loads(line)) != {"type": "alive"}]
    assert said[0]["command"].items() >= {"type": "seek", "beat": 8.0}.items()


def test_beats_are_sent_as_they_are_due() -> None:
    with bound() as (other, port):
        play: ToOsc = {"type": "plays", "generation": 1, "score": to_json(score("r $ repeat forward"), RowsWritten())}
        now: ToOsc = at("playing", 1, monotonic=time.monotonic(), tempo=240.0)
        heard: list[tuple[OscMessage, int]] = []
        with running(telling(port, time_tags=True), play, now):
            while len(heard) < 6:  # state, word, and four beats
                bundle = other.recv(4096)
                (tag,) = struct.unpack(">Q", bundle[8:16])  # in seconds since 1900, times 2³²
                heard += [(each, tag) for each in read(bundle)]
    said = [(each.address, *each.arguments) for each, _ in heard]
    assert said[0] == ("/improv/state", "playing")
    assert ("/improv/word", "r", "forward") in said
    beats: list[Any] = [(each.arguments[0], tag / 2**32) for each, tag in heard if each.address == "/improv/beat"]
    (first, began), *later = beats  # beats that are long past are left out
    assert [round(tag - began, 3) for _, tag in later] == [(number - first) * 0.25 for number, _ in later]


def test_programs_that_read_no_bundles_get_messages() -> None:
    with bound() as (other, port), running(telling(port, time_tags=False), at("paused", 1)):
        assert other.recv(4096) == b"/improv/state\0\0\0,s\0\0paused\0\0"


def test_a_port_that_is_taken_is_tried_again_for_two_seconds_and_then_reported() -> None:
    desk = DeskOnClock()
    with bound() as (_, port):
        desk.desk.take(exchange(port))
        desk.turn(1.0)
    desk.turn(0.5)
    assert (len(desk.desk.sockets), desk.lines) == (1, [])
    with bound() as (_, port):
        desk.desk.take(exchange(port))
        desk.turn(2.5)
    why = "Address already in use; change `listen` under [osc] in improv.toml, then save"
    assert desk.lines == [f"OSC can't listen on 127.0.0.1:{port}: {why}"]


def test_a_failure_is_reported() -> None:
    child = Child(helper_command("music.osc"), Policy(LIMIT))
    child.write(b'{"type": "plays", "generation": 1, "score": {}}\n')
    *_, said = said_by(child, 2)
    assert said == {"type": "warning", "message": "OSC fails: KeyError: 'known'"}
    assert child.end() == 1
