"""textDocument/foldingRange."""

from __future__ import annotations

from lsprotocol import types

from improv_core.ide.folding_range import folds
from improv_core.ide.robots_file import folding_range as robots_file
from improv_ls import to_lsp_locations as to_lsp
from improv_ls.session import Session


def folding_range(ls: Session, params: types.FoldingRangeParams) -> list[types.FoldingRange]:
    if file := ls.robots_files.get(params.text_document.uri):
        return [to_lsp.folding_range(fold) for fold in robots_file.folds(file.lines)]
    document = ls.documents.get(params.text_document.uri)
    return [to_lsp.folding_range(fold) for fold in folds(document.analysis)] if document else []
