"""Work runs in slices: messages are read in between, and small or new work comes first."""

from __future__ import annotations

import dataclasses
import json
from collections.abc import Callable, Iterable
from concurrent.futures import Future, ThreadPoolExecutor
from functools import partial
from typing import Any

import pytest

from improv_core.ide.folding_range import folds
from improv_core.ide.formatting import format_all
from improv_core.ide.references import plays
from improv_core.program.analysis import Analysis, analyze
from improv_core.program.idle import find_idle
from improv_core.program.meaning import Meaning, understand
from improv_core.slices import checkpoint, on_checkpoint
from improv_core.values import value
from improv_ls import coloring, framing
from improv_ls.documents import Document, opened
from improv_ls.settling import Settling
from improv_ls.slices import BRIEF, SLICE, Slices
from improv_ls.urdfs import BEING_READ, SMALL, Urdfs
from tests.heavy import HEAVY
from tests.ls.client import Client, place

WORST, OTHER = "file:///worst.improv", "file:///other.improv"
STEP = SLICE / 2


def ignore(*_: object) -> None:
    pass


class Turns:
    """Turns of an event loop, and a clock that only work moves."""

    def __init__(self) -> None:
        self.now = 0.0
        self.seen: list[str] = []
        self._soon: list[Callable[[], object]] = []
        self.slices = Slices(self._soon.append, lambda: self.now)

    def work(self, name: str, steps: int) -> Callable[[], str]:
        def run() -> str:
            for _ in range(steps):
                self.now += STEP
                self.seen.append(name)
                checkpoint()
            return name

        return run

    @property
    def is_busy(self) -> bool:
        return bool(self._soon)

    def turn(self) -> None:
        soon, self._soon[:] = [*self._soon], []
        for each in soon:
            each()


def test_short_work_is_done_at_once() -> None:
    turns = Turns()
    assert turns.slices.begin(turns.work("short", 1)).result(0) == "short"


def test_long_work_stops_after_each_slice() -> None:
    turns = Turns()
    future = turns.slices.begin(turns.work("long", 5))
    assert turns.seen == ["long"] * 2
    turns.turn()
    assert turns.seen == ["long"] * 4
    assert not future.done()
    turns.turn()
    assert future.result(0) == "long"


def test_only_the_first_slice_may_be_brief() -> None:
    turns = Turns()
    turns.slices.begin(turns.work("long", 5), share=BRIEF)
    assert turns.seen == ["long"]
    turns.turn()
    assert turns.seen == ["long"] * 3


def test_short_new_work_is_done_before_older_work() -> None:
    turns = Turns()
    long = turns.slices.begin(turns.work("long", 100))
    for _ in range(5):
        turns.turn()
    short = turns.slices.begin(turns.work("short", 3))
    for _ in range(2):
        turns.turn()
    assert (short.done(), long.done()) == (True, False)


def test_dropped_work_never_continues() -> None:
    turns = Turns()
    future: Future[str] = turns.slices.begin(turns.work("old", 100))
    future.cancel()
    before = [*turns.seen]
    for _ in range(3):
        turns.turn()
    assert turns.seen == before


def test_an_error_reaches_its_waiter() -> None:
    def fail() -> None:
        turns.now += SLICE
        checkpoint()
        raise ValueError("wrong")

    turns = Turns()
    future = turns.slices.begin(fail)
    turns.turn()
    with pytest.raises(ValueError, match="wrong"):
        future.result(0)


def test_another_file_is_answered_before_the_worst_one_is_analyzed() -> None:
    with Client({"onSave": "off"}, hurries=True) as client:
        client.open(WORST, HEAVY["phrases in phrases"])
        client.open(OTHER, "r $ forward\n")
        whole = client.begin("textDocument/rename", place(WORST, 18, 0, newName="ada"))
        assert client.request("textDocument/hover", place(OTHER, 0, 5))
        client.command("stop")
        answered = [each.message["id"] for each in client.log if each.by_server and "result" in each.message]
        assert whole not in answered


