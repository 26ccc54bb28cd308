"""A real VS Code: its window, and the robot's movement."""

from __future__ import annotations

import os
import re
import signal
import subprocess
import sys
from collections.abc import Callable, Collection, Iterator, Mapping
from contextlib import contextmanager, suppress
from pathlib import Path
from urllib.parse import quote, urlsplit

import pygls
import pytest
from playwright.sync_api import Frame, Locator, Page, expect

from tests.editors.editors import LIMIT, ROOT, kill_servers, nothing_left, servers_from, slow_server, started_from
from tests.editors.vscode.workbench import PATIENCE, VSCode, framed, framed_page, keep_picture, run_command, word
from tests.editors.vscode.workbench import vscode as started
from tests.waiting import until

pytestmark = pytest.mark.slow("drives VS Code")

PROGRAM = "beat 120\n\nturtle1 $ repeat (forward lft)\n"
SERVER = str(Path(sys.executable).with_name("improv-ls"))
LINK = "[Click](command:workbench.action.terminal.new)"
"""A link in a notification would run any command with one click, even in a workspace that is not trusted."""
IS_LIT = """text => {
  const boxes = selector => [...document.querySelectorAll(selector)].map(
    each => [each.textContent.trim(), each.getBoundingClientRect()])
  const near = (a, b) => Math.abs(a.left - b.left) < 2 && Math.abs(a.right - b.right) < 2 && Math.abs(a.top - b.top) < 9
  const lit = boxes(".view-overlays [class*=TextEditorDecorationType]")
  const words = boxes(".view-line span:not(:has(span))")
  return words.some(([word, its]) => word === text && lit.some(([, light]) => near(light, its)))
}"""
"""A function that returns whether a word of the program is highlighted without its neighbors."""


@pytest.fixture(scope="module")
def vscode(tmp_path_factory: pytest.TempPathFactory) -> Iterator[VSCode]:
    """A VS Code that finds no server on the `PATH`. There, pip installs no packages from the network."""
    with nothing_left() as env:
        folders = [each for each in env["PATH"].split(os.pathsep) if not (Path(each) / "improv-ls").exists()]
        env |= {"PATH": os.pathsep.join(folders), "PYTHONPATH": str(Path(pygls.__file__).parents[1])}
        env |= {"PIP_NO_COMPILE": "1", "PIP_NO_DEPS": "1", "PIP_NO_INDEX": "1"}
        with started(tmp_path_factory.mktemp("vscode"), env) as it:
            yield it


@pytest.mark.timeout(2 * LIMIT)
def test_a_missing_server_is_installed_and_a_wrong_one_replaced(vscode: VSCode, tmp_path: Path) -> None:
    settings = {"improv.backend": "sim"}
    with vscode.window(tmp_path / "work", PROGRAM, settings, {"improv.switchAt": LINK}) as page:
        _installs_its_server(page, vscode.folder)
        _wrong_servers_are_replaced_and_notifications_hold_no_links(page, vscode)


def _installs_its_server(page: Page, folder: Path) -> None:
    missing = _toast(page, "Improv can't find its language server")
    expect(missing).to_be_visible()
    run_command(page, "Notifications: Clear All Notifications")
    expect(missing).to_have_count(0)
    _status(page).click()
    missing.get_by_role("button", name="Install…").click()
    dialog = page.locator(".monaco-dialog-box")
    expect(dialog).to_contain_text(re.compile(r"Improv 0\.\d+\.\d+, which comes with this extension.*pygls.*lark"))
    keep_picture(page, "install")
    dialog.get_by_role("button", name="Install").click()
    expect(page.locator(".squiggly-error")).to_have_count(1, timeout=LIMIT * 1000)
    run_command(page, "Improv: Show Versions")
    expect(_toast(page, "improv-ls")).to_contain_text(str(folder))
    run_command(page, "Notifications: Clear All Notifications")


