"""Modules that are imported, but loaded only if they are used."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from importlib import import_module
from importlib.util import find_spec
from pathlib import Path

import pytest

from improv_core.outputs.ros.lazy import imported_later

HEAVY = "heavy_in_a_test"


@pytest.fixture
def heavy(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[str]:
    (tmp_path / HEAVY).mkdir()
    (tmp_path / HEAVY / "__init__.py").write_text("answer = 42\n")
    (tmp_path / HEAVY / "part.py").write_text(f"from {HEAVY} import answer\nhalf = answer / 2\n")
    monkeypatch.syspath_prepend(str(tmp_path))
    yield HEAVY
    for name in [name for name in sys.modules if name.startswith(HEAVY)]:
        del sys.modules[name]


def is_loaded(name: str) -> bool:
    return "answer" in vars(sys.modules[name])


def test_a_module_is_loaded_on_first_use(heavy: str) -> None:
    imported_later(heavy)
    kept = import_module(heavy)
    assert find_spec(heavy)
    assert not is_loaded(heavy)
    assert kept.answer == 42
    assert is_loaded(heavy)
    assert sys.modules[heavy] is not kept
    assert kept.answer == 42
    with pytest.raises(AttributeError, match=f"module '{heavy}' has no attribute 'question'"):
        _ = kept.question


def test_submodules_can_be_imported(heavy: str) -> None:
    imported_later(heavy)
    assert import_module(f"{heavy}.part").half == 21


def test_a_loaded_module_stays_and_a_missing_one_stays_missing(heavy: str) -> None:
    loaded = import_module(heavy)
    imported_later(heavy)
    assert sys.modules[heavy] is loaded
    imported_later("missing_in_a_test")
    with pytest.raises(ModuleNotFoundError):
        import_module("missing_in_a_test")
