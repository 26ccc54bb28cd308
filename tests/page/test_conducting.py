"""Every control of the page, by mouse and by key, on a real stage."""

from __future__ import annotations

import re
from collections.abc import Callable
from datetime import datetime

import pytest
from playwright.sync_api import Page, expect

from improv_core.page.server import PageServer
from improv_core.protocol.page_messages import for_pages
from tests.page.conftest import (
    Commands,
    Keep,
    Show,
    asked,
    at,
    begin_paused,
    box,
    play_anew,
    transport,
    wait,
)

PROGRAM = "beat 60\nada $ repeat 40 (forward || left)\nbo $ repeat 40 (forward right)\n"


@pytest.fixture
def stage(shared: tuple[Show, Page]) -> Page:
    """The page on which PROGRAM begins again."""
    show, page = shared
    play_anew(page, show, PROGRAM)
    wait(page, "improv.transport.state === 'playing'")
    return page


def test_every_button_controls_the_dance(stage: Page) -> None:
    wait(stage, "improv.beat > 1.2")
    stage.get_by_role("button", name="Pause").click()
    wait(stage, "improv.transport.state === 'paused'")
    expect(stage.locator("#state")).to_have_text("paused")
    beat = stage.evaluate("improv.beat")
    expect(stage.get_by_role("status")).to_have_text(f"paused at beat {int(beat) + 1}")
    stage.get_by_role("button", name="Play").click()
    wait(stage, "improv.transport.state === 'playing'")
    assert stage.evaluate("improv.transport.beat") == beat  # it continues from the same place
    generation = stage.evaluate("improv.transport.generation")
    stage.get_by_role("button", name="Restart").click()
    wait(stage, f"improv.transport.generation > {generation} && improv.transport.beat < {beat}")
    stage.get_by_role("button", name="Stop").click()
    wait(stage, "improv.transport.state === 'stopped'")
    stage.get_by_role("button", name="Play").click()  # it begins again
    wait(stage, f"improv.transport.state === 'playing' && improv.transport.generation > {generation + 1}")
    assert stage.evaluate("improv.transport.beat") == 0


def test_the_play_button_begins_an_armed_dance(shared: tuple[Show, Page], keep: Keep) -> None:
    show, page = shared
    state = page.locator("#state-word")
    play_anew(page, show, PROGRAM, arming={"begins": datetime(2099, 11, 24, 20, 15).timestamp()})
    expect(state).to_have_text(re.compile("^armed for .*:15"))
    play_anew(page, show, PROGRAM, arming={})
    expect(state).to_have_text("armed")
    expect(page.get_by_role("status")).to_have_text("armed: press Play to begin")
    keep(page, "armed.png")
    assert page.evaluate("improv.transport.state") == "waiting"
    page.get_by_role("button", name="Begin").click()
    wait(page, "improv.transport.state === 'playing'")
    expect(state).to_have_text("playing")
    page.get_by_role("button", name="Stop").click()
    generation = page.evaluate("improv.transport.generation")
    for armed, says in ((True, "armed"), (False, "stopped")):  # real robots, beside which the simulator plays
        show.tell(for_pages({"type": "armed", "generation": generation, "armed": armed, "begins": None}))
        expect(state).to_have_text(says)


def test_a_dance_continues_with_the_scene_that_somebody_chooses(shared: tuple[Show, Page], stage: Page) -> None:
    show, page = shared
    expect(page.locator("#scenes")).to_be_hidden()  # there is nothing to choose
    scenes = "beat 60\n--- walk\nada $ repeat 20 forward\n--- bow\nada $ repeat 20 left\n---\nada $ repeat 20 right\n"
    play_anew(page, show, scenes)
    wait(page, "improv.transport.state === 'playing'")
    scene = page.get_by_label("Scene")
    assert scene.locator("option").all_text_contents() == ["walk", "bow", "scene 3"]
    expect(scene).to_have_value("walk")
    scene.select_option("scene 3")
    wait(page, "improv.beat >= 40")
    scene.select_option("bow")
    wait(page, "improv.beat >= 20 && improv.beat < 40 && improv.transport.state === 'playing'")
    expect(scene).to_have_value("bow")
    page.keyboard.press("R")
    wait(page, "improv.beat < 20")
    expect(scene).to_have_value("walk")


