"""Measures what plays: the real server is driven as by an editor, and real subscribers note when Twists come."""

from __future__ import annotations

import json
import math
import os
import sys
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from itertools import pairwise
from pathlib import Path
from random import Random
from tempfile import TemporaryDirectory
from typing import Any

from improv_core.stage.setpoints import LAST_ZEROS
from tests.benchmarks.documents import IMPROV, Edit, edits, improv
from tests.benchmarks.robots import ENV, PYTHON, RATE, Heard, Lateness, Listener, Steady, lateness, start_anew
from tests.benchmarks.servers import OURS, Server, memory
from tests.processes import descendants

TYPED_LINES = 1_000
KEYS_A_SECOND = 20
PATIENCE = 180.0
"""Seconds to wait for anything of the stage."""
STEP = 2.0
"""Metres of `forward` of a robot whose kind nobody has said."""
PROBE = "probe"
CAST = ("turtle1", "turtle2", "anna", "bruno", "clara", "drummer", "shaker", "walker")
"""The robots of `documents.improv`."""


class PlayError(Exception):
    """What was to be measured did not happen; one plain line."""


@dataclass(frozen=True, slots=True)
class Reactions:
    """How long it took from a message written to its effect heard, in ms: `crossing` is the part after publishing.

    `unheard` is how many saves had no effect, and `problems` what the stage said meanwhile.
    """

    saves: list[float]
    saves_while_playing: list[float]
    hushes: list[float]
    crossing: list[float]
    unheard: int
    problems: list[str]


@dataclass(frozen=True, slots=True)
class Crowd:
    """A thousand robots: lateness; the stage's and the listener's processor seconds a second; MB; the first save and
    a later one to the first Twist and to the last robot's first one, in ms."""

    lateness: Lateness
    stage_cpu: float
    listener_cpu: float
    memory: float
    first_save: float
    save: float
    save_to_last: float


def reactions(cycles: int, lines: int) -> Reactions:
    """Save, save again while it plays, hush: so many times, with a program of one robot or of so many lines."""
    random = Random(1)
    shortest = 0.5 if lines else 0.06  # so that whatever a save begins has been done
    text = f"beat 30\n{PROBE} $ repeat forward\n"
    if lines:
        text += "".join(improv(lines - 3).splitlines(keepends=True)[2:])
    robots = [PROBE, *CAST] if lines else [PROBE]
    saved: list[float] = []
    hushed: list[float] = []

    def pause() -> None:
        """Never in step with the commands."""
        time.sleep(shortest + random.uniform(0, 0.1))

    with Listener("spin", [*map(_topic, robots)]) as listener, _server() as (server, tap):
        server.open(text)
        server.save()
        tap.wait("playing")
        beats = [str(30 + number) for number in range(2 * cycles + 1)]
        for place, (old, new) in enumerate(pairwise(beats)):
            pause()
            server.change(Edit(0, len(f"beat {old}"), f"beat {new}", False))
            saved.append(server.save())
            if place % 2:
                pause()
                hushed.append(server.command("improv.hush"))
        time.sleep(1)
        heard = listener.end()[_topic(PROBE)]
        problems = tap.problems()
    first: dict[float, Heard] = {}
    for each in heard:
        first.setdefault(round(each.x / STEP * 60, 6), each)
    answers = [first.get(float(beat)) for beat in beats[1:]]
    found = [(place, at, each) for place, (at, each) in enumerate(zip(saved, answers, strict=True)) if each]
    zeros = [(at, next(each for each in heard if each.heard > at and each.still)) for at in hushed]
    return Reactions(
        # The first save replaces what plays since the start; every other from the third one on follows a hush.
        [(each.heard - at) * 1000 for place, at, each in found if place and place % 2 == 0],
        [(each.heard - at) * 1000 for place, at, each in found if place % 2],
        [(each.heard - at) * 1000 for at, each in zeros],
        [(each.heard - each.published) * 1000 for each in [seen for _, seen in zeros] + [seen for *_, seen in found]],
        len(answers) - len(found),
        problems,
    )


def anew(times: int) -> list[float]:
    """From the start of a plain script to its first Twist heard, in ms."""
    topic = "/anew/cmd_vel"
    with Listener("spin", [topic]) as listener:
        begun = [start_anew(topic) for _ in range(times)]
        heard = listener.end()[topic]
    return [(next(each.heard for each in heard if each.heard > begin) - begin) * 1000 for begin in begun]


def beside_typing(count: int, seconds: int, plain_seconds: int) -> tuple[Lateness, Lateness]:
    """The lateness of commands to so many robots while somebody types, and then of a plain publisher's."""
    robots = [f"r{number}" for number in range(count)]
    plain = [f"/plain/r{number}" for number in range(count)]
    with Listener("drain", [*map(_topic, robots), *plain]) as listener, _server() as (server, tap):
        server.open(_program(robots, seconds, 60))
        server.save()
        zero = _zero(tap.wait("playing"))
        server.replace(improv(TYPED_LINES))
        _type(server, lambda: tap.state() != "playing")
        tap.wait("ended")
        time.sleep(0.5)
        steady = Steady(plain_seconds, plain)
        _type(server, lambda: not steady.runs)
        heard = listener.end()
    ours = {topic: heard[topic] for topic in map(_topic, robots)}
    _check(ours, seconds)
    theirs = {topic: heard[topic] for topic in plain}
    return lateness(ours, zero, _due(seconds)), lateness(theirs, steady.zero(), steady.due)


