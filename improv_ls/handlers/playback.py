"""Saving plays; the commands play and hush."""

from __future__ import annotations

from typing import Any

from lsprotocol import types

from improv_core.diagnostics import Severity
from improv_ls.documents import Document
from improv_ls.handlers.documents import refresh_robots
from improv_ls.session import Session


def did_save(ls: Session, params: types.DidSaveTextDocumentParams) -> None:
    # What was saved is what plays, whatever is typed from here on.
    document = ls.documents.get(params.text_document.uri)
    if document and ls.settings.on_save != "off":
        ls.soon(_play(ls, document))


def play(ls: Session, *arguments: Any) -> None:
    """Play the document whose URI is the first argument, or the only one that is open."""
    uris = list(arguments[:1]) or list(ls.documents)
    document = ls.documents.get(str(uris[0])) if len(uris) == 1 else None
    if document:
        ls.soon(_play(ls, document))
    else:
        ls.say("improv.play: say which open document to play, by its URI", types.MessageType.Warning)


def hush(ls: Session, *arguments: Any) -> None:
    ls.performance.hush()


async def _play(ls: Session, document: Document) -> None:
    document = refresh_robots(ls, document)
    if not document.analysis.cast.ok:
        ls.say("✗ improv.toml has errors; what plays goes on", types.MessageType.Warning)
        return
    errors = [each for each in document.analysis.diagnostics if each.severity is Severity.ERROR]
    if errors:
        first = errors[0]
        line = document.lines.position(first.span.start).line + 1
        more = f" (and {len(errors) - 1} more)" if len(errors) > 1 else ""
        ls.say(f"✗ line {line}: {first.message}{more}; what plays goes on", types.MessageType.Warning)
        return
    when = ls.settings.switch_at if ls.settings.on_save == "continue" else "restart"
    await ls.performance.play(document.analysis, when)