def _wrong_servers_are_replaced_and_notifications_hold_no_links(page: Page, vscode: VSCode) -> None:
    hanging = vscode.folder / "hanging"
    hanging.write_text("#!/bin/sh\nexec sleep 1000\n")
    hanging.chmod(0o755)

    def use_server(path: object) -> None:
        vscode.set_machine_settings({"improv.backend": "sim", "improv.server.path": str(path)})

    use_server(hanging)
    expect(_status(page)).to_have_text("Starting Improv…")
    use_server(SERVER)
    expect(_status(page)).to_have_text("Improv")
    expect(page.locator(".squiggly-error")).to_have_count(1)
    expect(page.locator(".notification-toast")).to_have_count(0)

    use_server(f"/nowhere/{LINK}")
    _has_no_link(_toast(page, "/nowhere/"))
    use_server(SERVER)
    expect(page.locator(".squiggly-error")).to_have_count(1)
    expect(_toast(page, "improv.switchAt")).to_have_count(0)
    run_command(page, "Workspaces: Manage Workspace Trust")
    page.get_by_role("button", name="Trust", exact=True).first.click()
    _has_no_link(_toast(page, "improv.switchAt"))


@pytest.mark.timeout(2 * LIMIT)
def test_requests_wait_for_a_server_that_starts(vscode: VSCode, tmp_path: Path) -> None:
    server, gate = slow_server(tmp_path)
    settings = {"improv.server.path": str(server), "improv.backend": "sim", "security.workspace.trust.enabled": False}
    env = vscode.env
    with vscode.window(tmp_path / "work", PROGRAM.replace("lft", "left"), settings) as page:
        expect(_status(page)).to_have_text("Starting Improv…")
        word(page, "forward").click()
        page.keyboard.press("End")
        page.keyboard.type(" ")
        page.keyboard.press("Control+S")
        until(lambda: "left) \n" in (tmp_path / "work" / "dance.improv").read_text(), lambda: "it is never saved")
        expect(page.locator(".tab.active")).not_to_have_class(re.compile(r"\bdirty\b"))  # VS Code has noticed that
        page.keyboard.type("(rig")
        gate.touch()
        _plays(page)  # what was saved, not what was half typed
        keep_picture(page, "half-typed")
        for _ in "(rig":
            page.keyboard.press("Backspace")
        page.keyboard.press("Control+S")

        _escape_twice(page, "Control+F", ".find-widget.visible")
        word(page, "repeat").click()
        page.keyboard.press("Control+Enter")
        _plays(page)
        _the_context_menu_plays(page)
        _a_killed_server_says_that_the_dance_ended(page, env)
        _a_server_that_is_killed_again_and_again_is_started_by_a_save(page, env)
        _one_server_plays_the_requests_between_restarts(page, env, gate)
        _robots_files_have_colors(page, tmp_path / "work")
        assert _stages(env)  # and it ends with the window


@pytest.mark.timeout(2 * LIMIT)
def test_colors_and_snippets_where_no_server_can_run(vscode: VSCode, tmp_path: Path) -> None:
    """In the browser's extension host, as on vscode.dev. Also, the extension's page has its picture."""
    settings = {"remote.extensionKind": {"improv.improv": ["web"]}, "security.workspace.trust.enabled": False}
    with vscode.window(tmp_path / "work", PROGRAM, settings) as page:
        word(page, "forward").click()
        run_command(page, "Improv: Show Menu")
        expect(_toast(page, "This window has only colors and snippets for Improv")).to_be_visible()
        word(page, "forward").click()
        colors = {name: _color(word(page, name)) for name in ("beat", "120", "turtle1", "repeat", "forward")}
        assert len(set(colors.values())) == len(colors), colors
        page.keyboard.press("Control+End")
        page.keyboard.type("squee")
        page.keyboard.press("Control+Space")
        expect(page.locator(".suggest-widget .monaco-list-row", has_text="squeeze").first).to_be_visible()
        page.keyboard.press("Escape")
        assert servers_from(vscode.env) == []

        page.keyboard.press("Control+Shift+X")
        page.locator(".extension-list-item", has_text="Improv").first.click()
        picture = framed(page).locator("img[alt*='Two robots draw']")
        page.wait_for_function("picture => picture.naturalWidth > 100", arg=picture.element_handle())
        keep_picture(page, "web")


