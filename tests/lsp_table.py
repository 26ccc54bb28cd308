"""`python -m tests.lsp_table` writes docs/lsp.md: each method of LSP that is served, and tests that prove it.

What a test proves is taken from what it says to the server: a request that was answered with something, a
notification that was sent, a message of the server's that the test has waited for. Each run of tests/ls holds the page
against that again (tests/ls/conftest.py).
"""

from __future__ import annotations

import json
import re
import sys
from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path
from typing import Any

import pytest

from improv_ls.server import create_server
from tests.ls.client import Client
from tests.ls.strict import NEEDS

ROOT = Path(__file__).parent.parent
PAGE = ROOT / "docs" / "lsp.md"
MOST_TESTS = 2
"""For one method: those that talk about little else."""

_NOT_OURS = {"$/setTrace", "window/workDoneProgress/cancel"}
"""pygls takes these, and nothing follows: there is no trace, and no progress that could be canceled."""
_NO_FEATURES = {"$/cancelRequest"}
"""pygls does these for us, and they must work."""
_ANSWERED_BY_NOTHING = {"shutdown", "workspace/executeCommand"}
_CLAIM = re.compile(r"\[`([^`]+)`\]\(\.\./([^)]+)\)")


def served() -> set[str]:
    """The methods that a client may send."""
    features = create_server().protocol.fm
    found = {*features.features, *features.builtin_features, *_NO_FEATURES} - _NOT_OURS
    return {method for method in found if not method.startswith("notebookDocument/")}


def proved(clients: Iterable[Client]) -> set[str]:
    """The methods that the sessions of a test have shown to work."""
    found: set[str] = set()
    for client in clients:
        found |= client.awaited
        asked: dict[object, str] = {}
        for by_server, message in client.log:
            if not by_server and "method" in message:
                asked[message.get("id")] = message["method"]
                found |= set() if "id" in message else {message["method"]}
            elif by_server and "method" not in message and "error" not in message:
                method = asked[message["id"]]
                found |= {method} if _says_something(message["result"]) or method in _ANSWERED_BY_NOTHING else set()
    return found


def claims() -> Mapping[str, set[str]]:
    """What the page says: the methods that each test proves, by the test's name in pytest without its parameters."""
    found: dict[str, set[str]] = {}
    for row in PAGE.read_text(encoding="utf-8").splitlines():
        if method := re.match(r"\| `([^`]+)` \|", row):
            for test, file in _CLAIM.findall(row):
                found.setdefault(f"{file}::{test}", set()).add(method[1])
    return found


def name_of(item: pytest.Item) -> str:
    """The name of a test without its parameters."""
    return item.nodeid.partition("[")[0]


def main() -> None:
    recorder = _Recorder()
    pytest.main(["-q", "--no-header", str(ROOT / "tests" / "ls")], plugins=[recorder])
    if missing := served().difference(*recorder.proved.values()):
        sys.exit(f"no test proves {', '.join(sorted(missing))}")
    PAGE.write_text("\n".join(_page(recorder.proved, recorder.sent)), encoding="utf-8")


class _Recorder:
    """A plugin of pytest's that notes what each test proves, with whatever parameters it runs."""

    def __init__(self) -> None:
        self.proved: dict[str, set[str]] = {}
        self.sent: set[str] = set()
        """Methods of the server."""

    @pytest.hookimpl(wrapper=True, tryfirst=True)
    def pytest_runtest_call(self, item: pytest.Item) -> Iterator[None]:
        yield
        now = proved(Client.of_test)
        self.proved[name_of(item)] = self.proved.get(name_of(item), now) & now
        self.sent |= {method for client in Client.of_test for method in client.awaited}


def _says_something(result: Any) -> bool:
    return bool(any(result.values()) if isinstance(result, dict) else result)


def _page(proofs: Mapping[str, set[str]], sent: set[str]) -> Iterator[str]:
    yield "# LSP, method by method"
    yield ""
    yield "What `improv-ls` speaks, and tests that prove it. `python -m tests.lsp_table` writes this page from what the"
    yield "tests say to the server; each run of `tests/ls` holds the page against that again."
    yield ""
    yield "## From the editor"
    yield "| method | proved by |"
    yield "|---|---|"
    for method in sorted(served()):
        yield f"| `{method}` | {_tests(method, proofs)} |"
    yield ""
    yield "## From the server"
    yield "What is asked of an editor or told to it, and what the editor must have said for that."
    yield ""
    yield "| method | only if it said | proved by |"
    yield "|---|---|---|"
    for method in sorted(sent):
        need = NEEDS.get(method, "")
        yield f"| `{method}` | {need if ' ' in need or not need else f'`{need}`'} | {_tests(method, proofs)} |"
    yield ""
    yield "## Editors replayed"
    yield "A session with each of these is played by what they say of themselves when they start a server"
    yield "([tests/ls/clients](../tests/ls/clients)): nothing comes that they have not said they take."
    yield "`python -m tests.ls.clients.record` records them again."
    yield ""
    yield "| editor | what it says is |"
    yield "|---|---|"
    for path in sorted((ROOT / "tests" / "ls" / "clients").glob("*.json")):
        record = json.loads(path.read_text(encoding="utf-8"))
        about = record["initialize"].get("clientInfo") or {"name": path.stem.capitalize()}
        yield f"| {' '.join(filter(None, (about['name'], about.get('version'))))} | {record['source']} |"
    yield ""


def _tests(method: str, proofs: Mapping[str, set[str]]) -> str:
    fitting = sorted((len(methods), test) for test, methods in proofs.items() if method in methods)
    found = []
    for _, test in fitting[:MOST_TESTS]:
        file, _, name = test.partition("::")
        found.append(f"[`{name}`](../{file})")
    return ", ".join(found)


if __name__ == "__main__":
    main()
