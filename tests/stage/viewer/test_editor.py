"""`improv edit` in a real browser: a program is written on the page, and nobody's text is lost."""

from __future__ import annotations

import queue
import subprocess
import threading
from collections.abc import Callable, Iterator
from itertools import product
from pathlib import Path
from typing import Any, Literal

import pytest
from playwright.sync_api import Browser, Page, expect

from improv_core.stage.protocol import LONGEST_TEXT
from improv_core.stage.tickets import issue
from tests.commands.command_line import IMPROV, LIMIT
from tests.needs import lacking
from tests.page import token_behind
from tests.stage.viewer.conftest import Show, wait, watch
from tests.stage.viewer.test_looks import AXE

SQUARE = "beat 60\nada $ repeat 4 (forward left)\n"
IDLE = "document.querySelector('#file-state').textContent === 'saved'"
PLAYING = "improv.transport.state === 'playing'"

# Whether the colored text lies exactly below the text that is written.
ALIGNED = """() => {
  const [ink, text] = ["ink", "text"].map(id => document.getElementById(id))
  const shown = [...ink.children].map(line => line.textContent).join("\\n")
  text.style.height = "0"
  const height = text.scrollHeight
  text.style.height = ""
  const same = ink.getBoundingClientRect().width === text.getBoundingClientRect().width
  const end = ink.lastElementChild.getBoundingClientRect().bottom + parseFloat(getComputedStyle(ink).paddingBottom)
  return [shown === text.value, same, Math.round(end - ink.getBoundingClientRect().top) - height]
}"""


class Edit:
    """`improv edit` on one file, and pages of it in one browser."""

    def __init__(self, file: Path, browser: Browser) -> None:
        self.file = file
        command = [*IMPROV, "edit", str(file), "--backend", "sim", "--no-browser"]
        self._process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
        self._lines: queue.SimpleQueue[str] = queue.SimpleQueue()
        threading.Thread(target=self._read, daemon=True).start()
        url = self.wait("watch it at").split()[-1]
        self._token, self._address = token_behind(url), url.partition("?")[0]
        self._context = browser.new_context(viewport={"width": 1280, "height": 800})
        self._wrong: list[str] = []

    def page(self) -> Page:
        """Another page of the program."""
        page = self._context.new_page()
        page.set_default_timeout(LIMIT * 1000)
        page.on("console", lambda message: self._wrong.append(message.text) if message.type == "error" else None)
        page.on("pageerror", lambda error: self._wrong.append(f"{error} {error.stack}"))
        page.goto(f"{self._address}?ticket={issue(self._token)}")
        wait(page, f"window.improv?.connected && {IDLE}")
        return page

    def wait(self, part: str) -> str:
        """The next line in the terminal with `part` in it."""
        while part not in (line := self._lines.get(timeout=LIMIT)):
            pass
        return line

    def close(self) -> None:
        self._context.close()
        self._process.terminate()
        assert self._process.wait(LIMIT) == 130
        assert self._wrong == []

    def _read(self) -> None:
        assert self._process.stdout
        for line in self._process.stdout:
            self._lines.put(line)


@pytest.fixture(autouse=True)
def patience() -> Iterator[None]:
    expect.set_options(timeout=LIMIT * 1000)
    yield
    expect.set_options(timeout=None)


@pytest.fixture
def edit(tmp_path: Path, browser: Browser) -> Iterator[Callable[[str], Edit]]:
    opened: list[Edit] = []

    def begin(program: str) -> Edit:
        file = tmp_path / "dance.improv"
        file.write_bytes(program.encode())
        opened.append(Edit(file, browser))
        return opened[-1]

    yield begin
    for each in opened:
        each.close()


def write(page: Page, keys: str) -> None:
    """Type at the end of the program."""
    page.locator("#text").focus()
    page.keyboard.press("Control+End")
    page.keyboard.type(keys)


