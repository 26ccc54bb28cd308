"""Rules of the base protocol: error codes, exit codes, and an end once messages can't be told apart."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
from collections.abc import Callable, Mapping
from concurrent.futures import ThreadPoolExecutor
from contextlib import suppress
from io import BytesIO
from typing import Any

import pytest

from improv_core import __version__
from improv_ls.__main__ import main
from improv_ls.server import create_server
from tests.ls.client import LIMIT, QUIET, Client, place
from tests.processes import wait_until_full
from tests.stage_on_thread import running

URI = "file:///dance.improv"
INITIALIZE = {"id": 1, "method": "initialize", "params": {"processId": None, "rootUri": None, "capabilities": {}}}
PLACE = place(URI, 0, 0)
SHUTDOWN = {"id": 2, "method": "shutdown"}
EXIT = {"method": "exit"}
PARSE_ERROR, INVALID_REQUEST, METHOD_NOT_FOUND, INVALID_PARAMS, NOT_INITIALIZED = -32700, -32600, -32601, -32602, -32002


def framed(message: bytes | dict[str, Any]) -> bytes:
    body = message if isinstance(message, bytes) else json.dumps({"jsonrpc": "2.0", **message}).encode()
    return b"Content-Length: %d\r\n\r\n%s" % (len(body), body)


def told(output: bytes) -> list[dict[str, Any]]:
    """Return the messages in a server's output."""
    found = []
    while output:
        header, _, output = output.partition(b"\r\n\r\n")
        length = int(header.partition(b"Content-Length: ")[2].split()[0])
        found.append(json.loads(output[:length]))
        output = output[length:]
    return found


def check(*messages: bytes | dict[str, Any], answers: Mapping[Any, int | None], code: int) -> None:
    """Compare the error code of each answer, by the request's ID, and the server's exit code. There are no other
    messages."""
    assert dict(answered(*messages, code=code)) == answers


def answered(*messages: bytes | dict[str, Any], code: int) -> list[tuple[Any, int | None]]:
    """Return the ID and the error code of each answer of a server that exits with this code, run in this process."""
    output = served(b"".join(map(framed, messages)), code)
    return [(each["id"], each.get("error", {}).get("code")) for each in told(output)]


def served(sent: bytes, code: int) -> bytes:
    """Return the output of a server that gets these bytes, and then the end of its input."""
    source, ours = os.pipe()
    output = BytesIO()

    def send() -> None:  # on a thread, as a pipe may not hold all of it
        with os.fdopen(ours, "wb") as pipe, suppress(BrokenPipeError):
            pipe.write(sent)

    with ThreadPoolExecutor() as another:
        another.submit(send)
        assert create_server().serve(source, output) == code
        os.close(source)  # the server doesn't read the rest
    return output.getvalue()


def test_the_exit_code_is_0_only_after_shutdown() -> None:
    check(INITIALIZE, SHUTDOWN, EXIT, answers={1: None, 2: None}, code=0)
    check(INITIALIZE, EXIT, answers={1: None}, code=1)
    check(INITIALIZE, answers={1: None}, code=1)
    check(EXIT, answers={}, code=1)


def test_exit_without_shutdown_stops_the_robots() -> None:
    ends_and_stops_the_robots(lambda client: client.notify("exit", None))


def ends_and_stops_the_robots(end: Callable[[Client], None]) -> None:
    """Start a server that makes robots dance, and end it."""
    others = running()
    with Client(QUIET) as client:
        client.play(URI, "r $ repeat left\n")
        assert running() - others
        end(client)
        client.code = 1
        client.wait_for_end()
        assert not running() - others


def test_nothing_else_is_answered_before_initialize() -> None:
    hover = {"id": 7, "method": "textDocument/hover", "params": PLACE}
    opened = {"uri": URI, "languageId": "improv", "version": 1, "text": "r $ lft\n"}
    early = {"method": "textDocument/didOpen", "params": {"textDocument": opened}}
    check(hover, early, EXIT, answers={7: NOT_INITIALIZED}, code=1)
    check(SHUTDOWN, INITIALIZE, EXIT, answers={2: NOT_INITIALIZED, 1: None}, code=1)


def test_nothing_else_is_answered_after_shutdown() -> None:
    late = {"id": 7, "method": "textDocument/hover", "params": PLACE}
    answers = {1: None, 2: None, 7: INVALID_REQUEST}
    check(INITIALIZE, SHUTDOWN, late, EXIT, answers=answers, code=0)
    check(INITIALIZE, {**INITIALIZE, "id": 3}, EXIT, answers={1: None, 3: INVALID_REQUEST}, code=1)


