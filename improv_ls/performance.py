"""What is playing, and how the editor is told about it."""

from __future__ import annotations

import asyncio
import os
import sys
import webbrowser
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any
from uuid import uuid4

from lsprotocol import types
from pygls.exceptions import JsonRpcException

from improv_core.diagnostics import Severity
from improv_core.ide.inlay_hint import Hint
from improv_core.ide.inlay_hint_playing import playing_hints
from improv_core.ide.moments import SoFar
from improv_core.ide.selection import Selection, UnplayableError, select
from improv_core.playback.playback import Change, News, Playback, each_beat
from improv_core.playback.stage_process import StageError
from improv_core.playback.start import Options
from improv_core.program.compiler import score_of
from improv_core.program.report import Mistake, mistakes, summary
from improv_core.robots.config import FILE_NAME
from improv_core.score.movement import near
from improv_core.score.performance import SenseEdge
from improv_core.score.senses import Key
from improv_core.stage.protocol import DEADMAN_LIMIT, Form, Place, SceneJson, State, TransportMessage, When
from improv_core.text import Span
from improv_ls import live
from improv_ls.documents import Document, RobotsFile, moved, name_of, opened, path_of
from improv_ls.editor import ANSWER_LIMIT, Editor
from improv_ls.hinting import Hinting
from improv_ls.placing import Placing
from improv_ls.records import By, Records, file_of

TRANSPORT_PERIOD = 1.0
"""Seconds between two messages that tell which beat is playing."""
KEY_PERIOD = DEADMAN_LIMIT / 3
"""Seconds between two messages that a sense's key is held: if they stop, it counts as let go."""
DECIDED_PERIOD = 0.03
"""Seconds in which what senses decide is collected before the editor is told."""
HINT = "this save started the dance over; with the setting improv.onSave at continue, robots you don't edit dance on"


