"""A process of ours in which a function answers one question at a time. Both are values that pickle can copy.

It is `python -m improv_core.ipc.asking MODULE FUNCTION`.
"""

from __future__ import annotations

import json
import os
import pickle
import sys
from base64 import b64decode, b64encode
from collections.abc import Callable
from importlib import import_module
from typing import Generic, TypeVar

from improv_core.ipc.child import Child, Policy
from improv_core.protocol.json_lines import own_output

ANSWER_LIMIT = 120.0
"""Seconds that an answer may take on a busy machine; a process that needs more counts as hung."""
NICENESS = 5
"""The process's niceness: it often works while a save is about to move robots."""
POLICY = Policy(1.0)
Question = TypeVar("Question")
Answer = TypeVar("Answer")


class Answerer(Generic[Question, Answer]):
    """The process of a function, which a module has. It starts with the first question."""

    def __init__(self, function: Callable[[Question], Answer]) -> None:
        self.function = function
        self.limit = ANSWER_LIMIT
        self._child: Child | None = None

    def ask(self, question: Question) -> Answer:
        """Return the answer of the process. Raises EOFError or OSError if it has ended, or has hung and was killed."""
        line = self.start().ask(b64encode(pickle.dumps(question)), self.limit)
        answer: Answer = pickle.loads(b64decode(json.loads(line)))
        return answer

    def start(self) -> Child:
        """Start the process if there is none, and return it. Raises OSError."""
        command = [sys.executable, "-m", __name__, self.function.__module__, self.function.__name__]
        child = self._child = self._child or Child(command, POLICY)
        return child

    def give_up(self) -> None:
        """Kill the process, so that the question that waits has no answer. Any thread may call it."""
        if child := self._child:
            child.kill()

    def close(self) -> None:
        """End the process. The next question starts another one."""
        child, self._child = self._child, None
        if child:
            child.kill()
            child.close_input()
            child.wait()


def _serve(module: str, function: str) -> None:
    """Answer the questions from standard input, until it is closed."""
    if sys.platform != "win32":
        os.nice(NICENESS)
    say, answer = own_output(), getattr(import_module(module), function)
    for line in sys.stdin.buffer:
        say(b64encode(pickle.dumps(answer(pickle.loads(b64decode(line))))).decode())


if __name__ == "__main__":
    _serve(*sys.argv[1:])
