"""textDocument/prepareRename and rename."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from urllib.parse import unquote

from lsprotocol import types
from pygls.exceptions import JsonRpcException

from improv_core.diagnostics import Edit
from improv_core.ide import rename as renaming
from improv_core.plain import message_without_links
from improv_ls.documents import AnyDocument, Document, RobotsFile, on_disk, robots_of
from improv_ls.handlers import robots_file
from improv_ls.positions import to_offset, to_range
from improv_ls.programs import programs_for
from improv_ls.session import Session
from improv_ls.to_lsp_locations import Changes, workspace_edit


def prepare_rename(
    ls: Session, document: AnyDocument, params: types.PrepareRenameParams
) -> types.PrepareRenamePlaceholder:
    offset = to_offset(document.lines, params.position, ls.editor.encoding)
    with _refusals():
        if isinstance(document, RobotsFile):
            found = robots_file.renamable(document, offset)
            span, name = found.span, found.name
        else:
            symbol = renaming.renamable(document.analysis, offset)
            span, name = symbol.span, symbol.text
    return types.PrepareRenamePlaceholder(to_range(document.lines, span, ls.editor.encoding), name)


def rename(ls: Session, document: AnyDocument, params: types.RenameParams) -> types.WorkspaceEdit:
    offset = to_offset(document.lines, params.position, ls.editor.encoding)
    with _refusals():
        if isinstance(document, RobotsFile):
            changes = robots_file.rename(ls, document, offset, params.new_name)
        else:
            changes = _in_program(ls, document, offset, params.new_name)
    return workspace_edit(changes, ls.editor, asks=True)


@contextmanager
def _refusals() -> Iterator[None]:
    """Answer a refusal with its reason, in one line."""
    try:
        yield
    except renaming.RefusalError as refusal:
        failed = types.LSPErrorCodes.RequestFailed
        raise JsonRpcException(message_without_links(str(refusal)), failed) from refusal


def _in_program(ls: Session, document: Document, offset: int, new: str) -> Changes:
    symbol = renaming.renamable(document.analysis, offset)
    edits = renaming.rename(document.analysis, symbol, new)
    return [(document, edits), *(_elsewhere(ls, document, symbol.text, new) if symbol.kind == "robot" else ())]


def _elsewhere(ls: Session, document: Document, old: str, new: str) -> Changes:
    """Return the edits of `improv.toml` and of all other programs that share one of its robots. Raises RefusalError.

    A robot that is not in that file belongs to its program alone.
    """
    robots = robots_of(document.uri)
    file, edits = on_disk(robots), renaming.rename_section(robots, old, new)
    if not file or not edits:
        return []
    changes: list[tuple[AnyDocument, Sequence[Edit]]] = [(file, edits)]
    for other in programs_for(ls.documents, robots.path, old):
        if other.uri != document.uri:
            try:
                changes.append((other, renaming.rename_robot(other.analysis, old, new)))
            except renaming.RefusalError as refusal:
                name = other.uri.rpartition("/")[2]
                raise renaming.RefusalError(f"in {unquote(name)}: {refusal}") from refusal
    return changes
