"""Errors of robots on the page: now, at the beat under the pointer, and after the dance."""

from __future__ import annotations

import re

import pytest
from playwright.sync_api import Page, expect

from tests.page.conftest import Show, box, wait, watch

WORN = """
[profiles.worn]
step = 2
dynamics = "motors"
wheel_error = [0.9, 0.9]
[robots.ada]
profile = "worn"
odom = "odom"
[robots.bert]
start = { y = 5 }
"""


OFF = "document.querySelector('li[data-robot=ada] .off')?.textContent"
AT_REST = """(
  window.same = window.off === OFF ? (window.same ?? 0) + 1 : 0,
  window.off = OFF,
  window.same > 12
)""".replace("OFF", OFF)
"""True once the robot's error has stayed the same for 12 frames."""


@pytest.mark.slow("robots drive in real time")
def test_the_page_shows_a_robots_error_now_and_earlier(page: Page, show: Show) -> None:
    watch(page, show, "beat 60\nada $ fast 2 (forward left forward left)\nbert $ left\n", WORN)
    wait(page, "improv.transport.state === 'ended'")
    wait(page, AT_REST)
    off = page.locator("li[data-robot=ada] .off")
    last = page.evaluate(OFF)
    assert re.fullmatch(r"\d\.\d\d m, \d+° off", last)
    expect(off).to_have_text(last)
    expect(page.locator("li[data-robot=bert] .off")).to_have_text("")
    line = box(page, "#playline")
    page.mouse.move(line["x"] + 3, line["y"] + line["height"] / 2)
    expect(page.locator("#robots-head")).to_have_text("beat 1")
    expect(off).not_to_have_text(last)
    then = off.text_content()
    assert then
    assert float(then.split()[0]) < float(last.split()[0])
    page.mouse.move(5, 5)
    expect(off).to_have_text(last)
    expect(page.locator("#robots-head")).to_have_text("")
    off.hover()
    expect(off).to_have_attribute("title", re.compile("^at most "))
    page.reload()
    wait(page, f"{OFF} === {last!r}")  # from the start, though the page is new
