"""A helper process as its parent sees it: messages in both directions, and the reason why it ended."""

from __future__ import annotations

import queue
import subprocess
import sys
from typing import Literal, TypedDict

import pytest

from improv_core.ipc import helper
from improv_core.ipc.child import Policy
from improv_core.ipc.helper import Helper

LIMIT = 60.0
PATIENT = Policy(LIMIT, errors=subprocess.PIPE)
SAY = 'import sys; say = lambda line: print(\'{"type": "said", "line": \' + line.strip() + \'}\', flush=True)\n'


class Said(TypedDict):
    type: Literal["said"]
    line: int


class Heard:
    """The messages of a process, and the reason why it ends."""

    def __init__(self, script: str, policy: Policy = PATIENT) -> None:
        self.messages: queue.SimpleQueue[Said] = queue.SimpleQueue()
        self.ends: queue.SimpleQueue[str] = queue.SimpleQueue()
        self.process = Helper([sys.executable, "-c", script], policy, Said, self.messages.put, self.ends.put)

    def end(self) -> str:
        return self.ends.get(timeout=LIMIT)


def test_messages_are_read_in_their_order_and_other_lines_are_ignored() -> None:
    heard = Heard(SAY + "print('no JSON')\nfor line in sys.stdin: say(line.split()[-1].strip('}'))")
    heard.process.put({"number": 1})
    heard.process.put(lambda: {"number": 2})
    assert [heard.messages.get(timeout=LIMIT)["line"] for _ in range(2)] == [1, 2]
    heard.process.close()
    assert heard.end() == ""


def test_its_last_error_is_the_reason_why_it_ended() -> None:
    assert Heard("raise ValueError('of this')").end() == "ValueError: of this"


def test_one_that_hangs_is_killed_when_it_is_closed() -> None:
    heard = Heard(SAY + "import time; say('1'); time.sleep(1000)", Policy(0.0))
    heard.messages.get(timeout=LIMIT)
    heard.process.close()
    assert heard.end() == ""


def test_one_that_does_not_read_is_killed(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(helper, "MAX_WAITING", 2)
    heard = Heard(SAY + "import time; say('1'); time.sleep(1000)")
    heard.messages.get(timeout=LIMIT)
    for _ in range(4):
        heard.process.put({"line": "x" * 1_000_000})
    assert heard.end() == ""
    heard.process.wait(LIMIT)
    assert not heard.process.is_alive
