"""Programs that play for ages, or use phrases in phrases, take little memory: nothing is written out."""

from __future__ import annotations

import gc
import tracemalloc
from itertools import islice

import pytest

from improv_core.program.analysis import analyze
from improv_core.program.compiler import score_of
from improv_core.score.score_json import to_json
from improv_core.score.walk import walk
from tests.program.huge import CHAINS, LONG

MAX_MEMORY = 50_000_000
"""Bytes for the analysis, the score, and a thousand moments from the middle, and of other threads of the tests.

Without sharing, it would be gigabytes."""
MAX_ROWS = 3_100
"""Rows of movements in the score. Of a thousand items, `accumulate` makes a thousand beginnings and their series."""


@pytest.mark.parametrize("text", [*CHAINS.values(), *LONG.values()], ids=[*CHAINS, *LONG])
def test_huge_programs_take_little_memory(text: str) -> None:
    gc.set_threshold(700, 10, 10)  # a stage on a thread of this process collects its garbage more rarely
    analyze("y (m) = m\nr $ choose (y left right)")  # allocate everything that is allocated only once
    tracemalloc.start()
    try:
        analysis = analyze(text)
        assert analysis.ok
        rows = to_json(score_of(analysis))["movements"]
        played = analysis.robots["r"]
        middle = int(played.duration) // 2
        moments = list(islice(walk(played, middle), 1_000))
        _, most = tracemalloc.get_traced_memory()
    finally:
        tracemalloc.stop()
    assert moments[0].start == middle
    assert len(rows) < MAX_ROWS
    assert most < MAX_MEMORY
