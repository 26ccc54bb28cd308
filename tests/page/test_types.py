"""The types in the JavaScript of the page and of the website's workers, which are JSDoc comments."""

from __future__ import annotations

import json
import subprocess
from pathlib import Path

import pytest

from tests.needs import need_extension

pytestmark = [pytest.mark.timeout(300), pytest.mark.slow("starts the TypeScript compiler")]

HERE = Path(__file__).parent
PAGE = HERE.parents[1] / "improv_core" / "page" / "static"
WORKERS = HERE.parent / "website"


def errors_in(project: Path) -> list[str]:
    compiler = need_extension() / "node_modules" / ".bin" / "tsc"
    checked = subprocess.run([compiler, "--project", project], capture_output=True, text=True, timeout=290, check=False)
    return [line for line in checked.stdout.splitlines() if ": error " in line]


def test_the_types_of_the_page_fit_together_and_a_wrong_one_is_found(tmp_path: Path) -> None:
    wrong = tmp_path / "wrong.js"
    wrong.write_text(
        f'// @ts-check\nimport {{ Clock }} from "{PAGE / "score" / "clock.js"}"\nnew Clock().isSilent(7)\n', "utf-8"
    )
    config = tmp_path / "tsconfig.json"
    checks = [str(HERE / "messages.d.ts"), str(PAGE / "**" / "*.js"), "wrong.js"]
    settings = {"extends": str(HERE / "tsconfig.json"), "include": checks}
    config.write_text(json.dumps(settings), encoding="utf-8")
    (error,) = errors_in(tmp_path)
    assert "wrong.js(3,22): error TS2345" in error


def test_the_types_of_the_workers_fit_together() -> None:
    # The page's own files never use in a worker the names that it lacks, such as `document`.
    assert [line for line in errors_in(WORKERS) if "improv_core/website/" in line.partition("(")[0]] == []
