"""What the page looks like, for everyone: what is drawn and lit, sizes and themes, files to take away, axe's rules."""

from __future__ import annotations

import struct
from collections.abc import Iterator
from contextlib import contextmanager
from functools import partial
from http.server import SimpleHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path
from threading import Thread
from typing import Any, Literal

import pytest
from playwright.sync_api import Browser, Page, expect

from improv_core.program.analysis import analyze
from improv_core.program.compiler import score_of
from improv_core.score.svg import plot
from tests.needs import lacking
from tests.stage.viewer.conftest import Show, wait, watch
from tests.stage.viewer.looks import COUNT, PIXEL, SLANTED

ROOT = Path(__file__).parents[3]
AXE = ROOT / ".cache" / "axe" / "node_modules" / "axe-core" / "axe.min.js"

FAINT = [222, 164, 124]  # half of the first robot's color in the light


def still(page: Page, show: Show, program: str = "beat 60\nada $ forward left forward\n") -> Page:
    """A page of a program that stands at its first beat."""
    show.play(program)
    watch(page, show)
    page.keyboard.press("n")  # which pauses, also a short dance that is over already
    wait(page, "improv.transport.state === 'paused'")
    page.keyboard.press("Home")
    wait(page, "improv.transport.state === 'paused' && improv.beat === 0")
    return page


def test_the_words_that_play_are_lit_also_after_emoji(page: Page, show: Show) -> None:
    still(page, show, "beat 60 # 🤖🤖 dance\nstep = forward || left\nada $ step right\n")
    lit = page.locator("#score-text .lit")
    expect(lit).to_have_text(["forward", "left", "step"])
    page.keyboard.press("n")
    expect(lit).to_have_text(["right"])
    expect(page.locator("#score-text")).to_contain_text("🤖🤖 dance")
    page.keyboard.press("Escape")
    expect(lit).to_have_count(0)


PAINTED = f"""(
  window.before = window.count,
  window.count = ({COUNT})({FAINT}),
  window.same = window.count === window.before ? window.same + 1 : 0,
  window.count > 100 && window.same > 10
)"""
"""A path ahead has been painted, and for ten frames nothing more."""


def test_the_path_ahead_is_drawn_and_can_be_hidden(page: Page, show: Show) -> None:
    still(page, show)
    wait(page, PAINTED)
    page.keyboard.press("a")
    wait(page, f"({COUNT})({FAINT}) < 40")
    page.keyboard.press("a")
    wait(page, f"({COUNT})({FAINT}) > 100")


def test_trails_can_be_cleared_and_turned_off(page: Page, show: Show) -> None:
    robots = "[robots.ada]\nstart = {x=0,y=0.3}\n"
    show.play("ada $ rest\n", robots)
    watch(page, show)
    show.play("beat 60\nada $ forward forward forward\n", robots)  # seen from its beginning
    wait(page, "improv.robots.ada.x > 1.2")
    page.keyboard.press("k")
    wait(page, "improv.transport.state === 'paused'")
    ground = f"({PIXEL})(0.55, 0.3) === '251,250,247'"
    wait(page, f"!({ground})")
    page.get_by_label("Trails").select_option("off")
    wait(page, ground)
    page.get_by_label("Trails").select_option("all")
    wait(page, f"!({ground})")
    page.get_by_role("button", name="Clear").click()
    wait(page, ground)
    assert page.evaluate("improv.transport.state") == "paused"  # it is only drawn otherwise


def test_an_endless_program_goes_on_being_known(page: Page, show: Show) -> None:
    show.play("beat 240\nada $ repeat (forward left)\nbo $ forward\n")
    watch(page, show)
    expect(page.locator("li[data-robot=ada] .endless")).to_be_visible()
    expect(page.locator("li[data-robot=bo] .endless")).to_have_count(0)
    known = page.evaluate("improv.known.ada")
    wait(page, f"improv.beat > 20 && improv.known.ada >= {known} + 16")


def test_a_program_that_takes_over_goes_on_from_where_the_robots_are(page: Page, show: Show) -> None:
    show.play("beat 240\nada $ repeat forward\n")
    watch(page, show)
    wait(page, "improv.robots.ada.x > 3")
    show.play("beat 60\nada $ left forward\n", when="now")
    wait(page, "Math.abs(improv.known.ada - improv.transport.begins?.ada - 2) < 1e-6")
    expect(page.locator("#score-text")).to_contain_text("left forward")
    assert page.evaluate("improv.robots.ada.x") > 2.9


