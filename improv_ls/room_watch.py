"""Has the meetings in open programs checked, one program at a time, whenever nobody has typed for a moment."""

from __future__ import annotations

import asyncio
from collections.abc import Callable, Mapping, Sequence
from typing import NamedTuple

from improv_core.diagnostics import Diagnostic
from improv_core.ipc.asking import Answerer
from improv_core.program import joint_check, room
from improv_core.robots.config import Robots
from improv_core.text import LineIndex
from improv_ls.documents import Document
from improv_ls.room_checker import OpenProgram, check

QUIET = 0.2
"""Seconds after the latest key before a program is checked."""


class _Checked(NamedTuple):
    """A version of a program, and its findings; None while they aren't known yet."""

    lines: LineIndex
    robots: Robots
    found: Sequence[Diagnostic] | None

    def is_of(self, document: Document) -> bool:
        return self.lines is document.lines and self.robots == document.analysis.config


class RoomWatch:
    """Findings about robots that meet in open programs. `show` is called with a program whose findings have changed."""

    def __init__(self, documents: Mapping[str, Document], show: Callable[[Document], None]) -> None:
        self._documents = documents
        self._show = show
        self._checker = Answerer(check)
        self._checked: dict[str, _Checked] = {}
        self._timer: asyncio.TimerHandle | None = None
        self._task: asyncio.Task[None] | None = None

    def found(self, document: Document) -> Sequence[Diagnostic]:
        """Return the known findings about this version of a program."""
        checked = self._checked.get(document.uri)
        return (checked.found or ()) if checked and checked.is_of(document) else ()

    def look(self, document: Document) -> None:
        """Have this version of a program, which is up to date, checked, unless that was done or is about to be."""
        checked = self._checked.get(document.uri)
        if checked and checked.is_of(document):
            return
        self._checked[document.uri] = _Checked(document.lines, document.analysis.config, None)
        if self._timer:
            self._timer.cancel()
        self._timer = asyncio.get_running_loop().call_later(QUIET, self._begin)

    def close(self) -> None:
        """End the process that checks."""
        if self._timer:
            self._timer.cancel()
        self._checked.clear()
        self._checker.close()

    def _begin(self) -> None:
        if self._task is None or self._task.done():
            self._task = asyncio.ensure_future(self._check())

    async def _check(self) -> None:
        """Check all programs that wait for it. Findings about a version are dropped if there is a newer one."""
        while document := self._next():
            checked = self._checked[document.uri]
            found: Sequence[Diagnostic] = ()
            if room.needs_check(document.analysis) or joint_check.needs_check(document.analysis):
                program = OpenProgram(document.uri, document.analysis.text, checked.robots)
                try:
                    found = await asyncio.to_thread(self._checker.ask, program)
                except (EOFError, OSError):
                    self._checker.close()
            if self._checked.get(document.uri) is checked:
                self._checked[document.uri] = checked._replace(found=found)
                now = self._documents.get(document.uri)
                if found and now and checked.is_of(now):
                    self._show(now)

    def _next(self) -> Document | None:
        """Return a program that is still to be checked."""
        for uri in [uri for uri, checked in self._checked.items() if checked.found is None]:
            document = self._documents.get(uri)
            if document and self._checked[uri].is_of(document):
                return document
            del self._checked[uri]
        return None
