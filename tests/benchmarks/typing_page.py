"""Keys on a page with a slow processor, from each to its letter and to its color; words, from each to the paths of the
text; and the price of a page at rest."""

from __future__ import annotations

import subprocess
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from statistics import median, quantiles
from tempfile import TemporaryDirectory

from playwright.sync_api import Browser, CDPSession, Page

from tests.benchmarks.chromium import chromium
from tests.benchmarks.documents import improv
from tests.benchmarks.tables import machine, print_head, print_row
from tests.commands.command_line import IMPROV, SIMULATED
from tests.page.conftest import wait

SLOWER = 4
"""The factor by which the processor of the browser is slowed."""
PERIOD = 0.12
"""Seconds from a key to the next: a fast typist."""
WRITTEN = " swing = repeat 4 (forward left) halfright"
PAINTED, COLORED = 50, 100
"""Milliseconds within which 95 % of keys are to be painted and colored."""
PREVIEWED = 100
"""Milliseconds within which the paths are painted after 95 % of words, each with a pause behind it."""
PAUSE = 0.5
"""Seconds of such a pause."""
FOUR = "4 robots, 300 lines"
AT_REST = 0.02
"""Seconds of a processor a second that a page may take while nothing moves."""
PROGRAMS = {
    "1 robot, 10 lines": "beat 30\n" + "# A line\n" * 8 + "ada $ repeat (forward left)\n",
    "12 robots, 300 lines": improv(296) + "".join(f"r{robot} $ repeat (forward left)\n" for robot in range(4)),
}

PREVIEW_PROGRAMS = {
    FOUR: "".join(f"r{line % 4} $ repeat 2 (forward left) scale 1/2 right ease forward\n" for line in range(300)),
    "1 robot, 10 lines": PROGRAMS["1 robot, 10 lines"],
}

# Notes the milliseconds from each change of the text until its paths are painted.
LISTEN_TO_PREVIEWS = """(() => {
  window.previews = []
  const edited = {}
  let latest = 0
  const send = WebSocket.prototype.send
  WebSocket.prototype.send = function (data) {
    const message = JSON.parse(data)
    if (message.type === "analyze") edited[message.number] = latest
    return send.call(this, data)
  }
  addEventListener("input", () => (latest = performance.now()), true)
  const { set } = Object.getOwnPropertyDescriptor(WebSocket.prototype, "onmessage")
  Object.defineProperty(WebSocket.prototype, "onmessage", { set(take) {
    set.call(this, (event) => {
      const message = JSON.parse(event.data)
      const before = message.type === "preview" && improv.previewed
      take(event)
      if (message.type !== "preview" || !edited[message.number]) return
      const note = () => previews.push(performance.now() - edited[message.number])
      const look = () => improv.previewed === before ? requestAnimationFrame(look) : note()
      look()
    })
  } })
})()"""

# Notes when each key, by the length of the text after it, was pressed, painted, and colored: with the letter, unless
# the answer changes a color. It reads no other message, and asks for no frame that the page doesn't need.
LISTEN = """(() => {
  const seen = window.seen = { pressed: {}, painted: {}, colored: {} }
  const texts = {}
  const text = () => document.querySelector("#text").value
  const send = WebSocket.prototype.send
  WebSocket.prototype.send = function (data) {
    if (data.startsWith('{"type":"analyze"')) texts[/\\d+/.exec(data)] = text()
    return send.call(this, data)
  }
  const changes = new MutationObserver(() => {})
  addEventListener("DOMContentLoaded", () =>
    changes.observe(document.querySelector("#highlight"), { subtree: true, childList: true, characterData: true }))
  const { set } = Object.getOwnPropertyDescriptor(WebSocket.prototype, "onmessage")
  Object.defineProperty(WebSocket.prototype, "onmessage", { set(take) {
    set.call(this, (event) => {
      take(event)
      if (!event.data.startsWith('{"type": "analyze"')) return
      const about = texts[/\\d+/.exec(event.data)]
      if (about !== text()) return
      const { length } = about
      const note = (now) => (seen.colored[length] ??= now)
      if (changes.takeRecords().length || !seen.painted[length]) afterPaint(note)
      else note(seen.painted[length])
    })
  } })
  let pressed = 0
  const afterPaint = (note) => requestAnimationFrame(() => {
    const { port1, port2 } = new MessageChannel()
    port1.onmessage = () => note(performance.now())
    port2.postMessage(null)
  })
  addEventListener("keydown", (event) => (pressed = event.timeStamp), true)
  addEventListener("input", ({ target }) => {
    const { length } = target.value
    seen.pressed[length] = pressed
    afterPaint((now) => (seen.painted[length] ??= now))
  }, true)
})()"""


# Resolves once the camera has not moved for half a second.
REST = """(async () => {
  let before = null
  while (before !== (before = JSON.stringify(improv.view))) await new Promise((end) => setTimeout(end, 500))
})()"""


@dataclass(frozen=True, slots=True)
class Typed:
    """Milliseconds from keys to letters and to colors, and the browser's processor milliseconds for each key."""

    painted: list[float]
    colored: list[float]
    work: float


