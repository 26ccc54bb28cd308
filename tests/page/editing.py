"""`improv edit` in the test's own process, and pages that write with it."""

from __future__ import annotations

from pathlib import Path

from playwright.sync_api import BrowserContext, Page

from improv_core.protocol.tickets import issue
from tests.commands.command_line import Running
from tests.open_page import token_behind
from tests.page.conftest import leave, new_page, wait

IDLE = "document.querySelector('#file-state').textContent === 'saved'"
PLAYING = "improv.transport.state === 'playing'"


class Edit:
    """`improv edit` on one file, on a thread, and pages of it in one window."""

    def __init__(self, file: Path, window: BrowserContext, *options: str) -> None:
        self.file = file
        self._running = Running("edit", file, "--backend", "sim", "--no-browser", *options)
        self.wait = self._running.wait
        url = self.wait("watch it at").split()[-1]
        self._token, self._address = token_behind(url), url.partition("?")[0]
        self._window = window
        self._pages: list[tuple[Page, list[str]]] = []

    def page(self) -> Page:
        """Open another page of the program."""
        page, wrong = new_page(self._window)
        self._pages.append((page, wrong))
        page.goto(f"{self._address}?ticket={issue(self._token)}")
        wait(page, f"window.improv?.connected && {IDLE}")
        return page

    def close(self) -> None:
        for page, _ in self._pages:
            leave(page)
        self._running.close()
        assert [wrong for _, wrong in self._pages if wrong] == []
