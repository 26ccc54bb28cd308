"""Semantic tokens: all at once, what has changed since, and what is in sight."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import count

from lsprotocol import types

from improv_ls.coloring import Chunk, Coloring, chunks, edits, numbers
from improv_ls.positions import to_span
from improv_ls.session import Session

_numbers = count(1)  # never the same for two answers, also of different documents


def semantic_tokens(ls: Session, params: types.SemanticTokensParams) -> types.SemanticTokens | None:
    document = ls.documents.get(params.text_document.uri)
    if not document:
        return None
    found = chunks(document.analysis, ls.encoding)
    return types.SemanticTokens(numbers(found), _keep(ls, document.uri, found))


def semantic_tokens_delta(
    ls: Session, params: types.SemanticTokensDeltaParams
) -> types.SemanticTokens | types.SemanticTokensDelta | None:
    document = ls.documents.get(params.text_document.uri)
    if not document:
        return None
    before = ls.colorings.get(document.uri)
    found = chunks(document.analysis, ls.encoding)
    result_id = _keep(ls, document.uri, found)
    if not before or before.result_id != params.previous_result_id:
        return types.SemanticTokens(numbers(found), result_id)
    changed = [types.SemanticTokensEdit(*edit) for edit in edits(before.chunks, found)]
    return types.SemanticTokensDelta(changed, result_id)


def semantic_tokens_range(ls: Session, params: types.SemanticTokensRangeParams) -> types.SemanticTokens | None:
    document = ls.documents.get(params.text_document.uri)
    if not document:
        return None
    seen = to_span(document.lines, params.range, ls.encoding)
    return types.SemanticTokens(numbers(chunks(document.analysis, ls.encoding, *seen)))


def _keep(ls: Session, uri: str, found: Sequence[Chunk]) -> str:
    """Keep what the editor is told, so that next time only the difference is sent."""
    result_id = str(next(_numbers))
    ls.colorings[uri] = Coloring(result_id, found)
    return result_id
