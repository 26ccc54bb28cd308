"""textDocument/foldingRange."""

from __future__ import annotations

from lsprotocol import types

from improv_core.ide.folding_range import folds
from improv_core.ide.robots_file import structure as robots_file
from improv_ls import to_lsp_locations as to_lsp
from improv_ls.documents import AnyDocument, RobotsFile
from improv_ls.session import Session


def folding_range(ls: Session, document: AnyDocument, params: types.FoldingRangeParams) -> list[types.FoldingRange]:
    found = robots_file.folds(document.lines) if isinstance(document, RobotsFile) else folds(document.analysis)
    return [*map(to_lsp.folding_range, found)]