def test_speed_and_silence_are_changed_and_shown(stage: Page) -> None:
    stage.get_by_role("button", name="Faster").click()
    wait(stage, "improv.transport.speed === 1.25")
    expect(stage.locator("#tempo")).to_have_text("75 beats/min")
    stage.keyboard.press("[")
    stage.keyboard.press("[")
    wait(stage, "improv.transport.speed < 1.25")
    stage.get_by_role("button", name="back to normal").click()
    wait(stage, "improv.transport.speed === 1")
    expect(stage.locator("#normal")).to_have_text("1×")
    mute = stage.get_by_role("button", name="Mute ada")
    mute.click()
    wait(stage, "improv.transport.muted.join() === 'ada'")
    expect(mute).to_have_attribute("aria-pressed", "true")
    stage.get_by_role("button", name="Solo ada").click()
    wait(stage, "improv.transport.soloed.join() === 'ada'")
    expect(stage.locator("li[data-robot=bo]")).to_have_attribute("data-silent", "true")
    expect(stage.locator("li[data-robot=ada]")).to_have_attribute("data-silent", "false")
    mute.click()
    stage.get_by_role("button", name="Solo ada").click()
    wait(stage, "!improv.transport.muted.length && !improv.transport.soloed.length")


def test_the_timeline_is_a_slider_for_hand_and_keys(stage: Page) -> None:
    stage.keyboard.press("k")
    wait(stage, "improv.transport.state === 'paused'")
    slider = stage.get_by_role("slider", name="Position in beats")
    line = box(stage, "#playline")
    stage.mouse.move(line["x"] + line["width"] * 0.6, line["y"] + 40)
    stage.mouse.down()
    stage.mouse.move(line["x"] + line["width"] * 0.7, line["y"] + 40, steps=4)
    stage.mouse.up()
    wait(stage, "improv.beat > 5")
    slider.focus()
    stage.keyboard.press("Home")
    wait(stage, "improv.beat === 0")
    for _ in range(3):
        stage.keyboard.press("ArrowRight")
    wait(stage, "improv.beat === 3")
    stage.keyboard.press("ArrowLeft")
    wait(stage, "improv.beat === 2")
    expect(slider).to_have_attribute("aria-valuenow", "2")
    expect(slider).to_have_attribute("aria-valuetext", "beat 3 of 80")
    wait(stage, "Math.abs(improv.robots.bo.x - 2) < 1e-3")


def test_keys_that_stop_stop_wherever_the_focus_is(stage: Page) -> None:
    stage.get_by_role("button", name="Starts").click()
    field = stage.get_by_label("x", exact=True).first
    field.focus()
    stage.keyboard.press("Space")
    wait(stage, "improv.transport.state === 'stopped'")
    assert field.input_value() == "0"
    stage.keyboard.press("Escape")


def test_shortcuts_work_with_caps_lock_and_a_cyrillic_keyboard(stage: Page) -> None:
    session = stage.context.new_cdp_session(stage)
    for key in ("L", "\u0434"):
        for shown in (False, True):
            session.send("Input.dispatchKeyEvent", {"type": "keyDown", "key": key, "code": "KeyL", "text": key})
            session.send("Input.dispatchKeyEvent", {"type": "keyUp", "key": key, "code": "KeyL"})
            expect(stage.locator("#timeline")).to_be_visible(visible=shown)


def test_escape_closes_what_is_open_and_the_next_one_stops(stage: Page) -> None:
    opened = stage.locator("dialog[open], #show-more[aria-expanded=true]")
    for name in ("View", "Help", "Save", "Sound", "Starts"):
        stage.set_viewport_size({"width": 600 if name == "View" else 1280, "height": 800})
        stage.get_by_role("button", name=name, exact=True).click()
        expect(opened).to_have_count(1)
        stage.keyboard.press("Escape")
        expect(opened).to_have_count(0)
        assert stage.evaluate("improv.transport.state") == "playing", name
    stage.keyboard.press("Escape")
    wait(stage, "improv.transport.state === 'stopped'")


