"""Modules that are imported, but loaded only if they are used."""

from __future__ import annotations

import sys
from importlib import import_module
from importlib.util import find_spec
from pathlib import Path

import pytest

from improv_core.outputs.ros.nodes import imported_later

HEAVY = "heavy_in_a_test"


def test_a_module_is_loaded_on_first_use(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / f"{HEAVY}.py").write_text("answer = 42\n")
    monkeypatch.syspath_prepend(str(tmp_path))
    monkeypatch.setitem(sys.modules, HEAVY, sys)  # so that whatever is there later is gone after the test
    del sys.modules[HEAVY]
    imported_later(HEAVY)
    kept = import_module(HEAVY)
    assert find_spec(HEAVY)
    assert "answer" not in vars(kept)
    assert kept.answer == 42
    loaded = sys.modules[HEAVY]
    assert loaded is not kept
    assert kept.answer == 42
    with pytest.raises(AttributeError, match=f"module '{HEAVY}' has no attribute 'question'"):
        _ = kept.question
    imported_later(HEAVY)
    assert sys.modules[HEAVY] is loaded
    imported_later("missing_in_a_test")
    with pytest.raises(ModuleNotFoundError):
        import_module("missing_in_a_test")
