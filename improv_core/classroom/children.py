"""The parent's side of the process that serves the children."""

from __future__ import annotations

import queue
import subprocess
import sys
import threading
from collections.abc import Callable, Collection
from pathlib import Path

from improv_core import LineError
from improv_core.classroom.messages import FromChildren, Remove, Serving
from improv_core.classroom.roster import new_code
from improv_core.ipc.child import Policy
from improv_core.ipc.helper import Helper
from improv_core.website.build import MARK

MODULE = "improv_core.classroom.student_server"
POLICY = Policy(1.0, leads=True, errors=subprocess.PIPE)
"""Ctrl-C in the terminal must not reach it: it would end the processes that read dances."""


class ChildrenError(LineError):
    """The children can't be served. The message is one line, which says what to do if somebody can do something."""


class Children:
    """Serves a built website to the children, and keeps what they send in a folder. They need `code` to join: a new
    one, unless the folder has that of a class that continues. Raises ChildrenError."""

    def __init__(self, site: Path, folder: Path, address: str, port: int) -> None:
        self._heard: queue.SimpleQueue[FromChildren | Serving | str] = queue.SimpleQueue()  # a text: it has ended
        command = [sys.executable, "-m", MODULE, str(site.absolute()), str(folder.absolute()), address, str(port)]
        self._helper = Helper(command, POLICY, FromChildren | Serving, self._heard.put, self._heard.put)
        self._helper.put({"code": new_code()})  # no argument, because everybody on this machine can list command lines
        first = self._heard.get()
        if isinstance(first, str):
            raise ChildrenError(_reason(first))
        assert first["type"] == "serving"
        self.address, self.code = first["address"], first["code"]
        if first["problem"]:
            self.close()
            raise ChildrenError(first["problem"])

    def listen(self, hear: Callable[[FromChildren], None], ended: Callable[[str], None]) -> None:
        """Pass children's messages to `hear`, and in the end the reason why their process ended to `ended`: both on a
        thread."""

        def pass_on() -> None:
            while not isinstance(news := self._heard.get(), str):
                if news["type"] != "serving":
                    hear(news)
            ended(_reason(news))

        threading.Thread(target=pass_on, name="improv-children", daemon=True).start()

    def remove(self, numbers: Collection[int]) -> None:
        """Refuse everything that these children send from now on."""
        message: Remove = {"type": "remove", "numbers": [*numbers]}
        self._helper.put(message)

    def close(self) -> None:
        """End the process and all connections."""
        self._helper.kill()


def check_site(site: Path) -> None:
    """Raise ChildrenError unless a folder is a website that this version has built."""
    if not (site / MARK).is_file() or not (site / "website" / "class.js").is_file():
        raise ChildrenError(f"{site} is no website of this version: run `improv site {site}` first")


def _reason(last_error: str) -> str:
    return f"the children's server has ended: {last_error or 'it was killed'}"