def test_a_program_is_typed_fixed_by_a_button_and_played(edit: Callable[[str], Edit], artifacts: Path) -> None:
    edited = edit("\ufeff# 🤖🤖\r\nbeat 60\r\n")
    page = edited.page()
    text, fix = page.locator("#text"), page.locator("#mistakes .fix")
    write(page, "ada $ repeat (forwrd || le")
    offer = page.locator("#offers li")
    expect(offer).to_have_text(["left A quarter turn to the left."])
    page.keyboard.press("Tab")
    write(page, ")\nbo $ left\n")  # Enter is a new line, also while words are offered
    expect(page.locator("#ink .error")).to_have_text(["forwrd"])
    expect(fix).to_have_text(["Change to forward"])
    page.screenshot(path=artifacts / "edit-mistake.png")
    page.keyboard.press("Control+Enter")
    expect(page.get_by_role("alert").first).to_contain_text("dance.improv can't play")
    assert edited.wait("unknown-name")
    fix.click()
    whole = "# 🤖🤖\nbeat 60\nada $ repeat (forward || left)\nbo $ left\n"
    expect(text).to_have_value(whole)
    expect(page.locator("#mistakes")).to_be_hidden()
    expect(page.locator("#offers")).to_be_hidden()
    page.keyboard.press("Control+z")
    expect(text).to_have_value(whole.replace("forward", "forwrd"))
    page.keyboard.press("Control+Shift+z")
    page.get_by_role("button", name="Play", exact=True).click()
    wait(page, f"{PLAYING} && {IDLE} && improv.robots.ada?.x > 0")
    expect(page.locator("#problems")).to_be_hidden()
    assert edited.file.read_bytes() == f"\ufeff{whole}".replace("\n", "\r\n").encode()
    lit = page.locator("#ink .lit")
    expect(lit).to_contain_text(["forward"])
    write(page, "# more")  # the words that play stay lit where they are now
    expect(lit).to_contain_text(["forward"])
    page.locator("#ink .function").first.hover(force=True)
    expect(page.get_by_role("tooltip")).to_contain_text("forward: One step forward.")
    expect(page.locator("#tooltip img")).to_be_visible()
    page.screenshot(path=artifacts / "edit-playing.png")
    page.locator("#text").focus()
    page.keyboard.press("Escape")
    expect(page.get_by_role("tooltip")).to_be_hidden()
    expect(page.locator("#state")).to_have_text("stopped")


def test_unsaved_text_is_there_after_a_reload_and_on_a_new_page(edit: Callable[[str], Edit]) -> None:
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
    expect(page.locator("#ink .error").first).to_be_visible()
    assert page.evaluate(ALIGNED) == [True, True, 0]
    page.reload()
    expect(text).to_have_value(mine)
    expect(page.locator("#file-state")).to_have_text("not saved yet")
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


def test_a_stop_also_stops_what_is_to_be_saved_and_played_next(edit: Callable[[str], Edit]) -> None:
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
    assert page.evaluate("window.sent.filter(type => ['write', 'hush'].includes(type))") == ["write", "hush"]
    page.keyboard.press("Control+Enter")
    wait(page, PLAYING)


def test_two_pages_and_another_program_change_one_file_and_no_version_is_lost(
    edit: Callable[[str], Edit], artifacts: Path
) -> None:
    edited = edit(SQUARE)
    one, two = edited.page(), edited.page()
    write(one, "# one\n")
    one.keyboard.press("Control+s")
    wait(one, f"{IDLE} && {PLAYING}")
    expect(two.locator("#text")).to_have_value(f"{SQUARE}# one\n")  # it had nothing of its own
    write(one, "# mine\n")
    edited.file.write_text(f"{SQUARE}# theirs\n")
    expect(two.locator("#text")).to_have_value(f"{SQUARE}# theirs\n")
    versions = one.locator("#versions")
    expect(versions).to_contain_text("Another program has changed dance.improv")
    one.screenshot(path=artifacts / "edit-versions.png")
    one.keyboard.press("Control+Enter")  # asks first
    expect(one.get_by_role("button", name="Use the file's")).to_be_focused()
    assert edited.file.read_text() == f"{SQUARE}# theirs\n"
    one.reload()
    expect(versions).to_contain_text("Another program has changed dance.improv")
    one.get_by_role("button", name="Keep mine").click()
    expect(one.locator("#text")).to_have_value(f"{SQUARE}# one\n# mine\n")
    one.get_by_role("button", name="Save and play").click()
    wait(one, IDLE)
    assert edited.file.read_text() == f"{SQUARE}# one\n# mine\n"
    one.get_by_role("button", name="Show it instead").click()
    expect(one.locator("#text")).to_have_value(f"{SQUARE}# theirs\n")
    write(two, "# two\n")
    one.keyboard.press("Control+Enter")
    expect(two.locator("#versions")).to_be_visible()
    two.get_by_role("button", name="Use the file's").click()
    expect(two.locator("#text")).to_have_value(f"{SQUARE}# theirs\n")
    two.keyboard.press("Control+z")
    expect(two.locator("#text")).to_have_value(f"{SQUARE}# one\n# mine\n# two\n")


