"""textDocument/prepareRename and rename."""

from __future__ import annotations

from urllib.parse import unquote

from lsprotocol import types
from pygls.exceptions import JsonRpcException
from pygls.uris import from_fs_path

from improv_core.ide import rename as renaming
from improv_core.plain import message_without_links
from improv_core.text import LineIndex
from improv_ls.documents import Document, robots_of
from improv_ls.handlers import robots_file
from improv_ls.positions import to_offset, to_range
from improv_ls.session import Session
from improv_ls.sharing import programs_for
from improv_ls.to_lsp_locations import ChangedText, workspace_edit


def prepare_rename(ls: Session, params: types.PrepareRenameParams) -> types.PrepareRenamePlaceholder | None:
    if file := ls.robots_files.get(params.text_document.uri):
        try:
            found = robots_file.renamable(ls, file, params)
        except renaming.RefusalError as refusal:
            raise _failed(refusal) from refusal
        return types.PrepareRenamePlaceholder(to_range(file.lines, found.span, ls.editor.encoding), found.name)
    document = ls.documents.get(params.text_document.uri)
    if not document:
        return None
    try:
        symbol = renaming.renamable(document.analysis, to_offset(document.lines, params.position, ls.editor.encoding))
    except renaming.RefusalError as refusal:
        raise _failed(refusal) from refusal
    return types.PrepareRenamePlaceholder(to_range(document.lines, symbol.span, ls.editor.encoding), symbol.text)


def rename(ls: Session, params: types.RenameParams) -> types.WorkspaceEdit | None:
    file, document = ls.robots_files.get(params.text_document.uri), ls.documents.get(params.text_document.uri)
    try:
        changed = robots_file.rename(ls, file, params) if file else _in_program(ls, document, params)
    except renaming.RefusalError as refusal:
        raise _failed(refusal) from refusal
    return workspace_edit(changed, ls.editor.takes_document_changes, ls.editor.encoding) if changed else None


def _in_program(ls: Session, document: Document | None, params: types.RenameParams) -> dict[str, ChangedText]:
    if not document:
        return {}
    symbol = renaming.renamable(document.analysis, to_offset(document.lines, params.position, ls.editor.encoding))
    edits = renaming.rename(document.analysis, symbol, params.new_name)
    changed = {document.uri: ChangedText(document.version, document.lines, edits)}
    return changed | (_elsewhere(ls, document, symbol.text, params.new_name) if symbol.is_robot else {})


def _failed(refusal: renaming.RefusalError) -> JsonRpcException:
    return JsonRpcException(message_without_links(str(refusal)), types.LSPErrorCodes.RequestFailed)


def _elsewhere(ls: Session, document: Document, old: str, new: str) -> dict[str, ChangedText]:
    """Return the edits of `improv.toml` and of all other programs that share one of its robots. Raises RefusalError.

    A robot that is not in that file belongs to its program alone.
    """
    robots = robots_of(document.uri)
    uri = from_fs_path(str(robots.path)) if robots.path else None
    edits = renaming.rename_section(robots, old, new)
    if not uri or not edits:
        return {}
    changed = {uri: ChangedText(None, LineIndex(robots.text), edits)}
    for other in programs_for(ls.documents, robots.path, old):
        if other.uri != document.uri:
            try:
                edits = renaming.rename_robot(other.analysis, old, new)
            except renaming.RefusalError as refusal:
                name = other.uri.rpartition("/")[2]
                raise renaming.RefusalError(f"in {unquote(name)}: {refusal}") from refusal
            changed[other.uri] = ChangedText(other.version, other.lines, edits)
    return changed
