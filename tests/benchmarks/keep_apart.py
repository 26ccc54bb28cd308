"""From the pose that shows that two real robots are too near to each other to the zeros that they hear."""

from __future__ import annotations

import os
from collections.abc import Sequence
from statistics import median

from tests.benchmarks.air import LINK
from tests.benchmarks.hosts import AIR
from tests.benchmarks.keep_apart_hosts import delays
from tests.benchmarks.tables import machine, print_head, print_row

LINKS: dict[str, Sequence[str]] = {
    "none: one stage for both": (),
    "2 ms": ("--delay", "0.002"),
    "2–100 ms, 2 % lost": AIR,
}
"""Links to hosts, which need the rights of root."""


def run(quick: bool) -> None:
    """Measure and print; `quick` does it 10 times instead of 100."""
    rounds = 10 if quick else 100
    print(f"{machine()}\n\nMilliseconds from the pose to the zeros\n")
    print_head("link to each host", "zeros of", "times", "median", "p90", "worst")
    said = []
    for about, link in LINKS.items():
        if link and (os.geteuid() != 0 or not LINK.exists()):
            continue
        found = delays(rounds, link)
        both = [*map(max, found.shown, found.other)]
        for who, seconds in (("the one that is seen", found.shown), ("the other one", found.other), ("both", both)):
            times = sorted(1000 * each for each in seconds)
            figures = f"{median(times):.1f}", f"{times[len(times) * 9 // 10]:.1f}", f"{times[-1]:.1f}"
            print_row(about, who, str(len(times)), *figures)
        pauses = sum(line.startswith("paused ") for line in found.lines)
        said.append(f"{about}: {pauses} messages about {len(found.shown)} pauses")
        said += [f"{about}: {line}" for line in found.lines if "doesn't guard" in line]
    print("\n" + "\n".join(said))
