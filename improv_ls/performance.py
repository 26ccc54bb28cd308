"""The one dance that plays in a session: people start it and control it, and get its messages."""

from __future__ import annotations

import asyncio
from collections.abc import Callable, Mapping
from contextlib import suppress
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import NamedTuple

from improv_core.ide.rehearsal import rehearse, scenes_named
from improv_core.ide.selection import Selection, UnplayableError, select
from improv_core.ipc.stage_process import StageError
from improv_core.outputs.ros.setup.interpreter import find_ros_python
from improv_core.program.analysis import Analysis
from improv_core.program.compiler import score_of
from improv_core.program.report import Mistake, mistakes, summary
from improv_core.protocol.commands import Stop
from improv_core.protocol.editing import Form, PlaceRobots
from improv_core.protocol.messages import Misplaced, TransportMessage, When
from improv_core.protocol.robot_messages import FaultMessage
from improv_core.robots.config import FILE_NAME
from improv_core.score.score import Score
from improv_core.session.acts import News
from improv_core.session.on_request import StageRequest
from improv_core.session.session import Playback
from improv_core.session.start import Options
from improv_core.session.state import PlayScore
from improv_core.storage.history import Played
from improv_core.text import Span
from improv_ls.documents import Document, RobotsFile, name_of, opened, path_of
from improv_ls.editor import Editor
from improv_ls.held_keys import HeldKeys
from improv_ls.hinting import Hinting
from improv_ls.live import Live
from improv_ls.page import show_page
from improv_ls.placing import Placing
from improv_ls.playing import Playing
from improv_ls.progress import Progress
from improv_ls.records import Records, file_of
from improv_ls.refusals import refusal, wrong_robots
from improv_ls.settling import Settling

HINT = "this save started the dance over; set improv.onSave to continue, and robots you don't edit keep dancing"


class _Ready(NamedTuple):
    """A score, and a line that sums it up."""

    score: Score
    summary: str


