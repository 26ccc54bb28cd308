"""From a request to its answer in a document of a thousand lines, and from a keystroke to its diagnostics while a dance
plays and its page is open."""

from __future__ import annotations

import os
import platform
import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, replace
from itertools import islice
from random import Random
from statistics import median
from typing import Any

from tests.benchmarks.background import KEYS_A_SECOND, PLAYER, playing
from tests.benchmarks.documents import IMPROV, SHARED, SHARED_LINE, Edit, Uses, edits, improv
from tests.benchmarks.servers import OURS, Kind, Server
from tests.benchmarks.tables import p99, print_row

LINES = 1_000
AT_ONCE = 20
_ASKED = replace(OURS, options={**OURS.options, "hover": {"pictures": True}})


@dataclass(frozen=True, slots=True)
class Goal:
    """How much the median and the 99th percentile may be, in milliseconds."""

    p50: float
    p99: float

    def __str__(self) -> str:
        return f"≤ {self.p50:g} / {self.p99:g}"

    def verdict(self, times: list[float]) -> str:
        return "met" if median(times) <= self.p50 and p99(times) <= self.p99 else "not met"


@dataclass(frozen=True, slots=True)
class Request:
    """A request, and what it asks for after an edit: with `previous`, for the difference to the last answer."""

    method: str
    params: Callable[[Edit], dict[str, Any]]
    goal: Goal | None = None
    previous: bool = False


def run(quick: bool) -> None:
    """Measure and print; `quick` measures the same with fewer rounds."""
    rounds, opens, keys = (2, 3, 100) if quick else (10, 20, 400)
    print(f"{len(os.sched_getaffinity(0))} cores, {platform.system()}, Python {platform.python_version()}\n")
    print(
        f"Request written → answer read, milliseconds, {LINES:,} lines, {rounds * AT_ONCE} times, each after an edit\n"
    )
    print_row("what", "p50", "p99", "goal", "")
    print_row("---", "---:", "---:", "---", "---")
    for what, (times, goal) in _requests(rounds).items():
        _print(what, times, goal)
    _print("semantic tokens, full, just opened", [_first_tokens() for _ in range(opens)], Goal(15, 30))
    typing = f"{LINES:,} lines, {keys} keys, {KEYS_A_SECOND} a second"
    print(f"\nKeystroke written → diagnostics read, milliseconds, {typing}\n")
    print_row("while", "p50", "p99", "goal", "")
    print_row("---", "---:", "---:", "---", "---")
    with _server(PLAYER) as server:
        alone = _typed(server, keys)
    _print("nothing plays", alone, None)
    with _server(PLAYER) as server, playing(server):
        beside = _typed(server, keys)
    print_row("a dance plays, its page open", f"{median(beside):.2f}", f"{p99(beside):.2f}", *_doubled(alone, beside))


def _requests(rounds: int) -> Mapping[str, tuple[list[float], Goal | None]]:
    """The times of each request; every one comes right after an edit."""
    text = improv(LINES, "name")
    random = Random(3)
    shared = {"position": _place(SHARED_LINE, len(SHARED)), "newName": "theme"}
    asked = {
        "hover with a picture": Request(
            "hover", lambda edit: {"position": _place(edit.line, random.randrange(len(edit.text)))}, Goal(3, 10)
        ),
        "completion": Request("completion", lambda edit: {"position": _place(edit.line, len(edit.text))}, Goal(3, 10)),
        "semantic tokens, delta": Request("semanticTokens/full/delta", lambda _: {}, Goal(3, 10), previous=True),
        "semantic tokens, full": Request("semanticTokens/full", lambda _: {}, Goal(15, 30)),
        f"rename in {text.count(SHARED)} places": Request("rename", lambda _: shared, Goal(15, 30)),
        "outline": Request("documentSymbol", lambda _: {}),
        "code actions": Request("codeAction", lambda edit: {"range": _whole(edit), "context": {"diagnostics": []}}),
    }
    found: dict[str, list[float]] = {what: [] for what in asked}
    with _server(_ASKED, uses="name") as server:
        if not server.capabilities.get("codeActionProvider"):
            del found["code actions"]
        changes = edits(IMPROV, text)
        last = server.ask("semanticTokens/full")[1]["resultId"]
        for turn in range(rounds + 1):
            for what, times in found.items():
                request = asked[what]
                for edit in islice(changes, AT_ONCE):
                    server.change(edit)
                    previous = {"previousResultId": last} if request.previous else {}
                    seconds, answer = server.ask(request.method, **request.params(edit), **previous)
                    if isinstance(answer, dict):
                        last = answer.get("resultId", last)
                    if turn:  # the first one warms up
                        times.append(seconds * 1000)
    return {what: (times, asked[what].goal) for what, times in found.items()}


def _first_tokens() -> float:
    with _server(OURS) as server:
        return server.ask("semanticTokens/full")[0] * 1000


@contextmanager
def _server(kind: Kind, uses: Uses = "") -> Iterator[Server]:
    """A server with the document open."""
    with Server(kind) as server:
        if server.open(improv(LINES, uses)).mistakes:
            raise RuntimeError("there is a mistake where none is")
        yield server


def _typed(server: Server, keys: int) -> list[float]:
    """How long each of so many edits takes, typed at uneven times."""
    random = Random(2)
    changes = edits(IMPROV, improv(LINES))
    for edit in islice(changes, 20):  # these warm up
        server.change(edit)
    times = []
    due = time.monotonic()
    for edit in islice(changes, keys):
        due += random.uniform(0.5, 1.5) / KEYS_A_SECOND
        time.sleep(max(due - time.monotonic(), 0))
        times.append(server.change(edit).seconds * 1000)
    return times


def _place(line: int, character: int) -> dict[str, int]:
    return {"line": line, "character": character}


def _whole(edit: Edit) -> dict[str, Any]:
    return {"start": _place(edit.line, 0), "end": _place(edit.line, len(edit.text))}


def _doubled(alone: list[float], playing: list[float]) -> tuple[str, str]:
    return "p99 ≤ 2 × nothing plays", "met" if p99(playing) <= 2 * p99(alone) else "not met"


def _print(what: str, times: list[float], goal: Goal | None) -> None:
    print_row(what, f"{median(times):.2f}", f"{p99(times):.2f}", str(goal or ""), goal.verdict(times) if goal else "")
