"""The browser of the page's tests, and a class in its processes."""

from __future__ import annotations

import re
import subprocess
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, NamedTuple

import pytest

from improv_core.website.build import build
from tests.commands.command_line import IMPROV
from tests.page.conftest import browser, chromium, keep, page, window
from tests.pyodide import imitate

__all__ = ["browser", "chromium", "keep", "page", "window"]


class Running(NamedTuple):
    """A class: its process, the children's address, the code, and the teacher's address."""

    process: subprocess.Popen[str]
    address: str
    code: str
    teacher: str


@pytest.fixture
def running(tmp_path: Path) -> Iterator[Running]:
    pyodide, site = tmp_path / "pyodide", tmp_path / "site"
    imitate(pyodide)  # no child plays in these tests
    build(site, pyodide)
    command = [*IMPROV, "class", str(site), "--address", "127.0.0.1", "--port", "0"]
    command += ["--folder", str(tmp_path / "dances")]
    with started(command) as running:
        yield running


@contextmanager
def started(command: Any) -> Iterator[Running]:
    """Run a class until it is terminated."""
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True) as process:
        assert process.stdout
        said = ""
        while not (found := re.search(r"children: (\S+), code (\S+)\s.*teacher: (\S+) ", said, re.DOTALL)):
            line = process.stdout.readline()
            assert line, said
            said += line
        yield Running(process, *found.groups())
        process.terminate()
        process.communicate(timeout=60)
