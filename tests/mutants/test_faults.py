"""The rows of `faults.py` fit the source."""

from __future__ import annotations

from pathlib import Path

import pytest

import improv_core
from tests.mutants.faults import FAULTS, Fault

CORE = Path(improv_core.__file__).parent


@pytest.mark.parametrize("fault", FAULTS, ids=lambda fault: fault.breaks)
def test_the_original_of_a_fault_occurs_once(fault: Fault) -> None:
    assert (CORE / fault.file).read_text(encoding="utf-8").count(fault.original) == 1
