"""textDocument/completion and completionItem/resolve."""

from __future__ import annotations

from pathlib import Path

from lsprotocol import types

from improv_core.ide.completion import complete
from improv_core.ide.completion import document as documentation_of
from improv_core.ide.completion_item import Item
from improv_core.ide.robots_file import completion as robots_file
from improv_ls import to_lsp
from improv_ls.documents import AnyDocument, Document, RobotsFile, path_of
from improv_ls.handlers.hover import shows_pictures
from improv_ls.positions import to_offset
from improv_ls.session import Session


def completion(ls: Session, document: AnyDocument, params: types.CompletionParams) -> types.CompletionList | None:
    offset = to_offset(document.lines, params.position, ls.editor.encoding)
    if isinstance(document, RobotsFile):
        found, short = robots_file.complete(document.lines.text, offset, _robots_of(ls, document)), {"value"}
    else:
        found, short = complete(document.analysis, offset), {"plane", "sense"}
    if not found:
        return None
    # A trigger asks only in places with few choices, so that lists do not pop up between all words.
    if params.context and params.context.trigger_character and not (found.items and found.items[0].kind in short):
        return None
    snippets = ls.editor.can("text_document.completion.completion_item.snippet_support")
    return to_lsp.completion(document, found, bool(snippets), ls.editor.encoding)


def _robots_of(ls: Session, file: RobotsFile) -> list[str]:
    """Return the robots of the open programs that use the file, or will once it is saved."""
    path = path_of(file.uri)
    programs = (document for document in ls.documents.values() if path and _uses(document, path))
    return [robot for document in programs for robot in document.analysis.robots]


def _uses(document: Document, path: Path) -> bool:
    used, program = document.analysis.config.path, path_of(document.uri)
    if used == path or not program or path.exists():
        return used == path
    return program.is_relative_to(path.parent) and (used is None or path.is_relative_to(used.parent))


def resolve(ls: Session, item: types.CompletionItem) -> types.CompletionItem:
    """Add the documentation to an item, which is made only for an item that the person looks at."""
    uri, statement, kind = item.data if isinstance(item.data, list) and len(item.data) == 3 else ("", 0, "")
    document = ls.documents.get(uri)
    offered = Item(item.label, kind)
    formats = ls.editor.can("text_document.completion.completion_item.documentation_format")
    if document and (found := documentation_of(document.analysis, offered, statement, shows_pictures(ls, formats))):
        item.documentation = to_lsp.markup(found, formats)
    return item
