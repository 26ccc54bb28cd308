"""The website: its files, and their work in a browser, also without a network."""

from __future__ import annotations

import io
import json
import re
import shutil
import subprocess
import sys
import zipfile
from pathlib import Path
from urllib.parse import unquote

import pytest
from playwright.sync_api import Page, expect

from improv_core.storage.program_file import TEMPLATE
from improv_core.website.build import LIBRARY, MARK, SiteError, build
from improv_core.website.compile_cache import compiled
from tests.needs import lacking
from tests.page.conftest import Keep, wait
from tests.pyodide import imitate
from tests.web_server import served
from tests.website.conftest import OPENED, open_site, play
from tests.website.test_local_program import fragment

PYODIDE = Path(__file__).parents[2] / ".cache" / "pyodide" / "node_modules" / "pyodide"
COVERED = """() => {
  const [still, stage] = ["still", "stage"].map((id) => document.getElementById(id))
  const [one, other] = [still, stage].map((each) => JSON.stringify(each.getBoundingClientRect()))
  return [one === other, getComputedStyle(still).backgroundColor.startsWith("rgb(")]
}"""
BREAK = """async () => {
  const compiled = await caches.open((await caches.keys()).find((name) => name.startsWith("improv compiled ")))
  const [kept] = await compiled.keys()
  await compiled.put(kept, new Response("broken"))
}"""


def content(site: Path) -> dict[str, bytes]:
    return {path.relative_to(site).as_posix(): path.read_bytes() for path in site.rglob("*") if path.is_file()}


def test_all_loaded_files_are_in_the_folder_and_kept_for_later(pyodide: Path, tmp_path: Path) -> None:
    site = tmp_path / "site"
    files = build(site, pyodide)
    assert files == {name: len(data) for name, data in content(site).items()}
    listed = re.search(r"self.SITE = (\{.*\})\n", (site / "service-worker.js").read_text())
    assert listed
    kept = json.loads(listed[1])["files"]
    assert {*kept} == {"./", *files} - {"service-worker.js", MARK}
    page = (site / "index.html").read_text()
    assert {*re.findall(r'(?:src|href)="([^"#:]+)"', page)} <= {*files}
    for name in files:
        if name.endswith((".js", ".css", ".html")):
            hosts = re.findall(r"https?://[\w.]+", (site / name).read_text().replace("http://www.w3.org", ""))
            assert not hosts, name


def test_python_files_of_the_command_line_stay_out(built: Path) -> None:
    names = zipfile.ZipFile(built / "improv.zip").namelist()
    assert {"improv_core/website/browser_session.py", "lark/__init__.py", "segno/__init__.py"} <= {*names}
    assert not [name for name in names if re.search("/commands/|/static/|/hosts/|ros/output|__pycache__", name)]


def test_unused_modules_of_pythons_library_stay_out(built: Path, tmp_path: Path) -> None:
    assert zipfile.ZipFile(built / "pyodide" / LIBRARY).namelist() == ["re/__init__.py"]
    broken = imitate(tmp_path / "pyodide")
    (broken / LIBRARY).write_text("half of it")
    with pytest.raises(SiteError, match="is broken: run `npm install pyodide` again"):
        build(tmp_path / "site", broken)


def test_the_python_files_need_no_others(built: Path, tmp_path: Path) -> None:
    zipfile.ZipFile(built / "improv.zip").extractall(tmp_path / "files")
    scene = """
import asyncio, sys
sys.path = [each for each in sys.path if "site-packages" not in each and each] + [sys.argv[1]]
from improv_core.website.browser_session import BrowserBackend

async def play():
    told, ready = [], asyncio.Event()
    home = BrowserBackend(told.append, lambda number: None)
    serving = asyncio.create_task(home.serve("", "[robots.ada]\\nprofile = 1", 0, 0.0, ready.set))
    await ready.wait()
    for text in ("fly = lift || left\\nada $ near", "ada is puppet\\nada $ forward || head left"):
        home.hear('{"type": "analyze", "number": 1, "text": "%s"}' % text)
    home.use("[world]\\nsize = [4, 4]")
    home.hear('{"type": "complete", "number": 1, "offset": 2}')
    home.hear('{"type": "write", "number": 1, "text": "ada $ left", "revision": "0"}')
    while not any('"state": "playing"' in each for each in told):
        await asyncio.sleep(0.01)
    assert home.code("x") and home.paths()
    serving.cancel()

asyncio.run(asyncio.wait_for(play(), 60))
"""
    done = subprocess.run(
        [sys.executable, "-I", "-c", scene, tmp_path / "files"], capture_output=True, text=True, timeout=90, check=False
    )
    assert (done.returncode, done.stderr) == (0, "")


