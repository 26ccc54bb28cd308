"""Film a robot that keeps dancing while another one's line is saved: `python -m tests.stage.viewer.film film.webp`.

Needs Chromium and `pip install pillow`.
"""

from __future__ import annotations

import sys
from collections.abc import Iterator
from pathlib import Path

from playwright.sync_api import Page, sync_playwright

from tests.editors.vscode.film import Look, look, save
from tests.needs import need
from tests.stage.viewer.conftest import FLAGS, Show, wait, watch

SIZE = {"width": 1120, "height": 640}
LINES = (
    "bert $ repeat (forward left)",
    "bert $ repeat (forward forward right)",
    "bert $ repeat (forward || halfleft)",
)


def main() -> None:
    show = Show()
    try:
        with sync_playwright() as playwright:
            browser = playwright.chromium.launch(executable_path=need("chromium"), args=FLAGS)
            page = browser.new_page(viewport=SIZE)  # type: ignore[arg-type]
            looks = list(_session(page, show))
            browser.close()
    finally:
        show.close()
    save(looks, Path(sys.argv[1]))


def _session(page: Page, show: Show) -> Iterator[Look]:
    """Bert's line is saved again every few seconds."""
    show.play(_program(LINES[0]))
    watch(page, show)
    for generation, line in enumerate(LINES, 1):
        if generation > 1:
            show.play(_program(line), when="bar")
        wait(page, f"improv.transport.generation === {generation}")
        yield from look(page, 6)


def _program(line: str) -> str:
    return f"# Only bert's line is edited\nbeat 100\nanna $ repeat (forward [left left forward right])\n{line}\n"


if __name__ == "__main__":
    main()
