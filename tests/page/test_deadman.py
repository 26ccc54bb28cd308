"""The deadman button of a gamepad, which the tests hold. modules/deadman.test.js tests the time of its release."""

from __future__ import annotations

from typing import Any

import pytest
from playwright.sync_api import Page, expect

from improv_core.page.server import PageServer
from improv_core.preview import window
from improv_core.program.analysis import analyze
from improv_core.program.compiler import score_of
from tests.page.conftest import Commands, asked, link, wait

GAMEPADS = """
const pads = [null, { connected: true, buttons: [0, 1, 2, 3, 4, 5].map(() => ({ pressed: false })) }]
navigator.getGamepads = () => pads
window.press = (button, pressed) => pads[1].buttons[button].pressed = pressed
"""


@pytest.fixture
def held(page: Page, viewer: PageServer, commands: Commands) -> Page:
    """A page with a gamepad, while robots move only if its button 4 is held."""
    page.add_init_script(GAMEPADS)
    page.goto(link(viewer))
    wait(page, "window.improv?.connected")
    require(viewer, {"button": 4})
    return page


def require(viewer: PageServer, deadman: Any) -> None:
    score = score_of(analyze("r $ forward"))
    viewer.publish({**window.about(score, 1, takes_start_poses=False), "deadman": deadman})


def test_the_page_names_the_deadman_button_and_sends_its_state(
    held: Page, viewer: PageServer, commands: Commands
) -> None:
    line = held.get_by_text("hold button 4 to move")
    expect(line).to_be_visible()
    held.evaluate("press(4, true)")
    assert [asked(commands)["type"] for _ in range(3)] == ["held"] * 3
    expect(line).to_be_hidden()
    require(viewer, None)
    while (kind := asked(commands)["type"]) != "released":
        assert kind == "held"
    expect(line).to_be_hidden()
