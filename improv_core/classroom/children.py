"""The process that serves the children, as its parent sees it."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import threading
from collections.abc import Callable, Collection
from contextlib import suppress
from pathlib import Path

from improv_core.classroom.messages import FromChildren, SendOut, Serving
from improv_core.classroom.student_server import CODE, MODULE
from improv_core.ipc.child import Child, Policy

POLICY = Policy(1.0, leads=True, errors=subprocess.PIPE)
"""Ctrl-C in the terminal doesn't reach it, and with it end the processes that read dances."""


class ChildrenError(Exception):
    """The children can't be served. The message is one line."""


class Children:
    """Serves a built website to the children, who need `code` to join. Raises ChildrenError."""

    def __init__(self, site: Path, address: str, port: int, code: str) -> None:
        command = [sys.executable, "-m", MODULE, str(site.absolute()), address, str(port)]
        try:
            self._child = Child(command, POLICY, {**os.environ, CODE: code})  # everybody can list commands
        except OSError as error:
            raise ChildrenError(f"{sys.executable} can't be started: {error.strerror}") from None
        self.code = code
        self._lines: list[bytes] = []
        try:
            first, *self._lines = self._child.read()
        except EOFError:
            raise ChildrenError(self._why()) from None
        serving: Serving = json.loads(first)
        self.address = serving["address"]
        if serving["problem"]:
            self.close()
            raise ChildrenError(serving["problem"])

    def listen(self, hear: Callable[[FromChildren], None], ended: Callable[[str], None]) -> None:
        """From now on, `hear` what children do, and in the end why their process has ended: both on a thread."""
        threading.Thread(target=self._listen, args=(hear, ended), name="improv-children", daemon=True).start()

    def remove(self, numbers: Collection[int]) -> None:
        """From now on, these children can't send anything."""
        message: SendOut = {"numbers": [*numbers]}
        with suppress(OSError):  # it has ended, and the thread says so
            self._child.write(json.dumps(message).encode() + b"\n")

    def close(self) -> None:
        """End the process and all connections."""
        self._child.kill()
        self._child.close_input()

    def _listen(self, hear: Callable[[FromChildren], None], ended: Callable[[str], None]) -> None:
        lines = self._lines
        try:
            while True:
                for line in lines:
                    hear(json.loads(line))
                lines = self._child.read()
        except EOFError:
            ended(self._why())

    def _why(self) -> str:
        self._child.wait()
        return f"the children's server has ended: {self._child.last_error or 'it was killed'}"
