"""From each request to its answer in a document of a thousand lines, in turns with a pygls server that answers nothing;
and from a keystroke to its diagnostics while a dance plays with its page open, and while a folder is checked."""

from __future__ import annotations

import platform
import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass, field, replace
from itertools import islice
from random import Random
from statistics import median
from typing import Any

from lsprotocol import types

from improv_ls.server import FEATURES
from tests.benchmarks.background import KEYS_A_SECOND, PLAYER, page_of
from tests.benchmarks.documents import IMPROV, SHARED, SHARED_LINE, Edit, Uses, edits, improv
from tests.benchmarks.servers import BARE, OURS, Kind, Server
from tests.benchmarks.tables import machine, p99, print_head, print_row

LINES = 1_000
AT_ONCE = 20
"""How many edits and requests one server gets before it is the other's turn."""
CLASS, MANY = 20, 200
"""Programs in a folder: those of a class, and as many as take a while."""
_ASKED = replace(OURS, options={**OURS.options, "hover": {"pictures": True}}, pulls=True)
_BARE = replace(BARE, pulls=True)
_PAIR = (_ASKED, _BARE)


@dataclass(frozen=True, slots=True)
class Times:
    """Milliseconds that our server took, and another one, or ours while nothing else went on."""

    ours: list[float] = field(default_factory=list)
    other: list[float] = field(default_factory=list)

    def print(self, what: str, p50_goal: float, p99_goal: float) -> None:
        """A row with both medians and 99th percentiles, and how many times the other's ours are."""
        cells, met = [], True
        for figure, goal in ((median, p50_goal), (p99, p99_goal)):
            ours, other = figure(self.ours), figure(self.other)
            cells += [f"{ours:.2f}", f"{other:.2f}", f"{ours / other:.1f}"]
            met = met and ours <= goal * other
        print_row(what, *cells, f"≤ {p50_goal:g} × / {p99_goal:g} ×", "met" if met else "not met")


@dataclass(frozen=True, slots=True)
class Request:
    """A request, and its parameters after an edit of a document with this URI."""

    method: str
    params: Callable[[Edit, str], Mapping[str, Any]]


def run(quick: bool) -> None:
    """Measure and print; `quick` measures the same with fewer rounds."""
    rounds, opens, blocks = (2, 3, 2) if quick else (10, 20, 8)
    print(f"{machine()}, {platform.system()}, Python {platform.python_version()}\n")
    asked = f"{LINES:,} lines, {rounds * AT_ONCE} times, each after an edit"
    print(f"Request written → answer read, milliseconds, {asked}\n")
    _print_head("what", "bare pygls")
    for what, times in _requests(rounds).items():
        times.print(what, 3, 5)
    tokens, checks = _first_tokens(opens), _first_checks(opens)
    print(f"\nThe first time, milliseconds, {opens} times; {machine()}\n")
    print_head("what", "p50", "p99", "goal", "")
    verdict = "met" if median(tokens) <= 15 else "not met"
    print_row("semantic tokens, full", f"{median(tokens):.1f}", f"{p99(tokens):.1f}", "p50 ≤ 15", verdict)
    print_row(f"workspace diagnostics, {CLASS} programs", f"{median(checks):.1f}", f"{p99(checks):.1f}", "", "")
    typed = f"{LINES:,} lines, {blocks * AT_ONCE} keys, {KEYS_A_SECOND} a second, in turns with nothing else"
    print(f"\nKeystroke written → diagnostics read, milliseconds, {typed}; {machine()}\n")
    _print_head("while", "nothing else")
    _beside_a_dance(blocks).print("a dance plays, its page open", 1.5, 2)
    _beside_checks(blocks).print(f"{MANY} programs in the folder are checked", 1.5, 2)
    print(f"\n{machine()} at the end")


def _requests(rounds: int) -> Mapping[str, Times]:
    """The times of each request; every one comes right after an edit."""
    text = improv(LINES, "name")
    found = {what: Times() for what in _ASKED_FOR}
    last: dict[tuple[Kind, str], Any] = {}  # the answer before
    with ExitStack() as stack:
        servers = {kind: stack.enter_context(_opened(kind, "name")) for kind in _PAIR}
        for server in servers.values():
            _write_programs(server, CLASS)
        changes = {kind: edits(IMPROV, text) for kind in _PAIR}
        for turn in range(rounds + 1):
            for what, request in _ASKED_FOR.items():
                for kind, server in servers.items():
                    for edit in islice(changes[kind], AT_ONCE):
                        server.change(edit)
                        params = {**request.params(edit, server.uri), **_since(request.method, last, kind)}
                        seconds, answer = server.request(request.method, params)
                        last[kind, request.method.removesuffix("/delta")] = answer
                        if turn:  # the first one warms up
                            times = found[what].ours if kind is _ASKED else found[what].other
                            times.append(seconds * 1000)
    return found


