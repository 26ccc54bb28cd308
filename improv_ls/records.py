"""The history that a session keeps on disk, and what saves do if the editor's settings don't say it.

A thread writes, in the order in which things happened, so no save waits for a disk.
"""

from __future__ import annotations

import asyncio
from concurrent.futures import Future, ThreadPoolExecutor
from contextlib import suppress
from datetime import datetime, timezone
from pathlib import Path
from typing import Literal, cast

from improv_core.storage import history
from improv_core.storage.atomic_write import replacing
from improv_ls.documents import Document, path_of
from improv_ls.editor import Editor

Answer = Literal["", "offered", "continue", "restart"]
"""Nothing yet; offered, without an answer; or what a save does with a dance."""


class Records:
    """The records of one session."""

    def __init__(self, editor: Editor) -> None:
        self._editor = editor
        self._thread = ThreadPoolExecutor(1)
        self._told: set[str] = set()
        self.on_save = _answer()
        """The person's answer to the offer that saves continue the dance."""

    def keep_on_save(self, answer: Answer) -> None:
        """Keep an answer. If it can't be written, it counts for this session only."""
        self.on_save = answer
        self._thread.submit(_keep, answer)

    async def history(self) -> history.History:
        """Return the programs that have been kept, including those that played just now."""
        return await asyncio.get_running_loop().run_in_executor(self._thread, history.read)

    def played(self, document: Document) -> None:
        """Keep a program that plays."""
        loop = asyncio.get_running_loop()

        def done(writing: Future[None]) -> None:
            if problem := writing.exception():
                with suppress(RuntimeError):  # the loop is closed
                    loop.call_soon_threadsafe(self._tell, str(problem))

        kept = self._thread.submit(history.keep, file_of(document), document.analysis.text, datetime.now(timezone.utc))
        kept.add_done_callback(done)

    async def close(self) -> None:
        """Wait until everything is written."""
        await asyncio.to_thread(self._thread.shutdown)

    def _tell(self, problem: str) -> None:
        """Warn of a problem, once: it may come with every save."""
        if problem not in self._told:
            self._told.add(problem)
            self._editor.warn(problem)


def file_of(document: Document) -> str:
    """Return the name of a program in the history."""
    return str(path_of(document.uri) or document.uri)


def _answer() -> Answer:
    """Read the answer that was kept; none if it can't be read."""
    with suppress(OSError, UnicodeError):
        kept = _file().read_text("utf-8").strip()
        if kept in ("offered", "continue", "restart"):
            return cast(Answer, kept)
    return ""


def _keep(answer: Answer) -> None:
    with suppress(OSError):
        _file().parent.mkdir(0o700, parents=True, exist_ok=True)
        with replacing(_file(), private=True) as kept:
            kept.write(f"{answer}\n".encode())


def _file() -> Path:
    return history.folder().with_name("on_save")
