"""Inlay hints and code lenses: what is shown between the words and lines."""

from __future__ import annotations

from lsprotocol import types

from improv_core.ide.code_lens import Lens, lenses
from improv_core.ide.inlay_hint import hints
from improv_ls.positions import to_position, to_range, to_span
from improv_ls.session import Session


def inlay_hint(ls: Session, params: types.InlayHintParams) -> list[types.InlayHint]:
    document = ls.documents.get(params.text_document.uri)
    if not document or not ls.settings.hints_beats:
        return []
    return [
        types.InlayHint(
            position=to_position(document.lines, hint.offset, ls.encoding),
            label=hint.text,
            tooltip=hint.about,
            padding_left=not hint.before,
            padding_right=hint.before,
        )
        for hint in hints(document.analysis, to_span(document.lines, params.range, ls.encoding))
    ]


def code_lens(ls: Session, params: types.CodeLensParams) -> list[types.CodeLens]:
    document = ls.documents.get(params.text_document.uri)
    if not document or not ls.settings.code_lens:
        return []
    return [
        types.CodeLens(
            range=to_range(document.lines, lens.span, ls.encoding),
            command=types.Command(lens.text, f"improv.{lens.command}", arguments=_arguments(lens, document.uri)),
        )
        for lens in lenses(document.analysis, *ls.performance.silenced)
    ]


def _arguments(lens: Lens, uri: str) -> list[str]:
    if lens.robot:
        return [lens.robot]
    return [uri] if lens.command == "play" else []