def crowd(count: int, seconds: int) -> Crowd:
    """So many robots at once."""
    robots = [f"r{number}" for number in range(count)]
    with Listener("drain", [*map(_topic, robots)]) as listener, _server() as (server, tap):
        server.open(_program(robots, seconds, 60))
        saved = server.save()
        zero = _zero(tap.wait("playing"))
        both = _stage(server), listener.pid
        before = [_cpu(pid) for pid in both]
        begin = time.monotonic()
        tap.wait("ended")
        passed = time.monotonic() - begin
        stage_cpu, listener_cpu = ((_cpu(pid) - was) / passed for pid, was in zip(both, before, strict=True))
        now, _ = memory(both[0])
        time.sleep(1)
        server.replace(_program(robots, 2, 90))
        again = server.save()
        tap.wait("ended")
        time.sleep(1)
        heard = listener.end()
    first = {topic: [each for each in messages if each.published < again] for topic, messages in heard.items()}
    later = [min(each.received for each in messages if each.published > again) for messages in heard.values()]
    _check(first, seconds)
    return Crowd(
        lateness(first, zero, _due(seconds)),
        stage_cpu,
        listener_cpu,
        now,
        (min(messages[0].received for messages in first.values()) - saved) * 1000,
        (min(later) - again) * 1000,
        (max(later) - again) * 1000,
    )


class _Tap:
    """The transport messages of a server's stage."""

    def __init__(self, path: Path) -> None:
        self._path = path
        self._seen = 0

    def state(self) -> str:
        """The latest state; `gone` where the stage is."""
        told = [message for message in self._messages() if message["type"] in ("transport", "gone")]
        return str(told[-1].get("state", "gone"))

    def problems(self) -> list[str]:
        """What went wrong so far."""
        return [str(message["message"]) for message in self._messages() if message["type"] in ("error", "gone")]

    def wait(self, *states: str) -> dict[str, Any]:
        """The next message that tells one of these states. Raises PlayError if something goes wrong instead."""
        end = time.monotonic() + PATIENCE
        while time.monotonic() < end:
            messages = self._messages()
            for message in messages[self._seen :]:
                self._seen += 1
                if message["type"] in ("error", "gone"):
                    raise PlayError(message["message"])
                if message.get("state") in states:
                    return message
            time.sleep(0.02)
        raise PlayError(f"not {states} within {PATIENCE} s, but {messages}")

    def _messages(self) -> list[dict[str, Any]]:
        text = self._path.read_text(encoding="utf-8")
        return [json.loads(line) for line in text.splitlines(keepends=True) if line.endswith("\n")]


@contextmanager
def _server() -> Iterator[tuple[Server, _Tap]]:
    """Our server, which plays on ROS 2 alone."""
    with TemporaryDirectory() as folder:
        path = Path(folder) / "tap"
        path.touch()
        command = (sys.executable, str(Path(__file__).with_name("tapped_server.py")), str(path))
        options = {"backend": "ros", "page": {"open": False}, "ros": {"python": PYTHON}}
        with Server(replace(OURS, command=command, options=options), ENV) as server:
            yield server, _Tap(path)


def _program(robots: Sequence[str], seconds: int, beat: int) -> str:
    """Two beats again and again, `seconds` long at beat 60."""
    return f"beat {beat}\n{' '.join(robots)} $ repeat {seconds // 2} (forward left)\n"


def _due(seconds: int) -> list[float]:
    return [count / RATE for count in range(seconds * RATE + LAST_ZEROS)]


def _check(heard: Mapping[str, Sequence[Heard]], seconds: int) -> None:
    """Raises RuntimeError if anything else came than what the program says."""
    for topic, messages in heard.items():
        for each in messages:
            beat, end = divmod((each.number - 1) / RATE, 2)[1], each.number > seconds * RATE
            wanted = (0.0, 0.0) if end else (STEP, 0.0) if beat < 1 else (0.0, math.pi / 2)
            if (each.x, each.yaw) != wanted:
                raise RuntimeError(f"{topic}: {each} instead of {wanted}")


def _type(server: Server, until: Callable[[], bool]) -> None:
    """Type into the document, at times that are never in step with the commands."""
    random = Random(2)
    due = time.monotonic()
    for edit in edits(IMPROV, improv(TYPED_LINES)):
        if until():
            return
        due += random.uniform(0.5, 1.5) / KEYS_A_SECOND
        time.sleep(max(due - time.monotonic(), 0))
        server.change(edit)


def _zero(transport: Mapping[str, Any]) -> float:
    """When beat 0 was, by the monotonic clock."""
    return float(transport["monotonic"] - transport["beat"] * 60 / transport["tempo"])


def _topic(robot: str) -> str:
    return f"/{robot}/cmd_vel"


def _stage(server: Server) -> int:
    """The process of the server's stage."""
    for pid, descriptor in descendants(server.pid).items():
        os.close(descriptor)
        if b"--sink" in Path(f"/proc/{pid}/cmdline").read_bytes():
            return pid
    raise RuntimeError("no stage runs")


def _cpu(pid: int) -> float:
    """Seconds of a processor that a process has used (Linux)."""
    fields = Path(f"/proc/{pid}/stat").read_text(encoding="utf-8").rpartition(")")[2].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")
