"""What plays now, and how the editor is told about it."""

from __future__ import annotations

import asyncio
import os
import sys
import webbrowser
from collections.abc import Mapping
from dataclasses import replace
from typing import Any
from uuid import uuid4

from lsprotocol import types

from improv_core.playback.playback import Options, Playback, each_beat, whole_beats
from improv_core.playback.stage_process import Message, StageError
from improv_core.program.compiler import score_of
from improv_core.program.report import summary
from improv_ls import live
from improv_ls.documents import Document, moved
from improv_ls.placing import Placing
from improv_ls.session import ANSWER_LIMIT, Session

TELL_PERIOD = 1.0
"""Seconds between two messages that tell where it is."""


class Performance:
    """The one thing that plays in a session, on the stages of its settings."""

    def __init__(self, session: Session) -> None:
        self._session = session
        self._playback: Playback | None = None
        self._document: Document | None = None  # as it was saved
        self._generation = 0
        self.is_on = False
        """Whether something plays, or waits to."""
        self._placing = Placing(session)
        self._silenced = self.silenced  # as the editor was last told
        self._telling: asyncio.Task[None] | None = None
        self._progress: asyncio.Task[None] | None = None
        self._closing: set[asyncio.Task[None]] = set()

    async def warm_up(self) -> None:
        """Start the stages before the first save needs them; a problem is told when something is to play."""
        try:
            await self._stages().open()
        except StageError:
            await self.close()

    async def play(self, document: Document, when: str) -> None:
        """Play a right program and say so in one line."""
        playback, analysis = self._stages(), document.analysis
        try:
            generation = await playback.play(score_of(analysis), when)
        except StageError as error:
            self._say_why(error)
            return
        if generation is None:
            return
        self._document, self._generation, self.is_on = document, generation, True
        if self._session.shows_live:
            self._session.protocol.notify(live.EVALUATED, self.moments(0.0))
        self._session.say(f"▶ {summary(analysis)}, {playback.status}")
        if self._session.settings.page_open and playback.page and not self._session.page_shown:
            self._session.page_shown = True
            await self._show(playback.page)

    async def restart(self) -> None:
        """Play from beat 0 what was played last."""
        if self._document:
            await self.play(self._document, "restart")
        else:
            self._session.say(
                "improv.restart: nothing has been played yet: save a program, or use improv.play",
                types.MessageType.Warning,
            )

    async def show_page(self) -> str | None:
        """Show the simulator's page, or say its URL where nothing can show it; that URL, if there is a page."""
        playback = self._stages()
        try:
            await playback.open()
        except StageError as error:
            self._say_why(error)
            return None
        if not playback.page:
            self._session.say("improv.page: set improv.backend to auto, sim or both", types.MessageType.Warning)
            return None
        self._session.page_shown = True
        if not await self._show(playback.page):
            self._session.say(f"the page is at {playback.page}")
        return playback.page

    def moments(self, start: float) -> Mapping[str, Any]:
        """What plays from a beat on, and where it stands in the text as it is now; nothing if nothing was played."""
        if not self._document:
            return {}
        now = self._session.documents.get(self._document.uri, self._document)
        found = live.moments(now, self._document.analysis, self._session.encoding, start)
        return {"generation": self._generation, **found}

    def conduct(self, kind: str, **values: object) -> None:
        """Have what plays do something: a message of the stage's protocol, such as hush."""
        if self._playback:
            self._playback.conduct(kind, **values)

    def toggle(self, command: str, robot: str) -> None:
        """Mute or solo a robot, or end that."""
        if self._playback:
            muted, soloed = self._playback.muted, self._playback.soloed
            self._playback.silence(
                muted ^ {robot} if command == "mute" else muted, soloed ^ {robot} if command == "solo" else soloed
            )

    @property
    def silenced(self) -> tuple[frozenset[str], frozenset[str]]:
        """The muted robots, and the soloed ones."""
        return (self._playback.muted, self._playback.soloed) if self._playback else (frozenset(), frozenset())

    @property
    def robots(self) -> set[str]:
        """The robots of what was played, and those that are muted or soloed."""
        return {*(self._document.analysis.robots if self._document else ()), *self.silenced[0], *self.silenced[1]}

    def renamed(self, old: str, new: str) -> None:
        """What was played is in another file, or in another folder, from here on."""
        if self._document:
            self._document = replace(self._document, uri=moved(self._document.uri, old, new))

    async def close(self) -> None:
        """Stop the robots and end the stages."""
        self._stop_telling()
        playback, self._playback = self._playback, None
        await asyncio.gather(*self._closing, *([playback.close()] if playback else []))

    def _stages(self) -> Playback:
        settings = self._session.settings
        options = Options(
            settings.backend, settings.page_port, settings.ros_python, settings.ros_discovery, takes_start_poses=True
        )
        old = self._playback
        if old and old.options == options:
            return old
        self._playback = new = Playback(options, self._hear)
        if old:
            new.keep_as(old)
            self._closing.add(closing := asyncio.create_task(old.close()))  # only the session's end waits for it
            closing.add_done_callback(self._closing.discard)
        return new

    def _hear(self, message: Message, leads: bool) -> None:
        kind = message["type"]
        if kind == "transport" and leads:
            self._stop_progress()
            self.is_on = message["state"] in ("waiting", "playing", "paused")
            self._tell_transport(message)
            if self.silenced != self._silenced:
                self._silenced = self.silenced
                self._session.ask_again("code_lens")
            if message["state"] == "playing":
                self._progress = asyncio.create_task(self._show_progress(message))
        elif kind == "place" and self._document:
            self._session.soon(self._placing.offer(self._document, message["start_poses"]))
        elif kind == "warning":
            self._session.say(str(message["message"]), types.MessageType.Warning)
        elif kind in ("error", "gone"):
            if kind == "gone" and leads:
                self._stop_telling()
                self.is_on = False
            self._session.say(str(message["message"]), types.MessageType.Error)

    def _tell_transport(self, message: Message) -> None:
        """Tell where it is, and every second that it plays: clocks of editors drift, and clients join late."""
        if self._telling:
            self._telling.cancel()
        if self._session.shows_live:
            self._telling = asyncio.create_task(self._keep_telling(message))

    async def _keep_telling(self, message: Message) -> None:
        while True:
            uri = self._document.uri if self._document else None
            page = self._playback.page if self._playback else None
            self._session.protocol.notify(live.TRANSPORT, live.transport(message, uri, page))
            if message["state"] != "playing":
                return
            await asyncio.sleep(TELL_PERIOD)

    def _stop_telling(self) -> None:
        self._stop_progress()
        if self._telling:
            self._telling.cancel()

    def _stop_progress(self) -> None:
        if self._progress:
            self._progress.cancel()
            self._progress = None

    async def _show_progress(self, transport: Message) -> None:
        """The beat, until cancelled."""
        window = self._session.client_capabilities.window
        if not (window and window.work_done_progress):
            return
        token = f"improv-{uuid4()}"
        create = self._session.window_work_done_progress_create_async(types.WorkDoneProgressCreateParams(token))
        try:
            # Shielded: a late answer to a request that was given up would be an error to pygls.
            await asyncio.wait_for(asyncio.shield(create), ANSWER_LIMIT)
        except Exception:  # no answer, or a refusal: then there is no progress to show
            return
        first = f"beat 1/{whole_beats(transport)}"
        self._report(token, types.WorkDoneProgressBegin(title="Improv", message=first, cancellable=False))
        try:
            async for beat in each_beat(transport):
                self._report(token, types.WorkDoneProgressReport(message=beat))
        finally:
            self._report(token, types.WorkDoneProgressEnd())

    def _report(
        self,
        token: str,
        value: types.WorkDoneProgressBegin | types.WorkDoneProgressReport | types.WorkDoneProgressEnd,
    ) -> None:
        self._session.progress(types.ProgressParams(token, value))

    def _say_why(self, error: StageError) -> None:
        self._session.say(f"Improv can't play: {error}", types.MessageType.Error)

    async def _show(self, url: str) -> bool:
        """Whether the editor or a browser has been asked to."""
        window = self._session.client_capabilities.window
        if window and window.show_document and window.show_document.support:
            params = types.ShowDocumentParams(uri=url, external=True)
            self._session.window_show_document(params)
            return True
        if sys.platform in ("darwin", "win32") or "DISPLAY" in os.environ or "WAYLAND_DISPLAY" in os.environ:
            # Without a screen a browser would be one for the terminal, on top of the editor.
            return await asyncio.to_thread(webbrowser.open, url)
        return False
