"""What the server knows while it runs: the editor, the open documents, and what plays."""

from __future__ import annotations

import asyncio
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import count
from typing import TYPE_CHECKING, Any, Generic, TypeVar

from lsprotocol import types
from pygls.exceptions import FeatureRequestError

from improv_core import __version__
from improv_ls.editor import Editor
from improv_ls.framing import StdioServer

if TYPE_CHECKING:
    from improv_core.robots.config import Robots
    from improv_ls.coloring import Chunk
    from improv_ls.documents import Document, RobotsFile
    from improv_ls.performance import Performance
    from improv_ls.records import Records

T = TypeVar("T")
_numbers = count(1)


@dataclass(frozen=True, slots=True)
class Sent(Generic[T]):
    """What an editor was last sent for a document, and the id by which it asks for what is different since."""

    result_id: str
    items: Sequence[T]


def sent(items: Sequence[T]) -> Sent[T]:
    """With an id that no other result has, of whatever document."""
    return Sent(str(next(_numbers)), items)


@dataclass(frozen=True, slots=True)
class Checked:
    """What was wrong with a program on disk when its file had this state, for these robots."""

    stamp: tuple[int, int]
    robots: Robots
    sent: Sent[types.Diagnostic]


class Session(StdioServer):
    """One editor's session."""

    def __init__(self) -> None:
        super().__init__("improv-ls", __version__)
        self.editor = Editor(self)
        self.documents: dict[str, Document] = {}
        """The open programs."""
        self.robots_files: dict[str, RobotsFile] = {}
        """The `improv.toml` files that are open in the editor: few editors tell us of theirs."""
        self.sent_tokens: dict[str, Sent[Chunk]] = {}
        self.sent_diagnostics: dict[str, Sent[types.Diagnostic]] = {}
        self.checked: dict[str, Checked] = {}
        """The programs in the workspace's folders, by URI."""
        self.next_change = asyncio.Event()
        """Set, and replaced by another one, once a file or an open program has changed."""
        self.autosaving: set[str] = set()
        """Documents that the editor is about to save by itself."""

    @cached_property
    def performance(self) -> Performance:
        """What plays. Made when something is about to play, because it imports much."""
        from improv_ls.performance import Performance

        self.obey_while_busy()
        return Performance(self.editor, self.documents, self.robots_files, self.records)

    @cached_property
    def records(self) -> Records:
        """What is kept on disk. Made when somebody saves."""
        from improv_ls.records import Records

        return Records(self.editor)

    def files_changed(self) -> None:
        """Note that files on disk, or the set of open programs, have changed."""
        self.next_change.set()
        self.next_change = asyncio.Event()

    def settle(self, params: Any) -> None:
        """Bring the statements up to date that a request may be about: all up to its place, if it names one."""
        place = getattr(params, "position", None) or getattr(getattr(params, "range", None), "end", None)
        for uri, document in self.documents.items():
            if document.analysis.waiting:
                from improv_ls.documents import settled

                self.documents[uri] = settled(document, place.line if place else None)

    def report_server_error(self, error: Exception, source: type[Exception]) -> None:
        """Show an internal error, unless it happened in a request: that is answered with the error."""
        if not issubclass(source, FeatureRequestError):
            self.editor.report(f"Improv: internal error: {error}")

    async def close(self) -> None:
        """Stop the robots, if any have been moved, and end the stages."""
        if "performance" in self.__dict__:
            await self.performance.close()
        if "records" in self.__dict__:
            await self.records.close()
