"""The stage's side of the process that publishes the forecast. A script replaces that process, so no ROS is needed."""

from __future__ import annotations

import sys
import time
from fractions import Fraction

import pytest

from improv_core.outputs.ros.publisher import client
from improv_core.outputs.ros.publisher.client import PublisherClient
from improv_core.score.score import Score

LIMIT = 60.0
FAILS = """\
from improv_core.protocol.json_lines import own_output
own_output()({"type": "error", "message": "RuntimeError: no\\tROS"})
"""


@pytest.mark.parametrize(
    ("script", "why"),
    [(FAILS, "has ended: RuntimeError: no ROS"), ("", "has ended: it was killed"), (None, "can't start: ")],
    ids=["fails", "ends", "missing"],
)
def test_a_process_that_fails_is_reported(monkeypatch: pytest.MonkeyPatch, script: str | None, why: str) -> None:
    command = ["/nowhere/python"] if script is None else [sys.executable, "-c", script]
    monkeypatch.setattr(client, "helper_command", lambda name, *arguments: command)
    publisher = PublisherClient("node", [], time.monotonic)
    publisher.take(Score(Fraction(60), {}, publish=True), 1)
    end = time.monotonic() + LIMIT
    while not publisher.problem:  # the thread that writes sets it
        publisher.show({"type": "warning", "message": "still here"})
        assert time.monotonic() < end
        time.sleep(0.001)
    publisher.close()
    assert publisher.problem.startswith(f"the process that publishes the dance {why}")
    assert publisher.problem.endswith(": the next play starts another one")
