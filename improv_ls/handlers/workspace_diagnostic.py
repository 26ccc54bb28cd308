"""workspace/diagnostic: the programs in all folders, open or not, in small portions so that no key waits for them."""

from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator, Callable, Iterable, Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import Any

from lsprotocol import types
from pygls.uris import from_fs_path

from improv_core.ipc.asking import Answerer
from improv_core.robots.config import Robots
from improv_ls import to_lsp
from improv_ls.checker import Findings, ProgramFile, check
from improv_ls.documents import Document, path_of, robots_of
from improv_ls.handlers.diagnostics import diagnosed
from improv_ls.programs import LARGEST_FILE, programs_in
from improv_ls.session import Checked, LastSent, Session, sent

AT_ONCE = 10
"""Files in one portion."""

_Report = types.WorkspaceFullDocumentDiagnosticReport | types.WorkspaceUnchangedDocumentDiagnosticReport


async def workspace_diagnostic(ls: Session, params: types.WorkspaceDiagnosticParams) -> types.WorkspaceDiagnosticReport:
    """Return the diagnostics of each program, or that the client has them already.

    A client that takes partial results gets each portion at once. If it also reports files that change, the request
    stays open, as LSP allows, and later changes follow: otherwise the client would ask every few seconds.
    """
    known = {each.uri: each.value for each in params.previous_result_ids}
    token = params.partial_result_token
    answer: list[_Report] = []
    next_change = ls.next_change
    _tell(ls, params.work_done_token, types.WorkDoneProgressBegin("Checking programs", percentage=0))
    try:
        async for found, done in _reports(ls, known):
            if token is None:
                answer += found
            else:
                _tell(ls, token, types.WorkspaceDiagnosticReportPartialResult(found))
            _tell(ls, params.work_done_token, types.WorkDoneProgressReport(percentage=round(100 * done)))
    finally:
        _tell(ls, params.work_done_token, types.WorkDoneProgressEnd())
    while token is not None and ls.editor.can("workspace.did_change_watched_files.dynamic_registration"):
        await next_change.wait()
        next_change = ls.next_change
        async for found, _ in _reports(ls, known):
            if news := [each for each in found if each.kind == "full"]:
                _tell(ls, token, types.WorkspaceDiagnosticReportPartialResult(news))
    return types.WorkspaceDiagnosticReport(answer)


async def _reports(ls: Session, known: dict[str, str]) -> AsyncIterator[tuple[Sequence[_Report], float]]:
    """Yield the reports in portions, and the fraction of files that are done. `known` has the IDs that the client has,
    and is updated."""
    listed = await asyncio.to_thread(_listed, ls.editor.folders)
    ls.checked = {uri: each for uri, each in ls.checked.items() if uri in listed}
    robots: dict[Path, Robots] = {}
    uris = list(listed)
    checker, told = Answerer(check), partial(_diagnostics, ls)
    try:
        for first in range(0, len(uris), AT_ONCE):
            portion = uris[first : first + AT_ONCE]
            opened = {path_of(uri): document for uri, document in ls.documents.items()}
            closed = [uri for uri in portion if listed[uri] not in opened]
            ls.checked |= await asyncio.to_thread(_check, closed, listed, dict(ls.checked), robots, checker, told)
            reports = (partial(_report, ls, uri, opened.get(listed[uri]), known) for uri in portion)
            found = [await ls.settling.run(report) for report in reports]
            known.update({each.uri: each.result_id for each in found if each.result_id})
            yield found, (first + len(portion)) / len(uris)
    finally:
        checker.close()
    paths = {*listed.values(), *map(path_of, ls.documents)}
    gone = [uri for uri in known if path_of(uri) not in paths]
    for uri in gone:
        del known[uri]
    if gone:
        yield [types.WorkspaceFullDocumentDiagnosticReport(uri, []) for uri in gone], 1.0


def _listed(folders: Iterable[Path]) -> Mapping[str, Path]:
    return {uri: path for path in programs_in(folders).paths if (uri := from_fs_path(str(path)))}


def _check(
    uris: Sequence[str],
    listed: Mapping[str, Path],
    checked: Mapping[str, Checked],
    robots: dict[Path, Robots],
    checker: Answerer[ProgramFile, Findings | None],
    told: Callable[[str, Findings], list[Any]],
) -> dict[str, Checked]:
    """Check these files on a thread. A file that has not changed is not read. `robots` keeps the robots of each
    folder's `improv.toml`; `told` converts findings to the client's diagnostics."""
    news = {}
    for uri in uris:
        path = listed[uri]
        try:
            state = path.stat()
        except OSError:
            continue
        if path.parent not in robots:
            robots[path.parent] = robots_of(uri)
        config, stamp = robots[path.parent], (state.st_mtime_ns, state.st_size)
        before = checked.get(uri)
        if state.st_size > LARGEST_FILE or (before and (before.stamp, before.robots) == (stamp, config)):
            continue
        found = checker.ask(ProgramFile(path, config))
        items = told(uri, found) if found else []
        same = before.sent if before and before.sent.items == items else None
        news[uri] = Checked(stamp, config, same or sent(items))
    return news


def _diagnostics(ls: Session, uri: str, found: Findings) -> list[Any]:
    encoding, support = ls.editor.encoding, ls.editor.diagnostic_support
    return [to_lsp.diagnostic(uri, found.lines, each, encoding, support) for each in found.diagnostics]


def _report(ls: Session, uri: str, document: Document | None, known: Mapping[str, str]) -> _Report:
    """Return the report about a program: the editor's version if it is open, otherwise the file's."""
    now = diagnosed(ls, document) if document else ls.checked[uri].sent if uri in ls.checked else _UNREADABLE
    uri, version = (document.uri, document.version) if document else (uri, None)
    if known.get(uri) == now.result_id:
        return types.WorkspaceUnchangedDocumentDiagnosticReport(uri, now.result_id, version)
    return types.WorkspaceFullDocumentDiagnosticReport(uri, now.items, version, result_id=now.result_id)


_UNREADABLE: LastSent[Any] = sent(())


def _tell(
    ls: Session,
    token: types.ProgressToken | None,
    value: types.WorkspaceDiagnosticReportPartialResult
    | types.WorkDoneProgressBegin
    | types.WorkDoneProgressReport
    | types.WorkDoneProgressEnd,
) -> None:
    if token is not None:
        ls.progress(types.ProgressParams(token, value))
