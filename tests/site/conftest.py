"""The website, served as any web server does, and the browser of the page's tests."""

from __future__ import annotations

import functools
import http.server
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest

from improv_core.site.website import build
from tests.needs import lacking
from tests.pyodide import imitate
from tests.stage.viewer.conftest import browser, chromium, keep, page, window

__all__ = ["browser", "chromium", "keep", "page", "window"]

PYODIDE_HERE = Path(__file__).parents[2] / ".cache" / "pyodide" / "node_modules" / "pyodide"


@pytest.fixture
def pyodide(tmp_path: Path) -> Path:
    """A folder that looks like the npm package."""
    return imitate(tmp_path / "pyodide")


class _Quiet(http.server.SimpleHTTPRequestHandler):
    def log_message(self, format: str, *arguments: object) -> None:
        """Say nothing."""


@contextmanager
def served(folder: Path) -> Iterator[str]:
    """Where a plain web server serves a folder."""
    handler = functools.partial(_Quiet, directory=str(folder))
    with http.server.ThreadingHTTPServer(("127.0.0.1", 0), handler) as server:
        threading.Thread(target=server.serve_forever, daemon=True).start()
        yield f"http://127.0.0.1:{server.server_port}/"
        server.shutdown()


@pytest.fixture
def address(tmp_path: Path) -> Iterator[str]:
    """Where the website is served, in a folder of a plain web server."""
    if not PYODIDE_HERE.exists():
        lacking("Pyodide is missing: npm install --no-save --prefix .cache/pyodide pyodide@314")
    build(tmp_path / "classes" / "improv", PYODIDE_HERE)
    with served(tmp_path) as root:
        yield f"{root}classes/improv/"