class Performance:
    """The one dance that plays in a session, on the backend of its settings."""

    def __init__(
        self,
        editor: Editor,
        documents: Mapping[str, Document],
        robots_files: Mapping[str, RobotsFile],
        records: Records,
    ) -> None:
        self._editor = editor
        self._records = records
        self._documents = documents
        self._playback: Playback | None = None
        self._sent: dict[int, Document] = {}  # by generation: the one that plays, and those that are to take over
        self._latest: Document | None = None  # of them
        self._before: str | None = None  # its id in the history, if a version from there plays
        self._only: Selection | None = None  # what plays of it, if not all
        self._node: str | None = None  # as the improv.toml of the latest dance names it
        self._generation = 0  # of the one that plays
        self._edges: list[SenseEdge] = []  # what has been sensed since this scene began
        self._so_far = SoFar(edges=self._edges)  # how it has been performed
        self._held: dict[str, asyncio.Task[None]] = {}  # keys of senses
        self._changed: asyncio.TimerHandle | None = None  # what was decided is about to be told
        self._state: State = "stopped"
        self._transport: TransportMessage | None = None
        self._hinting = Hinting(editor, self._hints)
        self._hinted = False
        self._refused = 0  # the count of stops when the editor was last told that something did not begin
        self._page_shown = False
        self._placing = Placing(editor, robots_files)
        self._silenced = self.silenced  # as the editor was last told
        self._telling: asyncio.Task[None] | None = None
        self._progress: asyncio.Task[None] | None = None
        self._closing: set[asyncio.Task[None]] = set()

    async def warm_up(self) -> None:
        """Start the stages before the first save needs them. A problem is reported once something is to play."""
        try:
            await self._stages().open()
        except StageError:
            await self.close()

    async def play(self, document: Document, asked: int, by: By | None = "command") -> None:
        """Play a program and say so in one line, or say why not.

        `asked` is the count of stops when somebody asked for it: after a stop since then, it does not begin.
        """
        self._before = None
        self._present(document)
        if refusal := _refusal(document):
            self._refuse(refusal)
            return
        restarts = self._state == "playing" and self._editor.settings.on_save is None
        await self._play(document, self._when, asked, by)
        if restarts and not self._hinted:
            self._hinted = True
            self._editor.say(HINT)

    async def play_only(self, document: Document, wanted: Span | str, asked: int) -> None:
        """Play only what a span touches, or a name, and say so in one line, or say why not. `asked` as for `play`."""
        try:
            only = select(document.analysis, wanted)
        except UnplayableError as error:
            self._refuse(str(error))
            return
        if not document.analysis.cast.ok:
            self._refuse(_wrong_robots(document))
            return
        self._present(document, only=True)
        await self._play(replace(document, analysis=only.analysis), self._when, asked, only=only)

    @property
    def _when(self) -> When:
        """When what is asked for takes over from what plays."""
        settings = self._editor.settings
        return settings.switch_at if settings.on_save == "continue" else "restart"

    def _refuse(self, why: str) -> None:
        keeps = "; the previous dance keeps playing" if self._playback and self._playback.is_on else ""
        self._editor.warn(f"✗ {why}{keeps}")

    async def _play(
        self, document: Document, when: When, asked: int, by: By | None = "command", only: Selection | None = None
    ) -> None:
        analysis = document.analysis
        self._node = analysis.cast.node
        playback = self._stages()
        try:
            bar = self._editor.settings.beats_per_bar
            name, simulated = name_of(document.uri), bool(only and only.ghost)
            generation = await playback.play(score_of(analysis), name, asked, when, bar, simulated=simulated)
        except StageError as error:
            self._say_why(error)
            return
        if generation is None:
            if self._refused != playback.stops.count:  # one line, however many saves one stop was newer than
                self._refused = playback.stops.count
                self._editor.warn(f"■ {name_of(document.uri)} was stopped before it began: save to play it")
            return
        self._sent[generation] = self._latest = document
        self._only = only
        if by:
            self._records.played(document, by)
        self._editor.say(f"▶ {f'{only.name}: ' if only else ''}{summary(analysis)}, {playback.status}")
        if self._editor.settings.page_open and playback.page and not self._page_shown:
            self._show(playback)

    async def play_before(self, document: Document, asked: int) -> None:
        """Play the version of a program that played before the one that plays now. `asked` as for `play`.

        Each time again, it plays the one before that, until a save or another command plays something.
        """
        programs = (await self._records.history()).of(file_of(document))
        if self._before:
            earlier = [each for each in programs if each.id < self._before]
        else:
            latest = self._latest if self._latest and self._latest.uri == document.uri else None
            earlier = [each for each in programs if not latest or each.text != latest.analysis.text]
        if not earlier:
            self._editor.warn(f"improv.before: no earlier version of {name_of(document.uri)} has been kept")
            return
        await self.play(opened(document.uri, None, earlier[0].text), asked)
        self._before = earlier[0].id

    async def restart(self, asked: int) -> None:
        """Play the last dance again from beat 0. `asked` as for `play`."""
        if self._latest:
            await self._play(self._latest, "restart", asked, only=self._only)
        else:
            self._editor.warn("improv.restart: nothing has been played yet; save a program or use improv.play")

    async def show_page(self) -> str | None:
        """Show the simulator's page, or print its URL if nothing can show it. Returns another URL, if there is a page.

        Each URL opens the page once.
        """
        playback = self._stages()
        try:
            await playback.open()
        except StageError as error:
            self._say_why(error)
            return None
        if not playback.page:
            self._editor.warn("improv.page: there is no page; set improv.backend to auto, sim or both")
            return None
        if not self._sent and self._documents:
            self._present([*self._documents.values()][-1])  # the last one that was opened
        self._show(playback)
        return playback.link()

    def _present(self, document: Document, only: bool = False) -> None:
        """Have pages show which program is to be played, and what keeps it from being played, if not `only` some is."""
        path, analysis = path_of(document.uri) or Path(name_of(document.uri)), document.analysis
        found = [] if only else mistakes(path, analysis)
        if not found and not analysis.cast.ok:  # its text could not be read
            found = [Mistake(FILE_NAME, 0, 0, "", analysis.cast.diagnostics[0].message)]
        folder = str(path.parent) if path.is_absolute() else ""
        self._stages().present(path.name, folder, found)

    def moments(self, start: float) -> Mapping[str, Any]:
        """What plays from a beat on, and where that is in the text as it is now; empty if nothing was played."""
        played = self._sent.get(self._generation)
        if not played:
            return {}
        now = self._documents.get(played.uri, played)
        found = live.moments(now, played.analysis, self._editor.encoding, start, self._so_far)
        return {"generation": self._generation, **found}

    def hints(self, uri: str) -> Sequence[Hint]:
        """The inlay hints of a document about what plays now."""
        played = self._sent.get(self._generation)
        if not self._transport or not played or played.uri != uri:
            return ()
        return self._hints(live.beat_of(self._transport))

    def _hints(self, beat: float) -> Sequence[Hint]:
        played = self._sent.get(self._generation)
        if not played or self._state not in ("playing", "paused"):
            return ()
        now = self._documents.get(played.uri, played)
        return playing_hints(played.analysis, now.analysis, beat, self._so_far)

    def resume(self, asked: int) -> None:
        """Go on after a pause. `asked` as for `play`."""
        if self._playback:
            self._playback.resume(asked)

    def conduct(self, message: Change) -> None:
        """Send the stages a message of their protocol, such as seek."""
        if self._playback:
            self._playback.conduct(message)

    def toggle(self, command: str, robot: str) -> None:
        """Mute or solo a robot, or undo that."""
        if self._playback:
            muted, soloed = self._playback.muted, self._playback.soloed
            self._playback.silence(
                muted ^ {robot} if command == "mute" else muted, soloed ^ {robot} if command == "solo" else soloed
            )

    def toggle_key(self, key: str) -> None:
        """Hold the key of a sense until this is called again or the dance stops."""
        if key in self._held:
            self._held.pop(key).cancel()
            self.conduct({"type": "key", "key": key, "held": False})
            self._editor.say(f"{key} is released")
        elif self._state != "playing" or not self._latest:
            self._editor.warn("improv.key: nothing plays; save a program first")
        elif key not in (
            keys := {each.key for each in self._latest.analysis.cast.senses.values() if isinstance(each, Key)}
        ):
            known = f"one of {', '.join(sorted(keys))}" if keys else "but no sense in improv.toml has a key"
            self._editor.warn(f"improv.key: expected the key of a sense, {known}")
        else:
            self._held[key] = asyncio.create_task(self._keep_held(key))
            self._editor.say(f"{key} is held; the same command releases it")

    async def _keep_held(self, key: str) -> None:
        while True:
            self.conduct({"type": "key", "key": key, "held": True})
            await asyncio.sleep(KEY_PERIOD)

    def _release_keys(self) -> None:
        while self._held:
            self._held.popitem()[1].cancel()

    @property
    def silenced(self) -> tuple[frozenset[str], frozenset[str]]:
        """The muted robots, and the soloed ones."""
        return (self._playback.muted, self._playback.soloed) if self._playback else (frozenset(), frozenset())

    @property
    def robots(self) -> set[str]:
        """The robots of the last dance, and those that are muted or soloed."""
        return {*(self._latest.analysis.robots if self._latest else ()), *self.silenced[0], *self.silenced[1]}

    def renamed(self, old: str, new: str) -> None:
        """The file that was played, or a folder around it, has another name now."""
        self._sent = {
            number: replace(document, uri=moved(document.uri, old, new)) for number, document in self._sent.items()
        }
        if self._latest:
            self._latest = replace(self._latest, uri=moved(self._latest.uri, old, new))

    async def close(self) -> None:
        """Stop the robots and end the stages."""
        self._stop_telling()
        playback, self._playback = self._playback, None
        await asyncio.gather(*self._closing, *([playback.close()] if playback else []))

    def _stages(self) -> Playback:
        settings = self._editor.settings
        options = Options(
            settings.backend,
            settings.page_port,
            settings.ros_python,
            settings.ros_discovery,
            settings.ros_standby,
            report_sent=settings.study_log is not None,
            takes_start_poses=True,
            node=self._node,
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
        if message["type"] == "transport" and leads:
            self._stop_progress()
            self._follow(message)
            if message["state"] in ("stopped", "ended"):
                self._release_keys()
            self._tell_transport(message)
            self._transport = message
            self._hinting.follow(message)
            if self.silenced != self._silenced:
                self._silenced = self.silenced
                self._editor.refresh("code_lens")
            if message["state"] == "playing":
                self._progress = asyncio.create_task(self._show_progress(message))
            else:
                self._records.rested()
        elif message["type"] == "sent" and leads:
            self._records.sent(message)
        elif message["type"] == "sensed" and message["generation"] == self._generation:
            edge = SenseEdge(near(message["beat"]), message["robot"], message["sense"], message["value"])
            self._edges.append(edge)
        elif message["type"] == "decided" and message["generation"] == self._generation:
            self._tell_soon(message["beat"])
        elif (message["type"] == "place" or message["type"] == "form") and self._latest:
            if asked := _in_files(message, self._only):
                self._editor.soon(self._placing.offer(self._latest, asked))
        elif message["type"] == "warning":
            self._editor.warn(message["message"])
        elif message["type"] == "error" or message["type"] == "gone":
            if message["type"] == "gone" and leads:
                self._stop_telling()
                self._transport = None
                self._hinting.clear()
            self._editor.report(message["message"])

    def _follow(self, message: TransportMessage) -> None:
        """Note what plays, and tell the editor of a program that has taken over."""
        generation, before = message["generation"], self._generation
        self._state, self._generation = message["state"], generation
        scene = message.get("scene") or SceneJson(index=0, begins=0.0)
        so_far = SoFar(message.get("begins", {}), scene["index"], scene["begins"], self._edges)
        if generation == before and self._so_far == so_far and message["beat"]:
            return  # it goes on from there
        self._edges = []
        self._so_far = replace(so_far, edges=self._edges)
        if generation == before:
            self._tell_soon(message["beat"])
            return
        if not self._latest:
            return
        self._sent.setdefault(generation, self._latest)  # the page restarts it
        self._sent = {number: document for number, document in self._sent.items() if number >= generation}
        if self._editor.takes_own_messages:
            self._editor.server.protocol.notify(live.EVALUATED, self.moments(message["beat"]))

    def _tell_soon(self, beat: float) -> None:
        """Tell the editor what plays from a beat on, now that senses have decided something."""
        if self._editor.takes_own_messages and not self._changed:
            self._changed = asyncio.get_running_loop().call_later(DECIDED_PERIOD, self._tell_decided, beat)

    def _tell_decided(self, beat: float) -> None:
        self._changed = None
        if found := self.moments(beat):
            self._editor.server.protocol.notify(live.EVALUATED, found)

    def _tell_transport(self, message: TransportMessage) -> None:
        """Tell which beat is playing, again every second: clocks of editors drift, and clients join late."""
        if self._telling:
            self._telling.cancel()
        if self._editor.takes_own_messages:
            self._telling = asyncio.create_task(self._keep_telling(message))

    async def _keep_telling(self, message: TransportMessage) -> None:
        while True:
            document = self._sent.get(self._generation)
            uri = document.uri if document else None
            page = self._playback.page if self._playback else None
            self._editor.server.protocol.notify(live.TRANSPORT, live.transport(message, uri, page))
            if message["state"] != "playing":
                return
            await asyncio.sleep(TRANSPORT_PERIOD)

    def _stop_telling(self) -> None:
        self._stop_progress()
        self._release_keys()
        self._hinting.stop()
        if self._changed:
            self._changed.cancel()
            self._changed = None
        if self._telling:
            self._telling.cancel()

    def _stop_progress(self) -> None:
        if self._progress:
            self._progress.cancel()
            self._progress = None

    async def _show_progress(self, transport: TransportMessage) -> None:
        """Show the beat, until cancelled."""
        if not self._editor.can("window.work_done_progress"):
            return
        token = f"improv-{uuid4()}"
        create = self._editor.server.window_work_done_progress_create_async(types.WorkDoneProgressCreateParams(token))
        try:
            # Shielded: pygls fails on a late answer to a request that was cancelled here.
            await asyncio.wait_for(asyncio.shield(create), ANSWER_LIMIT)
        except Exception:  # no answer or a refusal: this client shows no progress
            return
        begun = False
        try:
            async for beat in each_beat(transport):
                if not self._editor.is_read:  # Helix shows the beat in the line of the message
                    continue
                if begun:
                    self._report(token, types.WorkDoneProgressReport(message=beat))
                else:
                    begun = True
                    self._report(token, types.WorkDoneProgressBegin(title="Improv", message=beat, cancellable=False))
        finally:
            if begun:
                self._report(token, types.WorkDoneProgressEnd())

    def _report(
        self,
        token: str,
        value: types.WorkDoneProgressBegin | types.WorkDoneProgressReport | types.WorkDoneProgressEnd,
    ) -> None:
        self._editor.server.progress(types.ProgressParams(token, value))

    def _say_why(self, error: StageError) -> None:
        self._editor.report(f"Improv can't play: {error}")

    def _show(self, playback: Playback) -> None:
        self._page_shown = True
        self._editor.soon(self._show_or_say(playback))

    async def _show_or_say(self, playback: Playback) -> None:
        """Have the editor show the page, or else a browser; print its URL if neither does."""
        url = playback.link(own=True)
        if url is None:  # closed meanwhile
            return
        if self._editor.can("window.show_document.support"):
            params = types.ShowDocumentParams(uri=url, external=True)
            answer = self._editor.server.window_show_document_async(params)
            try:
                # Shielded: an editor may ask the person first, and pygls fails on an answer to a cancelled request.
                shown = (await asyncio.wait_for(asyncio.shield(answer), ANSWER_LIMIT)).success
            except (JsonRpcException, TimeoutError):
                shown = False
            # Helix says that it has shown the page before it looks for a browser.
            shown = shown and (self._editor.takes_own_messages or _has_screen())
        else:
            # Without a screen, a browser would be one for the terminal, on top of the editor.
            shown = _has_screen() and await asyncio.to_thread(webbrowser.open, url)
        if not shown:
            # Another URL, as the first one may have been seen by others. A warning, so that it can be read.
            self._editor.warn(f"page: {playback.link()}")


def _in_files(asked: Place | Form, only: Selection | None) -> Place | Form | None:
    """What of it can be written to improv.toml: a ghost is in no file."""
    if asked["type"] == "form" or not only or not only.ghost:
        return asked
    poses = {robot: pose for robot, pose in asked["start_poses"].items() if robot != only.ghost}
    return {**asked, "start_poses": poses} if poses else None


def _has_screen() -> bool:
    """Whether a browser can open where the server runs, which it can't over SSH."""
    if sys.platform in ("darwin", "win32"):
        return "SSH_CONNECTION" not in os.environ
    return "DISPLAY" in os.environ or "WAYLAND_DISPLAY" in os.environ


def _wrong_robots(document: Document) -> str:
    """Why robots may not move, if improv.toml has errors."""
    cast = document.analysis.cast
    return "improv.toml has errors" if cast.text else cast.diagnostics[0].message  # without it, editors can't show them


def _refusal(document: Document) -> str | None:
    """Why a program cannot be played."""
    cast = document.analysis.cast
    if not cast.ok:
        return _wrong_robots(document)
    errors = [each for each in document.analysis.diagnostics if each.severity is Severity.ERROR]
    if not errors:
        return None
    line = document.lines.position(errors[0].span.start).line + 1
    more = f" (and {len(errors) - 1} more)" if len(errors) > 1 else ""
    return f"line {line}: {errors[0].message}{more}"
