"""The looks of the page, for everyone: drawings and lights, sizes, themes, files to download, and axe's rules."""

from __future__ import annotations

import struct
from collections.abc import Callable
from pathlib import Path

import pytest
from playwright.sync_api import Page, expect

from improv_core.outputs.simulator.simulator import Simulator
from improv_core.page.server import PageServer
from improv_core.program.analysis import analyze
from improv_core.program.compiler import score_of
from improv_core.score.motion import Twist
from improv_core.score.svg import plot
from tests.axe import Violations
from tests.page.conftest import (
    SCHEMES,
    Keep,
    Show,
    at,
    begin_paused,
    box,
    next_frame,
    play_anew,
    rest,
    switch_to,
    wait,
)
from tests.page.looks import COUNT

ROOT = Path(__file__).parents[2]

PROGRAM = "beat 60\nada $ forward left forward\n"
FAINT = [222, 164, 124]  # half of the first robot's color in the light


def test_the_words_that_play_are_lit_even_after_emoji(shared: tuple[Show, Page]) -> None:
    show, page = shared
    begin_paused(page, show, "beat 60 # 🤖🤖 dance\nstep = forward || left\nada $ step right\n")
    lit = page.locator("#score-text .lit")
    expect(lit).to_have_text(["forward", "left", "step"])
    page.keyboard.press("n")
    expect(lit).to_have_text(["right"])
    expect(page.locator("#score-text")).to_contain_text("🤖🤖 dance")
    page.keyboard.press("Escape")
    expect(lit).to_have_count(0)


@pytest.mark.slow("a browser on a busy machine")
def test_the_page_keeps_counting_and_lights_playing_words_at_their_current_places(shared: tuple[Show, Page]) -> None:
    show, page = shared
    before = "beat 240\nanna $ repeat slow 50 forward\nbert $ repeat slow 40 left\n"
    after = "# bert has another line, and anna's has moved\n" + before.replace("slow 40 left", "slow 40 right")
    play_anew(page, show, before)
    lit = page.locator("#score-text .lit")
    expect(lit).to_have_text(["forward", "left"])
    wait(page, "improv.beat > 4")
    show.play(after, when="bar")
    expect(lit).to_have_text(["forward", "right"])
    wait(page, "improv.known.bert > 8")
    beat = page.evaluate("improv.transport.beat")
    assert beat >= 8
    assert beat % 4 == 0
    assert page.evaluate("improv.transport.begins") == {"bert": beat}
    # Both are on their paths; a page that was held up may have thought otherwise, and has noticed since.
    wait(page, "Object.values(improv.moved).every(({ x, y, heading }) => Math.hypot(x, y, heading) < 0.3)")

    page.keyboard.press("k")  # pause
    expect(page.locator("#state")).to_have_text("paused")
    page.keyboard.press("ArrowLeft")  # once in any case: it may have paused in the instant before
    while page.evaluate("improv.beat") >= beat:
        page.keyboard.press("ArrowLeft")
    expect(lit).to_have_text(["forward"])  # bert has not begun


@pytest.mark.slow("looks at every pixel, again and again")
def test_the_path_ahead_is_drawn_and_can_be_hidden(shared: tuple[Show, Page]) -> None:
    show, page = shared
    begin_paused(page, show, PROGRAM)
    wait(page, f"({COUNT})({FAINT}) > 100")
    rest(page)
    page.keyboard.press("a")
    wait(page, f"({COUNT})({FAINT}) < 40")
    page.keyboard.press("a")
    wait(page, f"({COUNT})({FAINT}) > 100")


COVERED = """() => {
  const inside = ({ left, top, right, bottom }) => left >= 0 && top >= 0 && right <= innerWidth && bottom <= innerHeight
  const all = document.querySelectorAll("#bar button, #tools button, #presenting button, #robots button")
  return [...all].filter(each => each.checkVisibility()).filter(each => {
    const box = each.getBoundingClientRect()
    if (each.closest("#robots")) return box.right > innerWidth
    const hit = document.elementFromPoint((box.left + box.right) / 2, (box.top + box.bottom) / 2)
    return !inside(box) || !each.contains(hit)
  }).map(each => each.id)
}"""
"""Finds the buttons that are cut off or covered."""
SEEN = "[...document.querySelectorAll('button')].filter(each => each.checkVisibility()).map(({ id }) => id)"
BUTTONS = {"stop", "play", "restart", "step", "slower", "faster", "show-timeline", "show-score", "present", "show-help"}
WIDTHS = ((1920, 1080), (1280, 800), (800, 700), (757, 800), (721, 800), (390, 844), (320, 640))