def _since(method: str, last: Mapping[tuple[Kind, str], Any], kind: Kind) -> dict[str, Any]:
    """The parameters of a request for what is new since the answer before."""
    answer = last.get((kind, method.removesuffix("/delta"))) or {}
    if method.endswith("/delta"):
        return {"previousResultId": answer.get("resultId", "0")}
    if method == types.WORKSPACE_DIAGNOSTIC:
        known = [{"uri": each["uri"], "value": each["resultId"]} for each in answer.get("items", ())]
        return {"previousResultIds": known}
    return {}


def _place(line: int, character: int) -> dict[str, int]:
    return {"line": line, "character": character}


def _range(line: int, last: int, character: int) -> dict[str, Any]:
    return {"start": _place(line, 0), "end": _place(last, character)}


def _whole(edit: Edit) -> dict[str, Any]:
    return {"range": _range(edit.line, edit.line, len(edit.text))}


def _seen(edit: Edit) -> dict[str, Any]:
    """What an editor shows around an edit."""
    return {"range": _range(max(edit.line - 25, 0), min(edit.line + 25, LINES), 0)}


def _anywhere(edit: Edit) -> int:
    """A column of an edited line, the same for every server."""
    return Random(edit.text).randrange(len(edit.text))


_NAME = {"position": _place(SHARED_LINE, len(SHARED))}
_OPTIONS = {"options": {"tabSize": 4, "insertSpaces": True}}


def _of_document(method: str, params: Callable[[Edit], Mapping[str, Any]] = lambda _: {}) -> Request:
    return Request(method, lambda edit, uri: {"textDocument": {"uri": uri}, **params(edit)})


def _of_item(method: str) -> Request:
    span = _range(SHARED_LINE, SHARED_LINE, len(SHARED))
    item = {"name": SHARED, "kind": types.SymbolKind.Function, "range": span, "selectionRange": span}
    return Request(method, lambda _, uri: {"item": {**item, "uri": uri}})


