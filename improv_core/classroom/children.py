"""The parent's side of the process that serves the children."""

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
"""Ctrl-C in the terminal must not reach it: it would end the processes that read dances."""


class ChildrenError(Exception):
    """The children can't be served. The message is one line."""


class Children:
    """Serves a built website to the children, who need `code` to join. Raises ChildrenError."""

    def __init__(self, site: Path, address: str, port: int, code: str) -> None:
        command = [sys.executable, "-m", MODULE, str(site.absolute()), address, str(port)]
        try:
            # The code is in the environment, because everybody on this machine can list command lines.
            self._child = Child(command, POLICY, {**os.environ, CODE: code})
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
        """Pass children's messages to `hear`, and in the end the reason why their process ended to `ended`: both on a
        thread."""
        threading.Thread(target=self._listen, args=(hear, ended), name="improv-children", daemon=True).start()

    def remove(self, numbers: Collection[int]) -> None:
        """Refuse everything that these children send from now on."""
        message: SendOut = {"numbers": [*numbers]}
        with suppress(OSError):  # it has ended, which the thread reports
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
