"""The one dance that plays in a session: people start it and control it, and get its messages."""

from __future__ import annotations

import asyncio
from collections.abc import Mapping
from contextlib import suppress
from functools import partial
from pathlib import Path
from typing import assert_never

from improv_core.ide.selection import UnplayableError
from improv_core.ipc.stage_process import StageError
from improv_core.outputs.ros.setup.interpreter import find_ros_python
from improv_core.program.files import PlayedRobots, ReadError
from improv_core.program.report import Mistake, mistakes
from improv_core.protocol.commands import Editing, Stop, is_muted
from improv_core.protocol.editing import NO_DRAFT
from improv_core.protocol.messages import TransportMessage, When
from improv_core.protocol.robot_messages import FaultMessage
from improv_core.protocol.transport import silenced
from improv_core.robots.config import FILE_NAME
from improv_core.session.acts import News
from improv_core.session.on_request import StageRequest
from improv_core.session.session import Playback
from improv_core.session.start import Options, usual_port
from improv_core.session.state import HERE, PlayScore, SessionState, StageKey
from improv_core.storage.history import Played
from improv_ls.documents import Document, RobotsFile, name_of, opened, path_of
from improv_ls.editor import Editor
from improv_ls.held_keys import HeldKeys
from improv_ls.hinting import Hinting
from improv_ls.live import Live
from improv_ls.offers import Offers, OnSave
from improv_ls.page import show_page
from improv_ls.playing import Choose, Playing, PreparedProgram, among, prepare
from improv_ls.progress import Progress
from improv_ls.records import Records, file_of
from improv_ls.settling import Settling

SLOW = 1.0
"""Seconds after which a line says what a program waits for."""


