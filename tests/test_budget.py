"""The seconds that a test may take."""

from __future__ import annotations

import os

import pytest

from tests.budget import LONGEST, longest


@pytest.mark.parametrize(("load", "workers", "times"), [(0.0, 4, 1), (8.0, 4, 1), (24.0, 4, 3), (8.0, 1, 4)])
def test_a_test_may_take_longer_on_a_machine_with_other_work(
    load: float, workers: int, times: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(os, "getloadavg", lambda: (load, 0.0, 0.0))
    monkeypatch.setenv("PYTEST_XDIST_WORKER_COUNT", str(workers))
    assert longest() == times * LONGEST
