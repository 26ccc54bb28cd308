"""Take the picture on the extension's page: `python -m tests.editors.vscode.picture FILE.png`."""

from __future__ import annotations

import sys
from pathlib import Path
from tempfile import TemporaryDirectory

from playwright.sync_api import expect

from tests.editors.editors import nothing_left
from tests.editors.vscode.workbench import framed_page, run_command, word, workbench

SERVER = str(Path(sys.executable).with_name("improv-ls"))
SETTINGS = {
    "improv.server.path": SERVER,
    "improv.backend": "sim",
    "improv.onSave": "restart",
    "security.workspace.trust.enabled": False,
    "editor.minimap.enabled": False,
    "workbench.activityBar.location": "hidden",
}
PROGRAM = """\
# Two robots, one square
beat 90

square = repeat 4 (forward left)
turtle1 $ repeat square
turtle2 $ repeat retrograde square
"""
DRAWN = 6
"""A beat at which much of the square is drawn, and the robots don't meet."""


def main() -> None:
    with TemporaryDirectory() as folder, nothing_left() as env, workbench(Path(folder), PROGRAM, SETTINGS, env) as page:
        page.set_viewport_size({"width": 1080, "height": 640})
        run_command(page, "View: Toggle Primary Side Bar Visibility")
        word(page, "beat").click()
        page.keyboard.press("Control+S")
        beat = framed_page(page).locator("#beat-now")
        page.mouse.move(300, 500)
        expect(beat).to_have_text(str(DRAWN))
        page.screenshot(path=sys.argv[1])
        run_command(page, "Improv: Stop Robots")


if __name__ == "__main__":
    main()
