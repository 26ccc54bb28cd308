"""textDocument/selectionRange."""

from __future__ import annotations

from functools import partial

from lsprotocol import types

from improv_core.ide.robots_file import selection_range as robots_file
from improv_core.ide.selection_range import selections
from improv_ls import to_lsp_locations as to_lsp
from improv_ls.positions import to_offset
from improv_ls.session import Session


def selection_range(ls: Session, params: types.SelectionRangeParams) -> list[types.SelectionRange] | None:
    uri = params.text_document.uri
    if file := ls.robots_files.get(uri):
        lines, around = file.lines, partial(robots_file.selections, file.lines.text)
    elif document := ls.documents.get(uri):
        lines, around = document.lines, partial(selections, document.analysis)
    else:
        return None
    spans = (around(to_offset(lines, position, ls.editor.encoding)) for position in params.positions)
    return [to_lsp.selection_range(lines, each, ls.editor.encoding) for each in spans]
