"""Turns changes on the page, such as starts, tempos, and the first beats of songs, into lines of the program and of its
`improv.toml`, through the editor, which can undo them."""

from __future__ import annotations

import asyncio
from collections.abc import Mapping, Sequence

from lsprotocol import types

from improv_core.diagnostics import Edit
from improv_core.ide.placing import UNPLACED
from improv_core.page.program_changes import edits_of, is_first_beat
from improv_core.protocol.editing import ProgramChange
from improv_core.robots.config import FILE_NAME
from improv_core.robots.edits import set_first_beat
from improv_core.text import Span, difference
from improv_ls.documents import AnyDocument, Document, RobotsFile, name_of, robots_file_now
from improv_ls.editor import ANSWER_LIMIT, Editor
from improv_ls.to_lsp_locations import Changes, workspace_edit

SONG_NOT_WRITTEN = "its section [music] is missing, or written in an unusual form"
"""The reason in a message if `first_beat` could not be written."""


class Placing:
    """Asks the editor to make edits, one at a time: each is for the text after the previous one."""

    def __init__(
        self, editor: Editor, documents: Mapping[str, Document], robots_files: Mapping[str, RobotsFile]
    ) -> None:
        self._editor = editor
        self._documents = documents
        self._robots_files = robots_files
        self._one_at_a_time = asyncio.Lock()

    async def offer(self, uri: str, asked: ProgramChange) -> None:
        """Ask the editor to make the edit; if it does not, print so in one line."""
        async with self._one_at_a_time:
            document, name = self._documents.get(uri), name_of(uri)
            if not document:
                self._editor.warn(f"{name} was not changed: open it in the editor first")
                return
            edited, edits = self._edits(document, asked)
            name = name_of(edited.uri) if edited else FILE_NAME
            if not edited or edits is None:
                why = SONG_NOT_WRITTEN if asked["type"] == "tune" else UNPLACED
                self._editor.warn(f"{name} was not changed: {why}")
            elif not self._editor.can("workspace.apply_edit"):
                lines = " and ".join(f"`{line}`" for edit in edits for line in edit.text.split("\n") if line.strip())
                self._editor.warn(f"this editor takes no edits: write {lines} into {name} yourself")
            elif edits:
                await self._ask([(edited, edits)], _called(asked))

    def _edits(self, document: Document, asked: ProgramChange) -> tuple[AnyDocument | None, Sequence[Edit] | None]:
        """Return the document or file to change, and the edits; None if the person has to fix something first."""
        if not is_first_beat(asked):
            return document, edits_of(document.analysis, asked)
        path = document.analysis.config.path
        file = robots_file_now(path, self._robots_files) if path else None
        made = set_first_beat(file.lines.text, asked["value"]) if file else None
        if not file or made is None:
            return file, None
        start, end, written = difference(file.lines.text, made)
        return file, [Edit(Span(start, end), written)] if start < end or written else []

    async def _ask(self, changes: Changes, what: str) -> None:
        edit = workspace_edit(changes, self._editor)
        asking = self._editor.server.workspace_apply_edit_async(types.ApplyWorkspaceEditParams(edit, f"Improv: {what}"))
        try:
            applied = (await asyncio.wait_for(asyncio.shield(asking), ANSWER_LIMIT)).applied
        except TimeoutError:  # it may have made the edit, or may still make it
            return
        except Exception:  # a refusal
            applied = False
        if not applied:
            self._editor.warn(f"the editor did not accept the new {what}")


def _called(asked: ProgramChange) -> str:
    if asked["type"] == "place":
        return f"start of {', '.join(asked['start_poses'])}"
    if asked["type"] == "draw" or asked["type"] == "perform":
        return f"line of {asked['robot']}"
    if asked["type"] != "tune":
        return "formation" if asked["type"] == "arrange" else "measure"
    return "tempo" if asked["key"] == "beat" else "first beat of the song"
