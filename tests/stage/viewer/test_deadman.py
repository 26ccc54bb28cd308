"""The deadman button of a gamepad, which the tests hold."""

from __future__ import annotations

import json
import queue
from typing import Any

import pytest
from playwright.sync_api import Page, expect

from improv_core.program.analysis import analyze
from improv_core.program.compiler import score_of
from improv_core.stage.commands import PageRequest, Watched
from improv_core.stage.viewer import lookahead
from improv_core.stage.viewer.server import Viewer
from tests.stage.viewer.conftest import LIMIT, link, wait

Commands = queue.SimpleQueue[PageRequest | Watched]
GAMEPADS = """
const pads = [null, { connected: true, buttons: [0, 1, 2, 3, 4, 5].map(() => ({ pressed: false })) }]
navigator.getGamepads = () => pads
window.press = (button, pressed) => pads[1].buttons[button].pressed = pressed
window.unplug = () => pads[1] = null
"""


@pytest.fixture
def held(page: Page, viewer: Viewer, commands: Commands) -> Page:
    """A page with a gamepad, while robots move only if its button 4 is held."""
    page.add_init_script(GAMEPADS)
    page.goto(link(viewer))
    wait(page, "window.improv?.connected")
    require(viewer, {"button": 4})
    return page


def require(viewer: Viewer, deadman: Any) -> None:
    score = score_of(analyze("r $ forward"))
    viewer.publish({**lookahead.about(score, 1, takes_start_poses=False), "deadman": deadman})


def taken(commands: Commands) -> str:
    """The type of the next request."""
    while (command := commands.get(timeout=LIMIT)) == {"type": "watched"}:  # it may have reconnected
        pass
    return command["type"]


def until_released(commands: Commands) -> None:
    """Every request until it is released says that it is held."""
    while (kind := taken(commands)) != "released":
        assert kind == "held"


def test_the_page_says_which_button_to_hold_and_whether_it_is(held: Page, commands: Commands) -> None:
    line = held.get_by_text("hold button 4 to move")
    expect(line).to_be_visible()
    held.evaluate("press(3, true)")
    expect(line).to_be_visible()
    held.evaluate("press(4, true)")
    assert [taken(commands) for _ in range(3)] == ["held"] * 3
    expect(line).to_be_hidden()
    held.evaluate("press(4, false)")
    until_released(commands)
    expect(line).to_be_visible()
    held.evaluate("press(4, true)")
    assert taken(commands) == "held"


@pytest.mark.parametrize(
    "gone",
    [
        "unplug()",
        "Object.defineProperty(document, 'hidden', { value: true }); document.dispatchEvent(new Event(CHANGED))",
    ],
    ids=["unplugged", "hidden"],
)
def test_a_gamepad_or_page_that_disappears_counts_as_released(held: Page, commands: Commands, gone: str) -> None:
    held.evaluate("press(4, true)")
    assert taken(commands) == "held"
    held.evaluate(f"() => {{ const CHANGED = 'visibilitychange'; {gone} }}")
    until_released(commands)
    assert commands.empty()


def test_a_frame_without_access_to_gamepads_says_what_to_do(held: Page, commands: Commands) -> None:
    held.evaluate("press(4, true)")
    assert taken(commands) == "held"
    held.evaluate("() => { navigator.getGamepads = () => { throw new DOMException('not allowed', 'SecurityError') } }")
    until_released(commands)
    expect(held.get_by_text("open this page in a browser to use a gamepad")).to_be_visible()


def test_nothing_is_sent_if_no_button_is_required(held: Page, viewer: Viewer, commands: Commands) -> None:
    require(viewer, None)
    expect(held.get_by_text("hold button 4 to move")).to_be_hidden()
    held.evaluate("press(4, true)")
    held.evaluate("new Promise(requestAnimationFrame)")
    held.keyboard.press("Escape")
    assert taken(commands) == "stop"


def test_held_messages_are_a_tenth_of_a_second_apart(held: Page) -> None:
    sent = held.evaluate(
        """async () => {
          const { Deadman } = await import("/deadman.js")
          const sent = []
          const deadman = new Deadman((request) => sent.push(request.type))
          deadman.require({ button: 4 })
          press(4, true)
          for (let now = 5000; now < 5300; now += 10) deadman.look(now)
          press(4, false)
          for (let now = 5300; now < 5600; now += 10) deadman.look(now)
          return sent
        }"""
    )
    assert json.dumps(sent) == json.dumps(["held", "held", "held", "released"])
