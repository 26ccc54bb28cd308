"""docs/lsp.md has every method that is served, and names tests that exist."""

from __future__ import annotations

import re

from tests.lsp_table import PAGE, ROOT, claims, served


def test_every_method_has_its_proof_and_no_other_is_there() -> None:
    from_editors, from_server = PAGE.read_text(encoding="utf-8").split("## From the server")
    rows = re.findall(r"^\| `([^`]+)` \|.*\[`test_", from_editors, re.MULTILINE)
    assert set(rows) == served(), "run python -m tests.lsp_table"
    assert re.findall(r"^\| `([^`]+)` \|.*\[`test_", from_server, re.MULTILINE)


def test_the_tests_exist() -> None:
    for test in claims():
        file, _, name = test.partition("::")
        source = (ROOT / file).read_text(encoding="utf-8")
        assert f"def {name}(" in source, f"{test}: run python -m tests.lsp_table"
