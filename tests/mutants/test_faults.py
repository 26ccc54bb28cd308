"""The rows of `faults.py` fit the source."""

from __future__ import annotations

from pathlib import Path

import improv_core
from tests.mutants.faults import FAULTS, Fault

CORE = Path(improv_core.__file__).parent


def test_the_original_of_each_fault_occurs_once() -> None:
    assert [each for each in FAULTS if _source(each).count(each.original) != 1] == []


def _source(fault: Fault) -> str:
    return (CORE / fault.file).read_text(encoding="utf-8")
