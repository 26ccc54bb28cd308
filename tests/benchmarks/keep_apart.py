"""From the pose that shows that two real robots are too near to each other to the zeros that they hear."""

from __future__ import annotations

import os
import subprocess
import tempfile
from pathlib import Path
from statistics import median

from tests.benchmarks.air import LINK
from tests.benchmarks.hosts import AIR
from tests.benchmarks.keep_apart_hosts import delays
from tests.benchmarks.robots import ENV, HERE, PYTHON
from tests.benchmarks.tables import print_row
from tests.commands.command_line import IMPROV

TOML = """
[ros]
node = "improv"
odom_frame = "world"
[preflight]
distance = 100
degrees = 180
[world]
keep_apart = 0.3
[robots.a]
odom = "pose"
[robots.b]
odom = "pose"
start = { x = 5, y = 0, heading = 0 }
"""


def run(quick: bool) -> None:
    """Measure and print; `quick` does it 10 times instead of 100."""
    rounds = 10 if quick else 100
    print(f"{len(os.sched_getaffinity(0))} cores, load average {os.getloadavg()[0]:.2f}\n")
    with tempfile.TemporaryDirectory() as folder:
        Path(folder, "dance.improv").write_text("a b $ repeat scale 1/100 (forward backward)\n")
        Path(folder, "improv.toml").write_text(TOML)
        command = [*IMPROV, "play", "--backend", "ros", "--no-browser", "dance.improv"]
        with subprocess.Popen(
            command, cwd=folder, env=ENV, stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL
        ) as playing:
            script = [PYTHON, str(HERE / "ros_near.py"), str(rounds), "/improv/play"]
            told = subprocess.run(script, env=ENV, capture_output=True, text=True, check=False)
            playing.terminate()
    times = sorted(1000 * float(line) for line in told.stdout.split())
    if len(times) < rounds:
        raise SystemExit(f"only {len(times)} times: {told.stderr.strip()}")
    print(f"Milliseconds until both robots have zeros, {len(times)} times\n")
    print_row("median", "p90", "worst")
    print_row("---:", "---:", "---:")
    print_row(f"{median(times):.1f}", f"{times[len(times) * 9 // 10]:.1f}", f"{times[-1]:.1f}")
    if os.geteuid() == 0 and LINK.exists():
        _on_hosts(rounds)


def _on_hosts(rounds: int) -> None:
    print("\nThe same with two robots on hosts of their own\n")
    print_row("link", "zeros of", "times", "median", "p90", "worst")
    print_row("---", "---", "---:", "---:", "---:", "---:")
    said = []
    for about, link in (("2 ms", ("--delay", "0.002")), ("2–100 ms, 2 % lost", AIR)):
        found = delays(rounds, link)
        for who, seconds in (("the one that is seen", found.shown), ("the other one", found.other)):
            times = sorted(1000 * each for each in seconds)
            figures = f"{median(times):.1f}", f"{times[len(times) * 9 // 10]:.1f}", f"{times[-1]:.1f}"
            print_row(about, who, str(len(times)), *figures)
        pauses = sum(line.startswith("paused ") for line in found.lines)
        said.append(f"{about}: {pauses} messages about {len(found.shown)} pauses")
        said += [f"{about}: {line}" for line in found.lines if "doesn't guard" in line]
    print("\n" + "\n".join(said))
