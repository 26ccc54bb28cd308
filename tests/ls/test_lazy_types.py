"""The types of LSP that are completed later, and the modules that are loaded before `initialize` is answered."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

from tests.ls.client import LIMIT, ProcessClient

BEGIN = """
import sys, attrs
from improv_ls import lazy_types
"""
FIELDS = """
from lsprotocol import _hooks, types
_hooks._resolve_forward_references()
for name, each in [*types.ALL_TYPES_MAP.items()]:
    if isinstance(each, type) and attrs.has(each):
        print(name, *((field.name, field.type, field.default) for field in attrs.fields(each)), each.__hash__ is None)
"""
START = """
lazy_types.load()
from improv_ls.server import create_server
from lsprotocol import types
message = {"jsonrpc": "2.0", "id": 1, "method": "initialize", "params": {"processId": None, "capabilities": {}}}
create_server().protocol.structure_message(message)
fields = [vars(each).get("__attrs_attrs__") for each in types.ALL_TYPES_MAP.values() if isinstance(each, type)]
print(len(fields), sum(isinstance(each, tuple) for each in fields))
"""
CHECK = """
lazy_types.load()
from improv_ls import room_watch, settling
from improv_ls.handlers import completion, hover, initialize, text_document_sync, workspace_diagnostic
"""
LOADED = """
print(*(name for name in sys.modules if name.startswith("improv_core.")))
"""


def printed(code: str) -> list[str]:
    """Return the lines that code prints in a process of its own."""
    done = subprocess.run([sys.executable, "-c", BEGIN + code], capture_output=True, text=True, timeout=LIMIT)
    assert done.returncode == 0, done.stderr
    return done.stdout.splitlines()


def test_a_type_that_is_completed_later_is_the_usual_one() -> None:
    assert printed(f"lazy_types.load()\n{FIELDS}") == printed(FIELDS)


def test_an_editor_waits_for_few_types_and_for_no_compiler() -> None:
    counts, loaded = printed(START + LOADED)
    all_, complete = map(int, counts.split())
    assert all_ > 500
    assert complete < 40
    packages = {name.split(".")[1] for name in loaded.split()}
    assert packages == {"ide", "plain", "protocol", "safety", "score", "text", "slices", "values"}
    assert not {f"improv_core.score.{name}" for name in ("algebra", "path", "score")} & {*loaded.split()}


def test_a_server_that_checks_programs_needs_no_player_and_no_simulator() -> None:
    (loaded,) = printed(CHECK + LOADED)
    assert not {"outputs", "player", "stage"} & {name.split(".")[1] for name in loaded.split()}


@pytest.mark.skipif(sys.platform != "linux", reason="needs /proc")
def test_a_server_that_plays_has_not_loaded_openssl() -> None:
    with ProcessClient({"backend": "sim", "page": {"open": False}}) as client:
        client.play("file:///dance.improv", "r $ forward\n")
        assert "libcrypto" not in Path(f"/proc/{client.process.pid}/maps").read_text(encoding="utf-8")