def test_the_path_ahead_begins_exactly_where_a_program_takes_over(page: Page, show: Show) -> None:
    show.play("beat 240\nada $ repeat forward\n")
    watch(page, show)
    wait(page, "improv.robots.ada.x > 3")
    show.play("beat 120\nada $ repeat left\n", when="now")
    wait(page, "improv.known.ada > improv.transport.begins?.ada && improv.beat > improv.transport.begins?.ada + 2")
    assert page.evaluate("improv.moved") == {}  # it was where the score has it


def test_a_page_that_was_held_up_leaves_the_path_ahead_where_it_is(page: Page, show: Show) -> None:
    show.play("beat 240\nada $ repeat (forward left)\n")
    watch(page, show)
    for _ in range(3):
        beat = page.evaluate("improv.beat")
        page.evaluate("() => { const end = performance.now() + 400; while (performance.now() < end); }")
        wait(page, f"improv.beat > {beat} + 3")
        assert page.evaluate("improv.moved") == {}


def test_the_timeline_is_there_wherever_it_is_scrolled_to(page: Page, show: Show, artifacts: Path) -> None:
    show.play("".join(f"robot{number} $ repeat 8 (forward left)\n" for number in range(12)))
    watch(page, show)
    expect(page.locator("#cast-list li")).to_have_count(12)
    page.locator("#tracks").evaluate("tracks => tracks.scrollTo(0, tracks.scrollHeight)")
    wait(page, "document.getElementById('tracks').scrollTop > 100")
    tracks, rows = (page.locator(each).bounding_box() for each in ("#tracks", "#rows"))
    assert tracks
    assert rows
    assert rows["y"] == pytest.approx(tracks["y"], abs=1)
    page.screenshot(path=artifacts / "page-scrolled.png")


def test_a_seek_after_a_long_pause_draws_no_way_between(page: Page, show: Show) -> None:
    show.play("beat 120\nada $ forward left forward left forward left forward\n")
    watch(page, show)
    wait(page, "improv.robots.ada.y > 1.9")
    page.keyboard.press("k")
    wait(page, "improv.transport.state === 'paused'")
    began = page.evaluate("performance.now()")
    wait(page, f"performance.now() > {began} + 2500")
    ahead = page.evaluate(f"({PIXEL})(0, 1.3)")
    page.get_by_role("button", name="Paths").click()
    wait(page, f"({PIXEL})(0, 1.3) !== '{ahead}'")  # all is painted anew, at the very time of the seek
    page.keyboard.press("Home")
    wait(page, "improv.robots.ada.y < 0.1")
    assert page.evaluate(f"({PIXEL})(1.3, 1.3)") == "251,250,247"


def test_scrubbing_while_paused_draws_no_way_between(page: Page, show: Show) -> None:
    names = [f"r{number:02}" for number in range(30)]
    starts = "".join(f"[robots.{name}]\nstart = {{ y = {-3 * row} }}\n" for row, name in enumerate(names))
    page.add_init_script(SLANTED)
    show.play("".join(f"{name} $ repeat 60 (forward left forward right)\n" for name in names), starts)
    watch(page, show)
    wait(page, "improv.beat > 1")
    page.keyboard.press("k")
    wait(page, "improv.transport.state === 'paused'")
    line = page.locator("#playline").bounding_box()
    assert line
    page.evaluate("watched = true")
    for number in range(100):
        page.mouse.move(line["x"] + line["width"] * (0.1 + 0.37 * number % 0.8), line["y"] + 50)
        if number % 4 == 0:
            page.mouse.down()
        if number % 4 == 3:
            page.mouse.up()
        frames = page.evaluate("improv.frames")
        wait(page, f"improv.frames > {frames} + 2")
    assert page.evaluate("slanted") == 0


def test_a_page_that_gets_small_keeps_room_for_the_stage(page: Page, show: Show) -> None:
    still(page, show)
    expect(page.locator("#score")).to_be_visible()
    page.set_viewport_size({"width": 390, "height": 700})
    expect(page.locator("#score")).to_be_hidden()
    expect(page.locator("#timeline")).to_be_visible()
    wait(page, "document.getElementById('stage').clientHeight > 200")


