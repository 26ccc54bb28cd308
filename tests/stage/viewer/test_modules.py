"""Modules of the page that need no browser, under node's own test runner: `modules/*.test.js`."""

from __future__ import annotations

import re
import shutil
import subprocess
from pathlib import Path

import pytest

from tests.needs import lacking

TESTS = sorted(Path(__file__).with_name("modules").glob("*.test.js"))


@pytest.mark.slow("starts node for each module")
def test_the_modules_of_the_page() -> None:
    if shutil.which("node") is None:
        lacking("node is not installed")
    options = ["--experimental-default-type=module", "--no-warnings", "--test", "--test-reporter=spec"]
    done = subprocess.run(["node", *options, *TESTS], capture_output=True, text=True, timeout=110, check=False)
    assert done.returncode == 0, done.stdout
    (passed,) = re.findall(r"pass (\d+)", done.stdout)
    assert int(passed) > len(TESTS)  # a file without tests counts as one that passes
