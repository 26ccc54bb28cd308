"""Things that a website's page keeps, brings along, and passes on: programs, their improv.toml, links, files, new
versions."""

from __future__ import annotations

import json
import os
import shutil
import zlib
from base64 import urlsafe_b64decode, urlsafe_b64encode
from pathlib import Path

import pytest
from playwright.sync_api import Page, expect

from tests.page.conftest import Keep, wait
from tests.web_server import served
from tests.website.conftest import OPENED, open_site, play

FULL = """() => {
  for (let size = 2 ** 21; size >= 1; size = size >> 1)
    try { for (let i = 0; ; i++) localStorage.setItem(`full ${size} ${i}`, "x".repeat(size)) }
    catch { /* the next size */ }
}"""
FILES = """
  const dance = async () => (await navigator.storage.getDirectory()).getFileHandle("dance.improv", { create: true })
  window.showSaveFilePicker = dance
  window.saved = async () => (await (await dance()).getFile()).text()
"""
"""Nobody can click in a system's file dialog here: this file is a real one of the browser."""


def fragment(**held: object) -> str:
    """Return the end of a link that holds this."""
    packed = zlib.compressobj(wbits=-15)
    data = packed.compress(json.dumps({"v": 1, **held}).encode()) + packed.flush()
    return f"#dance={urlsafe_b64encode(data).decode().rstrip('=')}"


@pytest.mark.slow("a browser on a busy machine")
def test_a_link_is_shown_fixed_and_passed_on_and_begins_at_its_pause(address: str, page: Page, keep: Keep) -> None:
    page.add_init_script(FILES)
    toml = '[robots.ada]\nprofile = "quadrator"\n'
    open_site(page, f"{address}{fragment(text='ada $ repeat 40 left', toml=toml)}")
    expect(page.locator("#diagnostics")).to_contain_text("improv.toml, line 2")
    share, dialog = page.get_by_role("button", name="Share"), page.locator("#sharing")
    share.click()
    expect(page.get_by_label("improv.toml", exact=True)).to_have_value(toml)
    expect(page.get_by_label("Website")).to_be_hidden()  # this is one
    keep(page, "site-share-toml.png")
    page.get_by_label("improv.toml", exact=True).fill(toml.replace("quadrator", "quadrotor"))
    page.get_by_role("button", name="Use this").click()
    expect(page.locator("#sharing-line")).to_have_text("This holds from the next time on that you play.")
    page.keyboard.press("Escape")
    expect(dialog).to_be_hidden()
    expect(page.locator("#diagnostics")).to_be_hidden()
    page.get_by_role("button", name="Save and play").click()
    wait(page, 'improv.transport.state === "playing"')
    page.locator("#playline").press("ArrowRight")
    page.get_by_role("button", name="Pause").click()
    wait(page, 'improv.transport.state === "paused" && improv.transport.beat >= 1')
    share.click()
    expect(page.locator("#link-length")).to_contain_text("it begins at beat ")
    link = page.locator("#link").input_value()
    held = json.loads(zlib.decompress(urlsafe_b64decode(f"{link.partition('#dance=')[2]}=="), wbits=-15))
    assert held["still"] == [[0, 200, 200]]
    page.get_by_role("button", name="Save as a file").click()
    expect(page.locator("#sharing-line")).to_have_text("Saved as dance.improv.")
    page.keyboard.press("Escape")
    page.locator("#text").fill("bo $ left")
    share.click()
    with page.expect_file_chooser() as chooser:
        page.get_by_role("button", name="Open a file").click()
    saved = page.evaluate("saved()").encode()
    chooser.value.set_files({"name": "dance.improv", "mimeType": "text/plain", "buffer": saved})
    expect(page.locator("#text")).to_have_value("ada $ repeat 40 left")

    page.goto("about:blank")
    open_site(page, link)
    assert page.evaluate("improv.transport.generation") == 0
    page.get_by_role("button", name="Save and play").click()
    wait(page, 'improv.transport.state === "playing" && improv.transport.beat >= 1')
    share.click()
    expect(page.get_by_label("improv.toml", exact=True)).to_have_value(toml.replace("quadrator", "quadrotor"))


