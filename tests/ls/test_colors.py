"""Semantic tokens: exact in every unit, and a delta turns the old ones into the new ones."""

from __future__ import annotations

from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st
from lsprotocol.types import PositionEncodingKind as Encoding

from improv_core.program.analysis import analyze
from improv_ls import settling, slices
from improv_ls.coloring import chunks, edits, encoded
from improv_ls.positions import units
from tests.ls.client import Client, place, span

URI = "untitled:Untitled-1"
PROGRAM = "# 🐢\r\n\ufeff 𝑥 = up # 🐢\r\nr $ (left # 😀\r\n 𝑥 𝑥)\r\n"
LINES = ["𝑥 = up", "r $ 𝑥 (", "up # 😀)", ") left", "# é", "", "  beat 3/2", "s $ [𝑥 𝑥] || up", "x = left", "s $ x y"]
PROGRAMS = st.lists(st.sampled_from(LINES), max_size=8).flatmap(
    lambda lines: st.sampled_from(["\n", "\r\n", "\r"]).map(lambda end: "".join(line + end for line in lines))
)
ENCODINGS = [Encoding.Utf8, Encoding.Utf16, Encoding.Utf32]


def read(data: list[int], legend: dict[str, list[str]]) -> list[tuple[int, int, int, str]]:
    """Return line, column, length and type of each token, as an editor reads them."""
    found, line, column = [], 0, 0
    for at in range(0, len(data), 5):
        down, right, length, kind, _ = data[at : at + 5]
        line, column = line + down, right if down else column + right
        found.append((line, column, length, legend["tokenTypes"][kind]))
    return found


def test_full_range_and_delta() -> None:
    with Client() as client:
        options = client.initialized["capabilities"]["semanticTokensProvider"]
        assert (options["full"], options["range"]) == ({"delta": True}, True)
        client.open(URI, PROGRAM)
        asked: dict[str, Any] = {"textDocument": {"uri": URI}}
        full = client.request("textDocument/semanticTokens/full", asked)
        first = [(0, 0, 4, "comment"), (1, 2, 2, "variable"), (1, 5, 1, "operator"), (1, 7, 2, "function")]
        rest = [(2, 0, 1, "class"), (2, 2, 1, "operator"), (2, 5, 4, "function"), (2, 10, 4, "comment")]
        rest += [(3, 1, 2, "variable"), (3, 4, 2, "variable")]
        assert read(full["data"], options["legend"]) == [*first, (1, 10, 4, "comment"), *rest]

        seen = span(2, 3, 5)
        ranged = client.request("textDocument/semanticTokens/range", {**asked, "range": seen})
        assert read(ranged["data"], options["legend"]) == rest

        full = client.request("textDocument/semanticTokens/full", asked)
        client.change(URI, 2, {"text": PROGRAM.replace("left", "repeat left")})
        asked["previousResultId"] = full["resultId"]
        delta = client.request("textDocument/semanticTokens/full/delta", asked)
        data = apply(full["data"], [(edit["start"], edit["deleteCount"], edit["data"]) for edit in delta["edits"]])
        again = client.request("textDocument/semanticTokens/full", asked)
        assert data == again["data"]
        assert "data" in client.request("textDocument/semanticTokens/full/delta", {**asked, "previousResultId": "?"})


def test_a_delta_after_a_range_has_all_tokens() -> None:
    """Neovim 0.12 asks for both at once, and applies the edits of the second answer to the tokens of the first."""
    with Client() as client:
        client.open(URI, PROGRAM)
        asked: dict[str, Any] = {"textDocument": {"uri": URI}}
        full = client.request("textDocument/semanticTokens/full", asked)
        client.change(URI, 2, {"text": "r $ left\n"})
        client.request("textDocument/semanticTokens/range", {**asked, "range": span(0, 0, 5)})
        delta = client.request("textDocument/semanticTokens/full/delta", asked | {"previousResultId": full["resultId"]})
        assert delta["data"] == client.request("textDocument/semanticTokens/full", asked)["data"]


def test_an_editor_that_was_sent_colors_too_early_asks_again(monkeypatch: pytest.MonkeyPatch) -> None:
    """A word is undefined only once the lines above are read; until then, it has a name's color."""
    monkeypatch.setattr(settling, "PATIENCE", 0.0)
    many = 2_000
    with Client(capabilities={"workspace": {"semanticTokens": {"refreshSupport": True}}}, hurries=True) as client:
        legend = client.initialized["capabilities"]["semanticTokensProvider"]["legend"]

        def colors_of_last_line() -> list[str]:
            full = client.request("textDocument/semanticTokens/full", {"textDocument": {"uri": URI}})
            return [kind for line, _, _, kind in read(full["data"], legend) if line == many]

        client.open(URI, "x = left\n" + "r $ x\n" * many)
        client.request("textDocument/rename", place(URI, 0, 0, newName="z"))  # waits for all lines
        monkeypatch.setattr(slices, "SLICE", 0.0)  # the analysis stops wherever it can
        client.change(URI, 2, {"range": span(0, 0, 1), "text": "y"})
        assert colors_of_last_line() == ["class", "operator", "variable"]
        client.wait("workspace/semanticTokens/refresh")
        assert colors_of_last_line() == ["class", "operator"]


@pytest.mark.parametrize("encoding", ENCODINGS)
@given(text=PROGRAMS)
def test_every_token_is_at_its_stated_position(encoding: Encoding, text: str) -> None:
    analysis = analyze(text)
    legend = {"tokenTypes": [str(number) for number in range(10)]}
    end = (-1, 0)
    for line, column, length, _ in read(encoded(chunks(analysis, encoding)), legend):
        whole = analysis.lines.line(line)
        places = {units(whole[:at], encoding): at for at in range(len(whole) + 1)}
        word = whole[places[column] : places[column + length]]
        assert word.strip() == word != ""
        assert word.startswith("#") or " " not in word
        assert (line, column) >= end
        end = (line, column + length)


@given(before=PROGRAMS, after=PROGRAMS)
def test_a_delta_turns_the_old_tokens_into_the_new(before: str, after: str) -> None:
    old, new = (chunks(analyze(text), Encoding.Utf16) for text in (before, after))
    found = edits(old, new)
    assert apply(encoded(old), found) == encoded(new)
    for start, count, data in found:
        assert count or data
        replaced = encoded(old)[start : start + count]
        assert replaced[:1] != data[:1] or not data
        assert replaced[-1:] != data[-1:] or not data


def apply(data: list[int], found: Any) -> list[int]:
    """Apply edits as an editor does: from the last to the first, each counted in the old integers."""
    data = list(data)
    for start, count, new in reversed(found):
        data[start : start + count] = new or []
    return data
