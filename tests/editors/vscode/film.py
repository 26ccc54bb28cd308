"""Film a session in VS Code: `python -m tests.editors.vscode.film docs/images/vscode.webp`.

For a name that ends in .png, it only takes a picture of two robots that dance.
Needs code-server (`tests/editors/fetch.sh code-server`) and Chromium; a film also needs `pip install pillow`.
"""

from __future__ import annotations

import re
import sys
import time
from collections.abc import Iterator, Mapping
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from io import BytesIO
from itertools import pairwise
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from playwright.sync_api import Page, expect

from tests.editors.editors import nothing_left
from tests.editors.vscode.workbench import framed_page, run_command, vscode, word

SIZE = {"width": 1120, "height": 640}
KEY = 0.05
"""Seconds between two keys, at least."""
FRAME = 0.25
"""Seconds between two looks at the window, at least."""
QUALITY = 30
ASIDE = (300, 500)
"""A point at which the mouse is over nothing, in pixels."""
DRAWN = 6
"""A beat at which much of the square is drawn, and the robots don't meet."""
SERVER = str(Path(sys.executable).with_name("improv-ls"))
SETTINGS = {"improv.server.path": SERVER, "improv.backend": "sim", "improv.codeLens": False}
PROGRAM = "# Two robots, one square\nbeat 90\n\nsquare = repeat 4 (forward left)\nturtle1 $ repeat square\n"


@dataclass(frozen=True, slots=True)
class Look:
    """A picture of the window at a time in seconds."""

    time: float
    picture: bytes


def main() -> None:
    path = Path(sys.argv[1])
    if path.suffix == ".png":
        take_picture(path)
        return
    with _window(PROGRAM, SETTINGS) as page:
        _prepare(page)
        looks = list(_session(page))
    save(looks, path)


def take_picture(path: Path) -> None:
    settings = {**SETTINGS, "security.workspace.trust.enabled": False, "editor.minimap.enabled": False}
    settings["workbench.activityBar.location"] = "hidden"
    program = f"{PROGRAM}turtle2 $ repeat retrograde square\n"
    with _window(program, settings) as page:
        page.set_viewport_size({"width": 1080, "height": 640})
        run_command(page, "View: Toggle Primary Side Bar Visibility")
        word(page, "beat").click()
        page.keyboard.press("Control+S")
        page.mouse.move(*ASIDE)
        expect(framed_page(page).locator("#beat-now")).to_have_text(str(DRAWN))
        page.screenshot(path=path)
        run_command(page, "Improv: Stop Robots")


@contextmanager
def _window(program: str, settings: Mapping[str, object]) -> Iterator[Page]:
    with (
        TemporaryDirectory() as folder,
        nothing_left() as env,
        vscode(Path(folder), env) as started,
        started.window(Path(folder) / "work", program, settings) as page,
    ):
        yield page


def _prepare(page: Page) -> None:
    page.set_viewport_size(SIZE)  # type: ignore[arg-type]
    expect(word(page, "square").first).to_be_visible()
    run_command(page, "Workspaces: Manage Workspace Trust")
    page.get_by_role("button", name="Trust", exact=True).first.click()
    run_command(page, "View: Close Editor")
    run_command(page, "View: Toggle Primary Side Bar Visibility")
    run_command(page, "View: Toggle Minimap")
    page.keyboard.press("Control+End")
    page.mouse.move(*ASIDE)
    time.sleep(2)  # until nothing moves by itself


def _session(page: Page) -> Iterator[Look]:
    yield from look(page, 0.5)
    yield from _type(page, "turtle2 $ repeat retrograde square")
    yield from look(page, 1)
    for _ in range(2):  # the completions, and the word's parameters
        page.keyboard.press("Escape")
    page.keyboard.press("Control+S")
    with suppress(AssertionError):
        expect(framed_page(page).get_by_role("button", name="Stop")).to_be_visible(timeout=8000)
    yield from look(page, 7)
    word(page, "square").first.hover()
    yield from look(page, 3)
    page.mouse.move(*ASIDE)
    word(page, "left").first.dblclick()
    yield from _type(page, "lft")
    page.keyboard.press("Escape")
    page.keyboard.press("Control+S")
    yield from look(page, 3)
    word(page, "lft").first.dblclick()
    yield from _type(page, "right")
    page.keyboard.press("Escape")
    page.keyboard.press("Control+S")
    yield from look(page, 5)
    page.keyboard.press("Alt+.")
    expect(page.locator(".statusbar-item[id$='improv.status']")).to_have_text(re.compile("stopped"))
    yield from look(page, 1.5)


def _type(page: Page, text: str) -> Iterator[Look]:
    for letter in text:
        page.keyboard.type(letter)
        yield from look(page, KEY)


def look(page: Page, seconds: float) -> Iterator[Look]:
    end = time.monotonic() + seconds
    while True:
        began = time.monotonic()
        yield Look(began, page.screenshot())
        time.sleep(max(min(FRAME - (time.monotonic() - began), end - time.monotonic()), 0))
        if time.monotonic() >= end:
            return


def save(looks: list[Look], path: Path) -> None:
    from PIL import Image

    times = [look.time for look in looks] + [looks[-1].time + 2.0]
    durations = [round((end - start) * 1000) for start, end in pairwise(times)]
    frames = [Image.open(BytesIO(look.picture)).convert("RGB") for look in looks]
    first, *others = frames
    small: dict[str, Any] = {"quality": QUALITY, "method": 4, "minimize_size": True}
    first.save(path, save_all=True, append_images=others, duration=durations, loop=0, **small)
    print(f"{path}: {len(frames)} frames, {sum(durations) / 1000:.0f} s, {path.stat().st_size // 1000} KB")


if __name__ == "__main__":
    main()