def run(quick: bool) -> None:
    """Measure and print; `quick` types less, and rests less."""
    rounds, rest = (1, 5) if quick else (4, 30)
    print(machine())
    print(f"\nTyping on the page, {1 / PERIOD:.0f} keys a second, headless Chromium {SLOWER} times slower, ms\n")
    print_head("program", "goal", "painted, p50", "p95", "max", "goal", "colored, p50", "p95", "max", "work, each key")
    with TemporaryDirectory() as folder, chromium() as browser:
        for name, program in PROGRAMS.items():
            with opened(browser, Path(folder), program) as (page, tool):
                for how in ("stands", "plays"):
                    if how == "plays":
                        page.keyboard.press("Control+Enter")
                        wait(page, "improv.transport.state === 'playing'")
                    typed = _type(page, tool, rounds)
                    cells = (*_cells(PAINTED, typed.painted), *_cells(COLORED, typed.colored))
                    print_row(f"{name}, {how}", *cells, f"{typed.work:.0f}")
        print(f"\nFrom a word, with a pause of {PAUSE} s behind it, to the painted paths of the text, ms\n")
        print_head("program", "goal", "p50", "p95", "max")
        for name, program in PREVIEW_PROGRAMS.items():
            with opened(browser, Path(folder), program, LISTEN_TO_PREVIEWS, 1) as (page, _):
                for how in ("stands", "plays"):
                    if how == "plays":
                        page.keyboard.press("Control+Enter")
                        wait(page, "improv.transport.state === 'playing'")
                    print_row(f"{name}, {how}", *_cells(PREVIEWED, _previews(page, 20 * rounds)))
        print("\nProcessor seconds a second of the page's main thread\n")
        print_head("page", "goal", "seconds")
        for name, program in PROGRAMS.items():
            with opened(browser, Path(folder), program) as (page, tool):
                tool.send("Emulation.setCPUThrottlingRate", {"rate": 1})
                print_row(f"{name}, opened", f"{AT_REST:.2f}", f"{_busy(page, tool, rest):.3f}")
                page.keyboard.press("Control+Enter")
                wait(page, "improv.transport.state === 'playing'")
                page.keyboard.press("Escape")
                wait(page, "improv.transport.state === 'stopped'")
                print_row(f"{name}, stopped", f"{AT_REST:.2f}", f"{_busy(page, tool, rest):.3f}")


@contextmanager
def opened(
    browser: Browser, folder: Path, program: str, listen: str = LISTEN, slower: int = SLOWER
) -> Iterator[tuple[Page, CDPSession]]:
    """Open a program with `improv edit` and a page with a slow processor, which yields its cursor and its metrics."""
    file = folder / "dance.improv"
    file.write_text(program, encoding="utf-8")
    with edited(file) as url:
        page = browser.new_page(viewport={"width": 1280, "height": 800})
        page.add_init_script(listen)
        page.goto(url)
        wait(page, "window.improv?.connected && document.querySelector('#highlight .keyword')")
        tool = page.context.new_cdp_session(page)
        tool.send("Performance.enable", {"timeDomain": "threadTicks"})  # otherwise, others' load counts, too
        tool.send("Emulation.setCPUThrottlingRate", {"rate": slower})
        page.locator("#text").focus()
        yield page, tool
        page.close()


@contextmanager
def edited(file: Path) -> Iterator[str]:
    """Run `improv edit`, and yield the address of its page."""
    with subprocess.Popen([*IMPROV, "edit", str(file), *SIMULATED], stdout=subprocess.PIPE, text=True) as process:
        assert process.stdout
        try:
            yield next(line for line in process.stdout if "watch it at" in line).split()[-1]
        finally:
            process.terminate()


def _type(page: Page, tool: CDPSession, rounds: int) -> Typed:
    page.evaluate("seen.pressed = {}, seen.painted = {}, seen.colored = {}")
    page.locator("#text").evaluate(
        "text => { const at = text.value.indexOf('\\n', text.value.length / 2); text.setSelectionRange(at, at) }"
    )
    before = _work(tool)
    for _ in range(rounds):
        page.keyboard.press("Enter")
        for key in WRITTEN:
            began = time.monotonic()
            page.keyboard.press(key)
            time.sleep(max(0, began + PERIOD - time.monotonic()))
    keys = rounds * (1 + len(WRITTEN))
    work = (_work(tool) - before) * 1000 / keys
    wait(page, "Math.max(...Object.keys(window.seen.colored)) === document.querySelector('#text').value.length")
    seen = page.evaluate("seen")
    return Typed(_times(seen, "painted"), _times(seen, "colored"), work)


def _previews(page: Page, words: int) -> list[float]:
    """Write words into the last line but one, and return the milliseconds until the paths were painted."""
    page.evaluate("previews.length = 0")
    page.keyboard.press("Control+End")
    page.keyboard.press("ArrowLeft")
    for word in range(words):
        page.keyboard.insert_text((" left", " forward", " right")[word % 3])
        wait(page, f"previews.length > {word}")
        time.sleep(PAUSE)
    return [float(each) for each in page.evaluate("previews")]


def _times(seen: dict[str, dict[str, float]], kind: str) -> list[float]:
    """Return the milliseconds of each key until a text at least as long as the one after it was shown."""
    shown = [(int(length), at) for length, at in seen[kind].items()]
    pressed = [(int(length), at) for length, at in seen["pressed"].items()]
    return [min(at for reached, at in shown if reached >= length) - begun for length, begun in pressed]


def _cells(goal: int, times: list[float]) -> tuple[str, ...]:
    return str(goal), f"{median(times):.0f}", f"{quantiles(times, n=20)[-1]:.0f}", f"{max(times):.0f}"


def _work(tool: CDPSession) -> float:
    metrics = tool.send("Performance.getMetrics")["metrics"]
    return float(next(each["value"] for each in metrics if each["name"] == "TaskDuration"))


def _busy(page: Page, tool: CDPSession, seconds: float) -> float:
    page.evaluate(REST)
    before, began = _work(tool), time.monotonic()
    time.sleep(seconds)
    return (_work(tool) - before) / (time.monotonic() - began)
