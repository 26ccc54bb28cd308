"""textDocument/diagnostic, and publishDiagnostics: sent with every version of a document to editors that do not ask for
them."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from operator import attrgetter
from typing import Any

from lsprotocol import types

from improv_core.diagnostics import Diagnostic
from improv_core.program.files import robots_from
from improv_core.robots.config import Robots
from improv_ls import to_lsp
from improv_ls.documents import AnyDocument, Document, RobotsFile, on_disk, path_of
from improv_ls.session import LastSent, Session, sent


def diagnostic(
    ls: Session, document: Document, params: types.DocumentDiagnosticParams
) -> types.RelatedFullDocumentDiagnosticReport | types.RelatedUnchangedDocumentDiagnosticReport:
    """Return all diagnostics of a document, or that they have not changed since they were sent last."""
    now = diagnosed(ls, document)
    if now.result_id == params.previous_result_id:
        return types.RelatedUnchangedDocumentDiagnosticReport(now.result_id)
    return types.RelatedFullDocumentDiagnosticReport(now.items, result_id=now.result_id)


def diagnosed(ls: Session, document: Document) -> LastSent[Any]:
    """Return the diagnostics of an open document, with the ID of those that were sent last if they are the same."""
    items = as_sent(ls, document, diagnostics_of(ls, document))
    before = ls.sent_diagnostics.get(document.uri)
    now = ls.sent_diagnostics[document.uri] = before if before and before.items == items else sent(items)
    return now


def publish(ls: Session, document: Document) -> None:
    """Send the diagnostics of a version to an editor that does not ask for them."""
    if not ls.editor.pulls_diagnostics:
        _send(ls, document, diagnostics_of(ls, document))


def diagnostics_of(ls: Session, document: Document) -> list[Diagnostic]:
    """Return all known diagnostics of a version of a program, in the order of the text."""
    found = [*document.analysis.diagnostics, *ls.rooms.found(document)]
    return sorted(found, key=attrgetter("span"))


def publish_robots(ls: Session, robots: Robots) -> None:
    """Send the diagnostics of an `improv.toml` on disk, unless it is open: then those of the editor's text are sent."""
    file = on_disk(robots)
    if file and file.uri not in ls.robots_files:
        _send(ls, file, robots.diagnostics)


def publish_robots_file(ls: Session, file: RobotsFile) -> None:
    """Send the diagnostics of a version of an open `improv.toml`."""
    _send(ls, file, robots_from(file.lines.text, path_of(file.uri)).diagnostics)


def withdraw(ls: Session, document: Document) -> None:
    """Clear the diagnostics of a document that was closed, and of its `improv.toml` if no other document uses it."""
    if not ls.editor.pulls_diagnostics:
        _send(ls, replace(document, version=None), ())
    robots = document.analysis.config
    if all(other.analysis.config.path != robots.path for other in ls.documents.values()):
        publish_robots(ls, replace(robots, diagnostics=()))


def withdraw_robots(ls: Session, uri: str) -> None:
    """Show the errors of a closed `improv.toml` on disk if a program uses it, otherwise none."""
    path = path_of(uri)
    user = next((each for each in ls.documents.values() if each.analysis.config.path == path), None)
    publish_robots(ls, user.analysis.config if user else Robots(path=path))


def as_sent(ls: Session, document: AnyDocument, found: Iterable[Diagnostic]) -> list[Any]:
    """Return the JSON of diagnostics of a document, with the parts that the editor supports."""
    uri, lines, encoding, support = document.uri, document.lines, ls.editor.encoding, ls.editor.diagnostic_support
    return [to_lsp.diagnostic(uri, lines, each, encoding, support) for each in found]


def _send(ls: Session, document: AnyDocument, found: Iterable[Diagnostic]) -> None:
    told: dict[str, object] = {"uri": document.uri, "diagnostics": as_sent(ls, document, found)}
    if document.version is not None:
        told["version"] = document.version
    ls.protocol.notify(types.TEXT_DOCUMENT_PUBLISH_DIAGNOSTICS, told)
