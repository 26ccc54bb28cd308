"""Measures a performance: the real server works as with an editor, and real subscribers note the times of Twists."""

from __future__ import annotations

import json
import sys
import time
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from random import Random
from tempfile import TemporaryDirectory
from typing import Any

from improv_core.program.analysis import analyze
from improv_core.program.compiler import score_of
from improv_core.score.motion import Twist
from improv_core.stage.dry_run import perform
from tests.benchmarks.documents import Edit, improv
from tests.benchmarks.robots import (
    ENV,
    NOTHING,
    PYTHON,
    Due,
    Heard,
    Lateness,
    Listener,
    Plain,
    beat_0,
    lateness,
)
from tests.benchmarks.servers import Server
from tests.player.test_player import Memory

PATIENCE = 180.0
"""Seconds to wait for anything of the stage."""
STEP = 2.0
"""Meters of `forward` for a robot without a profile."""
OURS_IN_WORDS = "Improv"
LOOP_IN_WORDS = "an absolute loop"
"""Name of the plain script in tables."""
PROBE = "probe"
CAST = ("turtle1", "turtle2", "anna", "bruno", "clara", "drummer", "shaker", "walker")
"""Robots of `documents.improv`."""


class PlayError(Exception):
    """A measurement failed; the message is one plain line."""


@dataclass(frozen=True, slots=True)
class Reactions:
    """Times from a written message to its effect at a subscriber, in ms: `crossing` is the part after publishing.

    `unheard` is the number of saves without an effect, and `problems` the messages of the stage meanwhile.
    """

    saves: list[float]
    saves_while_playing: list[float]
    stops: list[float]
    crossing: list[float]
    unheard: int
    problems: list[str]


def reactions(cycles: int, lines: int) -> Reactions:
    """Save, save again while it plays, stop: repeatedly, with a program of one robot or of many lines."""
    random = Random(1)
    shortest = 0.5 if lines else 0.06  # so that the work of a save has ended
    text = f"beat 30\n{PROBE} $ repeat forward\n"
    if lines:
        text += "".join(improv(lines - 3).splitlines(keepends=True)[2:])
    robots = [PROBE, *CAST] if lines else [PROBE]
    saved: list[float] = []
    stopped: list[float] = []

    def pause() -> None:
        """Wait for a time that is never in step with the commands."""
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
                stopped.append(server.command("stop"))
        time.sleep(1)
        heard = listener.end()[_topic(PROBE)]
        problems = tap.problems()
    first: dict[float, Heard] = {}
    for each in heard:
        first.setdefault(round(each.x / STEP * 60, 6), each)
    answers = [first.get(float(beat)) for beat in beats[1:]]
    found = [(place, at, each) for place, (at, each) in enumerate(zip(saved, answers, strict=True)) if each]
    zeros = [(at, next(each for each in heard if each.heard > at and each.still)) for at in stopped]
    return Reactions(
        # The first save replaces the first dance; every other one from the third on follows a stop.
        [(each.heard - at) * 1000 for place, at, each in found if place and place % 2 == 0],
        [(each.heard - at) * 1000 for place, at, each in found if place % 2],
        [(each.heard - at) * 1000 for at, each in zeros],
        [(each.heard - each.published) * 1000 for each in [seen for _, seen in zeros] + [seen for *_, seen in found]],
        len(answers) - len(found),
        problems,
    )


def in_turns(count: int, rounds: int, seconds: int) -> dict[str, Lateness]:
    """Return the lateness of commands to this many robots: ours and those of a plain script, in turns, in the same
    minutes."""
    robots = [f"r{number}" for number in range(count)]
    program = _program(robots, seconds)
    ours = rehearsed(program)
    plain = [f"/loop/{robot}" for robot in robots]
    turns: list[tuple[str, float, Mapping[str, Sequence[Due]]]] = []
    with Listener("drain", [*ours, *plain]) as listener, _server() as (server, tap):
        server.open(program)
        for _ in range(rounds):
            server.save()
            turns.append((OURS_IN_WORDS, beat_0(tap.wait("playing")), ours))
            tap.wait("ended")
            time.sleep(0.5)
            played = Plain(seconds, plain)
            turns.append((LOOP_IN_WORDS, played.zero, played.due))
        heard = listener.end()
    found = {OURS_IN_WORDS: NOTHING, LOOP_IN_WORDS: NOTHING}
    for who, zero, due in turns:
        found[who] += lateness(heard, zero, due)
    return found


def rehearsed(program: str) -> dict[str, list[Due]]:
    """Return the commands that each topic should get."""
    memory = Memory()
    score = score_of(analyze(program))
    perform(score, memory)
    due: dict[str, list[Due]] = {part.topic: [] for part in score.parts.values()}
    latest: dict[str, Twist] = {}
    for robot, at, twist in memory.sent:
        due[score.parts[robot].topic].append(Due(at, latest.get(robot) != twist))
        latest[robot] = twist
    return due


class _Tap:
    """Transport messages of a server's stage."""

    def __init__(self, path: Path) -> None:
        self._path = path
        self._seen = 0

    def problems(self) -> list[str]:
        """Return the errors so far."""
        return [str(message["message"]) for message in self._messages() if message["type"] in ("error", "gone")]

    def wait(self, *states: str) -> dict[str, Any]:
        """Wait for the next message with one of these states. Raises PlayError if something fails first."""
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
    """Run our server, which plays on ROS 2 alone."""
    with TemporaryDirectory() as folder:
        path = Path(folder) / "tap"
        path.touch()
        command = (sys.executable, str(Path(__file__).with_name("tapped_server.py")), str(path))
        options = {"backend": "ros", "page": {"open": False}, "ros": {"python": PYTHON}}
        with Server(options, ENV, command) as server:
            yield server, _Tap(path)


def _program(robots: Sequence[str], seconds: int) -> str:
    """Write a program that repeats two beats, and lasts this many seconds."""
    return f"beat 60\n{' '.join(robots)} $ repeat {seconds // 2} (forward left)\n"


def _topic(robot: str) -> str:
    return f"/{robot}/cmd_vel"
