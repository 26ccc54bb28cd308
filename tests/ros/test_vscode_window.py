"""VS Code in a browser, and real robots: they keep dancing while its tab is hidden, and pause if the browser dies.

VS Code itself keeps running in both cases: it waits hours for its window to come back.
"""

from __future__ import annotations

import asyncio
import os
import signal
import subprocess
import sys
import time
from collections.abc import Iterator, Mapping
from contextlib import contextmanager, suppress
from itertools import count
from pathlib import Path
from typing import Any

import pytest
from aiohttp import ClientSession
from playwright.sync_api import Page, expect, sync_playwright

from tests.editors.editors import LIMIT as SESSION_LIMIT
from tests.editors.editors import nothing_left, program_of, started_from
from tests.editors.vscode.workbench import FLAGS, PATIENCE, code_server, framed_page, opened, word
from tests.needs import need
from tests.ros.conftest import Listen
from tests.ros.dance import BEFORE, BEFORE_SPEED, at_speed, moving, still
from tests.waiting import until

pytestmark = [pytest.mark.slow("drives VS Code, and waits for robots"), pytest.mark.timeout(2 * SESSION_LIMIT)]

SERVER = str(Path(sys.executable).with_name("improv-ls"))
SETTINGS = {"improv.server.path": SERVER, "improv.backend": "both", "security.workspace.trust.enabled": False}
FROZEN = 15.0
"""Seconds for which the hidden tab is frozen. It doesn't answer then, as when its timers run only once a minute, which
would take minutes to begin."""
LATEST = 20.0
"""Seconds until robots stand on a busy machine."""


def test_robots_dance_on_while_the_tab_is_hidden_and_pause_when_the_browser_is_killed(
    listen: Listen, alone: Mapping[str, str], tmp_path: Path
) -> None:
    robot = listen("/turtle1/cmd_vel")
    with nothing_left() as marked:
        env = {**alone, "IMPROV_TEST": marked["IMPROV_TEST"]}
        with code_server(tmp_path, env) as address, a_browser(tmp_path / "profile") as (browser, port):
            with its_page(port) as page, opened(page, address, tmp_path, tmp_path / "work", BEFORE, SETTINGS, {}):
                status = page.locator(".statusbar-item[id$='improv.status']")
                expect(status).to_have_text("Improv")  # from then on it gets each save
                word(page, "forward").click()
                page.keyboard.press("Control+S")
                robot.wait(at_speed(BEFORE_SPEED))
                expect(status).to_contain_text("ROS 2")
                expect(framed_page(page).locator("#state")).to_have_text("playing")  # it is connected
            asyncio.run(freeze(port, address))
            frozen = time.monotonic()
            robot.hear_all()
            robot.heard.clear()
            while time.monotonic() < frozen + FROZEN:
                robot.wait(moving)
            assert not any(map(still, robot.heard))
            os.kill(browser, signal.SIGKILL)
            killed = time.monotonic()
            assert robot.wait(still)["at"] - killed < LATEST
            assert any(program_of(pid) == "node" for pid in started_from(env)), "VS Code has not ended"
            for pid in started_from(env):
                if program_of(pid) == "node":
                    with suppress(ProcessLookupError):
                        os.kill(pid, signal.SIGKILL)


@contextmanager
def a_browser(profile: Path) -> Iterator[tuple[int, int]]:
    """Run our own browser, and yield its process and the port on which it takes commands.

    Playwright's would never hide a tab.
    """
    command = [need("chromium"), *FLAGS, f"--user-data-dir={profile}", "--remote-debugging-port=0", "about:blank"]
    browser = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    try:
        ports = profile / "DevToolsActivePort"
        until(lambda: ports.exists() and "\n" in ports.read_text(), lambda: "the browser does not start")
        yield browser.pid, int(ports.read_text().split()[0])
    finally:
        browser.kill()
        browser.wait(PATIENCE)


@contextmanager
def its_page(port: int) -> Iterator[Page]:
    """Yield the only tab. After this, it stays open by itself."""
    with sync_playwright() as playwright:
        page = playwright.chromium.connect_over_cdp(f"http://127.0.0.1:{port}").contexts[0].pages[0]
        page.set_viewport_size({"width": 1280, "height": 800})
        page.set_default_timeout(PATIENCE * 1000)
        expect.set_options(timeout=PATIENCE * 1000)
        yield page


async def freeze(port: int, address: str) -> None:
    """Put another tab in front of the one that shows this address, and freeze that one."""
    async with ClientSession() as session:
        version = await (await session.get(f"http://127.0.0.1:{port}/json/version")).json()
        async with session.ws_connect(version["webSocketDebuggerUrl"], max_msg_size=0) as socket:
            numbers = count(1)

            async def ask(method: str, **params: Any) -> Any:
                number = next(numbers)
                within = {"sessionId": params.pop("within")} if "within" in params else {}
                await socket.send_json({"id": number, "method": method, "params": params, **within})
                while (answer := await socket.receive_json()).get("id") != number:
                    pass
                return answer["result"]

            tabs = (await ask("Target.getTargets"))["targetInfos"]
            (tab,) = (each["targetId"] for each in tabs if each["type"] == "page" and each["url"].startswith(address))
            within = (await ask("Target.attachToTarget", targetId=tab, flatten=True))["sessionId"]
            other = (await ask("Target.createTarget", url="about:blank"))["targetId"]
            await ask("Target.activateTarget", targetId=other)
            end = time.monotonic() + PATIENCE
            is_hidden: Mapping[str, Any] = {}
            while is_hidden.get("value") is not True:
                assert time.monotonic() < end, "the tab is never hidden"
                asked = await ask("Runtime.evaluate", within=within, expression="document.hidden")
                is_hidden = asked["result"]
            await ask("Page.setWebLifecycleState", within=within, state="frozen")
