"""textDocument/foldingRange."""

from __future__ import annotations

from lsprotocol import types

from improv_core.ide.folding_range import folds
from improv_ls import to_lsp_locations as to_lsp
from improv_ls.session import Session


def folding_range(ls: Session, params: types.FoldingRangeParams) -> list[types.FoldingRange]:
    document = ls.documents.get(params.text_document.uri)
    return [to_lsp.folding_range(fold) for fold in folds(document.analysis)] if document else []
