"""`improv edit` in a real browser: a program is written on the page, and nobody's text is lost."""

from __future__ import annotations

from collections.abc import Callable
from itertools import product

import pytest
from playwright.sync_api import Page, expect

from improv_core.page.server import PageServer
from improv_core.protocol.editing import NO_DRAFT
from improv_core.protocol.fields import LONGEST_TEXT
from tests.axe import Violations
from tests.page.conftest import SCHEMES, Keep, at, box, wait
from tests.page.editing import IDLE, PLAYING, Edit
from tests.page.looks import COUNT
from tests.page.test_text_preview import previews

SQUARE = "beat 60\nada $ repeat 4 (forward left)\n"

# True if the colored text lies exactly below the written text.
ALIGNED = """() => {
  const [below, text] = ["highlight", "text"].map(id => document.getElementById(id))
  const shown = [...below.querySelectorAll("div")].map(line => line.textContent).join("\\n")
  text.style.height = "0"
  const height = text.scrollHeight
  text.style.height = ""
  const same = below.getBoundingClientRect().width === text.getBoundingClientRect().width
  const end = below.lastElementChild.getBoundingClientRect().bottom + parseFloat(getComputedStyle(below).paddingBottom)
  return [shown === text.value, same, Math.round(end - below.getBoundingClientRect().top) - height]
}"""

# Notes the types of the requests that the page sends from now on.
COUNT_REQUESTS = """() => {
  const { send } = WebSocket.prototype
  window.asked = []
  WebSocket.prototype.send = function (data) {
    asked.push(JSON.parse(data).type)
    return send.call(this, data)
  }
}"""


def write(page: Page, keys: str) -> None:
    """Type at the end of the program."""
    page.locator("#text").focus()
    page.keyboard.press("Control+End")
    page.keyboard.type(keys)


@pytest.mark.slow("writes a program as people do")
def test_a_program_is_typed_fixed_by_a_button_and_played(edit: Callable[[str], Edit], keep: Keep) -> None:
    edited = edit("\ufeff# 🤖🤖\r\nbeat 60\r\n")
    page = edited.page()
    text, fix = page.locator("#text"), page.locator("#diagnostics .fix")
    write(page, "ada $ repeat (forwrd || le")
    offer = page.locator("#completions li")
    expect(offer).to_have_text(["left A quarter turn to the left."])
    page.keyboard.press("Home")
    expect(page.locator("#completions")).to_be_hidden()
    page.keyboard.press("End")
    page.keyboard.press("Control+Space")
    expect(page.locator("#completions")).to_be_visible()
    page.keyboard.press("Tab")
    page.keyboard.press("ArrowLeft")
    page.keyboard.press("ArrowLeft")
    page.keyboard.press("Backspace")
    expect(page.locator("#completions")).to_be_visible()
    page.keyboard.press("Tab")  # the end of the word is there already
    write(page, ")\nbo $ left\n")  # Enter is a new line, also while words are offered
    expect(page.locator("#highlight .error")).to_have_text(["forwrd"])
    expect(fix).to_have_text(["Change to forward"])
    pressed = fix.element_handle()
    keep(page, "edit-mistake.png")
    page.keyboard.press("Control+Enter")
    expect(page.get_by_role("alert").first).to_contain_text("dance.improv can't play")
    assert edited.wait("unknown-name")
    page.locator("#highlight .function").first.hover(force=True)
    expect(page.get_by_role("tooltip")).to_be_visible()  # so the page has analyzed the saved text
    assert pressed.evaluate("button => button.isConnected")  # a button that is being pressed is not replaced
    fix.click()
    whole = "# 🤖🤖\nbeat 60\nada $ repeat (forward || left)\nbo $ left\n"
    expect(text).to_have_value(whole)
    cursor = text.evaluate("text => text.value.slice(text.selectionStart)")
    assert cursor.startswith(" || left")  # behind the word, not in it
    for gone in ("#diagnostics", "#problems", "#completions"):
        expect(page.locator(gone)).to_be_hidden()
    page.keyboard.press("Control+z")
    expect(text).to_have_value(whole.replace("forward", "forwrd"))
    page.keyboard.press("Control+Shift+z")
    page.get_by_role("button", name="Play", exact=True).click()
    wait(page, f"{PLAYING} && {IDLE} && improv.robots.ada?.x > 0")
    assert edited.file.read_bytes() == f"\ufeff{whole}".replace("\n", "\r\n").encode()
    lit = page.locator("#highlight .lit")
    expect(lit).to_contain_text(["forward"])
    write(page, "# more")  # the words that play stay lit at their current places
    expect(page.locator("#highlight .comment").last).to_have_text("# more")
    expect(lit).to_contain_text(["forward"])
    page.locator("#highlight .function").first.hover(force=True)
    expect(page.get_by_role("tooltip")).to_contain_text("forward: One step forward.")
    expect(page.locator("#tooltip img")).to_be_visible()
    keep(page, "edit-playing.png")
    page.locator("#text").focus()
    page.keyboard.press("Escape")
    expect(page.get_by_role("tooltip")).to_be_hidden()
    expect(page.locator("#state")).to_have_text("stopped")


