"""The order in which a stage hears of what arrives."""

from __future__ import annotations

import queue

import pytest

from improv_core.stage.inbox import Inbox
from improv_core.stage.protocol import Hush, Seek
from improv_core.stage.sinks import Edge


def test_edges_overtake_all_else_and_stay_in_order() -> None:
    inbox = Inbox()
    seek: Seek = {"type": "seek", "beat": 1.0}
    hush: Hush = {"type": "hush"}
    on, off = Edge("/e_stop", True, 1.0), Edge("/e_stop", False, 2.0)
    for arrival in (seek, on, hush, off):
        inbox.put(arrival)
    assert [inbox.get(timeout=0) for _ in range(4)] == [on, off, seek, hush]
    with pytest.raises(queue.Empty):
        inbox.get(timeout=0)
