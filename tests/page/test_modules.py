"""Modules of the page that need no browser, under node's own test runner: `modules/*.test.js`."""

from __future__ import annotations

import json
import re
import shutil
import subprocess
from pathlib import Path

import pytest

from tests.needs import lacking

TESTS = sorted(Path(__file__).with_name("modules").glob("*.test.js"))


@pytest.mark.slow("starts node")
def test_the_modules_of_the_page() -> None:
    if shutil.which("node") is None:
        lacking("node is not installed")
    written = {
        test.name: len(re.findall(r"^ *test\(", test.read_text(encoding="utf-8"), re.MULTILINE)) for test in TESTS
    }
    assert all(written.values()), written
    all_in_one = "".join(f"import {json.dumps(test.as_uri())};" for test in TESTS)  # with --test, each is a process
    options = ["--experimental-default-type=module", "--no-warnings", "--test-reporter=spec", "--input-type=module"]
    done = subprocess.run(
        ["node", *options, "-e", all_in_one], capture_output=True, text=True, timeout=290, check=False
    )
    assert done.returncode == 0, done.stdout
    (passed,) = re.findall(r"pass (\d+)", done.stdout)
    assert int(passed) >= sum(written.values())