@pytest.mark.timeout(2 * LIMIT)
def test_session(vscode: VSCode, tmp_path: Path) -> None:
    """The last of these tests, because it kills the VS Code that they share."""
    settings = {"improv.server.path": SERVER, "improv.backend": "sim"}
    with vscode.window(tmp_path / "work", PROGRAM, settings) as page:
        _nothing_moves_in_a_workspace_that_is_not_trusted(page, vscode.env)
        _words_are_checked_and_explained(page)
        _a_save_plays(page)
        robots = _robots(_frame(page))
        _the_words_that_play_are_lit(page)
        _a_wrong_save_changes_nothing(page, robots)
        _keys_stop_the_robots(page, robots)
        _a_new_server_plays(page)
        _the_one_before_plays_and_the_history_shows_it(page)
        _only_a_line_plays(page)
        _kill_the_editor(vscode.env)


def _wait_until_lit(page: Page, name: str) -> None:
    page.wait_for_function(IS_LIT, arg=name, polling=100)  # in milliseconds: it looks at all boxes of the text


def _retype(page: Page, old: str, new: str) -> None:
    _select(page, old)
    page.keyboard.type(new)
    expect(word(page, new)).to_be_visible()


def _select(page: Page, name: str) -> None:
    """Select a word. Lines may move between two clicks on a busy machine, which then hit two places."""
    selected = page.get_by_role("button", name=f"({len(name)} selected)")
    _until_visible(selected, lambda: word(page, name).dblclick())


def _open_actions(page: Page) -> None:
    """Open the actions. A change while VS Code waits for them, such as colors after a save, keeps their menu closed."""
    _until_visible(page.locator(".action-widget"), lambda: page.keyboard.press("Control+."))


def _until_visible(shown: Locator, ask: Callable[[], object]) -> None:
    """Ask for something, and again if it doesn't show soon."""
    for _ in range(10):
        ask()
        with suppress(AssertionError):
            expect(shown).to_be_visible(timeout=PATIENCE * 100)
            return
    expect(shown).to_be_visible()


def _escape_twice(page: Page, key: str, widget: str) -> None:
    """With a widget open, two Escapes close it and stop the robots. On a busy machine, they may come too slowly."""
    for _ in range(10):
        if not page.locator(widget).is_visible():
            page.keyboard.press(key)
        expect(page.locator(widget)).to_be_visible()
        page.keyboard.press("Escape")
        page.keyboard.press("Escape")
        expect(page.locator(widget)).to_be_hidden()
        with suppress(AssertionError):
            expect(_status(page)).to_have_text("Improv: stopped · simulator", timeout=PATIENCE * 100)
            return
    raise AssertionError("two Escapes do not stop the robots")


def _choose_in_menu(page: Page, item: str) -> None:
    page.locator(".monaco-menu").get_by_text(item, exact=True).hover()
    page.keyboard.press("Enter")  # for 100 ms, the menu ignores the mouse


def _plays(page: Page) -> None:
    expect(_status(page)).to_have_text(re.compile(r"beat \d+/∞"))


def _the_context_menu_plays(page: Page) -> None:
    for item, shown in (("Stop Robots", "Improv: stopped · simulator"), ("Play", re.compile(r"beat \d+/∞"))):
        word(page, "forward").click(button="right")
        _choose_in_menu(page, item)
        expect(_status(page)).to_have_text(shown)


def _a_killed_server_says_that_the_dance_ended(page: Page, env: Mapping[str, str]) -> None:
    kill_servers(env)
    expect(_toast(page, "so the robots stopped")).to_be_visible()
    keep_picture(page, "killed")
    run_command(page, "Notifications: Clear All Notifications")


