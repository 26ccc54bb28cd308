"""A robot was dragged on the page: its new start goes into improv.toml by way of the editor, where it can be undone."""

from __future__ import annotations

import asyncio
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from lsprotocol import types
from pygls.capabilities import get_capability
from pygls.uris import from_fs_path, to_fs_path

from improv_core.placing import place
from improv_core.program import ReadError, robots_near
from improv_core.robots import FILE_NAME
from improv_core.text import LineIndex
from improv_ls.documents import Document
from improv_ls.session import ANSWER_LIMIT, Session
from improv_ls.to_lsp_places import Changed, workspace_edit


async def offer(ls: Session, document: Document, asked: Mapping[str, Any]) -> None:
    """Ask the editor to make the edit; if it does not, say so in one line. `asked` has metres and degrees."""
    robot = str(asked["robot"])
    edit = _edit(ls, document, robot, float(asked["x"]), float(asked["y"]), float(asked["heading"]))
    workspace = ls.client_capabilities.workspace
    if edit is None or not (workspace and workspace.apply_edit):
        ls.say(
            f"the start of {robot} was not written: put the page's lines into improv.toml", types.MessageType.Warning
        )
        return
    asking = ls.workspace_apply_edit_async(types.ApplyWorkspaceEditParams(edit, f"Improv: start of {robot}"))
    try:
        answer = await asyncio.wait_for(asyncio.shield(asking), ANSWER_LIMIT)
    except Exception:  # no answer, or a refusal
        return
    if not answer.applied:
        ls.say(f"the editor did not take the new start of {robot}", types.MessageType.Warning)


def _edit(
    ls: Session, document: Document, robot: str, x: float, y: float, heading: float
) -> types.WorkspaceEdit | None:
    program = to_fs_path(document.uri) if document.uri.startswith("file:") else None
    if not program:
        return None
    folder = Path(program).parent
    try:
        robots = robots_near(folder)
    except ReadError:
        return None
    edit = place(robots.text, robot, x, y, heading, document.analysis.robots)
    uri = from_fs_path(str(robots.path or folder / FILE_NAME))
    creates = get_capability(ls.client_capabilities, "workspace.workspace_edit.resource_operations") or ()
    if edit is None or uri is None or not (robots.path or types.ResourceOperationKind.Create in creates):
        return None
    made = workspace_edit({uri: Changed(None, LineIndex(robots.text), [edit])}, bool(creates), ls.encoding)
    if made.document_changes and not robots.path:
        made.document_changes = [types.CreateFile(uri), *made.document_changes]
    return made
