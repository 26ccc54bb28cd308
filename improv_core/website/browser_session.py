"""All of Improv behind a page that has no server: it runs in a worker of the browser, on one thread."""

from __future__ import annotations

import asyncio
import io
import time
from collections.abc import Callable
from dataclasses import replace
from functools import partial
from pathlib import Path

from improv_core.ipc.rate_limit import Throttle
from improv_core.ipc.stage_process import HearStage
from improv_core.outputs.simulator.collisions import NoCollisions
from improv_core.outputs.simulator.simulator import Simulator
from improv_core.page.answers import Answers
from improv_core.page.broadcast import Broadcast
from improv_core.page.connection import PageConnection
from improv_core.page.open_pages import Pages
from improv_core.page.program_editor import PageEditor
from improv_core.page.stop_confirmations import PageStops
from improv_core.program.compiler import score_of
from improv_core.program.report import mistakes
from improv_core.protocol.commands import Editing, PageRequest
from improv_core.protocol.editing import Analyze, AskPreview, EditorAnswer, Write
from improv_core.robots.config import FILE_NAME, Robots, read_robots
from improv_core.safety.stops import Stops
from improv_core.session.session import Playback
from improv_core.session.start import Options
from improv_core.session.state import Output, PlayScore
from improv_core.slices import unless
from improv_core.website.in_process_stage import InProcessStage

PROGRAM = Path("dance.improv")
"""Name of the program: there are no files."""
UNWRITABLE = "this page can't write improv.toml: copy the line into it"
UNTOUCHED = 0.7
"""Seconds without a key after which the meetings of robots are checked."""
LONGEST_CHECK, LONGEST_PREVIEW = 0.4, 0.1
"""Seconds that this check and a preview may take, because the page waits meanwhile. Longer work is given up, but once
nobody types, a preview has as long as the check."""