_ASKED_FOR: Mapping[str, Request] = {
    "diagnostics": _of_document(types.TEXT_DOCUMENT_DIAGNOSTIC),
    f"workspace diagnostics, {CLASS} programs": Request(types.WORKSPACE_DIAGNOSTIC, lambda *_: {}),
    "hover with a picture": _of_document(
        types.TEXT_DOCUMENT_HOVER, lambda edit: {"position": _place(edit.line, _anywhere(edit))}
    ),
    "completion": _of_document(
        types.TEXT_DOCUMENT_COMPLETION, lambda edit: {"position": _place(edit.line, len(edit.text))}
    ),
    "completion, one item": Request(
        types.COMPLETION_ITEM_RESOLVE, lambda edit, uri: {"label": SHARED, "data": [uri, edit.line // 2, "name"]}
    ),
    "signature help": _of_document(
        types.TEXT_DOCUMENT_SIGNATURE_HELP,
        lambda edit: {"position": _place(edit.line, edit.text.rfind(" "))},
    ),
    "code actions": _of_document(
        types.TEXT_DOCUMENT_CODE_ACTION, lambda edit: {**_whole(edit), "context": {"diagnostics": []}}
    ),
    "code actions, one chosen": Request(
        types.CODE_ACTION_RESOLVE,
        lambda edit, uri: {"title": "Remove it", "kind": "quickfix", "data": [uri, 0, edit.line]},
    ),
    "code lenses": _of_document(types.TEXT_DOCUMENT_CODE_LENS),
    "inlay hints, 50 lines": _of_document(types.TEXT_DOCUMENT_INLAY_HINT, _seen),
    "formatting": _of_document(types.TEXT_DOCUMENT_FORMATTING, lambda _: _OPTIONS),
    "formatting, one line": _of_document(
        types.TEXT_DOCUMENT_RANGE_FORMATTING, lambda edit: {**_OPTIONS, **_whole(edit)}
    ),
    "formatting, as one types": _of_document(
        types.TEXT_DOCUMENT_ON_TYPE_FORMATTING,
        lambda edit: {**_OPTIONS, "position": _place(edit.line + 1, 0), "ch": "\n"},
    ),
    "declaration": _of_document(types.TEXT_DOCUMENT_DECLARATION, lambda _: _NAME),
    "definition": _of_document(types.TEXT_DOCUMENT_DEFINITION, lambda _: _NAME),
    "references": _of_document(
        types.TEXT_DOCUMENT_REFERENCES, lambda _: {**_NAME, "context": {"includeDeclaration": True}}
    ),
    "highlights": _of_document(types.TEXT_DOCUMENT_DOCUMENT_HIGHLIGHT, lambda _: _NAME),
    "rename, prepared": _of_document(types.TEXT_DOCUMENT_PREPARE_RENAME, lambda _: _NAME),
    "rename": _of_document(types.TEXT_DOCUMENT_RENAME, lambda _: {**_NAME, "newName": "theme"}),
    "call hierarchy": _of_document(types.TEXT_DOCUMENT_PREPARE_CALL_HIERARCHY, lambda _: _NAME),
    "call hierarchy, incoming": _of_item(types.CALL_HIERARCHY_INCOMING_CALLS),
    "call hierarchy, outgoing": _of_item(types.CALL_HIERARCHY_OUTGOING_CALLS),
    "outline": _of_document(types.TEXT_DOCUMENT_DOCUMENT_SYMBOL),
    "selection range": _of_document(
        types.TEXT_DOCUMENT_SELECTION_RANGE, lambda edit: {"positions": [_place(edit.line, len(edit.text))]}
    ),
    "folding ranges": _of_document(types.TEXT_DOCUMENT_FOLDING_RANGE),
    "semantic tokens, full": _of_document(types.TEXT_DOCUMENT_SEMANTIC_TOKENS_FULL),
    "semantic tokens, delta": _of_document(types.TEXT_DOCUMENT_SEMANTIC_TOKENS_FULL_DELTA),
    "semantic tokens, 50 lines": _of_document(types.TEXT_DOCUMENT_SEMANTIC_TOKENS_RANGE, _seen),
    "workspace symbols": Request(types.WORKSPACE_SYMBOL, lambda *_: {"query": SHARED}),
}
_NOT_ASKED = {
    method
    for method in FEATURES
    if (known := types.METHOD_TO_TYPES.get(method, (None, method)))[1]
    and method not in {types.INITIALIZE, *(each.method for each in _ASKED_FOR.values())}
}
if _NOT_ASKED:
    raise RuntimeError(f"requests that are not measured: {', '.join(sorted(_NOT_ASKED))}")


def _first_tokens(opens: int) -> list[float]:
    def first() -> float:
        with _opened(OURS) as server:
            return server.ask("semanticTokens/full")[0] * 1000

    return [first() for _ in range(opens)]


def _first_checks(opens: int) -> list[float]:
    """How long the programs of a class take, and the process that checks them takes to start."""

    def first() -> float:
        with _opened(_ASKED) as server:
            _write_programs(server, CLASS)
            return server.request(types.WORKSPACE_DIAGNOSTIC, {"previousResultIds": []})[0] * 1000

    return [first() for _ in range(opens)]


def _beside_a_dance(blocks: int) -> Times:
    """The times of keys while the document plays, and while it has been stopped, of one server, in turns."""
    times = Times()
    with _opened(PLAYER) as server, page_of(server) as page:
        type_ = _Typist(server)
        for _ in range(blocks):
            server.save()
            page.wait_for_selector("body[data-state=playing]")
            times.ours.extend(type_(AT_ONCE))
            if page.locator("body").get_attribute("data-state") != "playing":
                raise RuntimeError("the dance was over before the typing was")
            server.command("improv.hush")
            page.wait_for_selector("body[data-state=stopped]")
            times.other.extend(type_(AT_ONCE))
    return times


def _beside_checks(blocks: int) -> Times:
    """The times of keys while all programs in the folder are checked, and while they are not, in turns."""
    times = Times()
    with _opened(_ASKED) as server:
        type_ = _Typist(server)
        for block in range(blocks):
            _write_programs(server, MANY, block)
            check = server.begin(types.WORKSPACE_DIAGNOSTIC, {"previousResultIds": []})
            while server.is_waiting_for(check):
                times.ours.extend(type_(1))
            times.other.extend(type_(AT_ONCE))
    return times


class _Typist:
    """Types into the document of a server, at uneven times; the document is right again after each turn."""

    def __init__(self, server: Server) -> None:
        self._server = server
        self._random = Random(2)
        self._edits = edits(IMPROV, improv(LINES))
        self(AT_ONCE)  # these warm up

    def __call__(self, keys: int) -> list[float]:
        """How many milliseconds each of so many edits takes."""
        times, due = [], time.monotonic()
        for count, edit in enumerate(self._edits, 1):
            due += self._random.uniform(0.5, 1.5) / KEYS_A_SECOND
            time.sleep(max(due - time.monotonic(), 0))
            times.append(self._server.change(edit).seconds * 1000)
            if count >= keys and not edit.wrong:
                return times
        raise AssertionError("edits have no end")


@contextmanager
def _opened(kind: Kind, uses: Uses = "") -> Iterator[Server]:
    """A server with the document open."""
    with Server(kind) as server:
        if server.open(improv(LINES, uses)).mistakes:
            raise RuntimeError("there is a mistake where none is")
        yield server


def _write_programs(server: Server, count: int, seed: int = 0) -> None:
    """Write so many programs into the server's folder."""
    for number in range(count):
        text = improv(100, seed=seed * count + number)
        (server.folder / f"{number}.improv").write_text(text, encoding="utf-8")


def _print_head(what: str, other: str) -> None:
    print_head(what, *(cell for p in ("p50", "p99") for cell in (p, f"{p}, {other}", "ratio")), "goal", "")