def test_a_thousand_lines_are_colored_and_the_cursor_stays_in_view(
    edit: Callable[[str], Edit], artifacts: Path
) -> None:
    long = "# a line that is so long that it does not fit beside the stage and has to be broken\n"
    edited = edit("".join(f"{long}r{i} $ repeat 2 (forward || left) # 🤖\n\n" for i in range(334)))
    page = edited.page()
    write(page, "last $ left")
    wait(page, "document.querySelector('#ink').lastElementChild.querySelector('.function')")
    assert page.evaluate("document.querySelector('#ink').childElementCount") == 1003
    assert page.evaluate(ALIGNED) == [True, True, 0]
    shown = """() => {
      const [paper, last] = [document.querySelector("#paper"), document.querySelector("#ink").lastElementChild]
        .map(each => each.getBoundingClientRect())
      return last.top >= paper.top && last.bottom <= paper.bottom
    }"""
    assert page.evaluate(shown)
    page.screenshot(path=artifacts / "edit-long.png")
    write(page, "x")
    expect(page.locator("#mistakes .fix")).to_be_visible()  # which leaves less room for the text
    wait(page, f"({shown})()")
    assert page.locator("#text").get_attribute("maxlength") == str(LONGEST_TEXT)


def test_the_editor_has_room_and_axe_finds_nothing(edit: Callable[[str], Edit], artifacts: Path) -> None:
    if not AXE.exists():
        lacking("axe-core is not installed: npm install --prefix .cache/axe axe-core")
    edited = edit(f"# a dance\n{SQUARE}bo $ repeat 2 (forwrd || near)\nstep = left\n")
    page = edited.page()
    page.evaluate(AXE.read_text(encoding="utf-8"))
    schemes: tuple[Literal["light", "dark"], ...] = ("light", "dark")
    for scheme, (width, height) in product(schemes, ((390, 844), (1920, 1080))):
        page.emulate_media(color_scheme=scheme)
        page.set_viewport_size({"width": width, "height": height})
        write(page, "b")
        expect(page.locator("#offers li").first).to_be_visible()
        expect(page.locator("#mistakes .fix").first).to_be_visible()
        for name in ("Stop", "Play", "Save and play"):
            expect(page.get_by_role("button", name=name, exact=name != "Stop")).to_be_in_viewport(ratio=1)
        assert page.evaluate("document.documentElement.scrollWidth <= innerWidth")
        found: list[dict[str, Any]] = page.evaluate("axe.run().then(({ violations }) => violations)")
        assert [(each["id"], [node["target"] for node in each["nodes"]]) for each in found] == []
        page.screenshot(path=artifacts / f"edit-{width}-{scheme}.png")
        page.keyboard.press("Backspace")


def test_only_improv_edit_lets_a_page_write(page: Page, show: Show) -> None:
    show.play("ada $ repeat forward\n")
    watch(page, show)
    expect(page.locator("#read-only")).to_contain_text("Read-only here")
    expect(page.locator("#text")).to_be_hidden()

    said = page.evaluate(
        """() => new Promise(done => {
          const token = encodeURIComponent(sessionStorage.getItem("improv.token"))
          const socket = new WebSocket(`ws://${location.host}/live?token=${token}`)
          const said = []
          socket.onopen = () => {
            socket.send(JSON.stringify({ type: "analyze", number: 1, text: "r $ left" }))
            socket.send(JSON.stringify({ type: "write", number: 1, text: "r $ left", revision: "" }))
            socket.send(JSON.stringify({ type: "hush" }))
          }
          socket.onmessage = ({ data }) => {
            said.push(JSON.parse(data).type)
            if (JSON.parse(data).state === "stopped") done(said)
          }
        })"""
    )
    assert not {"source", "analyzed", "written"} & set(said)
