"""Presses of controls: nothing that is being pressed moves."""

from __future__ import annotations

from collections.abc import Callable

import pytest
from playwright.sync_api import BrowserContext, Page

from tests.page.conftest import next_frame, wait
from tests.page.editing import PLAYING, Edit

SIZES = ((390, 480), (390, 844), (683, 384), (1366, 768))
"""Pixels: a phone with its keyboard and without, a laptop at 200 % zoom, and a laptop."""
PROGRAM = "beat 30\nada $ repeat (forward left)\nbo $ repeat (backwrd left)\n"
# Presses no control, but notes where it is at pointerdown and at pointerup.
LISTEN = """() => {
  const place = ({ left, top, width, height }) => [left, top, width, height].map(Math.round).join()
  for (const kind of ["pointerdown", "pointerup"]) addEventListener(kind, () => {
    if (window.control) window.seen.push(place(window.control.getBoundingClientRect()))
  }, true)
  for (const kind of ["click", "change"]) addEventListener(kind, (event) => {
    if (!window.control) return
    event.preventDefault()
    event.stopImmediatePropagation()
  }, true)
}"""
CONTROLS = """[...document.querySelectorAll("button, summary, [role=slider]")].filter((control) => {
  const { x, y, width, height } = control.getBoundingClientRect()
  return control.contains(document.elementFromPoint(x + width / 2, y + height / 2))
})"""


@pytest.fixture
def window(lively: BrowserContext) -> BrowserContext:
    return lively


@pytest.mark.slow("presses every control at four sizes")
def test_no_control_moves_while_it_is_pressed(edit: Callable[[str], Edit]) -> None:
    page = edit(PROGRAM).page()
    page.evaluate(LISTEN)
    for width, height in SIZES:
        page.set_viewport_size({"width": width, "height": height})
        index = 0
        while place := _write(page, index):
            assert _places(page, place) == "same", f"{width}×{height}"
            index += 1


def test_the_first_press_of_save_and_play_plays_while_a_phone_has_its_keyboard_open(
    edit: Callable[[str], Edit],
) -> None:
    page = edit("ada $ repeat (forward left)\n").page()
    page.set_viewport_size({"width": 390, "height": 480})
    page.locator("#text").focus()
    page.locator("#write").hover()
    page.mouse.down()
    next_frame(page)
    page.mouse.up()
    wait(page, PLAYING)


def _write(page: Page, index: int) -> list[float] | None:
    """Put the focus into the text. Return the middle of a control, once all are laid out; None if there are fewer."""
    page.evaluate("document.querySelector('#text').focus()")
    next_frame(page)
    place: list[float] | None = page.evaluate(
        f"""() => {{
          window.seen = []
          window.control = {CONTROLS}[{index}]
          const box = control?.getBoundingClientRect()
          return box ? [box.x + box.width / 2, box.y + box.height / 2] : null
        }}"""
    )
    return place


def _places(page: Page, place: list[float]) -> str:
    """Press a control. Return its name, and where it was before and after, unless that is the same."""
    page.mouse.move(place[0], place[1])
    page.mouse.down()
    next_frame(page)
    page.mouse.up()
    return str(
        page.evaluate(
            """() => {
          const [before, after] = seen
          const name = control.id || control.className || control.textContent
          window.control = null
          return before === after ? "same" : `${name} moves from ${before} to ${after}`
        }"""
        )
    )
