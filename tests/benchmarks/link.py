"""Error of another machine's clock as known through ssh over a bad Wi-Fi, and the price of a link.

Both ends run on this machine, so the right answer is known: both clocks are the same, except that the one there may be
made to drift. `tests/hosts/slow_link.py` is the Wi-Fi: 2 to 100 ms of random delay each way, and 2% is lost.
"""

from __future__ import annotations

import os
import tempfile
import time
from collections.abc import Mapping
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from statistics import median

import pytest

from improv_core.hosts.clock_queries import Asking, asked, estimated, lag, period, told
from improv_core.hosts.connect import connect
from improv_core.hosts.frames import LONGEST_UP, UP, Incoming, time_in
from improv_core.ipc.child import Child
from tests.benchmarks.tables import print_head, print_row
from tests.hosts.sshd import NAME, SLOW, Host, a_host
from tests.ros.conftest import with_code

MARKS = (3.0, 10.0, 30.0, 60.0, 120.0)
DRIFT = """\
import time
_real = time.monotonic_ns
time.monotonic_ns = lambda: _real() + int(_real() * {drift})
"""


class Followed:
    """One link, and the error of its clock at each mark, in milliseconds."""

    def __init__(self, host: Host, marks: tuple[float, ...], drift: float, seed: int) -> None:
        self.off: dict[float, tuple[float, float]] = {}
        self.lag = 0.0
        connection = connect(NAME, ["--look"], str(host.slow(seed)))
        try:
            self._follow(connection.ssh, connection.said, marks, drift)
        finally:
            connection.ssh.close_input()
            connection.ssh.kill()
            connection.ssh.wait()

    def _follow(self, ssh: Child, said: bytes, marks: tuple[float, ...], drift: float) -> None:
        incoming = Incoming(UP, LONGEST_UP)
        begun = due = time.monotonic()
        asking = Asking(begun)
        waiting = [*marks]
        while waiting:
            now = time.monotonic()
            for frame in incoming.take(said):
                if frame.letter == "c":
                    asking = told(asking, time_in(frame.rest), now)
            asking = estimated(asking, now)
            if now >= begun + waiting[0]:
                mark = waiting.pop(0)
                if asking.clocks and asking.found:
                    right = now + now * drift
                    self.off[mark] = (1e3 * (asking.clocks.there(now) - right), 1e3 * asking.found.error)
                    self.lag = 1e3 * lag(asking)
            if now >= due:
                due = now + period(asking, now, moves=True)
                asking = asked(asking, asking.number + 1, time.monotonic())
                ssh.write(b"c%d\n" % asking.number)
            said = ssh.read_some(max(due - time.monotonic(), 0.0))


def measure(folder: Path, marks: tuple[float, ...], drift: float, links: int) -> list[Followed]:
    there: Mapping[str, str] = with_code(DRIFT.format(drift=drift)) if drift else {}
    with a_host(folder, there) as host, pytest.MonkeyPatch.context() as patch, ThreadPoolExecutor(links) as pool:
        patch.setenv("XDG_CONFIG_HOME", host.env["XDG_CONFIG_HOME"])
        return [*pool.map(lambda seed: Followed(host, marks, drift, seed), range(links))]


def run(quick: bool) -> None:
    """Print the error of the clock after some time, and the error that it reports as possible."""
    marks = MARKS[:3] if quick else MARKS
    print_head("drift", "links", *(f"{mark:g} s: median, worst (says)" for mark in marks), "a message arrives within")
    for drift in (0.0,) if quick else (0.0, 50e-6, -100e-6):
        with tempfile.TemporaryDirectory() as folder:
            links = measure(Path(folder), marks, drift, 4 if quick else 10)
        cells = []
        for mark in marks:
            off = [abs(link.off[mark][0]) for link in links if mark in link.off]
            says = [link.off[mark][1] for link in links if mark in link.off]
            cells.append(f"{median(off):.2f}, {max(off):.2f} ms ({median(says):.2f})" if off else "not known")
        print_row(f"{drift * 1e6:g} ppm", str(len(links)), *cells, f"{max(link.lag for link in links):.0f} ms")
    print(f"(SLOW: {' '.join(SLOW)}; load of this machine: {os.getloadavg()[0]:.1f})")
