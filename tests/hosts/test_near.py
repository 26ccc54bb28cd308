"""The near end of a link: a stop that comes straight to it is answered once the stage over there has obeyed."""

from __future__ import annotations

import os
import threading
from collections.abc import Sequence
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, cast

from improv_core.hosts.near import MAX_DIRECT, NearEnd
from improv_core.safety.stage_stops import StageSocket, stop_stages

LIMIT = 60.0
HOST = "pi@pi.local"
OBEYED = {"type": "obeyed", "direct": "p 1", "waits_for": []}


class Near(NearEnd):
    """A near end without a link."""

    def __init__(self) -> None:
        self.told: list[Any] = []
        super().__init__(HOST, cast(Any, None), self.told.append)
        self.sent = threading.Semaphore(0)

    def _send_first(self, frame: bytes) -> None:
        super()._send_first(frame)
        self.sent.release()


def test_a_stop_is_passed_on_first_and_answered_once_the_stage_has_obeyed() -> None:
    near, answers = Near(), list[Sequence[str] | None]()
    with TemporaryDirectory(dir="/tmp") as folder:
        show = Path(folder, "7-abc")
        reached = StageSocket(show, HOST, near._stop)
        near._put(b"a score")
        asking = threading.Thread(
            target=lambda: answers.append(stop_stages(show, {"type": "stop", "direct": "p 1", "by": "osc"}, LIMIT))
        )
        asking.start()
        assert near.sent.acquire(timeout=LIMIT)
        assert near._outgoing.next() == b's{"type": "stop", "direct": "p 1", "by": "osc", "number": 0}\n'
        assert answers == []
        near._pass_up({**OBEYED, "direct": "p 2"})
        near._pass_up(OBEYED)
        asking.join(LIMIT)
        assert answers == [[]]
        reached.close()


def test_a_stop_of_the_parent_goes_before_the_rest_of_a_long_score() -> None:
    near, stop = Near(), b'{"type": "stop", "number": 3}\n'
    near._put(b"#" * 3_000_000, is_score=True)
    assert [near._outgoing.next()[:1] for _ in range(2)] == [b"l", b"m"]  # type: ignore[index]
    reads, writes = os.pipe()
    threading.Thread(target=near._read_stops, args=(reads,), daemon=True).start()
    os.write(writes, stop)
    assert near.sent.acquire(timeout=LIMIT)
    assert near._outgoing.next() == b"s" + stop
    near._gone.set()
    os.close(writes)


def test_a_flood_of_stops_that_nobody_confirms_is_bounded() -> None:
    near, answered = Near(), list[int]()
    for number in range(2 * MAX_DIRECT):
        near._stop({"type": "stop", "direct": str(number)}, lambda line, number=number: answered.append(number))  # type: ignore[misc]
    for number in range(2 * MAX_DIRECT):
        near._pass_up({**OBEYED, "direct": str(number)})
    assert answered == [*range(MAX_DIRECT, 2 * MAX_DIRECT)]
