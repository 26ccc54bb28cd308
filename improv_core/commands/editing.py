"""Lets pages edit a program, and plays it when they save it."""

from __future__ import annotations

import asyncio
from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path

from improv_core.commands.exit_codes import INTERRUPTED
from improv_core.commands.settings import PlaySettings
from improv_core.commands.terminal import TerminalSession, first, performance
from improv_core.page.program_editor import PageEditor
from improv_core.program.files import ReadError, outputs_near, read_bytes, robots_or_problem
from improv_core.protocol.commands import Editing
from improv_core.protocol.editing import Analyze, AskHandle, AskPreview, EditorAnswer, Write
from improv_core.robots.config import absolute, find_robots_file
from improv_core.session.start import Options
from improv_core.slices import keep_collections_short
from improv_core.storage.program_file import Version, WriteError, read_version, write_text
from improv_core.storage.saves import changes, read_saved, settle
from improv_core.storage.song_offset import write_first_beat
from improv_core.syntax.derivation import prepare

QUIET = 0.2
"""Seconds after the latest key before robots that meet are looked for."""


async def edit(path: Path, version: Version, options: Options, settings: PlaySettings, *, browser: bool) -> int:
    """Let pages edit a program and play it, until interrupted. Return the exit code. Raises StageError."""
    asks: asyncio.Queue[tuple[Editing, int]] = asyncio.Queue()
    async with performance(
        options,
        browser=False,
        settings=settings,
        hosts=outputs_near(path.parent) if options.backend == "ros" else frozenset(),
        edit=lambda editing, asked: asks.put_nowait((editing, asked)),
    ) as performing:
        desk = _Desk(performing, path, version)
        await asyncio.to_thread(prepare)  # otherwise, the first word that is half written would wait for it
        keep_collections_short()  # one over all modules would have a key wait for 0.1 s
        if browser:
            opening = asyncio.create_task(performing.keyboard.open_page())
        performing.screen.say(f"editing {path.name}: Ctrl+Enter on the page saves and plays it, Ctrl-C here ends it")
        await first(desk.serve(asks), desk.preview(), desk.check_rooms(), desk.follow(), performing.interrupted.wait())
        if browser:
            opening.cancel()
    return INTERRUPTED


class _Desk:
    """One program that pages edit, and its file."""

    def __init__(self, performing: TerminalSession, path: Path, version: Version) -> None:
        self._performing = performing
        self._path = path
        self._version = version
        self._saved = read_saved(path)
        self._robots = robots_or_problem(path.parent)
        self._editor = PageEditor(self._robots, lambda value: write_first_beat(path.parent, value))
        self._unchecked: asyncio.Queue[tuple[int, Analyze]] = asyncio.Queue()
        self._unseen: asyncio.Queue[tuple[int, AskPreview | AskHandle]] = asyncio.Queue()
        performing.present(path)
        self._show()

    async def serve(self, asks: asyncio.Queue[tuple[Editing, int]]) -> None:
        """Obey the requests of pages, forever."""
        while True:
            editing, asked = await asks.get()
            page, ask = editing["page"], editing["ask"]
            if ask["type"] == "write":
                await self._write(page, ask, asked)
                continue
            if ask["type"] == "preview" or ask["type"] == "handle":
                self._unseen.put_nowait((page, ask))
                continue
            self._answer(page, self._editor.answer(page, ask, rehearses=self._performing.rehearses))
            if ask["type"] == "analyze":
                self._unchecked.put_nowait((page, ask))

    async def preview(self) -> None:
        """Send the paths of the pages' texts, and the handles of their movements, forever."""
        while True:
            page, ask = await self._unseen.get()
            if ask["type"] == "handle":
                await self._apart(page, partial(self._editor.handle, page, ask))
                continue
            answers = self._editor.previews(page, ask)
            while await self._apart(page, partial(next, answers, None)):
                pass

    async def check_rooms(self) -> None:
        """Report the meetings of robots in the pages' texts, once nobody types, forever."""
        while True:
            page, ask = await self._unchecked.get()
            if self._editor.has(page, ask["number"]):
                await asyncio.sleep(QUIET)
            await self._apart(page, partial(self._editor.check_room, page, ask))

    async def _apart(self, page: int, answer: Callable[[], EditorAnswer | None]) -> EditorAnswer | None:
        """Compute an answer on another thread, since it may take a second, send it to a page, and return it."""
        found = None
        try:
            found = await asyncio.to_thread(answer)
            self._answer(page, found)
        except Exception as problem:
            self._performing.screen.complain(f"improv: the text on the page could not be looked at: {problem!r}")
        return found

    async def follow(self) -> None:
        """Report changes of the file or its `improv.toml` by other programs, forever."""
        contents = self._contents()
        async for _ in changes(self._path.parent):
            now = self._contents()  # not the times: another program may set them, and clocks are coarse
            if now != contents:
                await self._take_changes()
                contents = now

    def _contents(self) -> Sequence[bytes]:
        """Return the content of the file, its `improv.toml`, and the URDFs that it names, or why they can't be read."""
        files = [self._path, find_robots_file(self._path.parent), *self._robots.urdfs]
        return [_content(path) for path in files if path]

    async def _take_changes(self) -> None:
        """Show pages the content of the file and its `improv.toml` once both are complete, if it is new."""
        self._saved = await settle(self._path, self._saved)
        robots = robots_or_problem(self._path.parent)
        try:
            version = read_version(self._path)
        except ReadError as problem:  # pages keep their text
            self._performing.screen.complain(f"improv: {problem}")
            version = self._version
        if version != self._version:
            self._performing.screen.say(f"{self._path.name} was changed by another program")
        if robots != self._robots:
            self._robots = self._editor.robots = robots
        elif version == self._version:
            return
        self._version = version
        self._show()

    async def _write(self, page: int, ask: Write, asked: int) -> None:
        """Save the text of a page, and play it."""
        try:
            self._version = write_text(self._path, ask["text"], ask["revision"])
        except WriteError as problem:
            self._performing.screen.complain(f"improv: {problem}")
            self._answer(page, {"type": "write", "number": ask["number"], "revision": "", "problem": str(problem)})
            await self._take_changes()  # the page has to choose
            return
        revision = self._version.revision
        self._answer(page, {"type": "write", "number": ask["number"], "revision": revision, "problem": ""})
        self._show()
        while robots_or_problem(self._path.parent) != self._robots:
            await self._take_changes()  # no robot may move by limits that somebody has just changed
        analysis = self._editor.analysis(ask["text"])
        await self._performing.play_if_right(analysis, self._path, asked)

    def _show(self) -> None:
        """Send all pages the content of the file."""
        ask, path, toml = self._performing.playback.ask, str(absolute(self._path)), self._robots.text
        text, revision = self._version.text, self._version.revision
        ask({"type": "source", "path": path, "text": text, "revision": revision, "toml": toml})

    def _answer(self, page: int, answer: EditorAnswer | None) -> None:
        if answer:
            self._performing.playback.ask({"type": "answer", "page": page, "answer": answer})


def _content(path: Path) -> bytes:
    try:
        return read_bytes(path)
    except ReadError as problem:
        return str(problem).encode()