@pytest.mark.slow("looks at seven sizes, twice each")
def test_stop_is_whole_and_the_stage_is_large_at_every_width(still: Callable[..., Page], keep: Keep) -> None:
    page = still("beat 60\n" + "".join(f"r{number:02} $ repeat 8 (forward left)\n" for number in range(12)))
    expect(page.locator("#robots-list li")).to_have_count(12)
    page.set_viewport_size({"width": 844, "height": 390})  # as when a phone is turned
    wait(page, f"document.getElementById('stage').clientWidth <= 844 && !({COVERED})().length")
    assert set(page.evaluate(SEEN)) >= BUTTONS
    assert box(page, "#hall")["height"] > 120
    present = page.get_by_role("button", name="Present")
    for width, height in WIDTHS:
        page.set_viewport_size({"width": width, "height": height})
        wait(page, f"innerWidth === {width} && document.getElementById('stage').clientWidth <= {width}")
        next_frame(page)
        assert page.evaluate(COVERED) == [], f"at {width} pixels"
        assert set(page.evaluate(SEEN)) >= BUTTONS
        assert page.evaluate("document.documentElement.scrollWidth <= innerWidth")
        assert box(page, "#stop")["y"] < 60  # an editor's messages lie at the bottom
        assert box(page, "#hall")["height"] > 0.49 * height, f"at {width} pixels"
        assert box(page, "#tools")["height"] < 60  # one row
        assert box(page, "#tracks")["height"] < 0.26 * height  # the rest is scrolled to
        keep(page, f"page-twelve-{width}.png")
        present.click()
        next_frame(page)
        assert page.evaluate(COVERED) == [], f"presenting at {width} pixels"
        page.get_by_role("button", name="End").click()


def test_reduced_motion_gives_a_still_view(page: Page, still: Callable[..., Page], simulator: Simulator) -> None:
    page.emulate_media(reduced_motion="reduce")
    still(PROGRAM)
    assert page.evaluate("getComputedStyle(document.querySelector('.lamp')).transform") == "none"
    at(page, 0, 0)  # once the view has come to rest
    view = page.evaluate("improv.view")
    simulator.send("ada", Twist(2.0), 0.0)
    simulator.advance(1.0)
    wait(page, "improv.robots.ada.x > 1.9")
    assert page.evaluate("improv.view") == view


APART = """() => {
  const [one, other] = ["notice", "start-poses"].map(id => document.getElementById(id).getBoundingClientRect())
  return one.right <= other.left || other.right <= one.left || one.bottom <= other.top || other.bottom <= one.top
}"""
"""True if the notice and the card of start poses cover no part of each other."""


def test_no_card_covers_the_notice_of_a_lost_connection(still: Callable[..., Page], viewer: PageServer) -> None:
    page = still(PROGRAM)
    page.get_by_role("button", name="Starts").click()
    viewer.close()
    expect(page.locator("#notice")).to_have_text("Disconnected. Trying again…")
    for width, height in WIDTHS[1:-1]:
        page.set_viewport_size({"width": width, "height": height})
        next_frame(page)
        assert page.evaluate(APART), f"at {width} pixels"


@pytest.mark.slow("records a video")
def test_the_paths_and_a_video_can_be_downloaded(shared: tuple[Show, Page], tmp_path: Path) -> None:
    show, page = shared
    program = "beat 60\nada $ repeat (forward || left)\nbo $ forward\n"
    play_anew(page, show, program)
    page.get_by_role("button", name="Save").click()
    svg = downloaded(page, "SVG", tmp_path / "paths.svg").read_text(encoding="utf-8")
    assert svg == plot(score_of(analyze(program)))
    png = downloaded(page, "PNG", tmp_path / "paths.png").read_bytes()
    assert png.startswith(b"\x89PNG\r\n\x1a\n")
    width, height = struct.unpack(">II", png[16:24])
    assert max(width, height) == 2400
    page.keyboard.press("Escape")  # which closes the card
    page.keyboard.press("Escape")
    wait(page, "improv.transport.state === 'stopped'")
    page.get_by_role("button", name="Save").click()
    page.get_by_role("button", name="Record a video").click()
    expect(page.locator("#record")).to_have_text("Recording begins with the dance")
    assert page.evaluate("document.body.dataset.recording") != "true"
    page.get_by_role("button", name="Play", exact=True).click()
    expect(page.locator("#record")).to_have_text("Stop and save the video")
    beat = page.evaluate("improv.beat")
    wait(page, f"improv.beat > {beat} + 1")
    video = downloaded(page, "Stop and save the video", tmp_path / "dance.webm").read_bytes()
    assert video.startswith(b"\x1a\x45\xdf\xa3")  # EBML
    assert b"webm" in video[:64]
    assert len(video) > 10_000
    page.get_by_role("dialog", name="Save").get_by_role("button", name="Close").click()


def downloaded(page: Page, button: str, path: Path) -> Path:
    with page.expect_download() as download:
        page.get_by_role("button", name=button).click()
    assert download.value.suggested_filename.endswith(path.suffix)
    download.value.save_as(path)
    return path


@pytest.mark.slow("axe looks at the page with each card, in two colors")
def test_axe_finds_nothing(violations: Violations, still: Callable[..., Page]) -> None:
    page = still("# a dance\nbeat 60\nada $ (forward || left) forward\nbo $ repeat right\n")
    for card in ("", "Help", "Starts", "Save"):
        if card:
            page.get_by_role("button", name=card, exact=True).click()
        for scheme in SCHEMES:
            switch_to(page, scheme)
            assert violations(page) == [], f"{card}, {scheme}"
        if card:
            page.get_by_role("dialog", name=card).get_by_role("button", name="Close").click()
