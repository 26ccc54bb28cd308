"""textDocument/codeLens."""

from __future__ import annotations

from typing import Any

from lsprotocol import types

from improv_core.ide.code_lens import lenses, scene_ids
from improv_ls.documents import Document
from improv_ls.positions import to_scenes
from improv_ls.session import Session


def code_lens(ls: Session, document: Document, params: types.CodeLensParams) -> list[types.CodeLens]:
    if not ls.editor.settings.code_lens or document.analysis.earlier:  # not read yet, so it has no analysis
        return []
    scenes = ls.scenes_with_lenses.setdefault(document.uri, scene_ids(document.analysis))
    found = []
    for lens in lenses(document.analysis, scenes):
        arguments: list[Any] = [document.uri]
        if lens.only:
            arguments.append(to_scenes(lens.only))
        start = types.Position(lens.line, 0)
        found.append(
            types.CodeLens(types.Range(start, start), types.Command(lens.text, "improv.play", arguments=arguments))
        )
    return found
