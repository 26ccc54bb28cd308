"""textDocument/semanticTokens/full, full/delta and range."""

from __future__ import annotations

from collections.abc import Sequence

from lsprotocol import types

from improv_ls.coloring import Chunk, chunks, edits, encoded
from improv_ls.documents import Document
from improv_ls.positions import to_span
from improv_ls.session import Session, sent


def semantic_tokens(ls: Session, document: Document, params: types.SemanticTokensParams) -> types.SemanticTokens:
    found = chunks(document.analysis, ls.editor.encoding)
    return types.SemanticTokens(encoded(found), _keep(ls, document.uri, found))


def semantic_tokens_delta(
    ls: Session, document: Document, params: types.SemanticTokensDeltaParams
) -> types.SemanticTokens | types.SemanticTokensDelta:
    before = ls.sent_tokens.get(document.uri)
    found = chunks(document.analysis, ls.editor.encoding)
    result_id = _keep(ls, document.uri, found)
    if not before or before.result_id != params.previous_result_id:
        return types.SemanticTokens(encoded(found), result_id)
    changed = [types.SemanticTokensEdit(*edit) for edit in edits(before.items, found)]
    return types.SemanticTokensDelta(changed, result_id)


def semantic_tokens_range(
    ls: Session, document: Document, params: types.SemanticTokensRangeParams
) -> types.SemanticTokens:
    # Neovim 0.12 asks for a range and for the difference at once, and applies the difference to the range. So the next
    # answer has all tokens.
    ls.sent_tokens.pop(document.uri, None)
    seen = to_span(document.lines, params.range, ls.editor.encoding)
    return types.SemanticTokens(encoded(chunks(document.analysis, ls.editor.encoding, *seen)))


def _keep(ls: Session, uri: str, found: Sequence[Chunk]) -> str:
    """Keep the tokens that the editor gets, so that the next answer has only the difference."""
    now = ls.sent_tokens[uri] = sent(found)
    return now.result_id