def _a_server_that_is_killed_again_and_again_is_started_by_a_save(page: Page, env: Mapping[str, str]) -> None:
    for _ in range(3):
        expect(_status(page)).to_have_text("Improv")
        killed = kill_servers(env)
        until(lambda: set(servers_from(env)) - set(killed), lambda: "no server was started again")  # noqa: B023
    _retype(page, "left", "lft")
    expect(page.locator(".squiggly-error")).to_have_count(1)
    page.keyboard.press("Control+S")
    expect(_status(page)).to_have_text(re.compile(r"`lft` is not defined"))
    kill_servers(env)
    expect(_toast(page, "ended five times within three minutes")).to_be_visible()
    expect(_status(page)).to_have_text("Improv: server not running")
    keep_picture(page, "given-up")
    run_command(page, "Notifications: Clear All Notifications")
    _retype(page, "lft", "left")
    page.keyboard.press("Control+S")
    _plays(page)


def _robots_files_have_colors(page: Page, folder: Path) -> None:
    (folder / "improv.toml").write_text('# one\n[robots.turtle1]\nprofile = "turtlesim"\n')
    page.get_by_role("treeitem", name="improv.toml").dblclick()
    expect(page.locator(".view-line", has_text=re.compile(r"#\sone"))).to_be_visible()
    leaves = page.locator(".view-line span:not(:has(span))")

    def colors() -> set[str]:
        return {_color(leaves.filter(has_text=each).first) for each in ("one", "robots", '"')}

    until(lambda: len(colors()) == 3, lambda: f"only these colors: {colors()}")


def _has_no_link(toast: Locator) -> None:
    expect(toast.first).to_contain_text("Click")
    assert toast.locator("a[href], .notification-list-item-message a").count() == 0


def _nothing_moves_in_a_workspace_that_is_not_trusted(page: Page, env: Mapping[str, str]) -> None:
    expect(page.locator(".squiggly-error")).to_have_count(1)
    word(page, "forward").click()
    page.keyboard.press("Control+S")
    page.keyboard.press("Control+Enter")
    refusal = _toast(page, "Robots move only in a workspace that you trust")
    assert not _stages(env)
    refusal.get_by_role("button", name="Manage Trust").click()
    page.get_by_role("button", name="Trust", exact=True).first.click()
    page.get_by_role("tab", name="dance.improv").click()


def _words_are_checked_and_explained(page: Page) -> None:
    assert _color(word(page, "lft")) != _color(word(page, "forward"))
    hover = _explained(page, "forward")
    expect(hover).to_contain_text("1 beat, 0.50 s at beat 120")
    picture = hover.locator("img[src^='data:image/svg']")
    page.wait_for_function("picture => picture.naturalWidth > 100", arg=picture.element_handle())
    keep_picture(page, "hover")
    page.keyboard.press("Escape")
    word(page, "lft").hover()
    expect(page.locator(".monaco-hover:visible a", has_text="unknown-name")).to_be_visible()  # links to its section
    page.keyboard.press("Escape")

    _retype(page, "lft", "left")
    expect(page.locator(".squiggly-error")).to_have_count(0)


def _a_save_plays(page: Page) -> None:
    page.keyboard.press("Control+S")
    expect(_status(page)).to_have_text(re.compile(r"beat \d+/∞ · 120 beats/min · simulator"))
    expect(framed_page(page).get_by_role("button", name="Stop")).to_be_visible()
    drawn = _frame(page).evaluate("document.querySelector('#stage').toDataURL()")
    _frame(page).wait_for_function("drawn => document.querySelector('#stage').toDataURL() !== drawn", arg=drawn)
    expect(page.locator(".notification-toast")).to_have_count(0)
    run_command(page, "Preferences: Toggle between Light/Dark Themes")
    _frame(page).wait_for_function("() => matchMedia('(prefers-color-scheme: dark)').matches")


