"""docs/lsp.md lists every method that the server registers, with its handler and a test."""

from __future__ import annotations

import re
from pathlib import Path

from improv_ls.server import FEATURES, create_server

ROOT = Path(__file__).parents[2]
ROW = re.compile(r"^\| `([^`]+)` \| \[`([^`]+)`\]\(\.\./improv_ls/\2\) \| \[`(\w+)`\]\(\.\./([^)]+)\) \|$", re.M)
ROWS = ROW.findall((ROOT / "docs" / "lsp.md").read_text(encoding="utf-8"))
NOT_OURS = {"$/setTrace", "window/workDoneProgress/cancel"}
"""Methods that pygls takes without an effect: there is no trace, and no progress that could be canceled."""


def test_every_method_is_in_the_table_and_no_other() -> None:
    manager = create_server().protocol.fm
    served = {*manager.features, *manager.builtin_features, "$/cancelRequest"} - NOT_OURS
    listed = [method for method, *_ in ROWS]
    assert sorted(listed) == sorted(method for method in served if not method.startswith("notebookDocument/"))


def test_handlers_and_tests_are_where_the_table_says() -> None:
    for method, handler, test, file in ROWS:
        if method in FEATURES:
            assert handler == f"handlers/{FEATURES[method].partition('.')[0]}.py"
        assert (ROOT / "improv_ls" / handler).is_file()
        assert f"def {test}(" in (ROOT / file).read_text(encoding="utf-8"), test
