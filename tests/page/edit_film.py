"""Film a person's first minute with `improv edit`: `python -m tests.page.edit_film docs/images/edit.webp`.

Needs Chromium and `pip install pillow`.
"""

from __future__ import annotations

import sys
from collections.abc import Iterator
from pathlib import Path
from tempfile import TemporaryDirectory

from playwright.sync_api import Page, expect, sync_playwright

from tests.editors.vscode.film import FRAME, Look, look, save
from tests.needs import need
from tests.page.conftest import FLAGS, wait
from tests.page.editing import Edit

SIZE = {"width": 1120, "height": 620}
LINE = ("bo ", "$ ", "rep", "eat ", "4 ", "(fow", "rard ", "|| ", "left)")
"""The typed text, with a look at the page after each piece."""


def main() -> None:
    with TemporaryDirectory() as folder, sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=need("chromium"), args=FLAGS)
        edited = Edit(Path(folder, "dance.improv"), browser.new_context(viewport=SIZE))  # type: ignore[arg-type]
        page = edited.page()
        looks = list(_session(page))
        edited.close()
        browser.close()
    save(looks, Path(sys.argv[1]))


def _session(page: Page) -> Iterator[Look]:
    yield from look(page, 1.5)
    page.get_by_role("button", name="Save and play").click()
    wait(page, "improv.transport.generation === 1")
    yield from look(page, 4)
    page.locator("#text").press("Control+End")
    for keys in LINE:
        page.keyboard.type(keys)
        yield from look(page, FRAME)
    page.keyboard.press("Escape")  # closes the list of words
    fix = page.locator("#diagnostics .fix")
    expect(fix).to_be_visible()
    yield from look(page, 2)
    fix.click()
    yield from look(page, 1)
    page.locator("#text").press("Control+Enter")
    wait(page, "improv.transport.generation === 2")
    yield from look(page, 5)
    page.keyboard.press("Escape")
    yield from look(page, 1.5)


if __name__ == "__main__":
    main()
