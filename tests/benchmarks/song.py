"""Error of the song that a page plays against the beat of its stage, as the audio context renders it in a real browser.

The song is a ramp, so each sample shows its place in the song. A listener in the page's audio graph notes one of every
128 samples, with the context's own time. The browser reports when that time is audible, and the stage reports the
beats. Nothing here asks the page's own modules. Without an audio device, Chromium plays to one of its own that keeps
time and reports a latency; the delay of a real device beyond its report isn't measured.
"""

from __future__ import annotations

import tempfile
import time
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from random import Random
from statistics import median
from typing import Any

from tests.benchmarks.chromium import chromium
from tests.benchmarks.tables import machine, p99, print_head, print_row
from tests.page.conftest import Show, wait
from tests.page.songs import EAR, improv_toml, ramp

GOAL = 20.0
"""Milliseconds."""
TEMPO = 120
LENGTH = 400
"""Seconds of the song."""
FIRST = 0.5
SETTLING = 0.25
"""Seconds after a change of the playback until the song must be right again: the message, a check, and the output."""
SPEEDS = (0.5, 0.75, 1.25, 2)
DANCE = f"beat {TEMPO}\nada $ repeat (forward left)\n"


@dataclass(frozen=True, slots=True)
class Change:
    """Message of the stage: from this Unix time on, it is at `beat`, at a tempo; it plays or not."""

    wall: float
    beat: float
    tempo: float
    plays: bool


@dataclass(slots=True)
class Found:
    """Milliseconds by which the song is off: at its own speed, at others, and the time until it was right."""

    steady: list[float] = field(default_factory=list)
    stretched: list[float] = field(default_factory=list)
    until_right: list[float] = field(default_factory=list)


def run(quick: bool) -> None:
    """Measure and print; `quick` measures for half a minute instead of five."""
    seconds, seeks = (30, 6) if quick else (300, 40)
    show = Show()
    try:
        with tempfile.TemporaryDirectory() as name, chromium() as browser:
            folder = Path(name)
            robots = improv_toml(folder, ramp(LENGTH), first_beat=FIRST)
            page = browser.new_context(bypass_csp=True).new_page()
            page.add_init_script(EAR)
            show.play(DANCE, robots, folder=folder)
            page.goto(show.url)
            page.locator("#stage").click()
            wait(page, "improv.song !== null")
            page.evaluate("hear()")
            _perform(show, folder, robots, seconds, seeks)
            noted: dict[str, Any] = page.evaluate("({ heard, hearings, changes })")
            latency: float = page.evaluate("1000 * contexts[0].outputLatency")
    finally:
        show.close()
    found = compared(noted["heard"], noted["hearings"], [Change(*each) for each in noted["changes"]])
    print(machine())
    print(f"\nThe song against the beat, {seconds} s with {seeks} seeks, pauses, speeds, and saves, milliseconds")
    print(f"headless Chromium without an audio device, which reports a latency of {latency:.0f} ms\n")
    print_head("what", "times", "p50", "p99", "max", "goal", "")
    _print("off, at the song's own speed", found.steady, f"p99 ≤ {GOAL:g}")
    _print(f"off, at {', '.join(map(str, SPEEDS))} times that", found.stretched, f"p99 ≤ {GOAL:g}")
    _print("from a change to the right place", found.until_right, "")


def compared(heard: Sequence[Sequence[float]], hearings: Sequence[Sequence[float]], changes: Sequence[Change]) -> Found:
    """Return the errors in the samples: pairs of the context's time and a sample, with the page's notes about clocks:
    its own seconds, the context's time that is audible then and the page's seconds for that, and Unix time."""
    ahead = median(unix - page for page, _, _, unix in hearings) + 0.0005  # Unix time has whole milliseconds
    found, at, near = Found(), 0, 0
    right: dict[int, float] = {}
    for context, sample in heard:
        while near + 1 < len(hearings) and hearings[near + 1][1] <= context:
            near += 1
        around = hearings[max(near - 5, 0) : near + 6]
        shift = median(page - audio for _, audio, page, _ in around)
        unix = context + shift + ahead
        while at + 1 < len(changes) and changes[at + 1].wall <= unix:
            at += 1
        change = changes[at]
        if sample == 0 or not change.plays or unix < change.wall:
            continue
        rate = change.tempo / TEMPO
        wanted = FIRST + (change.beat + (unix - change.wall) * change.tempo / 60) * 60 / TEMPO
        off = 1000 * abs((sample + 0.5) * LENGTH - wanted) / rate
        since = unix - change.wall
        if off > GOAL:
            right.pop(at, None)
        else:
            right.setdefault(at, 1000 * since)
        if since > SETTLING:
            (found.steady if abs(rate - 1) < 0.01 else found.stretched).append(off)
    found.until_right.extend(right.values())
    return found


def _perform(show: Show, folder: Path, robots: str, seconds: float, seeks: int) -> None:
    """Seek, pause, change speeds, and save, for this many seconds."""
    random, end = Random(7), time.monotonic() + seconds
    pause = seconds / seeks / 3
    for number in range(seeks):
        show.tell({"type": "seek", "beat": random.uniform(0, 300)})
        time.sleep(pause)
        if number % 4 == 1:
            show.tell({"type": "pause"})
            time.sleep(0.5)
            show.tell({"type": "resume"})
        elif number % 4 == 2:
            show.tell({"type": "speed", "factor": SPEEDS[number // 4 % len(SPEEDS)]})
            time.sleep(pause)
            show.tell({"type": "speed", "factor": 1})
        elif number % 4 == 3:
            show.play(DANCE, robots, folder=folder, when="now" if number % 8 == 3 else "restart")
        time.sleep(max(min(end - time.monotonic(), pause), 0))


def _print(what: str, found: list[float], goal: str) -> None:
    met = "" if not goal else "met" if p99(found) <= GOAL else "not met"
    print_row(what, f"{len(found):,}", f"{median(found):.1f}", f"{p99(found):.1f}", f"{max(found):.1f}", goal, met)
