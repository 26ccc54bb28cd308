"""Brings open programs up to date in slices, and answers requests about them as soon as their data is known."""

from __future__ import annotations

import asyncio
from collections.abc import Callable, Sequence
from concurrent.futures import Future
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import partial
from typing import TypeVar

from lsprotocol import types
from pygls.exceptions import JsonRpcException

from improv_core.diagnostics import Diagnostic
from improv_core.text import difference
from improv_ls.documents import Document
from improv_ls.slices import BRIEF, Slices
from improv_ls.urdfs import Urdfs

PATIENCE = 0.02
"""Seconds that a request waits for statements to be up to date. Then the known data answers it."""
T = TypeVar("T")


class ModifiedError(JsonRpcException):
    """The text has changed since a request about it."""

    CODE = types.LSPErrorCodes.ContentModified
    MESSAGE = "the text has changed"


@dataclass(frozen=True, slots=True, eq=False)
class _Asked:
    """A request that waits until it `is_ready`."""

    uri: str | None
    is_ready: Callable[[], bool]
    begin: Callable[[], object]
    future: Future[object]


class Settling:
    """Brings the open programs up to date. `publish` shows the diagnostics of one as far as they are known, `look` is
    called with each version that is up to date, `finished` once one is about which a request was answered before, and
    `failed` with the error that stopped one."""

    def __init__(
        self,
        slices: Slices,
        urdfs: Urdfs,
        documents: dict[str, Document],
        publish: Callable[[Document], None],
        look: Callable[[Document], None],
        finished: Callable[[], None],
        failed: Callable[[BaseException], None],
    ) -> None:
        self._slices = slices
        self._urdfs = urdfs
        self._documents = documents
        self._publish = publish
        self._look_at = look
        self._finished = finished
        self._failed = failed
        self._works: dict[str, list[Future[None]]] = {}
        self._asked: list[_Asked] = []
        self._answering: dict[Future[object], str] = {}
        self._guessed: set[str] = set()  # texts about which a request was answered before they were up to date
        self._shown: dict[str, Sequence[Diagnostic]] = {}  # the known diagnostics of a text that isn't up to date
        self._failures: dict[str, BaseException] = {}  # the error that stopped the analysis of a text

    def keep(self, document: Document) -> None:
        """Keep a version of a document and bring it up to date. Work on the previous version is dropped."""
        before = self._documents.get(document.uri)
        self.drop(document.uri, before is not None and before.lines is document.lines)
        self._documents[document.uri] = document
        work = self._slices.begin(partial(self._settle, document.uri), share=BRIEF)
        if work.done():
            self._done_with(work, document.uri)
            return
        self._works[document.uri] = [work]
        work.add_done_callback(partial(self._done, uri=document.uri))
        self._preview(document.uri)

    def drop(self, uri: str, same_text: bool = False) -> None:
        """Drop the work on a document, and requests about it unless its text is the same."""
        for work in self._works.pop(uri, ()):
            work.cancel()
        self._failures.pop(uri, None)
        self._shown.pop(uri, None)
        if not same_text:
            self._guessed.discard(uri)
            waiting = [asked.future for asked in self._asked if asked.uri == uri]
            for future in [*waiting, *(each for each, about in self._answering.items() if about == uri)]:
                if not future.done():
                    future.set_exception(ModifiedError())

    def answer(
        self,
        function: Callable[[], object],
        future: Future[object],
        uri: str | None,
        line: int | None = None,
        whole: bool = False,
    ) -> None:
        """Answer a request with the result of a function, once the document is up to date as far as the end of a line
        (by default: all of it) or after `PATIENCE`. If it needs the `whole`, it waits until all documents are."""
        document = self._documents.get(uri or "")
        if failure := self._failures.get(uri or ""):
            future.set_exception(failure)
            return
        is_ready = self._is_settled if whole else partial(self._is_ready, uri or "", line)
        if is_ready():
            self._begin(function, future, uri)
            return
        asked = _Asked(uri, is_ready, partial(self._begin, function, future, uri), future)
        self._asked.append(asked)
        if document and not document.analysis.earlier and not whole:  # there is something to answer with
            asyncio.get_running_loop().call_later(PATIENCE, self._begin_waiting, asked)

    async def run(self, function: Callable[[], T]) -> T:
        """Return the result of a slow function, which may look at any document."""
        self._guessed.update(uri for uri, each in self._documents.items() if not each.analysis.is_settled)
        future = self._slices.begin(function)
        return future.result() if future.done() else await asyncio.wrap_future(future)  # that wakes up the loop first

    async def settled(self, document: Document, text: str | None = None) -> Document:
        """Return this version of a document with everything up to date, also its robots, no matter what is typed
        meanwhile.

        With a `text`, it is the document as it was saved with that: an editor sends the text if it had saved before its
        message could reach us. Words that are the same keep their places in the open document.
        """
        while self._urdfs.works:
            await asyncio.wrap_future(next(iter(self._urdfs.works.values())))
        document = await self._settled(document)
        if text is None or text == document.analysis.text:
            return document
        saved = document.analysis.touched(*difference(document.analysis.text, text))
        return replace(document, version=None, analysis=await self.run(saved.settled))

    async def _settled(self, document: Document) -> Document:
        now = self._documents.get(document.uri)
        if now and now.lines is document.lines and not now.analysis.is_settled:
            future: Future[object] = Future()
            is_ready = partial(self._is_ready, document.uri, None)
            self._asked.append(_Asked(document.uri, is_ready, lambda: future.set_result(None), future))
            with suppress(ModifiedError):
                await asyncio.wrap_future(future)
            now = self._documents.get(document.uri)
        if now and now.lines is document.lines and now.analysis.is_settled:
            return now
        return replace(document, analysis=await self.run(document.analysis.settled))

    def _settle(self, uri: str) -> None:
        """Bring one version of a document up to date: replacing that version drops the work."""
        while not (document := self._documents[uri]).analysis.is_settled:
            self._documents[uri] = replace(document, analysis=document.analysis.settled(self._slices.is_over))
            if document.analysis.earlier:
                asyncio.get_running_loop().call_soon(self._preview, uri)
            if self._asked:
                asyncio.get_running_loop().call_soon(self._look)
            self._slices.rest()
        for preview in self._works.get(uri, ())[1:]:
            preview.cancel()
        if self._shown.get(uri) != document.analysis.diagnostics:
            self._publish(document)
        self._look_at(document)

    def _preview(self, uri: str) -> None:
        """Show the known diagnostics of a document that has been read but isn't up to date."""
        works = self._works.get(uri, [])
        if len(works) == 1 and not works[0].done() and not self._documents[uri].analysis.earlier:
            works.append(preview := self._slices.begin(partial(self._show, uri)))
            preview.add_done_callback(self._report)

    def _show(self, uri: str) -> None:
        document = self._documents[uri]
        # None, of lines that were never understood, would mean that nothing is wrong in them, which nobody knows yet.
        if document.analysis.diagnostics or document.analysis.is_understood:
            self._publish(document)
            self._shown[uri] = document.analysis.diagnostics

    def _done(self, work: Future[None], uri: str) -> None:
        if not work.cancelled():
            self._done_with(work, uri)
            self._look()
            if uri in self._guessed:
                self._guessed.remove(uri)
                self._finished()

    def _done_with(self, work: Future[None], uri: str) -> None:
        """Answer every request about this text with the error if the work failed."""
        if error := work.exception():
            self._failures[uri] = error
            for asked in [each for each in self._asked if each.uri == uri]:
                self._asked.remove(asked)
                if not asked.future.done():
                    asked.future.set_exception(error)
            self._failed(error)

    def _report(self, work: Future[None]) -> None:
        if not work.cancelled() and (error := work.exception()):
            self._failed(error)

    def _is_settled(self) -> bool:
        """Return whether all documents are up to date, as far as they can be."""
        return all(each.analysis.is_settled or uri in self._failures for uri, each in self._documents.items())

    def _is_ready(self, uri: str, line: int | None) -> bool:
        """Return whether a document is up to date as far as the end of a line; -1 is above all lines."""
        document = self._documents.get(uri)
        if not document or line is None:
            return not document or document.analysis.is_settled
        return document.analysis.is_settled_to(document.lines.start(line + 1) if line >= 0 else -1)

    def _look(self) -> None:
        for asked in [each for each in self._asked if each.future.done() or each.is_ready()]:
            self._begin_waiting(asked)

    def _begin_waiting(self, asked: _Asked) -> None:
        if asked in self._asked:
            self._asked.remove(asked)
            if not asked.future.done():
                asked.begin()

    def _begin(self, function: Callable[[], object], future: Future[object], uri: str | None) -> None:
        if uri and not self._is_ready(uri, None):
            self._guessed.add(uri)
        self._slices.begin(function, future)
        if uri and not future.done():
            self._answering[future] = uri
            future.add_done_callback(lambda _: self._answering.pop(future, None))
