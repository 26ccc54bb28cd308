"""What a session keeps on disk: the history, and the study log if a setting names one.

A thread writes, in the order in which things happened, so no save waits for a disk.
"""

from __future__ import annotations

import asyncio
import time
from collections.abc import Callable
from concurrent.futures import Future, ThreadPoolExecutor
from contextlib import suppress
from datetime import datetime, timezone
from pathlib import Path
from secrets import token_hex
from typing import Literal

from improv_core.diagnostics import Severity
from improv_core.program.report import problems
from improv_core.protocol.messages import Sent
from improv_core.storage import history
from improv_core.storage.study import Distances, Event, Noted, append
from improv_ls.documents import Document, name_of, path_of
from improv_ls.editor import Editor

By = Literal["save", "command"]
"""What plays a program."""


class Records:
    """The records of one session."""

    def __init__(self, editor: Editor) -> None:
        self._editor = editor
        self._thread = ThreadPoolExecutor(1)
        self._session = token_hex(4)
        self._distances = Distances()
        self._told: set[str] = set()

    async def history(self) -> history.History:
        """What has been kept, including what happened just now."""
        return await asyncio.get_running_loop().run_in_executor(self._thread, history.read)

    def saved(self, document: Document) -> None:
        """Note that somebody saved a program, and the errors of it and of its `improv.toml`."""
        program = name_of(document.uri)
        found = problems(path_of(document.uri) or Path(program), document.analysis)
        errors = [each for each in found if each[2].severity is Severity.ERROR]
        self._note({"event": "save", "program": program, "errors": len(errors)})
        for path, lines, each in errors:
            line = lines.position(each.span.start).line + 1
            self._note({"event": "error", "program": path.name, "code": each.code, "line": line})

    def played(self, document: Document, by: By) -> None:
        """Keep a program that plays, and note that it does."""
        self._write(history.keep, file_of(document), document.analysis.text, datetime.now(timezone.utc))
        robots = len(document.analysis.robots)
        self._note({"event": "play", "program": name_of(document.uri), "by": by, "robots": robots})

    def sent(self, message: Sent) -> None:
        """Count how far a robot moves by what it was told."""
        self._distances.add(message)

    def rested(self) -> None:
        """Note how far robots have moved, if they have."""
        if meters := self._distances.take():
            self._note({"event": "moved", "meters": meters})

    async def close(self) -> None:
        """Wait until everything is written."""
        self.rested()
        await asyncio.to_thread(self._thread.shutdown)

    def _note(self, event: Event) -> None:
        if log := self._editor.settings.study_log:
            self._write(append, Path(log).expanduser(), Noted(time.time(), self._session, event))

    def _write(self, write: Callable[..., None], *what: object) -> None:
        loop = asyncio.get_running_loop()

        def done(writing: Future[None]) -> None:
            if problem := writing.exception():
                with suppress(RuntimeError):  # the loop was closed
                    loop.call_soon_threadsafe(self._tell, str(problem))

        self._thread.submit(write, *what).add_done_callback(done)

    def _tell(self, problem: str) -> None:
        """Warn about a problem, once: it may come with every save."""
        if problem not in self._told:
            self._told.add(problem)
            self._editor.warn(problem)


def file_of(document: Document) -> str:
    """The name of a program in the history."""
    return str(path_of(document.uri) or document.uri)
