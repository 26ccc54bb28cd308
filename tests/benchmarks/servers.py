"""A language client for benchmarks: one thread that writes a message and reads until the answer is there."""

from __future__ import annotations

import json
import os
import re
import select
import subprocess
import sys
from collections.abc import Iterable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory
from time import perf_counter
from typing import Any

from tests.benchmarks.documents import Edit
from tests.processes import stat_of

Message = dict[str, Any]
LIMIT = 60.0
"""Seconds to wait for anything, on a busy machine."""
SETTLES = 1.0
"""Seconds after which a server has no more to publish about a change."""

_CAPABILITIES: Mapping[str, Any] = {
    "general": {"positionEncodings": ["utf-16"]},
    "textDocument": {
        "codeAction": {"codeActionLiteralSupport": {"codeActionKind": {"valueSet": []}}},
        "hover": {"contentFormat": ["markdown"]},
        "publishDiagnostics": {"versionSupport": True},
    },
    "window": {"workDoneProgress": True, "showDocument": {"support": True}},
    "workspace": {"configuration": True, "didChangeConfiguration": {"dynamicRegistration": True}},
}


COMMAND = (sys.executable, "-m", "improv_ls")
OPTIONS: Mapping[str, Any] = {"backend": "sim", "page": {"open": False}, "onSave": "off"}
"""Options with which no stage starts."""


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
        command: Sequence[str] = COMMAND,
    ) -> None:
        self._version = 0
        self._next_id = 0
        self._changed = 0.0
        self._deadline = 0.0  # the limit of the current wait
        self._seen = Seen(0.0, 0)  # after the latest change
        self._bytes = bytearray()
        self.page: str | None = None
        """Address that the server has asked to show."""
        self._folder = TemporaryDirectory()
        self.folder = Path(self._folder.name)
        root = self.folder.as_uri()
        self.uri = f"{root}/document.improv"
        begin = perf_counter()
        env = {"DISPLAY": ":0", **(os.environ if env is None else env)}  # without a screen, it shows no page
        self._process = subprocess.Popen(
            command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, cwd=self._folder.name, bufsize=0, env=env
        )
        folders = [{"uri": root, "name": "benchmark"}]
        common = {"processId": os.getpid(), "rootUri": root, "workspaceFolders": folders}
        params = {**common, "capabilities": _CAPABILITIES, "initializationOptions": options}
        self.request("initialize", params)
        self.start_seconds = perf_counter() - begin
        self._notify("initialized", {})

    @property
    def pid(self) -> int:
        return self._process.pid

    def __enter__(self) -> Server:
        return self

    def __exit__(self, *failure: object) -> None:
        try:
            if failure[0] is None:
                self.request("shutdown", None)
                self._notify("exit", None)
                self._process.wait(LIMIT)
        finally:
            self._process.kill()
            self._process.communicate()
            self._folder.cleanup()

    def open(self, text: str) -> Seen:
        """Open the document."""
        document = {"uri": self.uri, "languageId": "improv", "version": self._version, "text": text}
        return self._see("textDocument/didOpen", {"textDocument": document})

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
        self._notify("textDocument/didSave", {"textDocument": {"uri": self.uri}})
        return begin

    def command(self, name: str) -> float:
        """Have a command executed, and return the time at which the write began, by the monotonic clock."""
        begin = perf_counter()
        self.request("workspace/executeCommand", {"command": name})
        return begin

    def settle(self) -> float:
        """Return the seconds from the latest change until everything that depends on it was up to date: then the server
        publishes its diagnostics again, unless there was nothing left to do at the first time."""
        with suppress(TimeoutError):
            self._seen = self._published(self._changed, SETTLES)
        return self._seen.seconds

    def ask(self, method: str, **params: Any) -> tuple[float, Any]:
        """Send a request about the document. Return the seconds until its answer, and the answer."""
        return self.request(f"textDocument/{method}", {"textDocument": {"uri": self.uri}, **params})

    def _change(self, change: Message) -> Seen:
        self._version += 1
        document = {"uri": self.uri, "version": self._version}
        return self._see("textDocument/didChange", {"textDocument": document, "contentChanges": [change]})

    def _see(self, method: str, params: Message) -> Seen:
        message = _framed({"method": method, "params": params})
        self._changed = perf_counter()
        self._write(message)
        self._seen = self._published(self._changed)
        return self._seen

    def _published(self, begin: float, limit: float = LIMIT) -> Seen:
        """Wait for the next diagnostics of the version that the server has now. Raises TimeoutError."""
        self._deadline = perf_counter() + limit
        while True:
            body, end = self._read()
            found = self._take(body)
            if found.get("method") != "textDocument/publishDiagnostics":
                continue
            published = found["params"]
            if published["uri"] == self.uri and published.get("version") == self._version:
                return Seen(end - begin, _mistakes(published["diagnostics"]))

    def request(self, method: str, params: Any) -> tuple[float, Any]:
        """Send a request. Return the seconds until its answer, and the answer."""
        self._next_id += 1
        message = _framed({"id": self._next_id, "method": method, "params": params})
        begin = perf_counter()
        self._deadline = begin + LIMIT
        self._write(message)
        while True:
            body, end = self._read()
            answer = self._take(body)
            if answer.get("id") == self._next_id and "method" not in answer:
                if "error" in answer:
                    raise RuntimeError(f"{method}: {answer['error']}")
                return end - begin, answer["result"]

    def _notify(self, method: str, params: Any) -> None:
        self._write(_framed({"method": method, "params": params}))

    def _take(self, body: bytes) -> Message:
        """Decode a message, and answer it if it is a request."""
        message: Message = json.loads(body)
        if "method" in message and "id" in message:
            result: Any = None
            if message["method"] == "workspace/configuration":
                result = [None for _ in message["params"]["items"]]
            elif message["method"] == "window/showDocument":
                self.page, result = message["params"]["uri"], {"success": True}
            self._write(_framed({"id": message["id"], "result": result}))
        return message

    def _write(self, message: bytes) -> None:
        assert self._process.stdin
        rest = memoryview(message)
        while rest:
            rest = rest[self._process.stdin.write(rest) :]

    def _read(self) -> tuple[bytes, float]:
        """Read the body of the next message, and the time of its last byte."""
        while True:
            head, mark, rest = self._bytes.partition(b"\r\n\r\n")
            if mark:
                length = int(re.findall(rb"(?i)content-length: *(\d+)", head)[0])
                if len(rest) >= length:
                    end = perf_counter()
                    del self._bytes[: len(head) + len(mark) + length]
                    return bytes(rest[:length]), end
            self._bytes += self._more()

    def _more(self) -> bytes:
        assert self._process.stdout
        left = self._deadline - perf_counter()
        if left < 0 or not select.select([self._process.stdout], [], [], left)[0]:
            raise TimeoutError("the server did not say in time what was waited for")
        more = os.read(self._process.stdout.fileno(), 1 << 20)
        if not more:
            raise RuntimeError("the server has ended")
        return more


def _mistakes(diagnostics: Iterable[Message]) -> int:
    return sum(each["severity"] <= 2 for each in diagnostics)


def _framed(message: Message) -> bytes:
    body = json.dumps({"jsonrpc": "2.0", **message}).encode()
    return b"Content-Length: %d\r\n\r\n%s" % (len(body), body)