def _the_words_that_play_are_lit(page: Page) -> None:
    for name in ("forward", "left", "forward"):
        _wait_until_lit(page, name)
    keep_picture(page, "playing")
    word(page, "beat").click()
    page.keyboard.press("Home")
    page.keyboard.press("Enter")
    page.keyboard.press("ArrowUp")
    page.keyboard.type("# A line above moves them.")
    for name in ("forward", "left", "forward"):
        _wait_until_lit(page, name)


def _a_wrong_save_changes_nothing(page: Page, robots: str) -> None:
    _retype(page, "left", "lft")
    expect(page.locator(".squiggly-error")).to_have_count(1)
    page.keyboard.press("Control+S")
    expect(_status(page)).to_have_text(re.compile(r"line 4: `lft` is not defined.*beat \d+/∞$"))
    keep_picture(page, "wrong-save")
    _robot(robots, "moves")
    _wait_until_lit(page, "forward")
    _retype(page, "lft", "left")
    expect(_status(page)).to_have_text(re.compile(r"^ ?beat \d+/∞"))
    page.keyboard.press("Control+S")


def _keys_stop_the_robots(page: Page, robots: str) -> None:
    _wait_until_lit(page, "left")
    _select(page, "left")  # surely: a selection that changes ends the menu
    _open_actions(page)
    expect(page.locator(".action-widget", has_text="Stop all robots")).to_be_visible()
    keep_picture(page, "actions")
    page.keyboard.press("Escape")
    expect(page.locator(".action-widget")).to_be_hidden()
    _plays(page)
    page.keyboard.press("Alt+.")
    expect(_status(page)).to_have_text("Improv: stopped · simulator")
    keep_picture(page, "stopped")
    _robot(robots, "stands")
    expect(page.locator(".view-overlays [class*=TextEditorDecorationType]")).to_have_count(0)
    page.keyboard.press("Control+Space")
    expect(page.locator(".suggest-widget")).to_be_visible()
    page.keyboard.press("Control+Enter")
    _plays(page)
    _escape_twice(page, "Control+Space", ".suggest-widget")


def _one_server_plays_the_requests_between_restarts(page: Page, env: Mapping[str, str], gate: Path) -> None:
    gate.unlink()
    with _halted_server(env) as ending:
        _restart(page)
        _restart(page)
        run_command(page, "Improv: Show Versions")
        expect(_toast(page, "no language server")).to_be_visible()  # then the extension has handled both restarts
    run_command(page, "Notifications: Clear All Notifications")
    (starting,) = until(lambda: _only_server(env, [ending]), lambda: "the server before it does not end")
    word(page, "forward").click()
    page.keyboard.press("Control+S")
    for _ in range(3):
        page.keyboard.press("Control+Enter")
    gate.touch()
    _plays(page)
    assert servers_from(env) == [starting]


@contextmanager
def _halted_server(env: Mapping[str, str]) -> Iterator[int]:
    """Halt the server. If that takes longer than ten seconds on a busy machine, VS Code kills it."""
    (server,) = until(lambda: _only_server(env, ()), lambda: "there is no server, or more than one")
    os.kill(server, signal.SIGSTOP)
    yield server
    with suppress(ProcessLookupError):
        os.kill(server, signal.SIGCONT)


def _restart(page: Page) -> None:
    """Restart the server. The status bar may show the previous dance for a moment."""
    run_command(page, "Improv: Restart Language Server")
    expect(_status(page)).to_have_text("Starting Improv…")


def _only_server(env: Mapping[str, str], before: Collection[int]) -> list[int]:
    """Return the server, unless another one is there, such as an earlier one or a process that it is just starting."""
    found = servers_from(env)
    return found if len(found) == 1 and found[0] not in before else []


def _a_new_server_plays(page: Page) -> None:
    run_command(page, "Improv: Restart Language Server")
    expect(_status(page)).to_have_text("Improv")
    with page.expect_event("framenavigated", lambda frame: "ticket=" in frame.url) as frame:
        page.locator(".codelens-decoration a", has_text="▶ play · ∞").click()  # a lens that no server knows is no link
    _plays(page)
    expect(framed_page(page).locator("#state")).to_have_text("playing")
    _robot(_robots(frame.value), "moves")
    expect(_explained(page, "forward")).to_contain_text("1 beat")


