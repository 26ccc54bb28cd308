"""The website, served as any web server does, and the browser of the page's tests."""

from __future__ import annotations

import fcntl
import os
import shutil
from collections.abc import Iterator
from pathlib import Path

import pytest
from playwright.sync_api import Page

from improv_core.website.build import build
from tests.page.conftest import browser, chromium, keep, page, violations, wait, window
from tests.pyodide import imitate
from tests.web_server import served
from tests.website.native import homes, run_natively

__all__ = ["browser", "chromium", "keep", "page", "violations", "window"]

OPENED = 'document.body.dataset.connection === "open"'
"""True if the page has its Python."""


def open_site(page: Page, address: str) -> None:
    """Open the website, and wait until it can play."""
    page.goto(address)
    wait(page, OPENED)


def play(page: Page, text: str) -> None:
    """Write a program, and save it by its key."""
    page.locator("#text").fill(text)
    page.keyboard.press("Control+Enter")


@pytest.fixture(scope="session")
def pyodide(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder that looks like the npm package. No test changes it."""
    return imitate(tmp_path_factory.mktemp("npm") / "pyodide")


@pytest.fixture(scope="session")
def built(pyodide: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The website built from that package, once for all workers. No test changes it."""
    own = tmp_path_factory.getbasetemp()
    shared = own.parent if "PYTEST_XDIST_WORKER" in os.environ else own
    with (shared / "built.lock").open("w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        if not (shared / "built").exists():
            build(own / "draft", pyodide)
            (own / "draft").rename(shared / "built")
    return shared / "built"


@pytest.fixture(scope="session")
def natively(tmp_path_factory: pytest.TempPathFactory, built: Path) -> Iterator[Path]:
    """The website with its Python in this process, in a subfolder. No test changes it."""
    root = tmp_path_factory.mktemp("classes")
    shutil.copytree(built, root / "improv")
    with homes() as port:
        run_natively(root / "improv", port)
        yield root


@pytest.fixture
def address(natively: Path) -> Iterator[str]:
    """The address of that website, for one test: on its own port, for which a browser has kept nothing yet."""
    with served(natively) as root:
        yield f"{root}improv/"