def test_fifty_robots_are_shown_without_holding_up_the_page(page: Page, show: Show, artifacts: Path) -> None:
    names = [f"r{index}" for index in range(50)]
    starts = (f"[robots.{name}]\nstart = {{x={5 * (i % 10)},y={-5 * (i // 10)}}}\n" for i, name in enumerate(names))
    show.play("".join(f"{name} $ repeat (forward || left)\n" for name in names), "".join(starts))
    watch(page, show)
    wait(page, "Object.keys(improv.robots).length === 50 && Object.keys(improv.known).length === 50 && improv.beat > 2")
    expect(page.locator("#cast-list li")).to_have_count(50)
    frames = page.evaluate("improv.frames")
    wait(page, f"improv.frames > {frames + 60}")
    page.screenshot(path=artifacts / "page-fifty.png")


def test_after_the_end_the_page_says_so_and_goes_on_with_what_is_played_next(
    page: Page, show: Show, artifacts: Path, tmp_path: Path
) -> None:
    program = "beat 60\nada $ forward left forward\n"
    show.play(program)
    watch(page, show)
    wait(page, "improv.robots.ada.x > 0.2")
    show.end_stage()
    notice = page.locator("#notice")
    expect(notice).to_have_text("The performance is over. Play again from your editor or terminal.")
    expect(page.get_by_role("status")).to_have_text(notice.inner_text())
    expect(page.locator("#state")).to_have_text("stopped")
    expect(page.locator("#stage")).to_have_css("filter", "none")
    page.get_by_role("button", name="Save").click()
    assert downloaded(page, "SVG", tmp_path / "paths.svg").read_text() == plot(score_of(analyze(program)))
    page.screenshot(path=artifacts / "page-over.png")
    expect(page.get_by_role("button", name="Play")).to_have_attribute("aria-disabled", "true")
    show.play("beat 60\nbo $ forward left\n")
    wait(page, "improv.connected && improv.known.bo === 2 && improv.transport.state === 'playing'")
    expect(notice).to_be_hidden()


def test_editors_on_this_machine_may_frame_the_page_and_strangers_may_not(
    browser: Browser, show: Show, tmp_path: Path
) -> None:
    show.play("beat 60\nada $ repeat (forward || left)\n")
    url = show.url
    (tmp_path / "index.html").write_text(f"<iframe src='{url}' width=900 height=600></iframe>", encoding="utf-8")
    page = browser.new_page()
    with served(tmp_path) as editor:
        page.goto(editor)
        inside = page.frame_locator("iframe")
        expect(inside.locator("#state")).to_have_text("playing")
        inside.get_by_role("button", name="Stop").click()
        expect(inside.locator("#state")).to_have_text("stopped")
    with page.expect_event("requestfailed") as failed:
        page.goto((tmp_path / "index.html").as_uri())
    assert (failed.value.url, failed.value.failure) == (url, "net::ERR_BLOCKED_BY_RESPONSE")
    page.close()


@contextmanager
def served(folder: Path) -> Iterator[str]:
    """The URL of a folder's files, as an editor in a browser has one."""
    with ThreadingHTTPServer(("127.0.0.1", 0), partial(SimpleHTTPRequestHandler, directory=folder)) as server:
        Thread(target=server.serve_forever).start()
        yield f"http://127.0.0.1:{server.server_port}/"
        server.shutdown()


def test_what_the_server_should_not_say_is_dropped(page: Page, show: Show) -> None:
    still(page, show)
    read = page.evaluate(
        """async () => {
          const { read } = await import("/messages.js")
          return [
            "", "{", "7", "null", "[]", "{}", '{"type":"constructor"}',
            '{"type":"poses","at":0,"placed":0,"poses":[[0,0,0]]}',
            '{"type":"poses","at":0,"placed":0,"poses":{"ada":[0,0,0,0]}}',
            '{"type":"poses","at":null,"placed":0,"poses":[]}', '{"type":"poses","at":0,"poses":[]}',
            '{"type":"transport","generation":1,"state":"dancing"}',
            '{"type":"robots","robots":[]}', '{"type":"bumps","bumps":[{}]}',
            '{"type":"window","generation":1,"from":0,"to":1,"robots":{"ada":{"pose":null,"moments":[[0]],"until":1}}}',
          ].map(read)
        }"""
    )
    assert read == [None] * 15