class Performance:
    """The one dance that plays in a session, on the backend of its settings."""

    def __init__(
        self,
        editor: Editor,
        documents: Mapping[str, Document],
        robots_files: Mapping[str, RobotsFile],
        records: Records,
        settling: Settling,
    ) -> None:
        self._settling = settling
        self._preparing = asyncio.Lock()  # programs are prepared in the order in which people asked for them
        self._editor = editor
        self._records = records
        self._documents = documents
        self._playback: Playback | None = None
        self.playing = Playing(documents)
        self._played_robots = PlayedRobots()
        self.live = Live(editor, self.playing, lambda: self.state)
        self.keys = HeldKeys(editor, self.playing, self.ask)
        self.offers = Offers(editor, records, self.playing, self.ask, documents, robots_files)
        self._before: Played | None = None  # the version from the history that plays, if one does
        self._node: str | None = None  # the name in the improv.toml of the latest dance
        self._hinting = Hinting(editor, lambda beat: settling.run(partial(self.playing.hints_at, beat)))
        self._progress = Progress(editor)
        self._wanted: object = None  # the latest program that somebody asked to play
        self._refused = 0  # the count of stops at the latest message that a dance did not begin
        self._page_shown = False
        self.presented = ""
        """The URI of the program that pages show."""
        self._closing: set[asyncio.Task[None]] = set()

    @property
    def state(self) -> SessionState:
        """The state of the session."""
        return self._playback.state if self._playback else SessionState()

    async def warm_up(self) -> None:
        """Start the stages before the first save needs them. An error is reported once a program should play."""
        with suppress(StageError):
            await self._stages().open()

    async def play(
        self,
        document: Document,
        asked: int,
        choose: Choose | None = None,
        *,
        joins: bool = False,
        text: str | None = None,
        keep: bool = True,
        before: Played | None = None,
    ) -> None:
        """Play a program, or what `choose` selects of it, and print one line about it, or print why not. If that
        `joins`, all other robots keep dancing.

        A `text` is the text with which the editor saved it. `asked` is the count of stops when somebody asked for it:
        after a stop since then, it does not begin. With `keep`, the history gets it; `before` is the version in the
        history that this is.
        """
        if not choose:
            self._before = before
        async with self._preparing:
            document = await self._settling.settled(document, text)
            try:
                prepared = await self._settling.run(partial(prepare, document, choose))
                if path := path_of(document.uri):
                    self._played_robots.check(path, document.analysis.config)
            except (UnplayableError, ReadError) as error:
                if not choose:
                    self._present(document)
                self._editor.warn(f"✗ {error}{'; the previous dance keeps playing' if self.state.is_on else ''}")
                return
        if choose:
            self._before = None
        self._present(document, plays=True)
        restarts = not choose and self.playing.state == "playing" and self._editor.settings.on_save is None
        when = self._editor.settings.switch_at if joins else self._when
        await self._play(prepared, when, asked, keep=keep, joins=joins)
        if restarts:
            await self.offers.to_continue()

    @property
    def _when(self) -> When:
        """The time at which a new program takes over from the one that plays."""
        settings = self._editor.settings
        return settings.switch_at if (settings.on_save or self._records.on_save) == "continue" else "restart"

    @property
    def other_on_save(self) -> OnSave | None:
        """The other thing that a save could do with the dance that plays; None if the settings say it."""
        if self._editor.settings.on_save or not self.state.is_on:
            return None
        return "restart" if self._records.on_save == "continue" else "continue"

    async def _play(
        self, prepared: PreparedProgram, when: When, asked: int, *, keep: bool = True, joins: bool = False
    ) -> None:
        self._wanted = wanted = object()
        document, only = prepared.document, prepared.only
        self._node = document.analysis.config.node
        playback, name = self._stages(), name_of(document.uri)
        bar, simulated = self._editor.settings.beats_per_bar, bool(only.ghost)
        waits = asyncio.get_running_loop().call_later(SLOW, _tell_wait, self._editor, playback, name)
        try:
            play = PlayScore(prepared.score, name, asked, when, bar, simulated=simulated, joins=joins)
            generation = await playback.play(play)
        except StageError as error:
            self._report_failure(error)
            return
        finally:
            waits.cancel()
        if generation is None:
            if self._playback not in (None, playback):  # others replaced the stages that it waited for
                if wanted is self._wanted:
                    await self._play(prepared, when, asked, keep=keep, joins=joins)
                return
            stops = playback.stops
            # One line, however many saves came before one stop. An emergency stop that is on already has its line.
            if not stops.pressed["topics"] and self._refused != stops.count:
                self._refused = stops.count
                self._editor.warn(f"■ {name} was stopped before it began: save to play it")
            return
        if joins and self.playing.latest and (played := playback.state.played):
            prepared = among(prepared, played.score, self.playing.latest.only)
        self.playing.sent(generation, prepared)
        if only.span:
            self.live.evaluated(document, only.span)
        if keep:
            self._records.played(document)
        refusals = self._editor.refusals
        line = await self._settling.run(prepared.line)  # not before, since robots would wait for it
        if refusals == self._editor.refusals:  # otherwise, this line would hide that it, or a later one, is refused
            stands = any(is_muted(robot, *self.state.silenced) for robot in prepared.score.parts)
            why = f"; {silenced(*self.state.silenced)}" if stands else ""
            self._editor.say(f"▶ {line}, {playback.state.status}{why}")
        if only.note:
            self._editor.say(only.note)
        if self._editor.settings.page_open and playback.state.page and not self._page_shown:
            self._show(playback)

    async def play_before(self, document: Document, asked: int) -> None:
        """Play the version of a program that played before the current one. `asked` as for `play`.

        Each repetition plays the version before that, until a save or another command plays something.
        """
        file = file_of(document)
        programs = (await self._records.history()).of(file)
        if self._before and self._before.file == file:
            earlier = [each for each in programs if each.id < self._before.id]
        else:
            latest = self.playing.latest and self.playing.latest.document
            current = latest.analysis.text if latest and latest.uri == document.uri else None
            earlier = [each for each in programs if each.text != current]
        if not earlier:
            self._editor.warn(f"improv.before: no earlier version of {name_of(document.uri)} has been kept")
            return
        await self.play(opened(document.uri, None, earlier[0].text), asked, before=earlier[0])

    async def restart(self, asked: int) -> None:
        """Play the last dance again from beat 0. `asked` as for `play`."""
        if self.playing.latest:
            await self._play(self.playing.latest, "restart", asked)
        else:
            self._editor.warn("improv.restart: nothing has been played yet; save a program or use improv.play")

    async def show_page(self) -> str | None:
        """Show the simulator's page, or print its URL if nothing can show it. Return another URL, if there is a page.

        Each URL opens the page once.
        """
        playback = self._stages()
        try:
            await playback.open()
        except StageError as error:
            self._report_failure(error)
            return None
        if not playback.state.page:
            self._editor.warn("improv.page: there is no page; set improv.backend to auto, sim or both")
            return None
        if not self.playing.latest and self._documents:
            latest = await self._settling.settled([*self._documents.values()][-1])  # the one that was opened last
            await self._settling.run(lambda: latest.analysis.diagnostics)
            self._present(latest)
        self._show(playback)
        return playback.link()

    def _present(self, document: Document, plays: bool = False) -> None:
        """Have pages show the program that should play, and the errors that prevent it, unless it `plays`."""
        path, analysis = path_of(document.uri) or Path(name_of(document.uri)), document.analysis
        if document.uri != self.presented:
            self.presented = document.uri
            self.ask(NO_DRAFT)
        found = [] if plays else mistakes(path, analysis)
        if not found and not analysis.config.ok:  # its text could not be read
            found = [Mistake(FILE_NAME, 0, 0, "", analysis.config.diagnostics[0].message)]
        folder = str(path.parent) if path.is_absolute() else ""
        self._stages().present(path.name, folder, found)

    def ask(self, wish: StageRequest, asked: int = 0) -> None:
        """Have the stages obey a command, such as seek. For a resume, `asked` is as for `play`."""
        if self._playback:
            self._playback.ask(wish, asked)

    def toggle(self, command: str, robot: str) -> None:
        """Mute or solo a robot, or undo that."""
        muted, soloed = self.state.silenced
        if command == "mute":
            muted ^= {robot}
        else:
            soloed ^= {robot}
        self.ask({"type": "silence", "muted": sorted(muted), "soloed": sorted(soloed)})

    @property
    def robots(self) -> set[str]:
        """Robots of the last dance, and those that are muted or soloed."""
        latest = self.playing.latest
        return {*(latest.document.analysis.robots if latest else ()), *self.state.silenced[0], *self.state.silenced[1]}

    def stop(self, stop: Stop) -> str | None:
        """Obey `improv stop`, on any thread. Return the line that answers it, unless there are no stages yet."""
        playback = self._playback
        return playback.stop(stop) if playback else None

    async def close(self) -> None:
        """Stop the robots and end the stages."""
        self._stop_followers()
        playback, self._playback = self._playback, None
        await asyncio.gather(*self._closing, *([playback.close()] if playback else []))

    def _stages(self) -> Playback:
        settings = self._editor.settings
        options = Options(
            settings.backend,
            settings.page_port,
            settings.ros_python,
            find_ros_python,
            settings.ros_discovery,
            settings.ros_standby,
            takes_start_poses=True,
            node=self._node,
            osc="network" if settings.osc_network else "here",
            usual_port=usual_port(str(folders[0])) if (folders := self._editor.folders) else 0,
        )
        old = self._playback
        if old and old.options == options:
            return old
        self._playback = new = Playback(options, self._hear, self._editor.server.stops, edit=self._offer_edit)
        if old:
            new.keep_as(old)
            self._closing.add(closing := asyncio.create_task(old.close()))  # only the session's end waits for it
            closing.add_done_callback(self._closing.discard)
        return new

    def _hear(self, message: News, leads: bool) -> None:
        match message["type"]:
            case "page_opened":
                if "framed" in message:
                    self.live.framed(message["framed"])
            case "sensed":
                if message["generation"] == self.playing.generation:
                    self.playing.sensed(message)
                    self.live.sensed()
            case "warning" | "unreached":
                self._editor.warn(message["message"])
            case "error":
                self._editor.report(message["message"])
            case "gone":
                if leads:
                    self._stop_followers()
                    self.playing.gone()
                    self._hinting.clear()
                self.live.framed(0)  # its pages reconnect to the next stage
                self._editor.report(message["message"])
            case "transport":
                if leads and not self.playing.is_old(message):
                    self._follow(message)
            case "fault":
                if leads and message["line"]:
                    self._tell_fault(message)
            case "misplaced":
                if leads:
                    self._editor.soon(self.offers.to_begin(message))
            case "ready" | "stopped" | "armed" | "decided" | "measured" | "sent" | "sent_joints" | "joints" | "vitals":
                pass  # shown on the page, or in a terminal
            case "request" | "seen" | "pressed" | "deserted" | "link" | "pong" | "obeyed" | "lacks":
                pass  # between stages, and between them and the session
            case other:
                assert_never(other)

    def _offer_edit(self, editing: Editing, asked: int) -> None:
        """Have the editor change the program, as a page asks."""
        latest, ask = self.playing.latest, editing["ask"]
        if latest and ask["type"] == "change":
            self.offers.to_edit(latest.document.uri, ask["change"], latest.only)

    def _tell_fault(self, message: FaultMessage) -> None:
        """Show a person the faults of robots, and their end."""
        if message["over"]:
            self._editor.say(message["line"])
        elif message["response"] == "stop":
            self._editor.report(message["line"])
        else:
            self._editor.warn(message["line"])

    def _follow(self, message: TransportMessage) -> None:
        """Pass a message on to all objects that follow the performance."""
        before, resumes = self.playing.transport, message.get("resumes")
        if resumes and not (before and before.get("resumes") == resumes):
            self._editor.soon(self.offers.to_resume(message, resumes))
        self.playing.follow(message)
        self.live.follow(message)
        self._progress.follow(message)
        self._hinting.follow(message)
        if message["state"] in ("stopped", "ended"):
            self.keys.release()

    def _stop_followers(self) -> None:
        """Stop all objects that follow the performance."""
        self._progress.stop()
        self._hinting.stop()
        self.live.stop()
        self.keys.release()

    def _report_failure(self, error: StageError) -> None:
        self._editor.report(f"Improv can't play: {error}")

    def _show(self, playback: Playback) -> None:
        self._page_shown = True
        self._editor.soon(show_page(self._editor, playback))


def _tell_wait(editor: Editor, playback: Playback, name: str) -> None:
    """Say what a program waits for, if it is real robots, which take longest to get ready."""
    start = playback.starting.get(StageKey(HERE, "ros"))
    if start and not start.done():
        editor.say(f"{name} waits until ROS 2 and the standby process that can stop its robots have started")
