"""The types in the JavaScript of the website's workers, which are JSDoc comments."""

from __future__ import annotations

import subprocess
from pathlib import Path

import pytest

from tests.needs import need_extension

HERE = Path(__file__).parent


@pytest.mark.timeout(300)
@pytest.mark.slow("starts the TypeScript compiler")
def test_the_types_of_the_workers_fit_together() -> None:
    compiler = need_extension() / "node_modules" / ".bin" / "tsc"
    checked = subprocess.run([compiler, "--project", HERE], capture_output=True, text=True, timeout=290, check=False)
    # The page's own files never use in a worker the names that it lacks, such as `document`.
    assert [line for line in checked.stdout.splitlines() if "improv_core/website/" in line.partition("(")[0]] == []
