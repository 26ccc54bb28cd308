"""How fast a program is written on the page: from nothing to its first key, and from Ctrl+Enter to motion."""

from __future__ import annotations

import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from statistics import median
from subprocess import PIPE, Popen
from tempfile import TemporaryDirectory

from playwright.sync_api import Browser, Page

from tests.benchmarks.chromium import chromium
from tests.benchmarks.page import GAPS, ROBOTS, SETTLE, SIZE, dance
from tests.benchmarks.tables import machine, p99, print_head, print_row
from tests.commands.command_line import IMPROV
from tests.stage.viewer.conftest import wait

START_GOAL, MOTION_GOAL = 2000.0, 300.0
"""Milliseconds."""
SOLO = "beat 60\nada $ repeat forward\n"
STARTED_OVER = "improv.robots.ada?.x > 0.0005 && improv.robots.ada.x < 0.5"
"""The robot is on its way again: a round ends when it is 1 m from its start."""

# Milliseconds from the next Ctrl+Enter to the first frame that shows the robot on its way.
_WATCH = f"""() => {{
  window.took = new Promise(done => addEventListener("keydown", ({{ key }}) => {{
    const began = performance.now()
    const look = () => {STARTED_OVER} ? done(performance.now() - began) : requestAnimationFrame(look)
    if (key === "Enter") look()
  }}, {{ capture: true }}))
}}"""
# Milliseconds from a key to the first frame in which its letter has a color.
_TYPE = """() => {
  window.took = new Promise(done => {
    const text = document.getElementById("text")
    text.focus()
    text.setSelectionRange(text.value.length, text.value.length)
    addEventListener("keydown", () => {
      const began = performance.now()
      const look = () => {
        const [last] = [...document.querySelectorAll("#ink .comment")].slice(-1)
        last?.textContent === "#" ? done(performance.now() - began) : requestAnimationFrame(look)
      }
      requestAnimationFrame(look)
    }, { capture: true, once: true })
  })
}"""


def run(quick: bool) -> None:
    """Measure and print; `quick` takes fewer rounds."""
    rounds = 5 if quick else 20
    print(machine())
    print(f"\nWriting on the page in headless Chromium, {rounds} rounds (median, p99, max)\n")
    print_head("what", "ms", "goal, ms", "")
    with chromium() as browser:
        _print("from `improv edit` to a page that takes keys", [_start(browser) for _ in range(rounds)], START_GOAL)
        with _editing(browser, SOLO) as page:
            _print("from Ctrl+Enter to motion", [_play(page) for _ in range(rounds)], MOTION_GOAL)
        with _editing(browser, "".join(f"r{i} $ repeat 2 (forward || left)\n" for i in range(1000))) as page:
            _print("from a key to its color, 1,000 lines", [_type(page) for _ in range(rounds)], None)
        with _editing(browser, dance(ROBOTS)) as page:
            page.keyboard.press("Control+Enter")
            time.sleep(SETTLE)
            gaps: list[float] = page.evaluate(GAPS, 5 if quick else 30)
            frames = 1000 * len(gaps) / sum(gaps)
            print_row(
                f"frames a second, {ROBOTS} robots", f"{frames:.1f}", "60", "met" if frames >= 59.5 else "not met"
            )


def _print(what: str, took: list[float], goal: float | None) -> None:
    verdict = "" if goal is None else "met" if median(took) <= goal else "not met"
    values = f"{median(took):.0f}, {p99(took):.0f}, {max(took):.0f}"
    print_row(what, values, f"{goal:.0f}" if goal else "", verdict)


def _start(browser: Browser) -> float:
    began = time.monotonic()
    with _editing(browser, SOLO) as page:
        page.locator("#text").press("a")
        wait(page, "document.getElementById('text').value.includes('a')")
        return 1000 * (time.monotonic() - began)


def _play(page: Page) -> float:
    page.evaluate(_WATCH)
    page.keyboard.press("Control+End")
    page.keyboard.type("#")
    page.keyboard.press("Control+Enter")
    took: float = page.evaluate("took")
    wait(page, "improv.robots.ada.x > 1")
    return took


def _type(page: Page) -> float:
    page.evaluate(_TYPE)
    page.keyboard.press("#")
    took: float = page.evaluate("took")
    page.keyboard.press("Backspace")
    wait(page, "![...document.querySelectorAll('#ink .comment')].length")
    return took


@contextmanager
def _editing(browser: Browser, program: str) -> Iterator[Page]:
    """A page on which a program can be written; the browser runs already."""
    with TemporaryDirectory() as folder:
        file = Path(folder, "dance.improv")
        file.write_text(program, encoding="utf-8")
        command = [*IMPROV, "edit", str(file), "--backend", "sim", "--no-browser"]
        with Popen(command, stdout=PIPE, text=True) as process:
            assert process.stdout
            url = next(line for line in process.stdout if "watch it at" in line).split()[-1]
            page = browser.new_page(viewport={"width": SIZE[0], "height": SIZE[1]})
            page.goto(url)
            wait(page, "document.getElementById('text')?.value && document.querySelector('#ink .class')")
            page.locator("#text").focus()
            yield page
            page.close()
            process.terminate()