@pytest.mark.slow("opens three pages")
def test_unsaved_text_and_settings_are_there_after_a_reload_and_on_a_new_page(edit: Callable[[str], Edit]) -> None:
    edited = edit(SQUARE)
    page = edited.page()
    write(page, "bo $ ")
    session = page.context.new_cdp_session(page)
    session.send("Input.imeSetComposition", {"text": "かめ", "selectionStart": 2, "selectionEnd": 2})
    page.keyboard.press("Escape")  # belongs to the input method
    session.send("Input.imeSetComposition", {"text": "かめ", "selectionStart": 2, "selectionEnd": 2})
    session.send("Input.insertText", {"text": "亀 🐢"})
    mine = f"{SQUARE}bo $ 亀 🐢"
    text = page.locator("#text")
    expect(text).to_have_value(mine)
    expect(page.locator("#highlight .error").first).to_be_visible()
    assert page.evaluate(ALIGNED) == [True, True, 0]

    margin, numbers = "text => parseFloat(getComputedStyle(text).paddingLeft)", page.locator("#highlight div").nth(1)
    number = "line => getComputedStyle(line, '::before').content"
    wide = text.evaluate(margin)
    assert numbers.evaluate(number) == '"2"'
    page.get_by_role("button", name="Help").click()
    page.get_by_role("button", name="Line numbers").click()
    assert text.evaluate(margin) < wide
    assert numbers.evaluate(number) == "none"

    page.reload()
    expect(text).to_have_value(mine)
    expect(page.locator("#file-state")).to_have_text("not saved yet")
    assert text.evaluate(margin) < wide
    page.close()
    page = edited.page()  # a new tab offers what another one had
    expect(page.locator("#text")).to_have_value(SQUARE)
    page.get_by_role("button", name="Show it instead").click()
    expect(page.locator("#text")).to_have_value(mine)
    page.get_by_role("button", name="Show it instead").click()
    page.get_by_role("button", name="Forget it").click()
    expect(page.locator("#versions")).to_be_hidden()
    assert page.evaluate("Object.keys(localStorage).filter(key => key.includes('draft'))") == []
    assert edited.file.read_text() == SQUARE


def test_a_stop_also_stops_a_save_that_is_about_to_play(edit: Callable[[str], Edit]) -> None:
    show = edit(SQUARE)
    page = show.page()
    # All at once: the second save waits for the answer to the first one.
    page.evaluate("""() => {
      window.sent = []
      const send = WebSocket.prototype.send
      WebSocket.prototype.send = function (text) {
        window.sent.push(JSON.parse(text).type)
        send.call(this, text)
      }
      const press = (key, ctrlKey) => dispatchEvent(new KeyboardEvent("keydown", { key, ctrlKey }))
      press("Enter", true)
      press("Enter", true)
      press("Escape", false)
    }""")
    wait(page, IDLE)
    assert page.evaluate("window.sent.filter(type => ['write', 'press'].includes(type))") == ["write", "press"]
    page.keyboard.press("Control+Enter")
    wait(page, PLAYING)


