"""textDocument/codeLens and inlayHint: what stands above and between the words of a program."""

from __future__ import annotations

from typing import Any

from lsprotocol import types

from improv_core.ide.code_lens import lenses
from improv_core.ide.inlay_hint import hints
from improv_core.program.program import scene_ids
from improv_ls.documents import Document
from improv_ls.positions import to_position, to_scenes, to_span
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
