"""textDocument/prepareRename and rename."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from urllib.parse import unquote

from lsprotocol import types
from pygls.exceptions import JsonRpcException
from pygls.uris import from_fs_path

from improv_core.ide import rename as renaming
from improv_core.plain import message_without_links
from improv_core.program.analysis import analyze
from improv_core.program.files import ReadError, read_program
from improv_core.robots.config import Robots, find_robots_file
from improv_core.text import LineIndex
from improv_ls.documents import Document, path_of, robots_of
from improv_ls.positions import to_offset, to_range
from improv_ls.programs import programs_in
from improv_ls.session import Session
from improv_ls.to_lsp_locations import Changed, workspace_edit


def prepare_rename(ls: Session, params: types.PrepareRenameParams) -> types.PrepareRenamePlaceholder | None:
    document = ls.documents.get(params.text_document.uri)
    if not document:
        return None
    try:
        symbol = renaming.renamable(document.analysis, to_offset(document.lines, params.position, ls.editor.encoding))
    except renaming.RefusalError as refusal:
        raise _failed(refusal) from refusal
    return types.PrepareRenamePlaceholder(to_range(document.lines, symbol.span, ls.editor.encoding), symbol.text)


def rename(ls: Session, params: types.RenameParams) -> types.WorkspaceEdit | None:
    document = ls.documents.get(params.text_document.uri)
    if not document:
        return None
    try:
        symbol = renaming.renamable(document.analysis, to_offset(document.lines, params.position, ls.editor.encoding))
        edits = renaming.rename(document.analysis, symbol, params.new_name)
        changed = {document.uri: Changed(document.version, document.lines, edits)}
        if symbol.is_robot:
            changed |= _elsewhere(ls, document, symbol.text, params.new_name)
    except renaming.RefusalError as refusal:
        raise _failed(refusal) from refusal
    return workspace_edit(changed, ls.editor.takes_document_changes, ls.editor.encoding)


def _failed(refusal: renaming.RefusalError) -> JsonRpcException:
    return JsonRpcException(message_without_links(str(refusal)), types.LSPErrorCodes.RequestFailed)


def _elsewhere(ls: Session, document: Document, old: str, new: str) -> dict[str, Changed]:
    """The edits of `improv.toml` and of all other programs that share one of its robots. Raises RefusalError.

    A robot that is not in that file belongs to its program alone.
    """
    robots = robots_of(document.uri)
    uri = from_fs_path(str(robots.path)) if robots.path else None
    edits = renaming.rename_section(robots, old, new)
    if not uri or not edits:
        return {}
    changed = {uri: Changed(None, LineIndex(robots.text), edits)}
    for other in _sharing(ls, document, robots):
        if old in other.analysis.text:
            try:
                edits = renaming.rename_robot(other.analysis, old, new)
            except renaming.RefusalError as refusal:
                name = other.uri.rpartition("/")[2]
                raise renaming.RefusalError(f"in {unquote(name)}: {refusal}") from refusal
            changed[other.uri] = Changed(other.version, other.lines, edits)
    return changed


def _sharing(ls: Session, document: Document, robots: Robots) -> Iterator[Document]:
    """The other programs for the same robots: open ones as in the editor, others as in their files."""
    assert robots.path
    found = programs_in([robots.path.parent])
    if not found.complete:
        raise renaming.RefusalError(
            "rename it by hand: there are too many files near improv.toml to find all programs that use it"
        )
    opened = {path: other for other in ls.documents.values() if (path := path_of(other.uri))}
    for path in dict.fromkeys([*opened, *found.paths]):
        other = opened[path] if path in opened else _closed(path)
        if other and other.uri != document.uri and find_robots_file(path.parent) == robots.path:
            yield other


def _closed(path: Path) -> Document | None:
    uri = from_fs_path(str(path))
    try:
        return Document(uri, None, analyze(read_program(path))) if uri else None
    except ReadError:
        return None
