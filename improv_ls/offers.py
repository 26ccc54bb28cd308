"""Offers to the person at the editor while a dance plays. After a stop, an older offer does nothing."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import cached_property
from typing import TYPE_CHECKING, Literal

from lsprotocol import types

from improv_core.ide.selection import Selection
from improv_core.protocol.editing import ProgramChange
from improv_core.protocol.messages import Misplaced, TransportMessage
from improv_core.protocol.robot_messages import Resumes
from improv_core.protocol.transport import counted
from improv_core.session.on_request import StageRequest
from improv_ls.documents import Document, RobotsFile
from improv_ls.editor import Editor
from improv_ls.playing import Playing
from improv_ls.records import Records

if TYPE_CHECKING:
    from improv_ls.placing import Placing

OnSave = Literal["continue", "restart"]
SETTINGS = "improv/settings"
OFFER = "this save started the dance over; saves can also continue it, so that robots you don't edit keep dancing"
HINT = "saves can also continue a dance, not start it over: see the code actions"
"""As much as a status line of 80 columns shows."""


class Offers:
    """Makes these offers. `ask` has the stages do what a person chooses, unless a stop has come since this count."""

    def __init__(
        self,
        editor: Editor,
        records: Records,
        playing: Playing,
        ask: Callable[[StageRequest, int], None],
        documents: Mapping[str, Document],
        robots_files: Mapping[str, RobotsFile],
    ) -> None:
        self._editor = editor
        self._records = records
        self._playing = playing
        self._ask = ask
        self._files = documents, robots_files
        self._offered = False  # true while a button offers to begin, wherever robots stand

    @cached_property
    def _placing(self) -> Placing:
        """Writes into programs. Made when a page asks for that: it imports all that plays."""
        from improv_ls.placing import Placing

        return Placing(self._editor, *self._files)

    def set_on_save(self, does: OnSave) -> None:
        """Have saves do that with a dance from now on, in the editor's settings or else in our records."""
        if self._editor.keeps_settings:
            self._editor.server.protocol.notify(SETTINGS, {"onSave": does})
        else:
            self._records.keep_on_save(does)
            what = "continue the dance" if does == "continue" else "start the dance over"
            self._editor.say(f"from now on, saves {what}, unless the setting improv.onSave says otherwise")

    async def to_continue(self) -> None:
        """Offer that saves continue the dance, in nobody's way: once, and never again in any session."""
        if self._records.on_save:
            return
        self._records.keep_on_save("offered")
        if await self._editor.offer(OFFER, "Continue from Now On", instead=HINT, kind=types.MessageType.Info):
            self.set_on_save("continue")

    async def to_begin(self, message: Misplaced) -> None:
        """Offer a button to begin anyway, once robots are not in their places."""
        offered, self._offered = self._offered, message["waits"]
        if offered or not message["robots"]:
            return
        count, stops = len(message["robots"]), self._editor.server.stops.count
        what = "1 robot is not in its place" if count == 1 else f"{count} robots are not in their places"
        line = f"{what}, so the dance doesn't begin"
        if await self._editor.offer(line, "Begin anyway", instead=f"{line}; improv.anyway begins it"):
            self._ask({"type": "resume", "anyway": True}, stops)

    async def to_resume(self, message: TransportMessage, resumes: Resumes) -> None:
        """Offer buttons to continue after a stop that nobody asked for. They do nothing once something plays again."""
        stops = self._editor.server.stops.count
        known: TransportMessage = {**message, "beats": None}  # senses decide how many, and a new stage has heard none
        scene, beat = (f"From {counted(known, at).removesuffix('/∞')}" for at in (resumes["scene"], resumes["beat"]))
        line = "Robots were stopped: resume from this scene, or this beat?"
        pressed = await self._editor.offer(line, scene, beat, instead="Robots were stopped: resume by the code actions")
        latest = self._playing.transport
        if pressed and latest and latest.get("resumes") == resumes:
            self._ask({"type": "resume", "beat": resumes["scene" if pressed == scene else "beat"]}, stops)

    def to_edit(self, uri: str, asked: ProgramChange, only: Selection) -> None:
        """Have the editor change the program, as a page asks. The part of it that plays, `only`, may lack the place to
        change."""
        if only.moved:
            is_music = asked["type"] == "tune"
            begin, change = ("beat 1", "change its song") if is_music else ("the starts", "move them")
            self._editor.warn(f"this rehearsal doesn't begin at {begin}: play the program to {change}")
        elif changed := _without_ghost(asked, only):
            self._editor.soon(self._placing.offer(uri, changed))


def _without_ghost(asked: ProgramChange, only: Selection) -> ProgramChange | None:
    """Return the part of a change that can be written: a ghost is in no program."""
    if asked["type"] != "place" or not only.ghost:
        return asked
    poses = {robot: pose for robot, pose in asked["start_poses"].items() if robot != only.ghost}
    return {**asked, "start_poses": poses} if poses else None
