"""Robots were dragged on the page: their new starts go into improv.toml by way of the editor, where they can be undone.

All of them are one edit, of the text that the editor has. Few editors tell us of their improv.toml. Where one does not,
its text is that of the file, unless it has taken an edit of ours that it has not saved yet: then it has to save first.
"""

from __future__ import annotations

import asyncio
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from lsprotocol import types
from pygls.capabilities import get_capability
from pygls.uris import from_fs_path, to_fs_path

from improv_core.diagnostics import Edit
from improv_core.program.files import ReadError, robots_near
from improv_core.robots.config import FILE_NAME
from improv_core.robots.edits import inline, place
from improv_core.stage.protocol import StartJson
from improv_core.text import LineIndex, Span, difference
from improv_ls.documents import Document
from improv_ls.session import ANSWER_LIMIT, Session
from improv_ls.to_lsp_places import Changed, workspace_edit


@dataclass(frozen=True, slots=True)
class _File:
    """An improv.toml, as the editor has it; the version is None where it has not told us of it."""

    path: Path
    uri: str
    text: str
    version: int | None
    exists: bool


_Stamp = tuple[int, int, int] | None
"""Changes whenever a file is saved; None while there is none."""


class Placing:
    """Offers the editor new starts, one edit at a time."""

    def __init__(self, session: Session) -> None:
        self._session = session
        self._unsaved: dict[Path, _Stamp] = {}  # files edited here and not saved since, as they were then
        self._one_at_a_time = asyncio.Lock()

    async def offer(self, document: Document, asked: Mapping[str, StartJson]) -> None:
        """Ask the editor to make the edit; if it does not, say so in one line. `asked` has metres and degrees."""
        starts = {robot: (pose["x"], pose["y"], pose["heading"]) for robot, pose in asked.items()}
        async with self._one_at_a_time:
            file = _find(self._session, document)
            made = place(file.text, starts, document.analysis.robots) if file else None
            if file and file.version is None and self._is_unsaved(file):
                self._warn("save improv.toml first: it has starts that are not saved yet")
            elif not file or not made or not _can_write(self._session, file):
                lines = " and ".join(f"robots.{robot}.start = {inline(start)}" for robot, start in starts.items())
                self._warn(f"improv.toml was left as it is: write {lines} there by hand")
            elif made != file.text:
                await self._ask(document, file, made, ", ".join(starts))

    async def _ask(self, document: Document, file: _File, made: str, robots: str) -> None:
        """Have the editor put the text that was made in the place of the file's."""
        self._unsaved[file.path] = _stamp(file.path)
        params = types.ApplyWorkspaceEditParams(_edit(self._session, file, made), f"Improv: start of {robots}")
        asking = self._session.workspace_apply_edit_async(params)
        try:
            applied = (await asyncio.wait_for(asyncio.shield(asking), ANSWER_LIMIT)).applied
        except TimeoutError:  # it may have made the edit, or make it yet
            return
        except Exception:  # a refusal
            applied = False
        if not applied:
            del self._unsaved[file.path]
            self._warn(f"the editor did not take the new start of {robots}")
            return
        self._unsaved[file.path] = _stamp(file.path)  # a new file may be there now, still empty
        now = _find(self._session, document)
        if now and (now.version is not None or now.text == made):  # we are told of it, or it is saved already
            del self._unsaved[file.path]

    def _warn(self, line: str) -> None:
        self._session.say(line, types.MessageType.Warning)

    def _is_unsaved(self, file: _File) -> bool:
        """Whether the file is still as it was before an edit of ours; one of ours is never empty."""
        known = self._unsaved
        if file.path in known and known[file.path] != _stamp(file.path) and (file.text or not file.exists):
            del known[file.path]
        return file.path in known


def _find(session: Session, document: Document) -> _File | None:
    program = to_fs_path(document.uri) if document.uri.startswith("file:") else None
    if not program:
        return None
    folder = Path(program).parent
    try:
        robots = robots_near(folder)
    except ReadError:
        return None
    path = robots.path or folder / FILE_NAME
    for known in session.documents.values():
        if known.uri.startswith("file:") and to_fs_path(known.uri) == str(path):
            return _File(path, known.uri, known.lines.text, known.version or 0, True)
    uri = from_fs_path(str(path))
    return _File(path, uri, robots.text, None, robots.path is not None) if uri else None


def _stamp(path: Path) -> _Stamp:
    try:
        found = path.stat()
    except OSError:
        return None
    return found.st_mtime_ns, found.st_ino, found.st_size


def _can_write(session: Session, file: _File) -> bool:
    """Whether the editor can be asked to."""
    workspace = session.client_capabilities.workspace
    can_edit = bool(workspace and workspace.apply_edit)
    return can_edit and (file.exists or types.ResourceOperationKind.Create in _operations(session))


def _edit(session: Session, file: _File, made: str) -> types.WorkspaceEdit:
    """The edit after which the editor has the text that was made."""
    changes = get_capability(session.client_capabilities, "workspace.workspace_edit.document_changes")
    start, end, text = difference(file.text, made)
    changed = Changed(file.version, LineIndex(file.text), [Edit(Span(start, end), text)])
    edit = workspace_edit({file.uri: changed}, bool(changes or _operations(session)), session.encoding)
    if edit.document_changes and not file.exists:
        create = types.CreateFile(file.uri, options=types.CreateFileOptions(ignore_if_exists=True))
        edit.document_changes = [create, *edit.document_changes]
    return edit


def _operations(session: Session) -> Sequence[types.ResourceOperationKind | str]:
    return get_capability(session.client_capabilities, "workspace.workspace_edit.resource_operations") or ()
