"""The types in the page's JavaScript, which are JSDoc comments."""

from __future__ import annotations

import shutil
import subprocess
from pathlib import Path

from tests.needs import lacking

HERE = Path(__file__).parent
VSCODE = HERE.parents[2] / "editors" / "vscode"
TSC = VSCODE / "node_modules" / ".bin" / "tsc"


def check(*arguments: str | Path) -> subprocess.CompletedProcess[str]:
    if not TSC.exists() or shutil.which("node") is None:
        lacking(f"TypeScript is not installed: npm ci --prefix {VSCODE.relative_to(HERE.parents[2])}")
    return subprocess.run([TSC, *arguments], capture_output=True, text=True, timeout=110, check=False)


def test_the_types_of_the_page_fit_together() -> None:
    checked = check("--project", HERE)
    assert (checked.returncode, checked.stdout) == (0, "")


def test_a_wrong_type_is_found(tmp_path: Path) -> None:
    """The check reads the page's files, and fails if one of them is wrong."""
    clock = HERE.parents[2] / "improv_core" / "stage" / "viewer" / "page" / "clock.js"
    wrong = tmp_path / "wrong.js"
    wrong.write_text(f'// @ts-check\nimport {{ Clock }} from "{clock}"\nnew Clock().isSilent(7)\n', encoding="utf-8")
    config = tmp_path / "tsconfig.json"
    config.write_text(f'{{"extends": "{HERE / "tsconfig.json"}", "include": ["wrong.js"]}}', encoding="utf-8")
    checked = check("--project", tmp_path)
    assert checked.returncode != 0
    assert "wrong.js(3,22): error TS2345" in checked.stdout
