"""Reports of where simulated robots are: they end once a report has shown that the robots stand."""

from __future__ import annotations

import math
from typing import Any

import pytest

from improv_core.outputs.simulator.simulator import Simulator
from improv_core.player.player import Player
from improv_core.program.analysis import analyze
from improv_core.program.compiler import score_of
from improv_core.robots.config import read_robots
from tests.player.plays import to_play

ROBOTS = '[robots.ada]\nprofile = "slow"\n[profiles.slow]\nbase = "thymio2"\ndynamics = "motors"\n'


@pytest.mark.parametrize("stall", [0.0, 0.04, 0.2, 3.0])
def test_the_last_two_reports_after_a_stop_are_of_one_pose(stall: float) -> None:
    robots = read_robots(ROBOTS)
    score = score_of(analyze("ada $ repeat forever left", robots))
    told: list[dict[str, Any]] = []
    now = 0.0
    player = Player(Simulator(), told.append, lambda: now)  # type: ignore[arg-type]
    player.take(to_play(score), 0.0)
    while now < 0.42:
        now += 0.01
        player.advance(now)
    player.take({"type": "stop"}, now)
    now += stall  # the process gets no time to run
    looks = 0
    while player.sends and (deadline := player.deadline(now)) < math.inf:
        now = max(now, deadline)
        player.advance(now)
        looks += 1
    headings = [each["robots"]["ada"]["pose"]["heading"] for each in told if each["type"] == "measured"]
    assert headings[-3] < headings[-2] == headings[-1] == player.whereabouts()["poses"]["ada"]["heading"]
    assert looks < 60
