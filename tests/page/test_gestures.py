"""Movements by hand on the page: a handle that is dragged, a drawing, and a robot that performs."""

from __future__ import annotations

import json
import math
import re
import time
from collections.abc import Callable
from fractions import Fraction

import pytest
from playwright.sync_api import BrowserContext, Page, ViewportSize, expect

from improv_core.score.primitives import rest_text
from tests.open_page import CALMLY
from tests.page.conftest import Keep, at, box, rest, wait
from tests.page.editing import Edit
from tests.page.looks import COUNT, PIXEL

SQUARE = "ada at 0 0\nada $ repeat 4 (forward left)\n"

ORANGE, BLUE = [192, 79, 0], [0, 114, 178]
GROUND = "251,250,247"
PHONE: ViewportSize = {"width": 390, "height": 844}
LOWER_END = "document.getElementById('{0}').getBoundingClientRect().bottom - document.getElementById('hall').offsetTop"


def put_cursor(page: Page, behind: str) -> None:
    """Put the cursor into the text, behind a word."""
    place = SQUARE.index(behind) + len(behind)
    page.locator("#text").focus()
    page.evaluate(f"document.getElementById('text').setSelectionRange({place}, {place})")


def drag(page: Page, places: list[tuple[float, float]], meanwhile: Callable[[], None] | None = None) -> None:
    """Drag the mouse along places on the floor, in meters, once the camera stands still. `meanwhile` comes before the
    mouse is released."""
    rest(page)
    stage = box(page, "#stage")
    seen = page.evaluate("places => places.map(([x, y]) => improv.toScreen(x, y))", places)
    first, *others = [(stage["x"] + place["x"], stage["y"] + place["y"]) for place in seen]
    page.mouse.move(*first)
    page.mouse.down()
    for place in others:
        page.mouse.move(*place)
    if meanwhile:
        meanwhile()
    page.mouse.up()


@pytest.fixture
def window(lively: BrowserContext) -> BrowserContext:
    """A window of its own, because a test stops the clock of its window."""
    lively.add_init_script(CALMLY)
    return lively


