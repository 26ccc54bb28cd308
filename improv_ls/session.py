"""State of the server while it runs: the editor, the open documents, and the performance."""

from __future__ import annotations

import asyncio
from collections.abc import Callable, Sequence
from concurrent.futures import Future
from dataclasses import dataclass
from functools import cached_property
from itertools import count
from typing import TYPE_CHECKING, Any, Generic, TypeVar
from urllib.parse import unquote

from lsprotocol import types
from pygls.exceptions import FeatureRequestError

from improv_core import STARTED, __version__
from improv_core.protocol.commands import Stop
from improv_core.safety.stop_socket import IDLE, StopSocket, listening
from improv_ls.editor import SHOWN, Editor
from improv_ls.framing import StdioServer

if TYPE_CHECKING:
    from improv_core.protocol.editing import Preview
    from improv_core.robots.config import Robots
    from improv_ls.coloring import Chunk
    from improv_ls.documents import Document, RobotsFile
    from improv_ls.performance import Performance
    from improv_ls.records import Records
    from improv_ls.room_watch import RoomWatch
    from improv_ls.settling import Settling

T = TypeVar("T")
_numbers = count(1)


@dataclass(frozen=True, slots=True)
class LastSent(Generic[T]):
    """The items that an editor got last for a document, and the ID with which it asks for later changes."""

    result_id: str
    items: Sequence[T]


def sent(items: Sequence[T]) -> LastSent[T]:
    """Give items an ID that no other result has, for any document."""
    return LastSent(str(next(_numbers)), items)


@dataclass(frozen=True, slots=True)
class Checked:
    """The diagnostics of a program on disk when its file had this state, for these robots."""

    stamp: tuple[int, int]
    robots: Robots
    sent: LastSent[Any]


def uri_of(params: Any) -> str | None:
    """Return the document that a request is about, if it is about one."""
    document = getattr(params, "text_document", None) or getattr(params, "item", None)
    return document.uri if document else None


class Session(StdioServer):
    """One editor's session."""

    def __init__(self) -> None:
        super().__init__("improv-ls", __version__)
        self.editor = Editor(self)
        self.publish: Callable[[Document], None] = lambda document: None
        """Sends the diagnostics of a program."""
        self.urdfs_changed: Callable[[], None] = lambda: None
        """Checks again everything that depends on URDFs."""
        self.documents: dict[str, Document] = {}
        """The open programs."""
        self.robots_files: dict[str, RobotsFile] = {}
        """The `improv.toml` files that are open in the editor: few editors report theirs."""
        self.sent_tokens: dict[str, LastSent[Chunk]] = {}
        self.sent_diagnostics: dict[str, LastSent[Any]] = {}
        self.checked: dict[str, Checked] = {}
        """The programs in the workspace's folders, by URI."""
        self.next_change = asyncio.Event()
        """Set, and replaced by another one, once a file or an open program has changed."""
        self.scenes_with_lenses: dict[str, frozenset[int]] = {}
        """The scenes that each program had when it was opened or saved, by the IDs of their statements.

        A program without an entry gets the scenes that it has once it has been read."""
        self._reached: StopSocket | None = None
        self.saving: dict[str, int | None] = {}
        """The documents that are being saved, each with the number of stops before a person asked for the save, or None
        if the editor saves on its own."""

    @cached_property
    def performance(self) -> Performance:
        """The performance. Made when a program is about to play, because it imports much."""
        from improv_ls.performance import Performance

        self.obey_while_busy()
        return Performance(self.editor, self.documents, self.robots_files, self.records, self.settling)

    @cached_property
    def records(self) -> Records:
        """Records on disk. Made when somebody saves."""
        from improv_ls.records import Records

        return Records(self.editor)

    @cached_property
    def rooms(self) -> RoomWatch:
        """Meetings of robots in the open programs. Made when the first program is up to date."""
        from improv_ls.room_watch import RoomWatch

        return RoomWatch(self.documents, self._show_room, self.is_on_pages, self._draw)

    def as_opened(self, uri: str) -> str:
        """Return the URI with which an editor has opened a document, however that is spelled now: `%C3%BC` or `ü`."""
        known = {*self.documents, *self.robots_files}
        return uri if uri in known else next((each for each in known if unquote(each) == unquote(uri)), uri)

    def _show_room(self, document: Document) -> None:
        self.publish(document)
        self.editor.refresh("diagnostics")

    def is_on_pages(self, document: Document) -> bool:
        """Return whether open pages show this program."""
        performance: Performance | None = self.__dict__.get("performance")
        return performance is not None and performance.presented == document.uri and bool(performance.state.pages)

    def _draw(self, document: Document, paths: Preview) -> None:
        self.performance.ask({"type": "draft", "text": document.analysis.text, "paths": paths})

    def files_changed(self) -> None:
        """Note that files on disk, or the set of open programs, have changed."""
        self.next_change.set()
        self.next_change = asyncio.Event()

    @cached_property
    def settling(self) -> Settling:
        """Brings the open programs up to date. Made on the event loop."""
        from improv_core.program.files import read_urdfs_by
        from improv_ls.settling import Settling
        from improv_ls.slices import Slices
        from improv_ls.urdfs import Urdfs

        slices = Slices(asyncio.get_running_loop().call_soon)
        urdfs = Urdfs(slices, self.urdfs_changed)
        read_urdfs_by(urdfs.skeleton_in)
        return Settling(
            slices, urdfs, self.documents, self.publish, lambda each: self.rooms.look(each), self._refresh, self._fail
        )

    def answer(self, method: str, function: Callable[[], Any], params: Any, future: Future[Any]) -> None:
        """Answer a request, in slices, as soon as the document is far enough up to date."""
        place = getattr(params, "position", None) or getattr(getattr(params, "range", None), "end", None)
        line = -1 if method == types.TEXT_DOCUMENT_DIAGNOSTIC else place.line if place else None
        whole = method == types.TEXT_DOCUMENT_RENAME
        self.settling.answer(function, future, uri_of(params), line, whole)

    def _refresh(self) -> None:
        """Have the editor ask again for its decorations, because a document is up to date now."""
        for feature in SHOWN:
            self.editor.refresh(feature)

    def _fail(self, error: BaseException) -> None:
        if isinstance(error, BrokenPipeError):
            self.end()
        else:
            self.editor.report(f"Improv: internal error: {error}")

    def report_server_error(self, error: Exception, source: type[Exception]) -> None:
        """Show an internal error, unless it happened in a request: then the answer is the error."""
        if not issubclass(source, FeatureRequestError):
            self.editor.report(f"Improv: internal error: {error}")

    def listen(self) -> None:
        """Let `improv stop` reach this session from now on, so that it also finds a program that is about to play."""
        self._reached = listening(self._stop, self.stops, STARTED)
        if self.stops.unreachable:
            self.editor.warn(f"`improv stop` won't work: {self.stops.unreachable}")

    def _stop(self, stop: Stop) -> str:
        performance: Performance | None = self.__dict__.get("performance")
        if performance and (answer := performance.stop(stop)):
            return answer
        self.stops.stop(stop)  # a save may be on its way
        return IDLE

    async def close(self) -> None:
        """Stop the robots, if any have been moved, and end the stages."""
        if "performance" in self.__dict__:
            await self.performance.close()
        if "records" in self.__dict__:
            await self.records.close()
        if "rooms" in self.__dict__:
            self.rooms.close()
        if self._reached:
            self._reached.close()
