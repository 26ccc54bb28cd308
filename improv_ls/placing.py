"""Start poses that people change on the page go into improv.toml through the editor, where that can be undone.

All start poses that were dragged, or a formation, are one edit of the text that the editor has. Few editors tell us
about their improv.toml. Where one does not, its text is the file's, unless it has made an edit of ours that it has not
saved yet: then it has to save first.
"""

from __future__ import annotations

import asyncio
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path

from lsprotocol import types
from pygls.uris import from_fs_path

from improv_core.diagnostics import Edit
from improv_core.program.files import ReadError, robots_near
from improv_core.robots.config import FILE_NAME
from improv_core.robots.edits import Start, form, formation_lines, inline, place
from improv_core.stage.commands import Form, PlaceRobots
from improv_core.text import LineIndex, Span, difference
from improv_ls.documents import Document, RobotsFile, path_of
from improv_ls.editor import ANSWER_LIMIT, Editor
from improv_ls.to_lsp_locations import ChangedText, workspace_edit


@dataclass(frozen=True, slots=True)
class _File:
    """An improv.toml as the editor has it; the version is None if the editor has not told us about it."""

    path: Path
    uri: str
    text: str
    version: int | None
    exists: bool


_Stamp = tuple[int, int, int] | None
"""Changes whenever a file is saved; None while there is no file."""


class Placing:
    """Offers the editor new start poses and formations, one edit at a time."""

    def __init__(self, editor: Editor, robots_files: Mapping[str, RobotsFile]) -> None:
        self._editor = editor
        self._robots_files = robots_files
        self._unsaved: dict[Path, _Stamp] = {}  # files edited here and not saved since, as they were then
        self._one_at_a_time = asyncio.Lock()

    async def offer(self, document: Document, asked: PlaceRobots | Form) -> None:
        """Ask the editor to make the edit; if it does not, say so in one line."""
        async with self._one_at_a_time:
            file = self._find(document)
            new_text = _new_text(file.text, asked, document.analysis.robots) if file else None
            if file and file.version is None and self._is_unsaved(file):
                self._editor.warn("save improv.toml first: it has changes from the page that are not saved yet")
            elif not file or not new_text or not self._can_write(file):
                self._editor.warn(f"improv.toml was not changed: add {_lines(asked)} yourself")
            elif new_text != file.text:
                what = f"start of {', '.join(asked['start_poses'])}" if asked["type"] == "place" else "formation"
                await self._ask(document, file, new_text, what)

    async def _ask(self, document: Document, file: _File, new_text: str, what: str) -> None:
        """Have the editor replace the file's text."""
        self._unsaved[file.path] = _stamp(file.path)
        params = types.ApplyWorkspaceEditParams(self._edit(file, new_text), f"Improv: {what}")
        asking = self._editor.server.workspace_apply_edit_async(params)
        try:
            applied = (await asyncio.wait_for(asyncio.shield(asking), ANSWER_LIMIT)).applied
        except TimeoutError:  # it may have made the edit, or may still make it
            return
        except Exception:  # a refusal
            applied = False
        if not applied:
            del self._unsaved[file.path]
            self._editor.warn(f"the editor did not accept the new {what}")
            return
        self._unsaved[file.path] = _stamp(file.path)  # a new file may exist now, still empty
        now = self._find(document)
        if now and (now.version is not None or now.text == new_text):  # we are told about it, or it is saved already
            del self._unsaved[file.path]

    def _is_unsaved(self, file: _File) -> bool:
        """Whether the file is still as it was before an edit of ours, which never leaves it empty."""
        known = self._unsaved
        if file.path in known and known[file.path] != _stamp(file.path) and (file.text or not file.exists):
            del known[file.path]
        return file.path in known

    def _find(self, document: Document) -> _File | None:
        program = path_of(document.uri)
        if not program:
            return None
        try:
            robots = robots_near(program.parent)
        except ReadError:
            return None
        path = robots.path or program.parent / FILE_NAME
        for known in self._robots_files.values():
            if path_of(known.uri) == path:
                return _File(path, known.uri, known.lines.text, known.version or 0, True)
        uri = from_fs_path(str(path))
        return _File(path, uri, robots.text, None, robots.path is not None) if uri else None

    def _can_write(self, file: _File) -> bool:
        """Whether the editor can be asked to."""
        can_edit = bool(self._editor.can("workspace.apply_edit"))
        return can_edit and (file.exists or self._editor.creates_files)

    def _edit(self, file: _File, new_text: str) -> types.WorkspaceEdit:
        """The edit that gives the file its new text."""
        start, end, text = difference(file.text, new_text)
        changed = ChangedText(file.version, LineIndex(file.text), [Edit(Span(start, end), text)])
        versions = self._editor.takes_document_changes or self._editor.creates_files
        new = [] if file.exists else [file.uri]
        return workspace_edit({file.uri: changed}, versions, self._editor.encoding, new)


def _new_text(text: str, asked: PlaceRobots | Form, cast: Iterable[str]) -> str | None:
    """The text of an improv.toml with what was asked for; None if it can't be written there."""
    if asked["type"] == "place":
        return place(text, _starts(asked), cast)
    return form(text, asked["shape"], asked["distance"], asked["facing"])


def _lines(asked: PlaceRobots | Form) -> str:
    """The same text for people to write themselves."""
    if asked["type"] == "place":
        return " and ".join(f"robots.{robot}.start = {inline(pose)}" for robot, pose in _starts(asked).items())
    entries = formation_lines(asked["shape"], asked["distance"], asked["facing"])
    return " and ".join(f"formation.{line}" for line in entries)


def _starts(asked: PlaceRobots) -> Mapping[str, Start]:
    return {robot: (pose["x"], pose["y"], pose["heading"]) for robot, pose in asked["start_poses"].items()}


def _stamp(path: Path) -> _Stamp:
    try:
        found = path.stat()
    except OSError:
        return None
    return found.st_mtime_ns, found.st_ino, found.st_size
