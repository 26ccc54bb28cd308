"""textDocument/inlayHint."""

from __future__ import annotations

from lsprotocol import types

from improv_core.ide.inlay_hint import hints
from improv_ls.documents import Document
from improv_ls.positions import to_position, to_span
from improv_ls.session import Session


def inlay_hint(ls: Session, document: Document, params: types.InlayHintParams) -> list[types.InlayHint]:
    seen = to_span(document.lines, params.range, ls.editor.encoding)
    found = hints(document.analysis, seen) if ls.editor.settings.inlay_hints_beats else []
    if ls.editor.hints_playing:
        found += [hint for hint in ls.performance.playing.hints(document.uri) if seen.holds(hint.offset)]
    return [
        types.InlayHint(
            position=to_position(document.lines, hint.offset, ls.editor.encoding),
            label=hint.text,
            tooltip=hint.about,
            padding_left=not hint.before,
            padding_right=hint.before,
        )
        for hint in found
    ]