def test_text_typed_outside_the_editor_starts_nothing(stage: Page) -> None:
    stage.get_by_role("button", name="Stop").click()
    wait(stage, "improv.transport.state === 'stopped'")
    generation = stage.evaluate("improv.transport.generation")
    did = stage.locator("#did")
    for focus in ("body", "#score-text"):
        stage.evaluate("focus => { document.activeElement.blur(); document.querySelector(focus).focus() }", focus)
        stage.keyboard.type("forwards", delay=20)
        expect(stage.locator("#score")).to_be_visible()
    expect(did).to_have_text("Keys work once you have clicked the stage")
    stage.locator("#stage").click(position={"x": 300, "y": 200})
    stage.keyboard.press("l")
    expect(did).to_have_text("L: timeline hidden")
    expect(stage.locator("#timeline")).to_be_hidden()
    assert stage.evaluate("improv.transport.generation") == generation
    stage.keyboard.press("r")
    expect(did).to_have_text("R: restart")
    wait(stage, f"improv.transport.generation > {generation}")
    stage.keyboard.press("l")
    expect(stage.locator("#timeline")).to_be_visible()
    stage.keyboard.press("a")  # a button that is out of sight, at this size or a smaller one
    expect(did).to_have_text("A: Paths ahead off")
    stage.keyboard.press("a")
    expect(stage.locator("#ahead")).to_have_attribute("aria-pressed", "true")


def test_keys_of_one_letter_can_be_turned_off(stage: Page) -> None:
    stage.keyboard.press("?")
    dialog = stage.get_by_role("dialog", name="Help")
    expect(dialog).to_be_visible()
    letters = dialog.get_by_role("button", name="Single-letter keys")
    letters.focus()
    stage.keyboard.press("Enter")
    expect(letters).to_have_attribute("aria-pressed", "false")
    stage.keyboard.press("k")
    stage.keyboard.press("ArrowRight")  # still works
    wait(stage, "improv.beat > 1")
    assert stage.evaluate("improv.transport.state") == "playing"
    letters.click()
    expect(letters).to_have_attribute("aria-pressed", "true")
    dialog.get_by_role("button", name="Close").click()
    expect(dialog).to_be_hidden()
    expect(stage.get_by_role("button", name="Help", exact=True)).to_be_focused()


def test_the_view_moves_by_keys_and_fits_again(shared: tuple[Show, Page]) -> None:
    show, page = shared
    begin_paused(page, show, PROGRAM)
    fit = page.get_by_role("button", name="Fit")
    at(page, 0, 0)  # once the view has come to rest
    before = page.evaluate("improv.view")
    page.keyboard.press("+")
    page.keyboard.press("Shift+ArrowLeft")
    wait(page, f"improv.view.scale > {before['scale']} && improv.view.x < {before['x']}")
    expect(fit).to_have_attribute("aria-pressed", "false")
    page.mouse.move(400, 300)
    page.mouse.wheel(0, 200)
    page.mouse.down()
    page.mouse.move(500, 350)
    page.mouse.up()
    page.keyboard.press("f")
    expect(fit).to_have_attribute("aria-pressed", "true")
    wait(page, f"Math.abs(improv.view.scale / {before['scale']} - 1) < 0.2")


def test_only_improv_edit_lets_a_page_write(stage: Page) -> None:
    expect(stage.locator("#read-only")).to_contain_text("Change it where it was written")
    expect(stage.locator("#text")).to_be_hidden()

    said = stage.evaluate(
        """() => new Promise(done => {
          const token = encodeURIComponent(JSON.parse(localStorage.getItem("improv.token")))
          const socket = new WebSocket(`ws://${location.host}/live?token=${token}`)
          const said = []
          socket.onopen = () => {
            socket.send(JSON.stringify({ type: "analyze", number: 1, text: "r $ left" }))
            socket.send(JSON.stringify({ type: "write", number: 1, text: "r $ left", revision: "" }))
            socket.send(JSON.stringify({ type: "stop" }))
          }
          socket.onmessage = ({ data }) => {
            said.push(JSON.parse(data).type)
            if (JSON.parse(data).state !== "stopped") return
            socket.close()
            done(said)
          }
        })"""
    )
    assert not {"source", "analyze", "write"} & set(said)


def test_a_step_continues_from_the_previous_one_even_if_the_server_is_late(
    still: Callable[..., Page], viewer: PageServer, commands: Commands
) -> None:
    page = still("beat 60\nada $ repeat 8 forward\n")
    page.get_by_role("slider", name="Position in beats").focus()
    for milliseconds in (0, 1000):
        page.evaluate(f"performance.now = () => 1e6 + {milliseconds}")
        page.keyboard.press("ArrowRight")
    assert [asked(commands)["beat"] for _ in range(2)] == [1, 2]
    for beat in (2.0, 5.0):  # confirmed, then somebody else has it continue elsewhere
        viewer.publish(transport(1, "paused", beat=beat))
        wait(page, f"improv.beat === {beat}")
    page.keyboard.press("ArrowRight")
    assert asked(commands)["beat"] == 6