def _ready(analysis: Analysis) -> _Ready:
    return _Ready(score_of(analysis), summary(analysis))


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
        self.live = Live(editor, self.playing, lambda: self._playback.state if self._playback else None)
        self.keys = HeldKeys(editor, self.playing, self.ask)
        self._before: Played | None = None  # the version from the history that plays, if one does
        self._only: Selection | None = None  # the part of it that plays, if not all
        self._node: str | None = None  # the name in the improv.toml of the latest dance
        self._hinting = Hinting(editor, lambda beat: settling.run(partial(self.playing.hints_at, beat)))
        self._progress = Progress(editor)
        self._hinted = False
        self._wanted: object = None  # the latest program that somebody asked to play
        self._refused = 0  # the count of stops at the latest message that a dance did not begin
        self._page_shown = False
        self._offered = False  # true while a button offers to begin, wherever robots stand
        self._placing = Placing(editor, documents, robots_files)
        self._closing: set[asyncio.Task[None]] = set()

    async def warm_up(self) -> None:
        """Start the stages before the first save needs them. An error is reported once a program should play."""
        with suppress(StageError):
            await self._stages().open()

    async def play(self, document: Document, asked: int, text: str | None = None, *, keep: bool = True) -> None:
        """Play a program and print one line about it, or print why not; with another `text`, if it was saved with that.

        `asked` is the count of stops when somebody asked for it: after a stop since then, it does not begin. With
        `keep`, the history gets it.
        """
        self._before = None
        await self._play_whole(document, asked, text, keep=keep)

    async def play_only(self, document: Document, wanted: Span | str, asked: int) -> None:
        """Play only the statements that a span touches, or a name, and print one line, or print why not. `asked` as for
        `play`."""
        await self._play_some(document, lambda analysis: select(analysis, wanted), asked)

    async def play_scenes(
        self, document: Document, ends: tuple[str | int | None, str | int | None], asked: int
    ) -> None:
        """Play only the scenes from one to another, as `play_only` does, with robots at their places at that time."""
        await self._play_some(document, lambda analysis: rehearse(analysis, scenes_named(analysis, *ends)), asked)

    async def _play_some(self, document: Document, choose: Callable[[Analysis], Selection], asked: int) -> None:
        async with self._preparing:
            document = await self._settling.settled(document)
            try:
                only = await self._settling.run(partial(choose, document.analysis))
            except UnplayableError as error:
                self._refuse(str(error))
                return
            ready = await self._settling.run(lambda: wrong_robots(document) or _ready(only.analysis))
        if isinstance(ready, str):
            self._refuse(ready)
            return
        self._before = None
        self._present(document, only=True)
        await self._play(replace(document, analysis=only.analysis), ready, self._when, asked, only=only)

    async def _play_whole(self, document: Document, asked: int, text: str | None = None, *, keep: bool = True) -> None:
        async with self._preparing:
            document = await self._settling.settled(document, text)
            ready = await self._settling.run(lambda: refusal(document) or _ready(document.analysis))
        self._present(document)
        if isinstance(ready, str):
            self._refuse(ready)
            return
        restarts = self.playing.state == "playing" and self._editor.settings.on_save is None
        await self._play(document, ready, self._when, asked, keep=keep)
        if restarts and not self._hinted:
            self._hinted = True
            self._editor.say(HINT)

    @property
    def _when(self) -> When:
        """The time at which a new program takes over from the one that plays."""
        settings = self._editor.settings
        return settings.switch_at if settings.on_save == "continue" else "restart"

    def _refuse(self, why: str) -> None:
        keeps = "; the previous dance keeps playing" if self._playback and self._playback.state.is_on else ""
        self._editor.warn(f"✗ {why}{keeps}")

    async def _play(
        self,
        document: Document,
        ready: _Ready,
        when: When,
        asked: int,
        only: Selection | None = None,
        keep: bool = True,
    ) -> None:
        self._wanted = wanted = object()
        analysis = document.analysis
        self._node = analysis.config.node
        playback = self._stages()
        try:
            bar = self._editor.settings.beats_per_bar
            name, simulated = name_of(document.uri), bool(only and only.ghost)
            generation = await playback.play(PlayScore(ready.score, name, asked, when, bar, simulated=simulated))
        except StageError as error:
            self._report_failure(error)
            return
        if generation is None:
            if self._playback not in (None, playback):  # others replaced the stages that it waited for
                if wanted is self._wanted:
                    await self._play(document, ready, when, asked, only, keep)
                return
            stops = playback.stops
            # One line, however many saves came before one stop. An emergency stop that is on already has its line.
            if not stops.pressed["topics"] and self._refused != stops.count:
                self._refused = stops.count
                self._editor.warn(f"■ {name_of(document.uri)} was stopped before it began: save to play it")
            return
        self.playing.sent(generation, document, ready.score)
        self._only = only
        if keep:
            self._records.played(document)
        self._editor.say(f"▶ {f'{only.name}: ' if only else ''}{ready.summary}, {playback.state.status}")
        if only and only.note:
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
            latest = self.playing.latest
            current = latest.analysis.text if latest and latest.uri == document.uri else None
            earlier = [each for each in programs if each.text != current]
        if not earlier:
            self._editor.warn(f"improv.before: no earlier version of {name_of(document.uri)} has been kept")
            return
        self._before = earlier[0]
        await self._play_whole(opened(document.uri, None, earlier[0].text), asked)

    async def restart(self, asked: int) -> None:
        """Play the last dance again from beat 0. `asked` as for `play`."""
        if latest := self.playing.latest:
            async with self._preparing:
                ready = await self._settling.run(partial(_ready, latest.analysis))
            await self._play(latest, ready, "restart", asked, only=self._only)
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

    def _present(self, document: Document, only: bool = False) -> None:
        """Have pages show the program that should play, and the errors that prevent it, unless `only` some of it
        plays."""
        path, analysis = path_of(document.uri) or Path(name_of(document.uri)), document.analysis
        found = [] if only else mistakes(path, analysis)
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
        muted, soloed = self.silenced
        if command == "mute":
            muted ^= {robot}
        else:
            soloed ^= {robot}
        self.ask({"type": "silence", "muted": sorted(muted), "soloed": sorted(soloed)})

    @property
    def silenced(self) -> tuple[frozenset[str], frozenset[str]]:
        """Return the muted robots, and the soloed ones."""
        return self._playback.state.silenced if self._playback else (frozenset(), frozenset())

    @property
    def robots(self) -> set[str]:
        """Robots of the last dance, and those that are muted or soloed."""
        latest = self.playing.latest
        return {*(latest.analysis.robots if latest else ()), *self.silenced[0], *self.silenced[1]}

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
        )
        old = self._playback
        if old and old.options == options:
            return old
        self._playback = new = Playback(options, self._hear, self._editor.server.stops)
        if old:
            new.keep_as(old)
            self._closing.add(closing := asyncio.create_task(old.close()))  # only the session's end waits for it
            closing.add_done_callback(self._closing.discard)
        return new

    def _hear(self, message: News, leads: bool) -> None:
        if message["type"] == "transport":
            if leads and not self.playing.is_old(message):
                self._follow(message)
        elif message["type"] == "watched" and "framed" in message:
            self.live.framed(message["framed"])
        elif message["type"] == "sensed" and message["generation"] == self.playing.generation:
            self.playing.sensed(message)
            self.live.sensed()
        elif message["type"] == "tune" and self.playing.latest:
            if self._only and self._only.moved:
                self._editor.warn("this rehearsal doesn't begin at beat 0: play the program to change its song")
            else:
                self._editor.soon(self._placing.offer(self.playing.latest.uri, message))
        elif (message["type"] == "place" or message["type"] == "form") and self.playing.latest:
            if self._only and self._only.moved:
                self._editor.warn("this rehearsal doesn't begin at the starts: play the program to move them")
            elif asked := _without_ghost(message, self._only):
                self._editor.soon(self._placing.offer(self.playing.latest.uri, asked))
        elif message["type"] == "fault":
            if leads:
                self._tell_fault(message)
        elif message["type"] == "misplaced" and leads:
            self._editor.soon(self._offer_to_begin(message))
        elif message["type"] == "warning" or message["type"] == "unreached":
            self._editor.warn(message["message"])
        elif message["type"] == "error" or message["type"] == "gone":
            if message["type"] == "gone" and leads:
                self._stop_followers()
                self.playing.gone()
                self._hinting.clear()
            if message["type"] == "gone":
                self.live.framed(0)  # its pages reconnect to the next stage
            self._editor.report(message["message"])

    def _tell_fault(self, message: FaultMessage) -> None:
        """Show a person the faults of robots, and their end."""
        if not (line := message["line"]):
            return
        if message["over"]:
            self._editor.say(line)
        elif message["response"] == "stop":
            self._editor.report(line)
        else:
            self._editor.warn(line)

    async def _offer_to_begin(self, message: Misplaced) -> None:
        """Offer a button to begin anyway, once robots are not in their places. After a stop it does nothing."""
        offered, self._offered = self._offered, message["waits"]
        if offered or not message["robots"]:
            return
        count, stops = len(message["robots"]), self._editor.server.stops.count
        what = "1 robot is not in its place" if count == 1 else f"{count} robots are not in their places"
        if await self._editor.offer(f"{what}, so the dance doesn't begin", "Begin anyway"):
            self.ask({"type": "anyway"}, stops)

    def _follow(self, message: TransportMessage) -> None:
        """Pass a message on to all objects that follow the performance."""
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


def _without_ghost(asked: PlaceRobots | Form, only: Selection | None) -> PlaceRobots | Form | None:
    """Return the part of a request that can be written: a ghost is in no program."""
    if asked["type"] == "form" or not only or not only.ghost:
        return asked
    poses = {robot: pose for robot, pose in asked["start_poses"].items() if robot != only.ghost}
    return {**asked, "start_poses": poses} if poses else None
