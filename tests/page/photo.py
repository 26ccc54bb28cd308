"""Take a picture of the page while four robots dance a canon: `python -m tests.page.photo page.png`.

Needs Chromium.
"""

from __future__ import annotations

import sys
from pathlib import Path

from playwright.sync_api import sync_playwright

from tests.needs import need
from tests.page.conftest import FLAGS, Show, wait, watch

PROGRAM = Path(__file__).parents[2] / "examples" / "canon.improv"
BEAT = 7.4
"""Beat at which everyone already dances, and no one has ended."""


def main() -> None:
    show = Show()
    try:
        with sync_playwright() as playwright:
            browser = playwright.chromium.launch(executable_path=need("chromium"), args=FLAGS)
            page = browser.new_page(viewport={"width": 1280, "height": 720})
            show.play(PROGRAM.read_text(encoding="utf-8"))
            watch(page, show)
            wait(page, f"improv.beat > {BEAT}")
            page.screenshot(path=sys.argv[1])
            browser.close()
    finally:
        show.close()


if __name__ == "__main__":
    main()
