"""Take pictures of the wall of robots: `python -m tests.stage.viewer.wall_photo FOLDER`. Needs Chromium."""

from __future__ import annotations

import json
import sys
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

from playwright.sync_api import Page, sync_playwright

from improv_core.score.faults import Fault
from improv_core.stage.robot_messages import FaultMessage, Vitals
from tests.needs import need
from tests.stage.viewer.conftest import FLAGS, Show, wait, watch

SIZES = {"wide": (1920, 1080), "laptop": (1280, 800), "phone": (390, 844)}
TROUBLE: Sequence[tuple[int, Fault]] = [(2, "silent"), (5, "off_path"), (5, "stuck"), (10, "gone")]


def robots(count: int) -> list[str]:
    return [f"tb{number}" for number in range(1, count + 1)]


def program(count: int) -> str:
    return f"beat 60\n{' '.join(robots(count))} $ repeat (forward left)\n"


def vitals(count: int, posed: float, battery: float | None = 0.8) -> Vitals:
    return {
        "type": "vitals",
        "generation": 1,
        "robots": {
            name: {
                "odom": number % 7 != 6,
                "posed": None if number % 7 == 6 else posed,
                "battery": battery,
                "instead": "",
            }
            for number, name in enumerate(robots(count))
        },
    }


def faults(count: int) -> Iterator[FaultMessage]:
    for number, fault in TROUBLE:
        if number < count:
            yield {
                "type": "fault", "generation": 1, "robot": robots(count)[number], "fault": fault, "over": False,
                "response": "tell", "worst": {}, "message": f"beat 3: {robots(count)[number]} is in trouble",
                "line": f"beat 3: {robots(count)[number]} is in trouble",
                "beat": 2.0, "performed": 2.0, "wall": 0,
            }  # fmt: skip


def tell(show: Show, message: Any) -> None:
    """Have the page's stage be told this, as by a stage of real robots that leads."""
    show.tell(json.loads(json.dumps(message)))


def open_wall(page: Page) -> None:
    page.locator("#show-wall").click()


def main() -> None:
    folder = Path(sys.argv[1])
    folder.mkdir(parents=True, exist_ok=True)
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=need("chromium"), args=FLAGS)
        for count in (1, 12, 30, 100):
            show = Show()
            show.play(program(count))
            for scheme in ("light", "dark"):
                for size, (width, height) in SIZES.items():
                    page = browser.new_page(viewport={"width": width, "height": height}, color_scheme=scheme)
                    watch(page, show)
                    wait(page, "improv.beat > 1")
                    tell(show, vitals(count, page.evaluate("improv.transport.performed + 1")))
                    for fault in faults(count):
                        tell(show, fault)
                    page.locator("#show-wall").wait_for()
                    page.screenshot(path=folder / f"chip-{count}-{scheme}-{size}.png")
                    open_wall(page)
                    page.locator("#wall tbody tr").first.wait_for()
                    page.screenshot(path=folder / f"wall-{count}-{scheme}-{size}.png")
                    page.close()
            show.close()
        browser.close()


if __name__ == "__main__":
    main()