@pytest.mark.parametrize("scheme", ["light", "dark"])
@pytest.mark.parametrize(("width", "height"), [(390, 844), (844, 390), (1280, 800), (1920, 1080)])
def test_everything_has_room(
    page: Page, show: Show, artifacts: Path, scheme: Literal["light", "dark"], width: int, height: int
) -> None:
    page.emulate_media(color_scheme=scheme)
    page.set_viewport_size({"width": width, "height": height})
    still(page, show, "beat 60\nada $ (forward || left) [forward left]\nbo $ repeat (forward || right)\n")
    transport = ("Stop", "Play", "Restart", "Step to the next beat", "Slower", "Faster")
    for name in (*transport, "Timeline", "Score", "Present", "Help"):
        button = page.get_by_role("button", name=name, exact=name != "Stop")
        expect(button).to_be_in_viewport(ratio=1)
    assert page.evaluate("document.documentElement.scrollWidth <= innerWidth")
    box = page.locator("#hall").bounding_box()
    assert box
    assert box["height"] > 120
    page.screenshot(path=artifacts / f"page-{width}-{scheme}.png")


def test_who_wants_no_motion_gets_a_view_that_stands(page: Page, show: Show) -> None:
    page.emulate_media(reduced_motion="reduce")
    still(page, show)
    assert page.evaluate("getComputedStyle(document.querySelector('.lamp')).transform") == "none"
    view = page.evaluate("improv.view")
    page.keyboard.press("n")
    wait(page, "improv.beat === 1 && improv.robots.ada.x > 1.9")
    assert page.evaluate("improv.view") == view


def test_the_paths_can_be_taken_away_as_svg_and_png(page: Page, show: Show, tmp_path: Path) -> None:
    still(page, show, "beat 60\nada $ forward || left\nbo $ forward\n")
    page.get_by_role("button", name="Save").click()
    svg = downloaded(page, "SVG", tmp_path / "paths.svg").read_text(encoding="utf-8")
    assert svg == plot(score_of(analyze("beat 60\nada $ forward || left\nbo $ forward\n")))
    png = downloaded(page, "PNG", tmp_path / "paths.png").read_bytes()
    assert png.startswith(b"\x89PNG\r\n\x1a\n")
    width, height = struct.unpack(">II", png[16:24])
    assert max(width, height) == 2400


def test_a_video_can_be_taken_away(page: Page, show: Show, tmp_path: Path) -> None:
    show.play("beat 60\nada $ repeat (forward || left)\n")
    watch(page, show)
    page.get_by_role("button", name="Save").click()
    page.get_by_role("button", name="Record a video").click()
    beat = page.evaluate("improv.beat")
    wait(page, f"improv.beat > {beat} + 1")
    video = downloaded(page, "Stop and save the video", tmp_path / "dance.webm").read_bytes()
    assert video.startswith(b"\x1a\x45\xdf\xa3")  # EBML
    assert b"webm" in video[:64]
    assert len(video) > 10_000


def downloaded(page: Page, button: str, path: Path) -> Path:
    with page.expect_download() as download:
        page.get_by_role("button", name=button).click()
    assert download.value.suggested_filename.endswith(path.suffix)
    download.value.save_as(path)
    return path


@pytest.mark.parametrize("scheme", ["light", "dark"])
@pytest.mark.parametrize("card", [None, "Help", "Starts", "Save"])
def test_axe_finds_nothing(browser: Browser, show: Show, scheme: Literal["light", "dark"], card: str | None) -> None:
    if not AXE.exists():
        lacking("axe-core is not installed: npm install --prefix .cache/axe axe-core")
    page = browser.new_page(color_scheme=scheme, viewport={"width": 1280, "height": 800})
    still(page, show, "# a dance\nbeat 60\nada $ (forward || left) forward\nbo $ repeat right\n")
    if card:
        page.get_by_role("button", name=card, exact=True).click()
    page.evaluate(AXE.read_text(encoding="utf-8"))
    found: list[dict[str, Any]] = page.evaluate("axe.run().then(({ violations }) => violations)")
    assert [(rule["id"], [node["html"] for node in rule["nodes"]]) for rule in found] == []
    page.close()
