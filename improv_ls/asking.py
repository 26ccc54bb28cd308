"""A process of ours that answers one question at a time. Questions and answers are values that pickle can copy."""

from __future__ import annotations

import json
import pickle
import sys
import threading
from base64 import b64decode, b64encode
from typing import Any

from improv_core.ipc.child import Child, Policy

ANSWER_LIMIT = 120.0
"""Seconds that an answer may take on a busy machine; a process that needs more counts as hung."""
POLICY = Policy(1.0)


class Answerer:
    """The process of a module that runs by itself. It starts with the first question."""

    def __init__(self, module: str, limit: float = ANSWER_LIMIT) -> None:
        self.limit = limit
        self._module = module
        self._child: Child | None = None

    def ask(self, question: object) -> Any:
        """Return the answer of the process. Blocks; raises EOFError or OSError if the process has ended, or has hung
        and was killed."""
        child = self._child = self._child or Child([sys.executable, "-m", self._module], POLICY)
        patience = threading.Timer(self.limit, child.kill)
        patience.daemon = True
        patience.start()
        try:
            child.write(json.dumps(packed(question)).encode() + b"\n")
            return unpacked(child.read()[0])
        finally:
            patience.cancel()

    def close(self) -> None:
        """End the process. The next question starts another one."""
        child, self._child = self._child, None
        if child:
            child.kill()
            child.close_input()
            child.wait()


def packed(value: object) -> str:
    return b64encode(pickle.dumps(value)).decode()


def unpacked(line: bytes) -> Any:
    return pickle.loads(b64decode(json.loads(line)))