def test_a_bad_request_is_refused() -> None:
    wrong: list[tuple[dict[str, Any], int]] = [
        ({"method": "textDocument/hover"}, INVALID_PARAMS),
        ({"method": "textDocument/hover", "params": None}, INVALID_PARAMS),
        ({"method": "textDocument/hover", "params": [1]}, INVALID_PARAMS),
        ({"method": "textDocument/hover", "params": {**PLACE, "position": {"line": "one"}}}, INVALID_PARAMS),
        ({"method": "workspace/executeCommand", "params": {"command": "improv.dance"}}, INVALID_PARAMS),
        ({"method": "textDocument/teleport"}, METHOD_NOT_FOUND),
        ({"method": 7}, INVALID_REQUEST),
        ({"jsonrpc": "1.0", "method": "textDocument/hover", "params": PLACE}, INVALID_REQUEST),
    ]
    requests = [{"id": 7 + number, **request} for number, (request, _) in enumerate(wrong)]
    codes = {7 + number: code for number, (_, code) in enumerate(wrong)}
    check(INITIALIZE, *requests, SHUTDOWN, EXIT, answers={1: None, **codes, 2: None}, code=0)


def test_input_that_is_not_a_message_is_answered_without_an_id() -> None:
    unreadable = [b"{", b"", b"\xff", b"[" * 100_000]
    invalid = [b"[]", b"7", b"{}"]
    codes = [(None, PARSE_ERROR)] * len(unreadable) + [(None, INVALID_REQUEST)] * len(invalid)
    assert answered(INITIALIZE, *unreadable, *invalid, SHUTDOWN, EXIT, code=0) == [(1, None), *codes, (2, None)]


def test_a_bad_notification_or_answer_is_ignored() -> None:
    wrong: list[dict[str, Any]] = [
        {"method": "textDocument/didOpen"},
        {"method": "textDocument/didSave", "params": {"textDocument": 7}},
        {"method": "$/cancelRequest", "params": None},
        {"method": "workspace/teleported"},
        {"id": 9, "result": None},
        {"id": 9, "error": {"code": -32600, "message": "no"}},
        {"id": [9], "result": None},
    ]
    check(INITIALIZE, *wrong, SHUTDOWN, EXIT, answers={1: None, 2: None}, code=0)


UNREADABLE = b"no header at all\r\n\r\n"
"""test_arrivals.py has others."""


def test_an_unreadable_stream_ends_the_server(capsys: pytest.CaptureFixture[str]) -> None:
    assert told(served(framed(INITIALIZE) + UNREADABLE, code=1))[0]["id"] == 1
    assert capsys.readouterr().err.startswith("improv-ls: cannot read the editor's messages: ")


def test_an_unreadable_stream_stops_the_robots() -> None:
    ends_and_stops_the_robots(lambda client: client.send_bytes(UNREADABLE))


def test_a_message_arrives_whole_if_the_server_is_halted_while_writing_it() -> None:
    """Otherwise, Python's unbuffered output writes only part of it."""
    program = {"uri": URI, "languageId": "improv", "version": 1, "text": "r $ forwrd\n" * 1000}
    opened = {"method": "textDocument/didOpen", "params": {"textDocument": program}}
    command, env = [sys.executable, "-m", "improv_ls"], {**os.environ, "PYTHONUNBUFFERED": "1"}
    with subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, env=env) as server:
        assert server.stdin
        server.stdin.write(framed(INITIALIZE) + framed(opened))
        server.stdin.flush()
        wait_until_full(server.pid, LIMIT)
        server.send_signal(signal.SIGSTOP)
        os.waitid(os.P_PID, server.pid, os.WSTOPPED)
        server.send_signal(signal.SIGCONT)
        output, _ = server.communicate(framed(SHUTDOWN) + framed(EXIT), timeout=LIMIT)
    assert [each["id"] for each in told(output) if "result" in each] == [1, 2]


def test_unknown_arguments_are_reported(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    def answer(*arguments: str) -> tuple[object, str, str]:
        monkeypatch.setattr(sys, "argv", ["improv-ls", *arguments])
        with pytest.raises(SystemExit) as ended:
            main()
        return ended.value.code, *capsys.readouterr()

    assert answer("--version") == (0, f"improv-ls, version {__version__}\n", "")
    code, helped, _ = answer("--help")
    assert (code, helped.partition(" [")[0]) == (0, "Usage: improv-ls")
    for arguments in (["--tcp"], ["--stdio", "dance.improv"], ["--stdio", "--port=7"]):
        problem = f"improv-ls: unknown argument {arguments[-1]!r}; see improv-ls --help\n"
        assert answer(*arguments) == (2, "", problem)
    command = [sys.executable, "-m", "improv_ls", "--stdio"]
    process = subprocess.run(command, input=framed(INITIALIZE) + UNREADABLE, capture_output=True, timeout=LIMIT)
    assert (process.returncode, len(told(process.stdout)), process.stderr.count(b"\n")) == (1, 1, 1)
