"""The website in Chromium, over a network of 10 Mbit/s: how soon one can write and play there, typing, and frames."""

from __future__ import annotations

import functools
import gzip
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from statistics import median
from typing import Any

from playwright.sync_api import Page

from improv_core.website.build import build
from tests.benchmarks.chromium import chromium
from tests.benchmarks.tables import print_row
from tests.site.test_website import PYODIDE
from tests.stage.viewer.conftest import wait
from tests.web_server import served

RATE = 10_000_000 / 8
"""Bytes a second."""
OPENED = 'document.body.dataset.connection === "open"'
FRAMES = """() => new Promise((done) => {
  const times = []
  let last = performance.now()
  const look = (now) => {
    times.push(now - last)
    last = now
    if (times.length < 600) requestAnimationFrame(look)
    else done(times)
  }
  requestAnimationFrame(look)
})"""
KEYS = 200
BETWEEN = 120.0
"""Milliseconds from key to key: ten words a minute more than most people type."""
LINES = 100
PROGRAM = "\n".join(
    [
        "beat 80",
        *(f"step{n} = repeat {n % 4 + 1} (forward || left) ease scale {n}/9 right" for n in range(1, LINES - 4)),
    ]
    + [f"{robot} $ {' '.join(f'step{n}' for n in range(first, LINES - 4, 4))}" for first, robot in enumerate("abcd", 1)]
)
WATCH = """
  const Plain = Worker
  window.keys = []
  window.drawn = []
  window.answered = []
  window.Worker = class extends Plain {
    asked = []
    constructor(...values) {
      super(...values)
      this.addEventListener("message", ({ data }) => {
        if (data.message?.startsWith('{"type": "analyzed"')) answered.push([this.asked.shift(), performance.now()])
      })
    }
    postMessage(message) {
      if (message.request?.startsWith('{"type":"analyze"')) this.asked.push(performance.now())
      super.postMessage(message)
    }
  }
  addEventListener("input", ({ timeStamp }) => {
    keys.push(timeStamp)
    const frame = new MessageChannel()
    frame.port1.onmessage = () => drawn.push(performance.now() - timeStamp)
    requestAnimationFrame(() => frame.port2.postMessage(null))
  }, true)
"""
"""Keeps when keys came, how long each took until a frame with it was drawn, and when texts were asked about and
answered."""
COMPRESSED = (".js", ".mjs", ".css", ".html", ".json")


def run(quick: bool) -> None:
    """Print what it took, in seconds and milliseconds, and how large each part is."""
    with tempfile.TemporaryDirectory() as folder:
        site = Path(folder, "site")
        build(site, PYODIDE)
        _print_sizes(site)
        firsts, seconds = [], []
        with served(site) as address, chromium() as browser:
            for _ in range(1 if quick else 5):
                context = browser.new_context(viewport={"width": 1280, "height": 800})
                page = context.new_page()
                network = context.new_cdp_session(page)
                network.send("Network.enable")
                slow = {"offline": False, "latency": 20, "downloadThroughput": RATE, "uploadThroughput": RATE}
                network.send("Network.emulateNetworkConditions", slow)
                firsts.append(_visit(page, functools.partial(page.goto, address)))
                page.evaluate("() => navigator.serviceWorker.ready.then(() => true)")
                context.set_offline(True)
                seconds.append(_visit(page, page.reload))
                context.close()
            print_row("first visit, 10 Mbit/s", *_figures(firsts), "≤ 2 s / 12 s")
            print_row("second visit, offline", *_figures(seconds), "≤ 2 s / 5 s")
            _print_typing(browser.new_page(viewport={"width": 1280, "height": 800}), address, quick)
            _print_frames(browser.new_page(viewport={"width": 1280, "height": 800}), address)


def _figures(visits: list[tuple[float, float]]) -> list[str]:
    writing, ready = zip(*visits, strict=True)
    return [f"{median(writing):.1f} s until one can write", f"{median(ready):.1f} s until one can play"]


def _visit(page: Page, go: Callable[[], Any]) -> tuple[float, float]:
    """How many seconds until the text can be written, and until it can be played."""
    begin = time.monotonic()
    go()
    page.wait_for_selector("body.editing", timeout=60_000)
    writing = time.monotonic() - begin
    wait(page, OPENED)
    return writing, time.monotonic() - begin


def _print_typing(page: Page, address: str, quick: bool) -> None:
    """From a key in a long program to a frame that shows it, and to its colors and mistakes."""
    page.add_init_script(WATCH)
    page.goto(address)
    wait(page, OPENED)
    page.locator("#text").fill(f"{PROGRAM}\n")
    wait(page, "answered.length > 0 && answered.at(-1)[0] > keys.at(-1)")
    page.evaluate("keys.length = drawn.length = answered.length = 0")
    page.locator("#text").press_sequentially(
        ("e $ step9 (left) " * KEYS)[: KEYS // 4 if quick else KEYS], delay=BETWEEN, timeout=240_000
    )
    wait(page, "answered.length > 0 && answered.at(-1)[0] >= keys.at(-1)")
    keys, drawn, answered = page.evaluate("[keys, drawn, answered]")
    colored = [next(end for asked, end in answered if asked >= key) - key for key in keys]
    for what, times in (("the frame that shows it", drawn), ("its colors and mistakes", colored)):
        times.sort()
        print_row(
            f"from a key in {LINES} lines to {what}",
            f"p50 {median(times):.0f} ms",
            f"p95 {times[int(0.95 * len(times))]:.0f} ms",
            "≤ 50 ms",
        )


def _print_frames(page: Page, address: str) -> None:
    """The times between frames while four robots dance."""
    page.goto(address)
    wait(page, OPENED)
    page.locator("#text").fill("a b c d $ repeat (forward left)\n")
    page.keyboard.press("Control+Enter")
    wait(page, "improv.robots.a?.x !== undefined")
    times = sorted(page.evaluate(FRAMES))
    middle, late = median(times), times[int(0.95 * len(times))]
    print_row("from frame to frame, four robots", f"p50 {middle:.1f} ms", f"p95 {late:.1f} ms", "≤ 20 ms")


def _print_sizes(site: Path) -> None:
    sizes: dict[str, int] = {}
    for path in site.rglob("*"):
        if path.is_file():
            data = path.read_bytes()
            part = path.name if path.stat().st_size > 200_000 else "the page"
            sizes[part] = sizes.get(part, 0) + (len(gzip.compress(data)) if path.suffix in COMPRESSED else len(data))
    for part, size in sorted(sizes.items(), key=lambda each: -each[1]):
        print_row(part, f"{size / 1e6:.2f} MB")
    print_row("all, as a server that compresses sends it", f"{sum(sizes.values()) / 1e6:.2f} MB", "≤ 7.5 MB")
