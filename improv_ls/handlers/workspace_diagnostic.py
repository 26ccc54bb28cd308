"""workspace/diagnostic: the programs in all folders, open or not, in small portions so that no key waits for them."""

from __future__ import annotations

import asyncio
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path

from lsprotocol import types
from pygls.uris import from_fs_path

from improv_core.robots.config import Robots
from improv_ls.checker import Checker, Program
from improv_ls.documents import Document, path_of, robots_of
from improv_ls.handlers.diagnostic import diagnosed
from improv_ls.programs import LARGEST_FILE, programs_in
from improv_ls.session import Checked, Sent, Session, sent

AT_ONCE = 10
"""Files in one portion."""

_Report = types.WorkspaceFullDocumentDiagnosticReport | types.WorkspaceUnchangedDocumentDiagnosticReport


async def workspace_diagnostic(ls: Session, params: types.WorkspaceDiagnosticParams) -> types.WorkspaceDiagnosticReport:
    """The diagnostics of each program, or that they are those that the client has. A client that takes partial results
    gets each portion at once, and an empty answer in the end."""
    changes, known = ls.file_changes, {each.uri: each.value for each in params.previous_result_ids}
    is_current = ls.listed is not None and ls.listed[0] == changes
    listed = ls.listed[1] if ls.listed and is_current else await asyncio.to_thread(_listed, ls.editor.folders)
    if not is_current:
        ls.checked = {uri: each for uri, each in ls.checked.items() if uri in listed}
    answer: list[_Report] = []
    robots: dict[Path, Robots] = {}
    checker = Checker(ls.editor.encoding, ls.editor.diagnostic_support)
    uris = list(listed)
    _tell(ls, params.work_done_token, types.WorkDoneProgressBegin("Checking programs", percentage=0))
    try:
        for first in range(0, len(uris), AT_ONCE):
            portion = uris[first : first + AT_ONCE]
            opened = {path_of(uri): document for uri, document in ls.documents.items()}
            unsure = [uri for uri in portion if listed[uri] not in opened and not (is_current and uri in ls.checked)]
            ls.checked |= await asyncio.to_thread(_check, unsure, listed, dict(ls.checked), robots, checker)
            found = [_report(ls, uri, opened.get(listed[uri]), known) for uri in portion]
            if params.partial_result_token is None:
                answer += found
            else:
                _tell(ls, params.partial_result_token, types.WorkspaceDiagnosticReportPartialResult(found))
            done = types.WorkDoneProgressReport(percentage=100 * (first + len(portion)) // len(uris))
            _tell(ls, params.work_done_token, done)
    finally:
        checker.close()
        _tell(ls, params.work_done_token, types.WorkDoneProgressEnd())
    if ls.editor.watches_files:
        ls.listed = changes, listed
    paths = {*listed.values(), *map(path_of, ls.documents)}
    gone = [types.WorkspaceFullDocumentDiagnosticReport(uri, []) for uri in known if path_of(uri) not in paths]
    return types.WorkspaceDiagnosticReport([*answer, *gone])


def _listed(folders: Iterable[Path]) -> Mapping[str, Path]:
    return {uri: path for path in programs_in(folders).paths if (uri := from_fs_path(str(path)))}


def _check(
    uris: Sequence[str],
    listed: Mapping[str, Path],
    checked: Mapping[str, Checked],
    robots: dict[Path, Robots],
    checker: Checker,
) -> dict[str, Checked]:
    """What is wrong with these files now, on a thread. One that has not changed is not read. `robots` keeps what each
    folder's `improv.toml` says."""
    stamps, changed = [], []
    for uri in uris:
        path = listed[uri]
        try:
            state = path.stat()
        except OSError:
            continue
        if path.parent not in robots:
            robots[path.parent] = robots_of(uri)
        cast, stamp = robots[path.parent], (state.st_mtime_ns, state.st_size)
        before = checked.get(uri)
        if state.st_size <= LARGEST_FILE and not (before and (before.stamp, before.robots) == (stamp, cast)):
            stamps.append(stamp)
            changed.append(Program(uri, path, cast))
    found = {}
    for program, stamp, items in zip(changed, stamps, checker.check(changed) if changed else (), strict=True):
        before = checked.get(program.uri)
        same = before.sent if before and before.sent.items == items else None
        found[program.uri] = Checked(stamp, program.robots, same or sent(items))
    return found


def _report(ls: Session, uri: str, document: Document | None, known: Mapping[str, str]) -> _Report:
    """The report about a program: as in the editor if it is open, otherwise as in its file."""
    nothing: Sent[types.Diagnostic] = Sent("", ())
    now = diagnosed(ls, document) if document else ls.checked[uri].sent if uri in ls.checked else nothing
    uri, version = (document.uri, document.version) if document else (uri, None)
    if now.result_id and known.get(uri) == now.result_id:
        return types.WorkspaceUnchangedDocumentDiagnosticReport(uri, now.result_id, version)
    return types.WorkspaceFullDocumentDiagnosticReport(uri, now.items, version, result_id=now.result_id or None)


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