@pytest.mark.slow("writes on two pages at once")
def test_two_pages_and_another_program_change_one_file_and_no_version_is_lost(
    edit: Callable[[str], Edit], keep: Keep
) -> None:
    edited = edit(SQUARE)
    one, two = edited.page(), edited.page()
    write(one, "# one\n")
    one.keyboard.press("Control+s")
    wait(one, f"{IDLE} && {PLAYING}")
    expect(two.locator("#text")).to_have_value(f"{SQUARE}# one\n")  # it had nothing of its own
    write(one, "# mine\n")
    write(two, "")
    two.keyboard.press("Control+Space")
    expect(two.locator("#completions")).to_be_visible()
    edited.file.write_text(f"{SQUARE}# theirs\n")
    expect(two.locator("#text")).to_have_value(f"{SQUARE}# theirs\n")
    expect(two.locator("#completions")).to_be_hidden()  # they were about another text
    versions = one.locator("#versions")
    expect(versions).to_contain_text("dance.improv was changed in another tab or program")
    keep(one, "edit-versions.png")
    one.keyboard.press("Control+Enter")  # asks first
    expect(one.get_by_role("button", name="Use the version on disk")).to_be_focused()
    assert edited.file.read_text() == f"{SQUARE}# theirs\n"
    one.reload()
    expect(versions).to_contain_text("dance.improv was changed in another tab or program")
    one.get_by_role("button", name="Keep mine").click()
    expect(one.get_by_role("button", name="Keep mine")).to_be_hidden()
    expect(versions).to_contain_text("Another text, from")
    expect(one.locator("#text")).to_have_value(f"{SQUARE}# one\n# mine\n")
    one.get_by_role("button", name="Save and play").click()
    wait(one, IDLE)
    assert edited.file.read_text() == f"{SQUARE}# one\n# mine\n"
    one.get_by_role("button", name="Show it instead").click()
    expect(one.locator("#text")).to_have_value(f"{SQUARE}# theirs\n")
    one.keyboard.press("Control+z")
    expect(one.locator("#text")).to_have_value(f"{SQUARE}# one\n# mine\n")
    one.get_by_role("button", name="Show it instead").click()  # it can still be opened
    expect(one.locator("#text")).to_have_value(f"{SQUARE}# theirs\n")
    keep(one, "edit-kept.png")
    expect(two.locator("#text")).to_have_value(f"{SQUARE}# one\n# mine\n")
    write(two, "# two\n")
    one.keyboard.press("Control+Enter")
    expect(two.locator("#versions")).to_be_visible()
    two.get_by_role("button", name="Use the version on disk").click()
    expect(two.locator("#text")).to_have_value(f"{SQUARE}# theirs\n")
    two.keyboard.press("Control+z")
    expect(two.locator("#text")).to_have_value(f"{SQUARE}# one\n# mine\n# two\n")


@pytest.mark.slow("writes in a program of a thousand lines")
def test_a_thousand_lines_are_colored_and_the_cursor_stays_in_view(edit: Callable[[str], Edit], keep: Keep) -> None:
    long = "# a line that is so long that it does not fit beside the stage and has to be broken\n"
    edited = edit("".join(f"{long}r{i} $ repeat 2 (forward || left) # 🤖\n\n" for i in range(334)))
    page = edited.page()
    write(page, "last $ left")
    wait(page, "[...document.querySelectorAll('#highlight div')].at(-1).querySelector('.function')")
    assert page.locator("#highlight div").count() == 1003
    assert page.evaluate(ALIGNED) == [True, True, 0]
    shown = """() => {
      const [paper, last] = [document.querySelector("#paper"), [...document.querySelectorAll("#highlight div")].at(-1)]
        .map(each => each.getBoundingClientRect())
      return last.top >= paper.top && last.bottom <= paper.bottom
    }"""
    assert page.evaluate(shown)
    keep(page, "edit-long.png")
    last = page.locator("#highlight div").last.element_handle()
    page.keyboard.press("Home")
    page.evaluate(COUNT_REQUESTS)
    page.keyboard.type("\n(")
    page.wait_for_function("last => last.dataset.number === '1004'", arg=last)  # the same line, with another number
    page.keyboard.press("Backspace")
    page.keyboard.press("Backspace")
    write(page, "x")
    expect(page.locator("#diagnostics .fix")).to_be_visible()  # which leaves less room for the text
    wait(page, "asked.includes('complete')")
    assert page.evaluate("asked.filter(type => type === 'complete').length") == 1  # words are offered for letters
    wait(page, f"({shown})()")
    for line in (1, 802, 400):  # lines go from one part to another as they come into view
        shown_line = page.locator("#highlight div").nth(line)
        shown_line.scroll_into_view_if_needed()
        expect(shown_line.locator(".keyword")).to_have_text("repeat")
        expect(shown_line).to_be_in_viewport()
        assert page.evaluate(ALIGNED) == [True, True, 0]
    page.locator("#text").evaluate("text => text.setSelectionRange(99, text.value.length / 2)")
    page.keyboard.press("Delete")
    wait(page, "document.querySelectorAll('#highlight div').length < 600")
    assert page.evaluate(ALIGNED) == [True, True, 0]
    assert page.locator("#text").get_attribute("maxlength") == str(LONGEST_TEXT)


