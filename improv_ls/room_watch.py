"""Has open programs drawn for pages and, whenever nobody has typed for a moment, their meetings checked."""

from __future__ import annotations

import asyncio
from collections.abc import Callable, Mapping, Sequence
from typing import NamedTuple

from improv_core.diagnostics import Diagnostic
from improv_core.ipc.asking import Answerer
from improv_core.program import joint_check, room
from improv_core.protocol.editing import Preview
from improv_core.robots.config import Robots
from improv_core.text import LineIndex
from improv_ls.documents import Document
from improv_ls.room_checker import OpenProgram, Sight, look

QUIET = 0.2
"""Seconds after the latest key before a program is checked."""


class _Checked(NamedTuple):
    """A version of a program, and its findings; None while they aren't known yet. If pages show it, they get its paths
    before that."""

    lines: LineIndex
    robots: Robots
    found: Sequence[Diagnostic] | None
    draws: bool
    senses: bool = False

    def is_of(self, document: Document) -> bool:
        return self.lines is document.lines and self.robots == document.analysis.config


class RoomWatch:
    """Sight about robots that meet in open programs. `show` is called with a program whose findings have changed,
    and `draw` with one that pages show, by `on_pages`, and its paths."""

    def __init__(
        self,
        documents: Mapping[str, Document],
        show: Callable[[Document], None],
        on_pages: Callable[[Document], bool],
        draw: Callable[[Document, Preview], None],
    ) -> None:
        self._documents = documents
        self._show = show
        self._on_pages = on_pages
        self._draw = draw
        self._checker = Answerer(look)
        self._checked: dict[str, _Checked] = {}
        self._is_quiet = False
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
        draws = self._on_pages(document)
        self._checked[document.uri] = _Checked(document.lines, document.analysis.config, None, draws)
        if self._timer:
            self._timer.cancel()
        self._is_quiet = False
        self._timer = asyncio.get_running_loop().call_later(QUIET, self._begin, True)
        if draws:
            self._begin()

    def close(self) -> None:
        """End the process that checks."""
        if self._timer:
            self._timer.cancel()
        self._checked.clear()
        self._checker.close()

    def _begin(self, is_quiet: bool = False) -> None:
        self._is_quiet = is_quiet
        if self._task is None or self._task.done():
            self._task = asyncio.ensure_future(self._check())

    async def _check(self) -> None:
        """Draw and check all programs that wait for it. Sight about a version are dropped if there is a newer
        one."""
        while document := self._next():
            checked, seen = self._checked[document.uri], Sight()
            needs_check = room.needs_check(document.analysis) or joint_check.needs_check(document.analysis)
            if checked.draws or checked.senses or needs_check:
                program = OpenProgram(document.uri, document.analysis.text, checked.robots, checked.draws)
                try:
                    seen = await asyncio.to_thread(self._checker.ask, program)
                except (EOFError, OSError):
                    self._checker.close()
            if self._checked.get(document.uri) is checked:
                senses = seen.paths is not None and bool(seen.paths["waits_for"])
                found = None if checked.draws else seen.diagnostics
                self._checked[document.uri] = checked._replace(found=found, draws=False, senses=senses)
                now = self._documents.get(document.uri)
                if now and checked.is_of(now):
                    if seen.paths:
                        self._draw(now, seen.paths)
                    if found:
                        self._show(now)

    def _next(self) -> Document | None:
        """Return a program that is still to be drawn or, if nobody types, to be checked."""
        waiting = [uri for uri, checked in self._checked.items() if checked.found is None]
        for uri in sorted(waiting, key=lambda uri: not self._checked[uri].draws):
            document = self._documents.get(uri)
            if not (document and self._checked[uri].is_of(document)):
                del self._checked[uri]
            elif self._is_quiet or self._checked[uri].draws:
                return document
        return None