def test_modules_that_were_compiled_need_no_source(tmp_path: Path) -> None:
    (tmp_path / "one" / "inner").mkdir(parents=True)
    (tmp_path / "one" / "__init__.py").write_text("from one.inner import word\n")
    (tmp_path / "one" / "inner" / "__init__.py").write_text("word = 'compiled'\n")
    (tmp_path / "one" / "never.py").write_text("word = 'source'\n")
    (tmp_path / "one" / "words.lark").write_text("a: b")
    run = [sys.executable, "-c"]
    subprocess.run([*run, "import one"], cwd=tmp_path, check=True)
    archive = zipfile.ZipFile(io.BytesIO(compiled(str(tmp_path))))
    assert {*archive.namelist()} == {"one/__init__.pyc", "one/inner/__init__.pyc", "one/never.py", "one/words.lark"}
    archive.extractall(tmp_path / "again")
    scene = "import one, one.never; print(one.word, one.never.word)"
    done = subprocess.run([*run, scene], cwd=tmp_path / "again", capture_output=True, text=True, check=True)
    assert done.stdout == "compiled source\n"


def test_the_same_files_make_the_same_website_also_in_place_of_an_earlier_one(
    built: Path, pyodide: Path, tmp_path: Path
) -> None:
    site = tmp_path / "site"
    site.mkdir()
    for name in (MARK, "old.js"):
        (site / name).write_text("")
    build(site, pyodide)
    assert content(site) == content(built)


def test_folders_with_other_files_stay(pyodide: Path, tmp_path: Path) -> None:
    other = tmp_path / "other"
    other.mkdir()
    (other / "thesis.txt").write_text("")
    with pytest.raises(SiteError, match="has other files in it: name a new folder"):
        build(other, pyodide)
    assert (other / "thesis.txt").exists()
    with pytest.raises(SiteError, match="run `npm install pyodide` here, or name the folder with --pyodide"):
        build(tmp_path / "new", tmp_path)


def test_the_page_opens_over_plain_http_as_in_a_class(built: Path, page: Page) -> None:
    with served(built) as root:
        page.goto(root.replace("127.0.0.1", "0.0.0.0"))  # the same server, but browsers don't trust this address
        assert not page.evaluate("isSecureContext")
        expect(page.locator("#text")).to_have_value(TEMPLATE)
        assert page.evaluate("improv.transport.generation") == 0


@pytest.mark.timeout(300)
@pytest.mark.slow("starts Python in a browser, twice")
def test_a_dance_is_written_played_passed_on_and_opened_without_a_network(
    tmp_path: Path, page: Page, keep: Keep
) -> None:
    if not PYODIDE.exists():
        lacking("Pyodide is missing: npm install --no-save --prefix .cache/pyodide pyodide@314")
    build(tmp_path / "site", PYODIDE)
    with served(tmp_path / "site") as address:
        link = _first_visit(page, address, keep)
        page.evaluate("() => navigator.serviceWorker.ready.then(() => true)")
        page.evaluate(BREAK)
        page.context.set_offline(True)
        try:
            page.goto("about:blank")
            page.goto(link)  # without its compiled files, it compiles again
            expect(page.locator("#text")).to_have_value("bo $ repeat 3 (forward left)\n")
            wait(page, OPENED)
            assert page.evaluate("location.hash") == ""
            assert page.evaluate("improv.transport.generation") == 0  # nothing plays by itself
            page.get_by_role("button", name="Show it instead").click()  # the earlier text is not lost
            expect(page.locator("#text")).to_have_value("cy $ forward\n")
            page.get_by_role("button", name="Save and play").click()
            wait(page, "improv.robots.cy?.x > 0.5")
        finally:
            page.context.set_offline(False)


