"""A language client for tests: it writes as an editor does, and fails on messages that an editor would not expect.

The server runs on a thread of the test's own process, where starting it costs nothing, and so does the simulator's
stage. Only tests of a process (signals, exit codes, standard error, its own environment) need a `ProcessClient`.
"""

from __future__ import annotations

import json
import os
import queue
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from pathlib import Path
from typing import IO, Any, NamedTuple, Self

import pytest

from improv_core.ipc.asking import Answerer
from improv_ls import framing, placing, progress, settling, slices
from tests.stage_on_thread import USED, StageOnThread

Message = dict[str, Any]
LIMIT = 120.0
"""Seconds to wait for anything, on a busy machine."""
TURNS = 20
"""Requests after which all earlier requests have had their effect, which can take a few turns."""

CONVERTER = framing.converter()
"""Converter of all servers on threads: learning LSP's types takes longer than the rest of a server's start."""
CAPABILITIES: Mapping[str, Any] = {
    "general": {"positionEncodings": ["utf-16"]},
    "textDocument": {"codeAction": {"codeActionLiteralSupport": {"codeActionKind": {"valueSet": []}}}},
    "window": {"workDoneProgress": True, "showDocument": {"support": True}},
    "workspace": {"configuration": True, "didChangeConfiguration": {"dynamicRegistration": True}},
}
TOLD: Mapping[str, Any] = {**CAPABILITIES, "experimental": {"improv": True}}
"""Capabilities of a client that gets messages about the playback."""
QUIET: Mapping[str, Any] = {"backend": "sim", "page": {"open": False}}
"""The settings of a session in which no page opens."""


def place(uri: str, line: int, character: int, **more: Any) -> dict[str, Any]:
    """Return the parameters of a place in a document, as most requests name it, and further ones."""
    return {"textDocument": {"uri": uri}, "position": {"line": line, "character": character}, **more}


def span(line: int, start: int, end: int, last: int | None = None) -> dict[str, dict[str, int]]:
    """Return a range of a document: from one column to another one, in the same line if no `last` one is given."""
    ends_in = line if last is None else last
    return {"start": {"line": line, "character": start}, "end": {"line": ends_in, "character": end}}


def places(diagnostics: Sequence[Mapping[str, Any]]) -> list[tuple[int, int, int, str]]:
    """Return line, first and last column, and code of each diagnostic."""
    found = [(each["range"]["start"], each["range"]["end"], each["code"]) for each in diagnostics]
    return [(start["line"], start["character"], end["character"], code) for start, end, code in found]


class Spoken(NamedTuple):
    """A message, and its sender."""

    by_server: bool
    message: Message
    at: float = 0.0
    """The time at which the server's last byte of it came, by `time.perf_counter`."""


