"""A program that says how long a bar is, how large the floor is, and what its scenes are called."""

from __future__ import annotations

from collections.abc import Callable

from playwright.sync_api import Page, expect

from improv_core.stage.viewer.server import Viewer
from tests.stage.viewer.conftest import transport, wait
from tests.stage.viewer.looks import PIXEL

PROGRAM = "room 6 4\nbar 3\nada at 1 0\nada $ repeat 6 (scale 1/8 forward left)\n"
WALL = "107,114,128"


def test_positions_are_counted_in_bars(still: Callable[..., Page], viewer: Viewer) -> None:
    page = still(PROGRAM)
    beat, line = page.locator("#beat"), page.get_by_role("slider", name="Position in beats")
    expect(beat).to_have_text("bar 1, beat 1 / 4 bars")
    viewer.publish(transport(1, "paused", 12.0, 7.4))
    expect(beat).to_have_text("bar 3, beat 2 / 4 bars")
    expect(line).to_have_attribute("aria-valuetext", "bar 3, beat 2 of bar 4, beat 3")
    expect(page.get_by_role("status")).to_have_text("paused at bar 1, beat 1")


def test_without_bars_beats_are_counted_as_before(still: Callable[..., Page], viewer: Viewer) -> None:
    page = still("ada $ repeat 6 (forward left)\n")
    viewer.publish(transport(1, "paused", 12.0, 7.4))
    expect(page.locator("#beat")).to_have_text("beat 8 / 12")


def test_the_floor_of_a_program_has_walls(still: Callable[..., Page]) -> None:
    page = still(PROGRAM)
    for x, y in ((3, 1), (-3, 1), (1, 2), (1, -2)):
        wait(page, f"({PIXEL})({x}, {y}) === '{WALL}'")
    assert page.evaluate("improv.robots.ada") == {"x": 1, "y": 0, "z": 0, "heading": 0}
