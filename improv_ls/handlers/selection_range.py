"""textDocument/selectionRange."""

from __future__ import annotations

from functools import partial

from lsprotocol import types

from improv_core.ide.robots_file import structure as robots_file
from improv_core.ide.selection_range import selections
from improv_ls import to_lsp_locations as to_lsp
from improv_ls.documents import AnyDocument, RobotsFile
from improv_ls.positions import to_offset
from improv_ls.session import Session


def selection_range(
    ls: Session, document: AnyDocument, params: types.SelectionRangeParams
) -> list[types.SelectionRange]:
    lines, encoding = document.lines, ls.editor.encoding
    if isinstance(document, RobotsFile):
        around = partial(robots_file.selections, lines.text)
    else:
        around = partial(selections, document.analysis)
    spans = (around(to_offset(lines, position, encoding)) for position in params.positions)
    return [to_lsp.selection_range(lines, each, encoding) for each in spans]