@pytest.mark.slow("axe looks at four pages")
def test_the_editor_has_room_and_axe_finds_nothing(
    violations: Violations, edit: Callable[[str], Edit], keep: Keep
) -> None:
    edited = edit(f"# a dance\n{SQUARE}bo $ repeat 2 (forwrd || near)\nstep = left\n")
    page = edited.page()
    for scheme, (width, height) in product(SCHEMES, ((390, 844), (1920, 1080))):
        page.emulate_media(color_scheme=scheme)
        page.set_viewport_size({"width": width, "height": height})
        write(page, "b")
        expect(page.locator("#completions li").first).to_be_visible()
        expect(page.locator("#diagnostics .quick").first).to_be_visible()
        for name in ("Stop", "Play", "Save and play"):
            expect(page.get_by_role("button", name=name, exact=name != "Stop")).to_be_in_viewport(ratio=1)
        assert page.evaluate("document.documentElement.scrollWidth <= innerWidth")
        assert violations(page) == [], f"{width}, {scheme}"
        keep(page, f"edit-{width}-{scheme}.png")
        page.keyboard.press("Backspace")
    page.set_viewport_size({"width": 390, "height": 500})  # a phone's keyboard is open
    for name in ("Stop", "Save and play"):
        expect(page.get_by_role("button", name=name)).to_be_in_viewport(ratio=1)
    expect(page.locator("#controls")).to_be_hidden()
    keep(page, "edit-phone-keyboard.png")


@pytest.mark.slow("drags a ring, types, and plays")
def test_a_ring_that_is_dragged_changes_its_line_in_one_step(edit: Callable[[str], Edit], keep: Keep) -> None:
    before = "beat 6\nada bo cleo at line 2\nada bo cleo $ repeat 4 (forward left)\n"
    edited = edit(before)
    page = edited.page()
    text = page.locator("#text")
    page.get_by_role("button", name="Save and play").click()
    wait(page, PLAYING)
    page.get_by_role("button", name="Stop").click()
    wait(page, "improv.transport.state === 'stopped'")
    page.get_by_role("button", name="Starts").click()
    dialog = page.get_by_role("dialog", name="Starts")
    card = box(page, "#start-poses")
    wait(page, f"improv.toScreen(0, 0).x > {card['x'] + card['width'] + 16}")  # the rings are beside it
    page.mouse.move(*at(page, 0, -2))
    page.mouse.down()
    page.mouse.move(*at(page, 2, 1), steps=4)
    page.mouse.up()
    dragged = before.replace("ada bo cleo at line 2", "ada bo at line 2 around 0 1\ncleo at 2 1")
    expect(text).to_have_value(dragged)
    keep(page, "edit-starts.png")
    text.press("Control+z")
    expect(text).to_have_value(before)  # one step
    text.press("Control+y")
    expect(dialog.get_by_label("x", exact=True).last).to_have_value("2")  # the server has read it again

    dialog.get_by_label("heading", exact=True).last.fill("90")
    page.get_by_role("button", name="Play", exact=True).click()  # at once: the typed text is written, then saved
    expect(text).to_have_value(dragged.replace("cleo at 2 1", "cleo at 2 1 facing 90"))
    wait(page, f"{PLAYING} && improv.transport.generation === 2 && improv.robots.cleo.x > 1.99")
    assert edited.file.read_text(encoding="utf-8") == text.input_value()

    x = dialog.get_by_label("x", exact=True).first
    kept = x.input_value()
    x.press("Control+a")
    x.press_sequentially("1e9")
    x.press("Enter")
    assert x.input_value() == "1e9"  # the browser shows what is wrong
    assert x.evaluate("field => field.validity.rangeOverflow")
    dialog.get_by_role("button", name="Close").click()
    page.get_by_role("button", name="Starts").click()
    expect(x).to_have_value(kept)  # not 1

    dialog.get_by_text("Formation", exact=True).click()
    dialog.get_by_label("Distance in meters").fill("4")
    dialog.get_by_role("button", name="Circle, out").click()
    expect(text).to_have_value(before.replace("line 2", "circle 2.309 facing out"))
    broken = before.replace("line 2", "x")
    text.fill(broken)
    dialog.get_by_label("x", exact=True).first.fill("3")
    expect(dialog.get_by_role("alert")).to_have_text("a line with `at` has an error: fix it first")
    expect(text).to_have_value(broken)


