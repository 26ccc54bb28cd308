"""From a save in an editor to the page in a browser, and from the page's button back to the robots."""

from __future__ import annotations

from pathlib import Path

from playwright.sync_api import Page, expect

from tests.ls.client import Client
from tests.stage.viewer.conftest import wait

URI = "file:///dance.improv"


def test_save_moves_the_robot_and_stop_stops_it(page: Page, artifacts: Path) -> None:
    with Client({"backend": "sim"}) as client:
        client.open(URI, "beat 120\nada $ repeat (forward || left)\nbo $ repeat (forward || right)\n")
        client.save(URI)
        client.wait_for_line("▶ ada ∞ · bo ∞, endless at beat 120, simulator")
        (url,) = client.wait_for_page()
        page.goto(url)
        wait(page, "window.improv?.robots.ada && improv.robots.ada.y > 1")
        expect(page.locator("#state")).to_have_text("playing")
        page.screenshot(path=artifacts / "save-moves-the-page.png")

        page.get_by_role("button", name="Stop").click()
        client.wait("$/progress", lambda params: params["value"]["kind"] == "end")
        expect(page.locator("#state")).to_have_text("stopped")
        wait_for_frames(page, 30)  # what is shown is some frames behind what is so
        page.evaluate("window.stood = {...improv.robots.ada}")
        wait_for_frames(page, 60)
        assert page.evaluate("stood.x === improv.robots.ada.x && stood.heading === improv.robots.ada.heading")

        client.change(URI, 2, {"text": "beat 120\nada $ forward\n"})
        client.save(URI)
        expect(page.locator("#state")).to_have_text("finished")
        wait(page, "Math.abs(improv.robots.ada.x - 2) < 1e-3 && !improv.robots.bo")


def wait_for_frames(page: Page, count: int) -> None:
    wait(page, f"improv.frames > {page.evaluate('improv.frames') + count}")