def test_a_large_urdf_is_read_in_slices_and_by_other_work_and_other_threads_at_once(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    turns, read = Turns(), list[str]()

    def skeleton_in(source: bytes) -> str:
        return turns.work("urdf", 5 if len(source) > SMALL else 1)()

    monkeypatch.setattr("improv_core.robots.skeletons.skeleton_in", skeleton_in)
    urdfs = Urdfs(turns.slices, lambda: read.append("read"))
    large = [bytes([number]) * (SMALL + 1) for number in range(3)]
    assert urdfs.skeleton_in(b"small") == "urdf"
    for _ in range(2):
        assert urdfs.skeleton_in(large[0]) == BEING_READ
    turns.turn()
    assert (urdfs.skeleton_in(large[0]), read) == (BEING_READ, [])
    turns.turn()
    assert (urdfs.skeleton_in(large[0]), read) == ("urdf", ["read"])
    request = turns.slices.begin(lambda: urdfs.skeleton_in(large[1]))
    while not request.done():
        turns.turn()
    assert request.result(0) == "urdf"
    with ThreadPoolExecutor() as thread:
        assert thread.submit(urdfs.skeleton_in, large[2]).result() == "urdf"
    assert turns.seen == ["urdf"] * (1 + 5 + 5 + 5)


def test_work_on_a_long_text_has_checkpoints() -> None:
    line, lines = analyze("r $ " + "up " * 5_000), analyze("x y z $ (\n" * 5_000)
    endless = analyze("x $ repeat up\n" * 5_000)
    works: dict[str, Callable[[], Iterable[object]]] = {
        "colors of a line": lambda: coloring.chunks(line, "utf-16"),
        "colors of lines": lambda: coloring.chunks(lines, "utf-16"),
        "JSON": lambda: framing._json({"data": [0] * 50_000}),
        "folds": lambda: folds(lines),
        "formatting": lambda: format_all(lines),
        "idle": lambda: find_idle(endless),
        "plays": lambda: plays(lines, "x"),
    }
    for name, work in works.items():
        passed: list[None] = []
        on_checkpoint(partial(passed.append, None))
        try:
            list(work())
        finally:
            on_checkpoint(None)
        assert len(passed) >= 50, name


def test_json_that_is_made_in_slices_is_the_same() -> None:
    long: object = {"data": [*range(2_500)], "resultId": "1", "none": None, "ä": {"b": [{"c": 1}] * 1_500}}
    for each in ({}, [], long):
        assert "".join(framing._json(each)) == json.dumps(each)


def test_a_request_about_an_older_text_is_dropped() -> None:
    with Client({"onSave": "off"}, hurries=True) as client:
        client.open(WORST, HEAVY["phrases in phrases"])
        old = client.begin("textDocument/rename", place(WORST, 18, 0, newName="ada"))
        client.change(WORST, 2, {"text": "r $ forwrd\n"})
        diagnostics = client.wait("textDocument/publishDiagnostics", lambda params: params["version"] == 2)
        assert [each["code"] for each in diagnostics["diagnostics"]] == ["unknown-name"]
        errors = {each.message["id"]: each.message["error"]["code"] for each in client.log if "error" in each.message}
        assert errors[old] == -32801


def test_no_empty_list_is_published_about_a_text_that_was_not_analyzed(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("improv_ls.slices.SLICE", 0)  # as on a machine that is far too slow
    with Client({"onSave": "off"}, hurries=True) as client:
        client.open(OTHER, "r $ forwrd\n")
        published = client.wait("textDocument/publishDiagnostics")
        assert [each["code"] for each in published["diagnostics"]] == ["unknown-name"]


def test_a_fixed_error_goes_before_the_lines_that_use_the_name_are_read_again(monkeypatch: pytest.MonkeyPatch) -> None:
    turns, published = Turns(), list[tuple[bool, list[str]]]()

    def slowly(*given: Any) -> Meaning:
        turns.now += STEP
        return understand(*given)

    def publish(document: Document) -> None:
        analysis = document.analysis
        published.append((analysis.is_settled, [each.code for each in analysis.diagnostics]))

    settling = Settling(turns.slices, Urdfs(turns.slices, ignore), {}, publish, ignore, ignore, ignore)
    wrong = analyze("a = forwrd\nb = a\nr $ b\n")
    monkeypatch.setattr("improv_core.program.analysis.understand", slowly)
    settling.keep(Document(OTHER, 1, wrong.touched(4, 10, "forward")))
    while turns.is_busy:
        turns.turn()
    assert published == [(False, [])]


def test_requests_get_the_error_of_a_text_that_fails_and_the_next_text_works() -> None:
    turns, told = Turns(), list[str]()
    urdfs = Urdfs(turns.slices, ignore)
    settling = Settling(turns.slices, urdfs, {}, ignore, ignore, ignore, lambda error: told.append(str(error)))
    plain = opened(OTHER, 1, "r $ up\n")

    @value(frozen=True, slots=False)
    class Failing(Analysis):
        def settled(self, enough: Callable[[], bool] | None = None, until: int | None = None) -> Analysis:
            turns.now += SLICE
            checkpoint()
            raise ValueError("wrong")

    given = {each.name: getattr(plain.analysis, each.name) for each in dataclasses.fields(plain.analysis)}
    settling.keep(dataclasses.replace(plain, analysis=Failing(**given)))
    before, after, next_text = Future[object](), Future[object](), Future[object]()
    settling.answer(lambda: "known", before, OTHER)
    turns.turn()
    settling.answer(lambda: "known", after, OTHER)
    assert [str(each.exception(0)) for each in (before, after)] == ["wrong", "wrong"]
    assert told == ["wrong"]
    settling.keep(dataclasses.replace(plain, analysis=plain.analysis.settled()))
    settling.answer(lambda: "known", next_text, OTHER)
    assert next_text.result(0) == "known"