class BrowserBackend:
    """Replaces the server of a page. `post` sends the page a message, which is JSON, and `obeyed` the number of a stop
    that was obeyed."""

    def __init__(self, post: Callable[[str], None], obeyed: Callable[[int], None]) -> None:
        self._post = post
        self._obeyed = obeyed
        self._stops = Stops(asleep=lambda: 0.0)
        self._simulator = Simulator(collide=NoCollisions)
        self._pages = Pages(self._simulator.snapshot)
        self._answers = Answers(lambda work: work())
        self._broadcast = Broadcast(
            self._pages, self._answers, lambda do, *values: do(*values), self._confirm, takes_start_poses=False
        )
        options = Options(backend="sim", osc="nowhere")  # browsers have no UDP
        self._asks: asyncio.Queue[tuple[Editing, int]] = asyncio.Queue()
        self._playback = Playback(
            options,
            lambda news, leads: None,  # the page knows it already, and there is no terminal
            self._stops,
            self._start,
            lambda editing, asked: self._asks.put_nowait((editing, asked)),
        )
        self._editor = PageEditor(_robots(""), lambda value: UNWRITABLE)
        self._throttle = Throttle(self._command, lambda delay, do: asyncio.get_running_loop().call_later(delay, do))
        self._text, self._revision, self._beat = "", 0, 0.0
        self._checking: asyncio.TimerHandle | None = None

    async def serve(self, text: str, toml: str, revision: int, beat: float, ready: Callable[[], None]) -> None:
        """Serve the page, forever, beginning with this program and its `improv.toml`, as saved last.

        If it first plays unchanged, it begins at this beat. Once it is `ready`, the page may send requests.
        """
        self._text, self._revision, self._beat = text, revision, beat
        self._editor.robots = _robots(toml)
        self._outbox = self._pages.join()
        self._page = PageConnection("", self._outbox, self._answers, PageStops(), self._stop, self._throttle.take)
        await self._playback.open()
        self._playback.present(PROGRAM.name, "")
        self._show()
        ready()
        await asyncio.gather(self._pages.watch(), self._page.send_by(self._send), self._obey())

    async def _send(self, text: str) -> None:
        self._post(text)

    def hear(self, text: str) -> None:
        """Take a request of the page. An invalid one is dropped."""
        self._page.receive(text)

    def use(self, toml: str) -> None:
        """Have the program use another `improv.toml` when it plays next."""
        self._editor.robots = _robots(toml)
        self._show()

    def paths(self) -> str | None:
        """Return the paths of the program that plays, as SVG; None if there are none."""
        return self._answers.picture()

    def code(self, text: str) -> str:
        """Return a QR code that holds a text, as SVG."""
        import segno

        out = io.BytesIO()
        segno.make(text, error="l", micro=False).save(out, kind="svg", xmldecl=False, scale=4, border=2, light="white")
        return out.getvalue().decode()

    def _stop(self, number: int) -> None:
        self._throttle.take({"type": "stop", "direct": str(number)})

    def _confirm(self, direct: str) -> None:
        self._obeyed(int(direct))

    def _command(self, command: PageRequest) -> None:
        self._stage.tell({"type": "request", "command": command})

    async def _start(self, sink: Output, options: Options, token: str, hear: HearStage, stops: Stops) -> InProcessStage:
        self._stage = InProcessStage(self._simulator, self._broadcast, hear, stops)
        return self._stage

    async def _obey(self) -> None:
        """Answer the page's requests while somebody edits the program."""
        while True:
            editing, asked = await self._asks.get()
            ask = editing["ask"]
            if ask["type"] == "write":
                await self._write(ask, asked)
                continue
            if ask["type"] == "preview":
                if not self._preview(ask, LONGEST_PREVIEW):
                    asyncio.get_running_loop().call_later(UNTOUCHED, self._preview_late, ask)
                continue
            self._answer(self._editor.answer(self._outbox.number, ask))
            if ask["type"] == "analyze":
                self._check_soon(ask)

    def _preview(self, ask: AskPreview, limit: float) -> bool:
        """Send the paths of a text. Return whether all were drawn, each answer within `limit` seconds."""
        answers = self._editor.previews(self._outbox.number, ask)
        while found := self._unless_slow(limit, partial(next, answers, None)):
            if found["type"] == "preview" and not found["waits_for"]:
                return True
        return False

    def _preview_late(self, ask: AskPreview) -> None:
        """Draw paths that took too long while somebody may have typed, or while the browser was busy."""
        if not self._stage.plays:
            self._preview(ask, LONGEST_CHECK)

    def _check_soon(self, ask: Analyze) -> None:
        """Report the meetings of robots once nobody has typed for a moment: that takes time, and there is only one
        thread."""
        if self._checking:
            self._checking.cancel()
        self._checking = asyncio.get_running_loop().call_later(UNTOUCHED, self._check, ask)

    def _check(self, ask: Analyze) -> None:
        if not self._stage.plays:
            self._unless_slow(LONGEST_CHECK, partial(self._editor.check_room, self._outbox.number, ask))

    def _unless_slow(self, limit: float, answer: Callable[[], EditorAnswer | None]) -> EditorAnswer | None:
        """Send an answer and return it, unless it takes more than `limit` seconds."""
        end = time.monotonic() + limit
        found = unless(lambda: time.monotonic() > end, answer)
        self._answer(found)
        return found

    async def _write(self, ask: Write, asked: int) -> None:
        """Play the program on the page. The page keeps the text itself."""
        beat = self._beat if ask["text"] == self._text else 0.0
        self._text, self._beat = ask["text"], 0.0
        self._revision += 1
        self._show()  # the page itself checks that its browser keeps it
        self._answer({"type": "write", "number": ask["number"], "revision": str(self._revision), "problem": ""})
        analysis = self._editor.analysis(self._text)
        self._playback.present(PROGRAM.name, "", mistakes(PROGRAM, analysis))
        if analysis.ok:
            score = replace(score_of(analysis), clock=None)  # nothing from outside reaches a website
            begun = await self._playback.play(PlayScore(score, PROGRAM.name, asked))
            if begun and beat:
                self._playback.ask({"type": "seek", "beat": beat})

    def _show(self) -> None:
        """Send the page its program."""
        path, text, revision, toml = str(PROGRAM), self._text, str(self._revision), self._editor.robots.text
        self._playback.ask({"type": "source", "path": path, "text": text, "revision": revision, "toml": toml})

    def _answer(self, answer: EditorAnswer | None) -> None:
        if answer:
            self._playback.ask({"type": "answer", "page": self._outbox.number, "answer": answer})


def _robots(toml: str) -> Robots:
    return read_robots(toml, Path(FILE_NAME))
