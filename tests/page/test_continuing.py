"""A save that edits the dance that plays, on the page."""

from __future__ import annotations

import pytest
from playwright.sync_api import Page, expect

from tests.page.conftest import Show, wait, watch

BEFORE = "beat 240\nanna $ repeat slow 50 forward\nbert $ repeat slow 40 left\n"
AFTER = "# bert has another line, and anna's has moved\n" + BEFORE.replace("slow 40 left", "slow 40 right")


@pytest.mark.slow("a browser on a busy machine")
def test_the_page_keeps_counting_and_lights_playing_words_at_their_current_places(page: Page, show: Show) -> None:
    lit = watch(page, show, BEFORE).locator("#score-text .lit")
    expect(lit).to_have_text(["forward", "left"])
    wait(page, "improv.beat > 4")
    show.play(AFTER, when="bar")
    expect(lit).to_have_text(["forward", "right"])
    wait(page, "improv.known.bert > 8")
    beat = page.evaluate("improv.transport.beat")
    assert beat >= 8
    assert beat % 4 == 0
    assert page.evaluate("improv.transport.begins") == {"bert": beat}
    # Both are on their paths; a page that was held up may have thought otherwise, and has noticed since.
    wait(page, "Object.values(improv.moved).every(({ x, y, heading }) => Math.hypot(x, y, heading) < 0.3)")

    page.keyboard.press("k")  # pause
    expect(page.locator("#state")).to_have_text("paused")
    page.keyboard.press("ArrowLeft")  # once in any case: it may have paused in the instant before
    while page.evaluate("improv.beat") >= beat:
        page.keyboard.press("ArrowLeft")
    expect(lit).to_have_text(["forward"])  # bert has not begun
