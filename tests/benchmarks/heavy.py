"""Delays of keys and requests in and beside programs whose analysis takes seconds."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from tempfile import TemporaryDirectory
from time import perf_counter, sleep

from improv_core.text import LineIndex, difference
from tests.benchmarks.tables import p99, print_head, print_row
from tests.heavy import HEAVY, LIMITED
from tests.ls.client import Client

GOAL = 100
"""Milliseconds."""
WHAT = ("key", "hover", "key elsewhere", "hover elsewhere")
PERIOD = 0.1
"""Seconds between two keys."""


def run(quick: bool) -> None:
    """Measure and print; `quick` measures the same with fewer keys."""
    keys = 10 if quick else 50
    print(f"Milliseconds from what is written to its answer, {keys} of each, while the heavy program is edited\n")
    print_head("heavy program", "what", "p50", "p99", "max", f"goal ≤ {GOAL}")
    for name, text in HEAVY.items():
        for what, times in _measured(text, keys).items():
            ordered = sorted(times)
            met = "met" if ordered[-1] <= GOAL else "not met"
            print_row(name, what, *(f"{each:.1f}" for each in (ordered[keys // 2], p99(times), ordered[-1])), met)


def _measured(text: str, keys: int) -> dict[str, list[float]]:
    """Measure keys in the heavy program: each changes a digit of its first line, so that all of it is analyzed
    again."""
    found: dict[str, list[float]] = {what: [] for what in WHAT}
    with TemporaryDirectory() as folder, Client({"onSave": "off", "backend": "sim"}, hurries=True) as client:
        (Path(folder) / "improv.toml").write_text(LIMITED, encoding="utf-8")
        heavy, light = ((Path(folder) / f"{name}.improv").as_uri() for name in ("heavy", "light"))
        texts = {heavy: text, light: "beat 60\nr1 $ forward\n"}
        for uri, opened in texts.items():
            client.open(uri, opened)
            _shown(client, uri, 1)  # nobody types before they see the text
        for version in range(2, keys + 2):
            number = f"# {version}\n" + (text if version % 2 else text.replace("beat 60", "beat 600", 1))

            def key(uri: str, written: str, version: int = version) -> Callable[[], object]:
                edit = _edit(texts[uri], written)
                texts[uri] = written

                def write() -> object:
                    client.change(uri, version, edit)
                    return _shown(client, uri, version)

                return write

            def hover(uri: str) -> Callable[[], object]:
                place = {"textDocument": {"uri": uri}, "position": {"line": 1, "character": 6}}
                return lambda: client.request("textDocument/hover", place)

            written = number.replace("scale n left", f"scale n{'*1' * (version % 3)} left", 1)
            acts = zip(
                WHAT,
                (key(heavy, written), hover(heavy), key(light, f"beat {version}\nr1 $ forward\n"), hover(light)),
                strict=True,
            )
            for what, act in acts:
                began = perf_counter()
                act()
                found[what].append((perf_counter() - began) * 1000)
            client.begin("textDocument/documentSymbol", {"textDocument": {"uri": heavy}})  # the next key comes first
            sleep(PERIOD)
        client.change(heavy, keys + 2, {"text": ""})
    return found


def _edit(before: str, after: str) -> dict[str, object]:
    """Return an editor's message when one text becomes another."""
    start, end, put = difference(before, after)
    lines = LineIndex(before)
    places = [{"line": line, "character": column} for line, column in map(lines.position, (start, end))]
    return {"range": dict(zip(("start", "end"), places, strict=True)), "text": put}


def _shown(client: Client, uri: str, version: int) -> object:
    """Wait for the diagnostics of a version."""
    return client.wait(
        "textDocument/publishDiagnostics", lambda params: (params["uri"], params.get("version")) == (uri, version)
    )
