"""Trails on the page: the arcs from the start of the performance, whenever the page was opened, and after a seek."""

from __future__ import annotations

import math
from fractions import Fraction

from playwright.sync_api import Page

from improv_core.outputs.simulator.simulator import Simulator
from improv_core.page.server import Viewer
from improv_core.score.motion import Pose, Twist
from improv_core.score.score import Score
from tests.page.conftest import link, part, wait


def trail(page: Page) -> list[tuple[float, float]]:
    """The corners of ada's trail, beginning with its start."""
    points = [(round(x, 2) + 0.0, round(y, 2) + 0.0) for x, y, _ in page.evaluate("improv.trails.ada")]
    return [point for point, before in zip(points, [None, *points], strict=False) if point != before]


SQUARE = [(0, 0), (2, 0), (2, 2), (0, 2)]


def test_a_page_that_is_delayed_or_opened_late_shows_the_whole_trail(
    page: Page, viewer: Viewer, simulator: Simulator
) -> None:
    page.goto(link(viewer))
    simulator.prepare(Score(Fraction(60), {"ada": part("ada", Pose())}), restart=True)
    wait(page, "window.improv?.robots.ada")
    for second in range(6):
        simulator.send("ada", Twist(yaw=math.pi / 2) if second % 2 else Twist(2.0), float(second))
    simulator.advance(6.0)  # all between two frames
    wait(page, "improv.trails.ada.length > 6")
    assert trail(page) == SQUARE
    page.reload()
    wait(page, "window.improv?.robots.ada && improv.trails.ada.length > 6")
    assert trail(page) == SQUARE