class Client:
    """Starts a server and speaks JSON-RPC to it; use as a context manager."""

    def __init__(
        self,
        options: Mapping[str, Any] | None = None,
        capabilities: Mapping[str, Any] = CAPABILITIES,
        configuration: Mapping[str, Any] | None = None,
        answers: bool = True,
        process: int | None = None,
        folders: Sequence[Path] = (),
        about: Mapping[str, Any] | None = None,
        screen: bool | None = None,
        hurries: bool = False,
    ) -> None:
        """`about` has the client's other values for the initialization of the server.

        By default there is a screen if the client can show a page: otherwise the server prints the page's URL. A server
        that `hurries` reads messages while it works, answers from what it knows, and checks folders in a process, as it
        does for people: how much it knows depends on how busy the machine is. Others do one thing after the other.
        """
        self._hurries = hurries
        self._answers = answers
        shows = capabilities.get("window", {}).get("showDocument", {}).get("support")
        self._input, self._output = self._start(bool(shows if screen is None else screen))
        self.code = 0
        """Exit code with which the server should end."""
        self.log: list[Spoken] = []
        self.notifications: list[Message] = []
        self.shown: list[str] = []
        self.replies: dict[str, Message] = {}
        """Unusual answers to requests of the server, by method: a result or an error, or none if it is empty."""
        self.presses: str | None = None
        """Button that the client presses in each message that has one with this title."""
        self.configuration = configuration
        self._unanswered: list[Message] = []
        self._writing = threading.Lock()
        self._inbox: queue.SimpleQueue[Message | None] = queue.SimpleQueue()
        self._next_id = 0
        threading.Thread(target=self._read, daemon=True).start()
        self.initialized = self.request(
            "initialize",
            {
                "processId": process,
                "rootUri": None,
                "workspaceFolders": [{"uri": folder.as_uri(), "name": folder.name} for folder in folders],
                "capabilities": capabilities,
                "initializationOptions": options,
                **(about or {}),
            },
        )
        self.notify("initialized", {})

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *failure: object) -> None:
        try:
            if failure[0] is None and self._runs:
                self.request("shutdown", None)
                self.notify("exit", None)
        finally:
            self._end(failure[0] is not None)

    def _start(self, screen: bool) -> tuple[IO[bytes], IO[bytes]]:
        """Start a server; return its input and its output."""
        from improv_ls.server import create_server

        source, ours = os.pipe()
        theirs, sink = os.pipe()
        self._environment = pytest.MonkeyPatch()
        for name in ("DISPLAY", "WAYLAND_DISPLAY"):
            self._environment.delenv(name, raising=False)
        if screen:
            self._environment.setenv("DISPLAY", ":0")
        self._environment.setattr(USED, StageOnThread)
        self._environment.setattr(framing, "converter", lambda: CONVERTER)
        for module in (progress, placing) if self._answers else ():
            self._environment.setattr(module, "ANSWER_LIMIT", LIMIT)
        if not self._hurries:
            self._environment.setattr(slices, "SLICE", LIMIT)
            self._environment.setattr(settling, "PATIENCE", LIMIT)
            self._environment.setattr(Answerer, "ask", lambda answerer, question: answerer.function(question))
        self._codes: list[int] = []

        def serve() -> None:
            # The source stays open: a thread that reads while the event loop is busy may look at it again.
            with os.fdopen(sink, "wb") as stream:
                self._codes.append(create_server().serve(source, stream))

        self._thread = threading.Thread(target=serve, daemon=True)
        self._thread.start()
        return os.fdopen(ours, "wb"), os.fdopen(theirs, "rb")

    @property
    def _runs(self) -> bool:
        return self._thread.is_alive()

    def _end(self, failed: bool) -> None:
        with self._writing, suppress(BrokenPipeError):
            self._input.close()
        self._thread.join(LIMIT)
        self._environment.undo()
        assert failed or self._codes == [self.code], "the server failed"

    def _last_words(self) -> str:
        return ""

    def send_bytes(self, sent: bytes) -> None:
        """Write bytes that may be no message."""
        with self._writing:
            self._input.write(sent)
            self._input.flush()

    def wait_for_end(self) -> None:
        """Wait until the server has ended."""
        self._thread.join(LIMIT)
        assert not self._runs

    def open(self, uri: str, text: str, language: str = "improv") -> None:
        document = {"uri": uri, "languageId": language, "version": 1, "text": text}
        self.notify("textDocument/didOpen", {"textDocument": document})

    def change(self, uri: str, version: int, *changes: Mapping[str, Any]) -> None:
        document = {"uri": uri, "version": version}
        self.notify("textDocument/didChange", {"textDocument": document, "contentChanges": changes})

    def save(self, uri: str, text: str | None = None) -> None:
        """Report a save, with the saved text if it isn't the one that the server has."""
        self.notify("textDocument/didSave", {"textDocument": {"uri": uri}, **({} if text is None else {"text": text})})

    def play(self, uri: str, text: str) -> str:
        """Open a program and save it; return the line about the dance."""
        self.open(uri, text)
        self.save(uri)
        return self.wait_for_line("▶")

    def command(self, name: str, *arguments: object) -> Any:
        """Have the server obey one of our commands."""
        return self.request("workspace/executeCommand", {"command": f"improv.{name}", "arguments": arguments})

    def set(self, **settings: object) -> None:
        """Report a change of settings."""
        self.notify("workspace/didChangeConfiguration", {"settings": {"improv": settings}})

    def actions(self, uri: str, line: int, character: int, **context: Any) -> list[Message]:
        """Return the code actions at a place."""
        asked = {"range": span(line, character, character), "context": {"diagnostics": [], **context}}
        found: list[Message] = self.request("textDocument/codeAction", {"textDocument": {"uri": uri}, **asked})
        return found

    def codes_of(self, file: Path) -> list[str]:
        """Return the codes of the next published diagnostics of a file."""
        sent = self.wait("textDocument/publishDiagnostics", lambda params: params["uri"] == file.as_uri())
        return [each["code"] for each in sent["diagnostics"]]

    def notify(self, method: str, params: Any) -> None:
        self._write({"method": method, "params": params})

    def request(self, method: str, params: Any) -> Any:
        """Send a request and return its result. Fails on an error."""
        answer = self._ask(method, params)
        assert "error" not in answer, answer
        return answer["result"]

    def refusal(self, method: str, params: Any) -> Any:
        """Send a request and return its error. Fails on a result."""
        answer = self._ask(method, params)
        assert "error" in answer, answer
        return answer["error"]

    def wait(self, method: str, fits: Callable[[Any], bool] = lambda params: True) -> Any:
        """Wait for the params of the next notification (or one that came already) that fits; skip those before it."""
        for place, message in enumerate(self.notifications):
            if message["method"] == method and fits(message.get("params")):
                del self.notifications[: place + 1]
                return message.get("params")
        self._wait_for(lambda message: message.get("method") == method and fits(message.get("params")), method)
        return self.notifications.pop().get("params")

    def wait_for_line(self, part: str) -> str:
        """Wait for the next line shown to the person that has `part` in it."""
        params = self.wait("window/showMessage", lambda params: part in params["message"])
        assert "\n" not in params["message"]
        return str(params["message"])

    def wait_for_page(self, pages: int = 1) -> list[str]:
        """Wait until the server has asked to show this many URLs, and return them."""
        while len(self.shown) < pages:
            self._wait_for(lambda message: message.get("method") == "window/showDocument", "page")
        return self.shown

    def begin(self, method: str, params: Any, cancelled: bool = False) -> int:
        """Send a request without waiting for the answer; return its ID. With `cancelled`, the cancellation follows at
        once."""
        self._next_id += 1
        note = {"method": "$/cancelRequest", "params": {"id": self._next_id}}
        self._write({"id": self._next_id, "method": method, "params": params}, *([note] if cancelled else []))
        return self._next_id

    def answer(self, number: int) -> Message:
        """Wait for the answer to a request that has been begun."""
        return self._wait_for(
            lambda message: message.get("id") == number and "method" not in message, f"answer to {number}"
        )

    def _ask(self, method: str, params: Any) -> Message:
        return self.answer(self.begin(method, params))

    def _wait_for(self, fits: Callable[[Message], bool], what: str) -> Message:
        end = time.monotonic() + LIMIT
        while True:
            try:
                message = self._inbox.get(timeout=max(end - time.monotonic(), 0))
            except queue.Empty:
                raise AssertionError(f"no {what} within {LIMIT} s; so far: {self.notifications}") from None
            if message is not None and message.get("method") == "error":
                raise AssertionError(message["params"])
            if message is None:
                raise AssertionError(f"the server ended before {what}: {self._last_words()}")
            if "method" in message:
                self.notifications.append(message)
            if fits(message):
                return message

    def answer_late(self, most: int | None = None) -> None:
        """Answer waiting requests: all, or this many, the latest first."""
        while self._unanswered and most != 0:
            self._answer(self._unanswered.pop())
            most = most and most - 1

    def _answer(self, request: Message) -> None:
        method = request["method"]
        if method == "window/showDocument":
            self.shown.append(request["params"]["uri"])
        if method in self.replies:
            if reply := self.replies[method]:
                self._write({"id": request["id"], **reply})
            return
        if method == "workspace/configuration":
            result: Any = [self.configuration for _ in request["params"]["items"]]
        elif method == "window/showDocument":
            result = {"success": True}
        elif method == "window/showMessageRequest":
            result = next((each for each in request["params"]["actions"] if each["title"] == self.presses), None)
        elif method == "workspace/applyEdit":
            result = {"applied": True}
        elif method in ("client/registerCapability", "window/workDoneProgress/create") or method.endswith("/refresh"):
            result = None
        else:
            self._inbox.put({"method": "error", "params": f"the client never said that it takes {method}"})
            return
        self._write({"id": request["id"], "result": result})

    def _write(self, *messages: Message) -> None:
        bodies = (json.dumps({"jsonrpc": "2.0", **message}).encode() for message in messages)
        with self._writing:
            self.log += (Spoken(False, message) for message in messages)
            if not self._input.closed:  # an answer that comes after the end
                self._input.write(b"".join(b"Content-Length: %d\r\n\r\n%s" % (len(body), body) for body in bodies))
                self._input.flush()

    def _read(self) -> None:
        stream = self._output
        while header := stream.readline():
            length = 0
            while header.strip():
                name, _, value = header.partition(b":")
                if name.lower() == b"content-length":
                    length = int(value)
                header = stream.readline()
            body, at = stream.read(length), time.perf_counter()
            message = json.loads(body)
            self.log.append(Spoken(True, message, at))
            if "method" in message and "id" in message:
                (self._answer if self._answers else self._unanswered.append)(message)
            self._inbox.put(message)
        self._inbox.put(None)


class ProcessClient(Client):
    """Starts `improv-ls` as editors do. `env` is its whole environment."""

    def __init__(
        self,
        options: Mapping[str, Any] | None = None,
        capabilities: Mapping[str, Any] = CAPABILITIES,
        env: Mapping[str, str] | None = None,
        process: int | None = None,
        command: Sequence[str] = (sys.executable, "-m", "improv_ls"),
    ) -> None:
        self._env, self._command = env, command
        super().__init__(options, capabilities, process=process)

    def _start(self, screen: bool) -> tuple[IO[bytes], IO[bytes]]:
        self.process = subprocess.Popen(
            self._command,
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            env={**({"DISPLAY": ":0"} if screen else {}), **os.environ} if self._env is None else self._env,
        )
        assert self.process.stdin
        assert self.process.stdout
        return self.process.stdin, self.process.stdout

    @property
    def _runs(self) -> bool:
        return self.process.poll() is None

    def _end(self, failed: bool) -> None:
        try:
            _, log = self.process.communicate(timeout=LIMIT)
        finally:
            self.process.kill()
        assert failed or (self.process.returncode, log) == (self.code, b""), log.decode()

    def _last_words(self) -> str:
        return self.process.stderr.read().decode() if self.process.stderr else ""
