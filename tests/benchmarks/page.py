"""Smoothness of the page with many robots, and its price for the stage: Chromium without a graphics card."""

from __future__ import annotations

import time
from dataclasses import dataclass

from tests.benchmarks.chromium import chromium
from tests.benchmarks.servers import processor_time
from tests.benchmarks.tables import machine, p99, print_head, print_row
from tests.page.conftest import Show, watch

ROBOTS = 50
SIZE = (1920, 1080)
LATE = 25.0
"""Milliseconds between two frames after which one was dropped, at 60 frames a second."""
GOAL = 60
SETTLE = 5
"""Seconds after which a page knows the next beats, and its view stands."""

# Milliseconds between the frames of so many seconds.
GAPS = """seconds => new Promise(done => {
  const gaps = []
  let last = null
  const look = now => {
    if (last !== null) gaps.push(now - last)
    last ??= now
    last = now
    if (gaps.reduce((sum, gap) => sum + gap, 0) < seconds * 1000) requestAnimationFrame(look)
    else done(gaps)
  }
  requestAnimationFrame(look)
})"""


@dataclass(frozen=True, slots=True)
class Seen:
    """Frames of one page, and their price: `gaps` are milliseconds between frames, the stage takes seconds a second."""

    gaps: list[float]
    stage_alone: float
    stage_watched: float

    @property
    def frames_per_second(self) -> float:
        return 1000 * len(self.gaps) / sum(self.gaps)

    @property
    def dropped(self) -> int:
        return sum(gap > LATE for gap in self.gaps)


def run(quick: bool) -> None:
    """Measure and print; `quick` measures for a few seconds."""
    seconds = 5 if quick else 30
    seen = measure(seconds)
    width, height = SIZE
    print(machine())
    print(f"\nThe page with {ROBOTS} robots that all move, {width}×{height}, headless Chromium, {seconds} s\n")
    print_head("what", "", "goal", "")
    verdict = "met" if seen.frames_per_second >= GOAL - 0.5 else "not met"
    print_row("frames a second", f"{seen.frames_per_second:.1f}", str(GOAL), verdict)
    print_row(f"frames dropped (over {LATE:g} ms)", f"{seen.dropped} of {len(seen.gaps)}", "", "")
    print_row("longest frame, p99 and max, ms", f"{p99(seen.gaps):.1f}, {max(seen.gaps):.1f}", "", "")
    print_row("the stage's processor seconds a second, no page", f"{seen.stage_alone:.3f}", "", "")
    print_row("with one page", f"{seen.stage_watched:.3f}", "", "")


def measure(seconds: float) -> Seen:
    """Play a dance, first unwatched, then to a page."""
    show = Show()
    try:
        show.play(dance(ROBOTS))
        stage = show.stage
        time.sleep(1)
        alone = _busy(stage, seconds)
        with chromium() as browser:
            page = browser.new_page(viewport={"width": SIZE[0], "height": SIZE[1]})
            watch(page, show)
            time.sleep(SETTLE)
            before, began = processor_time(stage), time.monotonic()
            gaps: list[float] = page.evaluate(GAPS, seconds)
            watched = (processor_time(stage) - before) / (time.monotonic() - began)
        return Seen(gaps, alone, watched)
    finally:
        show.close()


def dance(robots: int) -> str:
    """Write a dance in which all move all the time, in several ways that lead back to their starts."""
    ways = ("forward || left", "forward left", "scale 1/2 forward || halfright", "forward || slow 2 left")
    lines = (f"r{place} $ repeat ({ways[place % len(ways)]})\n" for place in range(robots))
    return "beat 60\n" + "".join(lines)


def _busy(pid: int, seconds: float) -> float:
    before = processor_time(pid)
    time.sleep(seconds)
    return (processor_time(pid) - before) / seconds
