"""Starts that people change on the page become lines of the program, through the editor, where that can be undone."""

from __future__ import annotations

import asyncio
from collections.abc import Mapping, Sequence

from lsprotocol import types

from improv_core.diagnostics import Edit
from improv_core.ide.placing import UNPLACED, formed, placed
from improv_core.program.analysis import Analysis
from improv_core.stage.commands import Form, PlaceRobots
from improv_ls.documents import Document, name_of
from improv_ls.editor import ANSWER_LIMIT, Editor
from improv_ls.to_lsp_locations import ChangedText, workspace_edit


class Placing:
    """Asks the editor to make edits, one at a time: each is of the text that the one before has left."""

    def __init__(self, editor: Editor, documents: Mapping[str, Document]) -> None:
        self._editor = editor
        self._documents = documents
        self._one_at_a_time = asyncio.Lock()

    async def offer(self, uri: str, asked: PlaceRobots | Form) -> None:
        """Ask the editor to make the edit; if it does not, say so in one line."""
        async with self._one_at_a_time:
            document, name = self._documents.get(uri), name_of(uri)
            if not document:
                self._editor.warn(f"{name} was not changed: open it in the editor first")
                return
            edits = edits_of(document.analysis, asked)
            if edits is None:
                self._editor.warn(f"{name} was not changed: {UNPLACED}")
            elif not self._editor.can("workspace.apply_edit"):
                lines = " and ".join(f"`{line}`" for edit in edits for line in edit.text.split("\n") if line.strip())
                self._editor.warn(f"this editor takes no edits: write {lines} into {name} yourself")
            elif edits:
                await self._ask(document, edits, asked)

    async def _ask(self, document: Document, edits: Sequence[Edit], asked: PlaceRobots | Form) -> None:
        what = f"start of {', '.join(asked['start_poses'])}" if asked["type"] == "place" else "formation"
        changed = ChangedText(document.version, document.analysis.lines, edits)
        edit = workspace_edit({document.uri: changed}, self._editor.takes_document_changes, self._editor.encoding)
        asking = self._editor.server.workspace_apply_edit_async(types.ApplyWorkspaceEditParams(edit, f"Improv: {what}"))
        try:
            applied = (await asyncio.wait_for(asyncio.shield(asking), ANSWER_LIMIT)).applied
        except TimeoutError:  # it may have made the edit, or may still make it
            return
        except Exception:  # a refusal
            applied = False
        if not applied:
            self._editor.warn(f"the editor did not accept the new {what}")


def edits_of(analysis: Analysis, asked: PlaceRobots | Form) -> Sequence[Edit] | None:
    """The edits of a program that do what was asked for; None if a line of it has to be fixed first."""
    analysis = analysis.settled()
    if asked["type"] == "form":
        return formed(analysis, asked["shape"], asked["distance"], asked["facing"])
    return placed(
        analysis, {robot: (pose["x"], pose["y"], pose["heading"]) for robot, pose in asked["start_poses"].items()}
    )
