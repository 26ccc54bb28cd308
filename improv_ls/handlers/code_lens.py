"""textDocument/codeLens."""

from __future__ import annotations

from typing import Any

from lsprotocol import types

from improv_core.ide.code_lens import Lens, lenses
from improv_core.ide.robots_file.code_lens import trials
from improv_core.text import LineIndex
from improv_ls.positions import to_range
from improv_ls.session import Session


def code_lens(ls: Session, params: types.CodeLensParams) -> list[types.CodeLens]:
    uri, settings = params.text_document.uri, ls.editor.settings
    if not settings.code_lens:
        return []
    if file := ls.robots_files.get(uri):
        return [_shown(ls, uri, file.lines, lens) for lens in trials(file.lines.text)]
    if document := ls.documents.get(uri):
        found = lenses(document.analysis, *ls.performance.silenced)
        return [_shown(ls, uri, document.lines, lens) for lens in found]
    return []


def _shown(ls: Session, uri: str, lines: LineIndex, lens: Lens) -> types.CodeLens:
    span = to_range(lines, lens.span, ls.editor.encoding)
    arguments: list[Any] = [uri] if lens.command == "play" else []
    if lens.only_this:
        arguments.append(span)
    if lens.robot:
        arguments.append(lens.robot)
    return types.CodeLens(span, types.Command(lens.text, f"improv.{lens.command}", arguments=arguments))