def _first_visit(page: Page, address: str, keep: Keep) -> str:
    """Open the website for the first time. Return a link to a dance that was written here; another one plays then."""
    page.goto(address)
    expect(page.locator("#notice")).to_contain_text(re.compile("Loading Improv:|Preparing Improv:"))  # one may be brief
    expect(page.locator("#text")).to_have_value(TEMPLATE)  # others may write it meanwhile
    wait(page, OPENED)
    page.locator("#text").fill("bo $ repeat 3 (forwrd left)\n")
    page.get_by_role("button", name="Change to forward").click()
    expect(page.locator("#text")).to_have_value("bo $ repeat 3 (forward left)\n")
    page.keyboard.press("Control+Enter")
    wait(page, "improv.robots.bo?.x > 0.5")
    keep(page, "site-playing.png")
    page.keyboard.press("Escape")
    page.locator("#stage").focus()
    page.keyboard.press("Escape")
    wait(page, 'improv.transport.state === "stopped"')

    page.get_by_role("button", name="Share").click()
    expect(page.locator("#code")).to_be_visible()
    keep(page, "site-share.png")
    link = page.locator("#link").input_value()
    page.get_by_role("button", name="Close").click()
    play(page, "cy $ forward\n")
    wait(page, "improv.robots.cy?.x > 0.5")
    return link


def test_the_waltz_of_the_gallery_plays_with_its_song(address: str, page: Page) -> None:
    open_site(page, address)
    page.locator("#stage").click()
    page.get_by_role("button", name="Examples").click()
    page.locator("#examples").get_by_role("button", name="waltz (music)").click()
    wait(page, "Math.abs(improv.song - (0.25 + (improv.beat * 60) / 144)) < 0.25")
    expect(page.locator("#song-line")).to_be_hidden()


def test_a_page_that_still_loads_shows_its_program_with_its_paths_and_what_is_wrong_with_its_link(
    built: Path, tmp_path: Path, page: Page, keep: Keep
) -> None:
    shutil.copytree(built, tmp_path / "site")
    (tmp_path / "site" / "worker.js").write_text("postMessage({ stage: 'Starting Python' })")
    with served(tmp_path / "site") as address:
        page.goto(address)
        expect(page.locator("#notice")).to_have_text("Starting Python")
        expect(page.locator("#state-word")).to_have_text("loading…")
        wait(page, "document.getElementById('still').naturalWidth > 100")
        expect(page.locator("#still")).to_be_visible()
        assert page.evaluate(COVERED) == [True, True], "the picture has another scale than the floor below"
        page.goto("about:blank")
        page.goto(f"{address}{fragment(text='ada $ left', still=[[0, 0, 0, 400, 0], [1, 0, 400, 400, -400]])}")
        wait(page, "document.getElementById('still').naturalWidth > 100")
        assert "l400 -400" in unquote(page.locator("#still").get_attribute("src") or "")
        keep(page, "site-still.png")
        page.goto("about:blank")
        page.goto(f"{address}#dance=q1YqU7Iy")
        expect(page.locator("#notice")).to_have_text(re.compile(r"^this link is broken.* \(Starting Python\)$"))


def test_a_page_tells_its_worker_how_much_it_loads(built: Path) -> None:
    sizes = {name: len(data) for name, data in content(built).items()}
    fetched = [name for name in sizes if name.startswith("pyodide/") and not name.endswith(".mjs")]
    told = re.search(r"bytes=(\d+)&amp;source=(\d+)", (built / "index.html").read_text())
    assert told
    assert int(told[2]) == sizes["improv.zip"]
    assert int(told[1]) == sum(sizes[name] for name in fetched) + sizes["improv.zip"]


def test_a_broken_link_says_so_and_the_page_works(address: str, page: Page) -> None:
    open_site(page, f"{address}#dance=q1YqU7Iy")
    expect(page.locator("#notice")).to_contain_text("this link is broken")
    play(page, "ada $ forward\n")
    wait(page, "improv.robots.ada?.x > 0.5")
