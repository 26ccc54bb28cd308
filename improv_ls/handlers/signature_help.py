"""textDocument/signatureHelp."""

from __future__ import annotations

from lsprotocol import types

from improv_core.ide.signature_help import signature
from improv_ls import to_lsp
from improv_ls.documents import Document
from improv_ls.positions import to_offset
from improv_ls.session import Session


def signature_help(ls: Session, document: Document, params: types.SignatureHelpParams) -> types.SignatureHelp | None:
    found = signature(document.analysis, to_offset(document.lines, params.position, ls.editor.encoding))
    return to_lsp.signature(found) if found else None