@pytest.mark.slow("bends, draws, and performs in a browser")
def test_movements_by_hand_become_words_and_each_is_undone_at_once(edit: Callable[[str], Edit], keep: Keep) -> None:
    page = edit(SQUARE).page()
    text = page.locator("#text")
    page.set_viewport_size({"width": 683, "height": 384})
    for button in ("Tutorial", "Examples", "Share"):
        expect(page.get_by_role("button", name=button, exact=True)).to_be_in_viewport(ratio=1)
    wait(page, "improv.toScreen(0, 2).y > " + LOWER_END.format("hint-title") + " + 8")  # the path is below the line
    page.set_viewport_size({"width": 1280, "height": 800})
    page.locator("#write").click()
    wait(page, "improv.transport.state === 'playing' && improv.drawn.ada?.y > 0.5")
    page.locator("#stop").click()

    put_cursor(page, "forwa")
    wait(page, "improv.handle?.place[0] === 2")
    keep(page, "gesture-handle.png")
    lengthened = SQUARE.replace("forward", "forward 3m")
    drag(page, [(2, 0), (2.4, 0), (2.7, 0.1), (3, 0)], lambda: expect(text).to_have_value(lengthened))
    text.focus()
    page.keyboard.press("Control+z")
    expect(text).to_have_value(SQUARE)
    put_cursor(page, "lef")
    wait(page, "improv.handle.text === 'left'")
    text.evaluate(
        """(text, place) => {  // at once, so the page doesn't know the movement at the cursor yet
          text.setSelectionRange(place, place)
          text.dispatchEvent(new KeyboardEvent("keydown", { key: "ArrowUp", altKey: true }))
        }""",
        SQUARE.index("orward"),
    )
    wait(page, "improv.handle.text === 'forward 2.1m'")
    page.keyboard.press("Alt+ArrowUp")
    expect(text).to_have_value(SQUARE.replace("forward", "forward 2.2m"))
    expect(page.locator("#news")).to_have_text("forward 2.2m")
    page.keyboard.press("Control+z")

    put_cursor(page, "left)\n")
    page.keyboard.type("bo $ (left 90deg)")
    written = f"{SQUARE}bo $ (left 90deg)"
    wait(page, "improv.handle.text === ''")
    page.keyboard.press("ArrowLeft")
    page.keyboard.press("ArrowLeft")
    wait(page, "improv.handle.text === 'left 90deg'")
    wait(page, f"({COUNT})({BLUE}) > 100")  # bo's color, although bo doesn't play yet
    for key, angle in (("Up", 105), ("Up", 120), ("Down", 105), ("Down", 90), ("Up", 105)):
        page.keyboard.press(f"Alt+Arrow{key}")
        expect(text).to_have_value(written.replace("90", str(angle)))
        wait(page, f"improv.handle.text === 'left {angle}deg'")
    page.keyboard.press("Control+z")
    expect(text).to_have_value(written)
    page.keyboard.press("Control+z")  # what was typed before: as many letters as the browser takes for one step
    wait(
        page,
        "(([now, all]) => now !== all && all.startsWith(now))([document.querySelector('#text').value, "
        + json.dumps(written)
        + "])",
    )
    text.fill(SQUARE)

    put_cursor(page, "left)")
    page.locator("#draw").click()
    page.locator("#gesture-parts").select_option("0")
    drag(page, [(math.sin(turn / 8), 1 - math.cos(turn / 8)) for turn in range(51)])
    expect(text).to_have_value(SQUARE.replace("left)", "left) left 360deg radius 1m"))
    keep(page, "gesture-drawn.png")
    page.get_by_role("button", name="Help", exact=True).click()
    for pressed in ("true", "false"):
        page.keyboard.press("Escape")  # closes Help first
        expect(page.locator("#help")).to_be_hidden()
        expect(page.locator("#draw")).to_have_attribute("aria-pressed", pressed)
    text.focus()
    page.keyboard.press("Control+z")
    expect(text).to_have_value(SQUARE)

    page.locator("#perform").click()
    page.locator("#gesture-parts").select_option("1")
    expect(page.locator("#gesture")).to_contain_text("Press Perform again: the words replace the robot's line")
    page.set_viewport_size(PHONE)
    wait(page, "improv.toScreen(0, 2).y > " + LOWER_END.format("gesture"))
    page.set_viewport_size({"width": 1280, "height": 800})
    page.locator("#fit").click()  # room that the drawing used would be kept for a while
    rest(page)
    shown = page.evaluate(COUNT, ORANGE)
    page.locator("#trail").select_option("off")
    rest(page)
    assert page.evaluate(COUNT, ORANGE) == shown  # no trail leads to where the robot was put
    page.locator("#trail").select_option("all")
    page.locator("#stage").focus()
    page.keyboard.down("ArrowUp")
    wait(page, "improv.drawn.ada.x > 1.5")
    page.keyboard.up("ArrowUp")
    keep(page, "gesture-performed.png")
    page.keyboard.press("Enter")
    expect(text).to_have_value(re.compile(r"ada at 0 0\nada \$ (repeat \d+ )?forward( forward)*\n"))
    text.focus()
    page.keyboard.press("Control+z")
    expect(text).to_have_value(SQUARE)
    wait(page, "improv.transport.state === 'stopped'")  # no robot has moved by this

    beat = math.floor(page.evaluate("improv.beat")) + 1  # a slow machine stopped it at a later beat
    page.locator("#step").click()
    wait(page, f"improv.transport.state === 'paused' && improv.beat === {beat}")
    heading, corner = math.radians(90 * (beat // 2)), [(0, 0), (2, 0), (2, 2), (0, 2)][(beat + 1) // 2 % 4]
    covered = f"Math.hypot(improv.drawn.ada.x - {corner[0]}, improv.drawn.ada.y - {corner[1]})"
    page.locator("#perform").click()
    wait(page, f"{covered} < 0.1 && Math.cos(improv.drawn.ada.heading - {heading}) > 0.99")  # where the dance has come
    page.keyboard.down("ArrowUp")
    wait(page, f"{covered} > 1.5")
    page.keyboard.up("ArrowUp")
    page.keyboard.press("Enter")
    kept = rf"ada \$ \(repeat 4 \(forward left\) \|\| {rest_text(Fraction(beat))}\)"
    expect(text).to_have_value(re.compile(rf"{kept} .*forward"))


@pytest.mark.slow("drags in a browser")
def test_a_hand_bends_nothing_while_somebody_performs(edit: Callable[[str], Edit]) -> None:
    page = edit(SQUARE).page()
    page.locator("#write").click()
    wait(page, "improv.transport.state === 'playing' && improv.drawn.ada?.x > 0.5")
    page.locator("#stop").click()
    put_cursor(page, "forwa")
    wait(page, "improv.handle?.place?.[0] === 2")
    page.locator("#perform").click()
    rest(page)
    for performs in (True, False):
        drag(page, [(2, 0), (2.4, 0), (3, 0)])
        expect(page.locator("#text")).to_have_value(SQUARE if performs else SQUARE.replace("forward", "forward 3m"))
        page.keyboard.press("Escape")
        page.locator("#text").focus()


@pytest.mark.slow("writes in a browser")
def test_a_page_asks_for_the_handle_once_nobody_types(edit: Callable[[str], Edit]) -> None:
    page = edit(SQUARE).page()
    put_cursor(page, "left)\n")
    wait(page, "improv.handle?.text === ''")
    page.evaluate(
        """() => {
          window.asked = []
          const { send } = WebSocket.prototype
          WebSocket.prototype.send = function (data) { asked.push(JSON.parse(data).type); send.call(this, data) }
        }"""
    )
    page.clock.install()
    page.clock.pause_at(time.time() + 60)
    page.keyboard.type("bo $ left")
    expect(page.locator("#highlight .function")).to_have_count(3)
    assert "handle" not in page.evaluate("asked")
    page.clock.run_for(400)
    page.clock.resume()
    wait(page, "improv.handle.text === 'left'")
    assert page.evaluate("asked").count("handle") == 1


@pytest.mark.slow("draws in a browser")
def test_a_phone_draws_for_a_robot_of_the_text_finely_and_performs_as_the_robot_that_is_dragged(
    edit: Callable[[str], Edit], keep: Keep
) -> None:
    page = edit("ada at 1 0\nbo $ (left)\n").page()
    page.set_viewport_size(PHONE)
    wait(page, "improv.previewed")  # so the page knows the robots of the text
    page.locator("#draw").click()
    expect(page.locator("#gesture-robot option")).to_have_text(["bo", "ada"])
    expect(page.locator("#gesture-line")).to_contain_text("the words replace the robot's line")
    rest(page)
    keep(page, "gesture-pen.png")
    assert page.evaluate(f"({PIXEL})(6 / improv.view.scale, 0)") == GROUND  # the pen has an edge: on the robot, too
    page.locator("#gesture-robot").select_option("ada")
    page.locator("#gesture-parts").select_option("0")
    bar = box(page, "#gesture-line")
    view = page.evaluate("improv.view")
    assert view["scale"] >= 80, "60 cm is too small for a finger"
    touch, (x, y) = page.context.new_cdp_session(page), at(page, 1, 0)
    for kind, fingers in (("Start", [-100]), ("Move", [-50]), ("Start", [-50, 0]), ("Move", [-55, 5]), ("End", [])):
        points = [{"x": x + place, "y": y, "id": finger} for finger, place in enumerate(fingers)]
        touch.send("Input.dispatchTouchEvent", {"type": f"touch{kind}", "touchPoints": points})
    wait(page, f"improv.view.scale > {view['scale']}")  # two fingers have zoomed, and drawn nothing

    end = at(page, 2, 0)

    def touch_above_the_floor() -> None:
        for kind, points in (("Start", [{"x": 10, "y": 10}]), ("End", [])):
            touch.send("Input.dispatchTouchEvent", {"type": f"touch{kind}", "touchPoints": points})
        rest(page)
        page.mouse.move(*end)  # the floor is where it was

    drag(page, [(1, 0), (1.5, 0)], touch_above_the_floor)
    drawn = "ada at 1 0\nbo $ (left)\nada $ forward 1m\n"
    expect(page.locator("#text")).to_have_value(drawn)
    assert box(page, "#gesture-line")["height"] < bar["height"]

    for robot, line in (("bo", "Draw anywhere"), ("ada", "continues at the dot")):
        page.locator("#gesture-robot").focus()
        page.locator("#gesture-robot").select_option(robot)
        expect(page.locator("#gesture-line")).to_contain_text(line)
    bar = box(page, "#gesture-line")
    page.mouse.move(bar["x"] + 20, bar["y"] + bar["height"] / 2)  # a narrow page has it where people begin to draw
    page.mouse.down()
    page.mouse.move(bar["x"] + 80, bar["y"] + bar["height"] / 2 + 100)
    page.mouse.up()
    expect(page.locator("#text")).to_have_value(re.compile(r"ada at 1 0\nbo \$ \(left\)\nada \$ forward 1m .+\n"))

    page.locator("#text").fill(drawn)
    page.locator("#write").click()
    wait(page, "improv.transport.state === 'ended'")
    page.locator("#perform").click()
    page.locator("#gesture-robot").select_option("ada")
    drag(page, [(0, 0), (0, -0.5), (0, -1)])
    expect(page.locator("#gesture-robot")).to_have_value("bo")


@pytest.mark.slow("performs in a browser")
def test_enter_writes_what_was_performed_despite_a_stop_and_a_click_on_a_button(edit: Callable[[str], Edit]) -> None:
    page = edit(SQUARE).page()
    page.locator("#write").click()
    wait(page, "improv.transport.state === 'playing'")
    page.locator("#perform").click()
    generation = page.evaluate("improv.transport.restarted")
    page.locator("#restart").click()
    wait(page, f"improv.transport.restarted !== {generation}")
    wait(page, "improv.beat > 2")
    page.evaluate("window.put = { ...improv.drawn.ada }")
    page.keyboard.down("ArrowUp")
    page.locator("#stop").click()  # takes the dance back to its start, but no beat of the movement
    wait(page, "Math.hypot(improv.drawn.ada.x - put.x, improv.drawn.ada.y - put.y) > 1")
    page.keyboard.up("ArrowUp")
    page.keyboard.press("Enter")
    expect(page.locator("#text")).not_to_have_value(SQUARE)
    page.locator("#perform").click()
    page.locator("#restart").focus()
    generation = page.evaluate("improv.transport.restarted")
    page.keyboard.press("Enter")  # somebody has moved the focus there by keyboard
    wait(page, f"improv.transport.restarted !== {generation}")


@pytest.mark.slow("draws in a browser")
def test_fit_is_off_while_draw_shows_a_part_of_the_floor_and_shows_all_if_pressed(edit: Callable[[str], Edit]) -> None:
    page = edit("ada at -2 0\nbo at 2 0\nada bo $ forward left forward 3m\n").page()
    page.set_viewport_size(PHONE)
    page.locator("#write").click()
    wait(page, "improv.transport.state === 'ended'")
    rest(page)
    scale, fit = page.evaluate("improv.view.scale"), page.locator("#fit")
    for begins, pressed in ((True, "false"), (False, "true")):
        page.locator("#draw").click()
        assert not begins or page.evaluate("improv.view.scale") > scale
        expect(fit).to_have_attribute("aria-pressed", pressed)
    page.locator("#draw").click()
    fit.click()
    expect(fit).to_have_attribute("aria-pressed", "true")
    wait(page, "improv.view.scale < 80")
