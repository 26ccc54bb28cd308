"""The browser of the page's tests, and a class in its processes."""

from __future__ import annotations

import re
import shutil
import subprocess
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, NamedTuple

import pytest

from tests.commands.command_line import IMPROV
from tests.page.conftest import browser, chromium, keep, page, violations, window
from tests.website.conftest import built, pyodide
from tests.website.native import keep_nothing

__all__ = ["browser", "built", "chromium", "keep", "page", "pyodide", "violations", "window"]


class Running(NamedTuple):
    """A class: its process, the children's address, the code, and the teacher's address."""

    process: subprocess.Popen[str]
    address: str
    code: str
    teacher: str


@pytest.fixture(scope="session")
def site(built: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The website of a class, of which browsers keep nothing."""
    site = shutil.copytree(built, tmp_path_factory.mktemp("class") / "site")
    keep_nothing(site)
    return site


@pytest.fixture
def running(site: Path, tmp_path: Path) -> Iterator[Running]:
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
