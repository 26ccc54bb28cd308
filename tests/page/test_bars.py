"""A program that sets the length of a bar, the size of the floor, and the names of its scenes."""

from __future__ import annotations

from collections.abc import Callable

from playwright.sync_api import Page, expect

from improv_core.outputs.simulator.simulator import Simulator
from improv_core.page.server import Viewer
from improv_core.program.analysis import analyze
from improv_core.program.compiler import score_of
from tests.page.conftest import transport, wait
from tests.page.looks import PIXEL

PROGRAM = "room 6 4\nbar 3\nada at 1 0\nada $ repeat 6 (scale 1/8 forward left)\n"
WALL = "107,114,128"


def test_positions_are_counted_in_bars_and_the_floor_has_walls(
    still: Callable[..., Page], viewer: Viewer, simulator: Simulator
) -> None:
    page = still(PROGRAM)
    beat, line = page.locator("#beat"), page.get_by_role("slider", name="Position in beats")
    expect(beat).to_have_text("bar 1, beat 1 / 4 bars")
    viewer.publish(transport(1, "paused", 12.0, 7.4))
    expect(beat).to_have_text("bar 3, beat 2 / 4 bars")
    expect(line).to_have_attribute("aria-valuetext", "bar 3, beat 2 of bar 4, beat 3")
    expect(page.get_by_role("status")).to_have_text("paused at bar 1, beat 1")
    for x, y in ((3, 1), (-3, 1), (1, 2), (1, -2)):
        wait(page, f"({PIXEL})({x}, {y}) === '{WALL}'")
    assert page.evaluate("improv.robots.ada") == {"x": 1, "y": 0, "z": 0, "heading": 0}

    score = score_of(analyze("ada $ repeat 6 (forward left)\n"))  # without bars
    simulator.prepare(score, restart=True)
    viewer.show(score, 2)
    viewer.publish(transport(2, "paused", 12.0, 7.4))
    expect(beat).to_have_text("beat 8 / 12")
