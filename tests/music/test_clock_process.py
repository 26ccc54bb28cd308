"""The process that listens to a clock of music: from bytes on a cable, or a Link session, to its messages."""

from __future__ import annotations

import asyncio
import ctypes
import importlib.util
import os
import subprocess
import sys
import time
from collections.abc import Awaitable, Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pytest

from improv_core.music import link, midi
from improv_core.music.clock_process import ClockProcess
from improv_core.score.score import Follow, OutsideClock
from tests.needs import lacking, need

LIMIT = 60.0
TICK = 1 / 48
"""Seconds, at 120 beats per minute."""


Until = Callable[..., Awaitable[Any]]


@contextmanager
def listening(clock: OutsideClock, tempo: float = 120.0) -> Iterator[Until]:
    """Listen to a clock. The result returns the next message of a type that fits."""
    heard: asyncio.Queue[Any] = asyncio.Queue()
    process = ClockProcess(clock, tempo, heard.put_nowait)

    async def until(kind: str, fits: Callable[[Any], bool] = lambda message: True) -> Any:
        while (message := await asyncio.wait_for(heard.get(), LIMIT))["type"] != kind or not fits(message):
            pass
        return message

    try:
        yield until
    finally:
        process.close()


@pytest.fixture
def cable(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    path = tmp_path / "cable"
    os.mkfifo(path)
    monkeypatch.setenv("MIDO_BACKEND", "midi_cable")
    monkeypatch.setenv("MIDI_CABLE", str(path))
    monkeypatch.setenv("PYTHONPATH", str(Path(__file__).parent))
    return path


def send(cable: Path, count: int) -> None:
    """A start, and ticks at 120 beats per minute."""
    with cable.open("wb", buffering=0) as bytes_to:
        begin = time.monotonic()
        bytes_to.write(b"\xfa")
        for tick in range(count):
            time.sleep(max(begin + tick * TICK - time.monotonic(), 0))
            bytes_to.write(b"\xf8")
        bytes_to.write(b"\xfc")


async def test_the_parent_receives_ticks_from_a_cable(cable: Path) -> None:
    with listening(OutsideClock("midi", "cab")) as until:
        sending = asyncio.create_task(asyncio.to_thread(send, cable, 36))
        began = time.monotonic()
        anchor = await until("anchor", lambda each: each["beat"] > 1)
        assert anchor["tempo"] > 0  # `test_midi_time` checks the value: here, ticks may come late
        assert began < anchor["at"] < time.monotonic()
        assert (await until("anchor", lambda each: each["tempo"] == 0))["beat"] == 1.5
        await sending


@pytest.mark.slow("it is looked for inputs every two seconds")
async def test_a_cable_that_is_pulled_is_a_line(cable: Path) -> None:
    with listening(OutsideClock("midi")) as until:
        await asyncio.to_thread(send, cable, 2)
        await asyncio.to_thread(cable.unlink)
        lines = [(await until("warning"))["message"] for _ in range(2)]
        assert lines == ["the MIDI input cable is gone: connect it again", "there is no MIDI input: connect one"]


async def test_an_input_that_is_not_there_is_a_line_with_those_that_are(cable: Path) -> None:
    with listening(OutsideClock("midi", "IAC")) as until:
        line = "there is no MIDI input whose name begins with IAC: there are cable"
        assert (await until("warning"))["message"] == line


@pytest.mark.parametrize(
    ("follow", "environment", "line"),
    [
        ("midi", {"MIDO_BACKEND": "nobody_has_this"}, midi.LACKS),
        ("midi", {"MIDO_BACKEND": "midi_cable"}, "this machine has no MIDI: 'MIDI_CABLE'"),  # its name is missing
        ("link", {}, link.LACKS),
    ],
)
async def test_a_line_says_why_a_clock_cannot_be_heard(
    follow: Follow, environment: dict[str, str], line: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "aalink.py").write_text("raise ImportError\n")
    monkeypatch.setenv("PYTHONPATH", f"{Path(__file__).parent}:{tmp_path}")
    for name, value in environment.items():
        monkeypatch.setenv(name, value)
    with listening(OutsideClock(follow)) as until:
        assert (await until("error"))["message"] == line
        assert (await until("clock_gone"))["message"] == ""


PEER = """
import asyncio, sys
from aalink import Link
async def main():
    link = Link(90.0)
    link.enabled = True
    while not link.num_peers:
        await asyncio.sleep(0.1)
    link.tempo = 97.0
    await asyncio.to_thread(sys.stdin.read)
asyncio.run(main())
"""
"""A musician, who joins the session and then changes its tempo."""


CLONE_NEWNET = 0x40000000


@pytest.fixture
def own_network() -> Iterator[None]:
    """Give this thread, and the processes it starts, a network of their own: Link broadcasts to the whole network."""
    need("ip")
    libc = ctypes.CDLL(None, use_errno=True)
    before = os.open("/proc/thread-self/ns/net", os.O_RDONLY) if sys.platform == "linux" else -1
    if before < 0 or libc.unshare(CLONE_NEWNET):
        pytest.skip("the kernel refuses network namespaces")
    try:
        for words in (
            "link set lo up",
            "link add cable type veth peer name end",
            "addr add 10.8.0.1/24 dev cable",
            "link set end up",
            "link set cable up",
        ):
            subprocess.run(["ip", *words.split()], check=True)
        yield
    finally:
        libc.setns(before, CLONE_NEWNET)
        os.close(before)


@pytest.mark.slow("members of a session find each other")
@pytest.mark.usefixtures("own_network")
async def test_a_link_session_counts_while_others_are_in_it() -> None:
    if not importlib.util.find_spec("aalink"):
        lacking('Ableton Link is under the GPL: pip install "improv-ls[link]"')
    with listening(OutsideClock("link"), 110) as until:
        peer = await asyncio.create_subprocess_exec(sys.executable, "-c", PEER, stdin=asyncio.subprocess.PIPE)
        try:
            first = await until("anchor", lambda each: round(each["tempo"]) == 97)
            later = await until("anchor", lambda each: each["at"] > first["at"] + 2)
            passed = (later["beat"] - first["beat"]) * 60 / (later["at"] - first["at"])
            assert passed == pytest.approx(97, rel=0.1), "the tempo that it left is 110"
        finally:
            assert peer.stdin
            peer.stdin.close()
            await peer.wait()