@pytest.mark.slow("a browser on a busy machine")
def test_ones_own_dance_and_its_improv_toml_come_back_after_links_and_examples(
    address: str, page: Page, keep: Keep
) -> None:
    own, toml = "ada $ forward # mine", "[robots.ada]\n"
    shared, given = page.get_by_role("button", name="Share"), page.get_by_label("improv.toml", exact=True)

    def has_own() -> None:
        expect(page.locator("#text")).to_have_value(own)
        shared.click()
        expect(given).to_have_value(toml)
        page.keyboard.press("Escape")

    open_site(page, address)
    play(page, own)
    expect(page.locator("#file-state")).to_have_text("saved")  # or the page would keep it, as unsaved, before any link
    shared.click()
    page.locator("#toml-part summary").click()
    given.fill(toml)
    page.get_by_role("button", name="Use this").click()
    page.keyboard.press("Escape")
    for query, link in (
        ("?fbclid=x", fragment(text="bo $ left # 1", toml="[robots.bo]\n")),
        ("", fragment(text="bo $ left # 2").replace("=", "%3D", 1)),
    ):
        page.goto("about:blank")
        open_site(page, f"{address}{query}{link}")
        expect(page.locator("#text")).to_have_value(f"bo $ left # {2 if '%' in link else 1}")
        assert page.url == address
    page.evaluate("hash => { location.hash = hash }", fragment(text="bo $ left # 3"))  # on the page that is open
    expect(page.locator("#text")).to_have_value("bo $ left # 3")
    wait(page, OPENED)
    expect(page.locator("#versions-text")).to_contain_text("Another text with its improv.toml, from ")
    keep(page, "site-kept-before-links.png")
    page.get_by_role("button", name="Show it instead").click()
    has_own()

    page.get_by_role("button", name="Tutorial").click()
    page.get_by_role("button", name="Play this").first.click()
    expect(page.locator("#text")).not_to_have_value(own)
    while page.locator("#text").input_value() != own:
        page.get_by_role("button", name="Show it instead").click()
    has_own()


@pytest.mark.slow("a browser on a busy machine")
def test_without_room_a_line_says_so_and_no_text_is_lost(address: str, page: Page) -> None:
    open_site(page, address)
    play(page, "cy $ forward")
    expect(page.locator("#file-state")).to_have_text("saved")
    page.evaluate(FULL)
    play(page, "cy $ repeat (forward backward) # longer")
    expect(page.locator("#file-state")).to_contain_text("not saved: this browser has no room for it")
    expect(page.locator("#state")).to_have_text("playing")
    page.locator("#text").fill("cy $ forward")  # kept, so no question whether to leave the page
    page.goto("about:blank")
    open_site(page, f"{address}{fragment(text='dee $ left')}")
    expect(page.locator("#notice")).to_contain_text("this browser has no room for another dance")
    expect(page.locator("#text")).to_have_value("cy $ forward")


@pytest.mark.slow("a browser on a busy machine")
def test_a_page_of_an_old_version_says_that_there_is_a_newer_one(
    built: Path, natively: Path, tmp_path: Path, page: Page
) -> None:
    shutil.copytree(natively / "improv", tmp_path / "site")
    worker = tmp_path / "site" / "service-worker.js"
    shutil.copy(built / "service-worker.js", worker)
    os.utime(worker, (0, 0))  # the server tells times in whole seconds, so the next one must not have the same
    with served(tmp_path / "site") as root:
        open_site(page, root)
        page.evaluate("() => navigator.serviceWorker.ready.then(() => true)")
        wait(page, "navigator.serviceWorker.controller")
        page.locator("#text").fill("cy $ forward")
        worker.write_text(worker.read_text().replace('{"version": "', '{"version": "newer '))
        page.reload()
        expect(page.locator("#notice")).to_contain_text("A newer version of this website is here.")
        expect(page.locator("#text")).to_have_value("cy $ forward")
