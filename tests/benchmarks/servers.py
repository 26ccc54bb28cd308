"""Our server as an editor starts it, with one document, and the times at which it answers."""

from __future__ import annotations

import os
import re
import sys
import sysconfig
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from time import perf_counter
from typing import Any

from tests.benchmarks.documents import Edit
from tests.ls.client import CAPABILITIES, ProcessClient, place
from tests.processes import stat_of

OPTIONS: Mapping[str, Any] = {"backend": "sim", "page": {"open": False}, "onSave": "off"}
"""Options with which no stage starts."""
URI = "file:///benchmark/document.improv"
PUBLISHED = "textDocument/publishDiagnostics"
RUFF = (str(Path(sysconfig.get_path("scripts")) / "ruff"), "server")
"""Another language server, for Python, beside which ours is measured."""
RUFF_OPTIONS: Mapping[str, Any] = {
    "settings": {
        "configurationPreference": "editorOnly",  # whatever configuration lies around
        "logLevel": "error",
        "lint": {"enable": True, "select": ["E4", "E7", "E9", "F"]},
    }
}


@dataclass(frozen=True, slots=True)
class Seen:
    """Time until diagnostics were there, and the number of errors and warnings among them."""

    seconds: float
    mistakes: int


def processor_time(pid: int) -> float:
    """Return the seconds of processor time that a process has used (Linux)."""
    fields = stat_of(pid)
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


def memory(pid: int) -> tuple[float, float]:
    """Return the memory of a process, now and at most so far, in MB (10^6 bytes; Linux)."""
    status = Path(f"/proc/{pid}/status").read_text(encoding="utf-8")
    now, most = (int(re.findall(rf"{name}:\s+(\d+) kB", status)[0]) for name in ("VmRSS", "VmHWM"))
    return now * 1024 / 1e6, most * 1024 / 1e6


class Server:
    """Our server with one document; use as a context manager."""

    def __init__(
        self,
        options: Mapping[str, Any] = OPTIONS,
        env: Mapping[str, str] | None = None,
        command: Sequence[str] = (sys.executable, "-m", "improv_ls"),
        uri: str = URI,
        language: str = "improv",
    ) -> None:
        self._uri, self._language = uri, language
        self._version = 1
        self._changed = 0.0
        begin = perf_counter()
        self.client = ProcessClient(options, CAPABILITIES, env, os.getpid(), command)
        self.start_seconds = perf_counter() - begin

    @property
    def pid(self) -> int:
        return self.client.process.pid

    def __enter__(self) -> Server:
        return self

    def __exit__(self, *failure: object) -> None:
        self.client.__exit__(*failure)

    def open(self, text: str) -> Seen:
        """Open the document."""
        self._changed = perf_counter()
        self.client.open(self._uri, text, self._language)
        return self._published()

    def change(self, edit: Edit) -> Seen:
        """Replace one line of the document."""
        start, end = ({"line": edit.line, "character": character} for character in (0, edit.length))
        return self._change({"range": {"start": start, "end": end}, "text": edit.text})

    def replace(self, text: str) -> Seen:
        """Replace the whole document."""
        return self._change({"text": text})

    def save(self) -> float:
        """Save the document, and return the time at which the write began, by the monotonic clock."""
        begin = perf_counter()
        self.client.save(self._uri)
        return begin

    def command(self, name: str) -> float:
        """Have a command executed, and return the time at which the write began, by the monotonic clock."""
        begin = perf_counter()
        self.client.command(name)
        return begin

    def settle(self) -> float:
        """Return the seconds from the latest change until all of the document was up to date, which a rename waits for:
        it is refused, since there is no name at the beginning."""
        return self._since_change(self.client.refusal("textDocument/rename", place(self._uri, 0, 0, newName="other")))

    def _change(self, change: Mapping[str, Any]) -> Seen:
        self._version += 1
        self._changed = perf_counter()
        self.client.change(self._uri, self._version, change)
        return self._published()

    def _published(self) -> Seen:
        """Wait for the next diagnostics of the version that the server has now."""
        found = self.client.wait(PUBLISHED, lambda params: params.get("version") == self._version)
        return Seen(self._since_change(found), _mistakes(found))

    def mistakes(self) -> int:
        """Return the number of errors and warnings in the diagnostics that came last."""
        messages = (each.message for each in reversed(self.client.log))
        return _mistakes(next(each for each in messages if each.get("method") == PUBLISHED)["params"])

    def _since_change(self, content: object) -> float:
        """Return the seconds from the latest change until the message with this content came."""
        messages = reversed(self.client.log)
        at = next(each.at for each in messages if any(value is content for value in each.message.values()))
        return at - self._changed


def _mistakes(published: Mapping[str, Any]) -> int:
    return sum(each["severity"] <= 2 for each in published["diagnostics"])
