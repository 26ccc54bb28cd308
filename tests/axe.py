"""Errors that axe finds on a page for people who use it with a keyboard or a screen reader."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from playwright.sync_api import Page

from tests.needs import lacking

AXE = Path(__file__).parents[1] / ".cache" / "axe" / "node_modules" / "axe-core" / "axe.min.js"
Violations = Callable[[Page], list[tuple[str, list[str]]]]


@pytest.fixture(scope="session")
def violations() -> Violations:
    """Return a function that returns the rules that a page breaks, and the elements that break them. Without axe, skip
    the test before it opens a page."""
    if not AXE.exists():
        lacking("axe-core is not installed: npm install --no-save --prefix .cache/axe axe-core")
    axe = AXE.read_text(encoding="utf-8")

    def violations(page: Page) -> list[tuple[str, list[str]]]:
        if not page.evaluate("'axe' in window"):
            page.evaluate(axe)
        found: list[dict[str, Any]] = page.evaluate("axe.run().then(({ violations }) => violations)")
        return [(rule["id"], [node["html"] for node in rule["nodes"]]) for rule in found]

    return violations