def _the_one_before_plays_and_the_history_shows_it(page: Page) -> None:
    word(page, "forward").click()
    page.keyboard.press("Alt+.")
    expect(_status(page)).to_have_text("Improv: stopped · simulator")
    run_command(page, "Improv: Play the One Before")
    _plays(page)
    run_command(page, "Improv: Show History")
    rows = page.locator(".quick-input-list .monaco-list-row", has_text="dance.improv")
    expect(rows.first).to_contain_text("turtle1 $ repeat (forward left)")
    keep_picture(page, "history")
    rows.first.click()
    expect(page.get_by_role("tab", name="Untitled-1")).to_be_visible()
    expect(word(page, "forward")).to_be_visible()
    expect(page.locator(".view-line", has_text="A line above")).to_have_count(0)


def _only_a_line_plays(page: Page) -> None:
    """Play only a line, and mute its robots in the context menu. No lens comes meanwhile, which would move lines."""
    page.get_by_role("tab", name="dance.improv").click()  # the history has opened another
    expect(page.locator(".view-line", has_text="A line above")).to_have_count(1)
    lit = page.locator(".view-overlays [class*=TextEditorDecorationType]")
    word(page, "forward").click()
    page.keyboard.press("End")
    page.keyboard.type("\nbob $ repeat right")
    page.keyboard.press("Control+Shift+Enter")
    _wait_until_lit(page, "right")
    page.keyboard.press("Shift+F10")
    _choose_in_menu(page, "Play Only This Line or Selection")
    expect(lit).to_have_count(1)
    page.keyboard.press("Control+S")
    expect(lit).to_have_count(2)
    keep_picture(page, "lenses")
    expect(page.locator(".codelens-decoration", has_text="▶")).to_have_count(1)
    page.keyboard.press("Shift+F10")
    keep_picture(page, "context-menu")
    _choose_in_menu(page, "Mute or Unmute Robots of This Line")
    expect(lit).to_have_count(1)
    _wait_until_lit(page, "left")


def _kill_the_editor(env: Mapping[str, str]) -> None:
    """Kill all of its processes at once, with no time for a message; the stage stops its robots before it ends."""
    assert _stages(env)
    for pid in started_from(env):
        with suppress(OSError):
            if Path(f"/proc/{pid}/exe").readlink().name == "node":
                os.kill(pid, signal.SIGKILL)


def _explained(page: Page, name: str) -> Locator:
    """Show the hover of a word. Lines may still move from under the mouse as lenses above them come."""
    hover = page.locator(".monaco-hover:visible", has_text=f"{name}: ")

    def point() -> None:
        page.mouse.move(0, 0)
        word(page, name).hover()

    _until_visible(hover, point)
    return hover


def _status(page: Page) -> Locator:
    return page.locator(".statusbar-item[id$='improv.status']")


def _toast(page: Page, text: str) -> Locator:
    return page.locator(".notification-toast", has_text=text)


def _color(its: Locator) -> str:
    return str(its.evaluate("element => getComputedStyle(element).color"))


def _frame(page: Page) -> Frame:
    return next(frame for frame in page.frames if urlsplit(frame.url).path.startswith("/proxy/"))


def _robots(frame: Frame) -> str:
    """Return the page's own address with its token: the frame has the address of code-server's proxy."""
    token = frame.evaluate("import('./net/token.js').then(({ token }) => token)")
    return f"http://127.0.0.1:{urlsplit(frame.url).path.split('/')[2]}/?token={quote(token)}"


def _robot(url: str, does: str) -> None:
    # A process of its own: playwright's event loop runs in this one.
    subprocess.run([sys.executable, "-m", "tests.editors.robot", url, does], cwd=ROOT, check=True)


def _stages(env: Mapping[str, str]) -> list[int]:
    return [pid for pid, its in started_from(env).items() if "IMPROV_PAGE_TOKEN" in its]
