"""The sound of a dance in a real browser. modules/music.test.js tests the order of sounds; the benchmark `song`
measures their times."""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path

import pytest
from playwright.sync_api import Page, expect

from tests.page.conftest import Show, next_frame, play_anew, wait
from tests.page.editing import Edit
from tests.page.songs import clicks, improv_toml
from tests.waiting import until

PROGRAM = "beat 120\nbar 3\nada $ repeat (forward left)\n"
SONG = clicks(200, 120)
RIGHT = "Math.abs(improv.song - (0.5 + improv.beat / 2)) < 0.25"
"""True if the page plays the position that belongs to the beat. The benchmark measures the error."""

TAP = """milliseconds => {
  const now = performance.now
  performance.now = () => 1e6 + milliseconds
  document.querySelector("#tap").click()
  performance.now = now
}"""
"""Taps the beat at a time that the test sets."""


@pytest.fixture
def dance(shared: tuple[Show, Page], tmp_path: Path) -> Page:
    """A page on which PROGRAM plays with its song, whose first beat is after half a second. No earlier song is left."""
    show, page = shared
    play_anew(page, show, PROGRAM)
    play_anew(page, show, PROGRAM, improv_toml(tmp_path, SONG, first_beat=0.5), folder=tmp_path)
    page.locator("#stage").click()  # before that, browsers play nothing
    return page


def test_the_page_plays_the_song_at_the_beat_and_through_pause_seek_and_stop(dance: Page) -> None:
    wait(dance, RIGHT)
    dance.locator("#play").click()
    wait(dance, "improv.transport.state === 'paused' && improv.song === null")
    dance.locator("#play").click()
    wait(dance, RIGHT)
    before = dance.evaluate("improv.transport.generation")
    dance.locator("#restart").click()
    wait(dance, f"improv.transport.generation > {before} && {RIGHT}")
    dance.locator("#stop").click()
    wait(dance, "improv.transport.state === 'stopped' && improv.song === null")
    expect(dance.locator("#song-line")).to_be_hidden()
    expect(dance.locator("#sound-on")).to_be_hidden()


def test_a_save_keeps_the_song_which_is_not_sent_again(dance: Page, shared: tuple[Show, Page], tmp_path: Path) -> None:
    show, _ = shared
    wait(dance, RIGHT)
    with dance.expect_response(re.compile("/song")) as answer:
        next_frame(dance)  # Playwright listens only once it has answered something
        show.play(PROGRAM, '[music]\nfile = "song.wav"\nfirst_beat = 0.5', when="now", folder=tmp_path)
    assert answer.value.status == 304
    wait(dance, RIGHT)


DROP = """({ name, content }) => {
  const dataTransfer = new DataTransfer()
  dataTransfer.items.add(new File(content ? [content] : [], name, { type: name.endsWith("wav") ? "audio/wav" : "" }))
  document.body.dispatchEvent(new DragEvent("drop", { dataTransfer, bubbles: true, cancelable: true }))
}"""


@pytest.mark.slow("a browser on a busy machine")
def test_a_file_that_somebody_chooses_or_drops_plays_and_stays_in_the_browser(shared: tuple[Show, Page]) -> None:
    show, page = shared
    play_anew(page, show, PROGRAM)
    sent: list[str] = []
    page.on("request", lambda request: sent.append(request.method))
    page.locator("#song-file").set_input_files({"name": "own.wav", "mimeType": "audio/wav", "buffer": SONG})
    wait(page, "Math.abs(improv.song - improv.beat / 2) < 0.25")
    page.get_by_role("button", name="Sound").click()
    expect(page.locator("#song-name")).to_have_text("own.wav")
    page.get_by_role("slider", name="Beat 1 in the song, in seconds").press("ArrowLeft")
    expect(page.locator("#sound-toml-lines")).to_have_text("[music]\nfirst_beat = 0.01")
    long = "can't be played: it is damaged, or so long that this browser has no room for its sound"
    for name, content, problem in (
        ("notes.txt", "text", "can't be played: this browser doesn't know its format"),
        ("silence.wav", "", "is empty"),
        ("long.wav", "text", long),
    ):
        page.evaluate(DROP, {"name": name, "content": content})
        for line in ("#song-line", "#song-problem"):  # the card may cover the stage
            expect(page.locator(line)).to_have_text(f"{name} {problem}.")
    wait(page, "Math.abs(improv.song - improv.beat / 2) < 0.25")
    page.get_by_role("button", name="Remove").click()
    wait(page, "improv.song === null")
    expect(page.locator("#sound-toml")).to_be_hidden()
    assert set(sent) == {"GET"}


@pytest.mark.slow("edits on a page")
def test_taps_and_drags_are_written_if_the_page_edits(tmp_path: Path, edit: Callable[[str], Edit]) -> None:
    robots = tmp_path / "improv.toml"
    robots.write_text(improv_toml(tmp_path, SONG), encoding="utf-8")
    page = edit(PROGRAM).page()
    page.get_by_role("button", name="Save and play").click()
    page.get_by_role("slider", name="Beat 1 in the song, in seconds").press("ArrowLeft")
    expect(page.locator("#did")).to_have_text("Writing first_beat = 0.01 into improv.toml")
    until(lambda: robots.read_text(encoding="utf-8").endswith("first_beat = 0.01\n"), robots.read_text)
    page.get_by_role("button", name="Sound").click()
    for tap in range(8):
        page.evaluate(TAP, 625 * tap)  # 96 beats a minute
    expect(page.locator("#tapped")).to_have_text("96 beats a minute")
    page.get_by_role("button", name="beat 96").click()
    expect(page.locator("#text")).to_have_value(PROGRAM.replace("120", "96"))
