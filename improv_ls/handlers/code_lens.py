"""textDocument/codeLens."""

from __future__ import annotations

from lsprotocol import types

from improv_core.ide.code_lens import Lens, lenses
from improv_ls.positions import to_range
from improv_ls.session import Session


def code_lens(ls: Session, params: types.CodeLensParams) -> list[types.CodeLens]:
    document = ls.documents.get(params.text_document.uri)
    if not document or not ls.editor.settings.code_lens:
        return []
    return [
        types.CodeLens(
            range=to_range(document.lines, lens.span, ls.editor.encoding),
            command=types.Command(lens.text, f"improv.{lens.command}", arguments=_arguments(lens, document.uri)),
        )
        for lens in lenses(document.analysis, *ls.performance.silenced)
    ]


def _arguments(lens: Lens, uri: str) -> list[str]:
    if lens.robot:
        return [lens.robot]
    return [uri] if lens.command == "play" else []
