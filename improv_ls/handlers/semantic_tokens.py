"""textDocument/semanticTokens/full, full/delta and range."""

from __future__ import annotations

from collections.abc import Sequence

from lsprotocol import types

from improv_ls.coloring import Chunk, chunks, edits, encoded
from improv_ls.positions import to_span
from improv_ls.session import Session, sent


def semantic_tokens(ls: Session, params: types.SemanticTokensParams) -> types.SemanticTokens | None:
    document = ls.documents.get(params.text_document.uri)
    if not document:
        return None
    found = chunks(document.analysis, ls.editor.encoding)
    return types.SemanticTokens(encoded(found), _keep(ls, document.uri, found))


def semantic_tokens_delta(
    ls: Session, params: types.SemanticTokensDeltaParams
) -> types.SemanticTokens | types.SemanticTokensDelta | None:
    document = ls.documents.get(params.text_document.uri)
    if not document:
        return None
    before = ls.sent_tokens.get(document.uri)
    found = chunks(document.analysis, ls.editor.encoding)
    result_id = _keep(ls, document.uri, found)
    if not before or before.result_id != params.previous_result_id:
        return types.SemanticTokens(encoded(found), result_id)
    changed = [types.SemanticTokensEdit(*edit) for edit in edits(before.items, found)]
    return types.SemanticTokensDelta(changed, result_id)


def semantic_tokens_range(ls: Session, params: types.SemanticTokensRangeParams) -> types.SemanticTokens | None:
    document = ls.documents.get(params.text_document.uri)
    if not document:
        return None
    seen = to_span(document.lines, params.range, ls.editor.encoding)
    return types.SemanticTokens(encoded(chunks(document.analysis, ls.editor.encoding, *seen)))


def _keep(ls: Session, uri: str, found: Sequence[Chunk]) -> str:
    """Keep the tokens that the editor gets, so that the next answer has only the difference."""
    now = ls.sent_tokens[uri] = sent(found)
    return now.result_id