def test_messages_are_rows_and_all_of_a_kind_are_fixed_at_once(edit: Callable[[str], Edit], keep: Keep) -> None:
    program = "".join(f"r{number} $ forwrd left\n" for number in range(45))
    page = edit(program).page()
    rows = page.locator("#diagnostics-list li")
    expect(rows).to_have_count(45)
    expect(page.get_by_role("heading", name="45 messages")).to_be_visible()
    page.set_viewport_size({"width": 390, "height": 844})
    assert box(page, "#hall")["height"] > 0.3 * 844
    assert box(page, "#diagnostics")["height"] < 0.33 * 844
    keep(page, "edit-messages.png")
    rows.first.locator(".where").focus()
    page.keyboard.press("ArrowDown")
    expect(rows.nth(1).locator(".where")).to_be_focused()
    page.get_by_role("button", name="Change to forward: all 45").click()
    expect(page.locator("#diagnostics")).to_be_hidden()
    expect(page.locator("#text")).to_have_value(program.replace("forwrd", "forward"))
    page.keyboard.press("Control+z")
    expect(rows).to_have_count(45)  # one step back


COLOR = """index => {
  const style = getComputedStyle(document.documentElement)
  const read = name => style.getPropertyValue(name).trim()
  const [from, to] = [read("--ground"), read("--robots").split(/\\s+/)[index]].map(color =>
    [1, 3, 5].map(i => parseInt(color.slice(i, i + 2), 16)))
  return from.map((value, i) => Math.round(value + (to[i] - value) * 0.85))
}"""
"""The color in which the path of the robot with this index is previewed."""


@pytest.mark.slow("looks at every pixel of a page, again and again")
def test_the_path_of_a_text_is_shown_before_it_is_saved_and_can_be_hidden(edit: Callable[[str], Edit]) -> None:
    page = edit("beat 60\nada $ forward\n").page()
    preview = page.get_by_role("button", name="Preview")
    ada, bo = (f"({COUNT})(({COLOR})({index}))" for index in range(2))
    wait(page, f"{ada} > 30 && {bo} === 0 && 'ada' in improv.drawn")
    write(page, "bo at 0 1\nbo $ repeat 4 (forward left)\n")
    wait(page, f"{ada} > 30 && {bo} > 30")
    write(page, "bo $ lft\n")
    expect(preview).to_have_text("Preview: `lft` in line 5 is not defined")
    wait(page, f"{ada} > 30 && {bo} === 0")
    preview.click()
    expect(preview).to_have_text("Preview")
    wait(page, f"{ada} === 0 && !('ada' in improv.drawn)")
    page.reload()
    expect(preview).to_have_attribute("aria-pressed", "false")
    preview.click()
    wait(page, f"{ada} > 30")


@pytest.mark.slow("plays on a page twice")
def test_a_dance_fills_the_view_again_after_the_preview_of_a_larger_one(edit: Callable[[str], Edit]) -> None:
    dance = "ada $ repeat 3 (forward left)\n"  # shorter than unused room is kept
    page = edit(dance).page()
    page.locator("#write").click()
    wait(page, f"{PLAYING} && improv.robots.ada?.x > 0")
    page.locator("#stop").click()
    near = page.evaluate("improv.view.scale")
    page.locator("#text").fill("ada $ repeat 40 forward\n")
    wait(page, f"improv.view.scale < {near / 4}")
    page.locator("#text").fill(dance)
    page.locator("#write").click()
    wait(page, f"{PLAYING} && improv.view.scale > {near / 2} || improv.transport.state === 'ended'")
    assert page.evaluate(PLAYING)


@pytest.mark.slow("looks at every pixel of a page, again and again")
def test_the_path_of_the_text_in_an_editor_is_shown_until_it_is_taken_back(
    still: Callable[..., Page], viewer: PageServer, keep: Keep
) -> None:
    page, bo = still("ada $ forward\n"), f"({COUNT})(({COLOR})(1))"
    expect(page.locator("#preview")).to_be_hidden()
    text = "ada $ forward left lft\nbo at 0 1\nbo $ repeat 4 (forward left)\n"
    (paths,) = previews(text.replace("lft", "forward"))
    viewer.publish({"type": "draft", "text": text, "paths": {**paths, "problem": "line 1"}})
    expect(page.get_by_role("button", name="Preview: line 1")).to_be_visible()
    wait(page, f"{bo} > 30")
    keep(page, "draft.png")
    viewer.publish(NO_DRAFT)
    wait(page, f"{bo} === 0")
    expect(page.locator("#preview")).to_be_hidden()
