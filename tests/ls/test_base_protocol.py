"""What the base protocol demands: error codes, exit codes, and an end where messages cannot be told apart."""

from __future__ import annotations

import json
import subprocess
import sys
from collections.abc import Mapping
from typing import Any

import pytest

from improv_core import __version__
from tests.ls.client import LIMIT, Client
from tests.processes import descendants, wait_until_gone

QUIET = {"backend": "sim", "page": {"open": False}}
URI = "file:///dance.improv"
INITIALIZE = {"id": 1, "method": "initialize", "params": {"processId": None, "rootUri": None, "capabilities": {}}}
PLACE = {"textDocument": {"uri": URI}, "position": {"line": 0, "character": 0}}
SHUTDOWN = {"id": 2, "method": "shutdown"}
EXIT = {"method": "exit"}
PARSE_ERROR, INVALID_REQUEST, METHOD_NOT_FOUND, INVALID_PARAMS, NOT_INITIALIZED = -32700, -32600, -32601, -32602, -32002


def framed(message: bytes | dict[str, Any]) -> bytes:
    body = message if isinstance(message, bytes) else json.dumps({"jsonrpc": "2.0", **message}).encode()
    return b"Content-Length: %d\r\n\r\n%s" % (len(body), body)


def run(*arguments: str, sent: bytes = b"") -> subprocess.CompletedProcess[bytes]:
    """A server that gets these bytes, and then the end of its input."""
    command = [sys.executable, "-m", "improv_ls", *arguments]
    return subprocess.run(command, input=sent, capture_output=True, timeout=LIMIT, check=False)


def told(output: bytes) -> list[dict[str, Any]]:
    """The messages in what a server has written."""
    found = []
    while output:
        header, _, output = output.partition(b"\r\n\r\n")
        length = int(header.partition(b"Content-Length: ")[2].split()[0])
        found.append(json.loads(output[:length]))
        output = output[length:]
    return found


def check(*messages: bytes | dict[str, Any], answers: Mapping[Any, int | None], code: int) -> None:
    """The error code of each answer, by the request's id, and the server's exit code. Nothing else is said."""
    assert dict(answered(*messages, code=code)) == answers


def answered(*messages: bytes | dict[str, Any], code: int) -> list[tuple[Any, int | None]]:
    """The id and the error code of each answer of a server that exits with this code."""
    ended = run(sent=b"".join(map(framed, messages)))
    assert (ended.returncode, ended.stderr) == (code, b"")
    return [(each["id"], each.get("error", {}).get("code")) for each in told(ended.stdout)]


def test_exit_tells_whether_the_editor_has_asked_for_shutdown() -> None:
    check(INITIALIZE, SHUTDOWN, EXIT, answers={1: None, 2: None}, code=0)
    check(INITIALIZE, EXIT, answers={1: None}, code=1)
    check(INITIALIZE, answers={1: None}, code=1)
    check(EXIT, answers={}, code=1)


def test_exit_without_shutdown_stops_the_robots() -> None:
    with Client(QUIET) as client:
        client.open(URI, "r $ repeat left\n")
        client.save(URI)
        client.wait_for_line("▶")
        stages = descendants(client.process.pid)
        assert stages
        client.notify("exit", None)
        assert client.process.wait(LIMIT) == 1
        wait_until_gone(stages, LIMIT)


def test_before_initialize_nothing_else_is_answered() -> None:
    hover = {"id": 7, "method": "textDocument/hover", "params": PLACE}
    opened = {"uri": URI, "languageId": "improv", "version": 1, "text": "r $ lft\n"}
    early = {"method": "textDocument/didOpen", "params": {"textDocument": opened}}
    check(hover, early, EXIT, answers={7: NOT_INITIALIZED}, code=1)
    check(SHUTDOWN, INITIALIZE, EXIT, answers={2: NOT_INITIALIZED, 1: None}, code=1)


def test_after_shutdown_nothing_else_is_answered() -> None:
    late = {"id": 7, "method": "textDocument/hover", "params": PLACE}
    answers = {1: None, 2: None, 7: INVALID_REQUEST}
    check(INITIALIZE, SHUTDOWN, late, EXIT, answers=answers, code=0)
    check(INITIALIZE, {**INITIALIZE, "id": 3}, EXIT, answers={1: None, 3: INVALID_REQUEST}, code=1)


def test_a_wrong_request_is_refused() -> None:
    wrong: list[tuple[dict[str, Any], int]] = [
        ({"method": "textDocument/hover"}, INVALID_PARAMS),
        ({"method": "textDocument/hover", "params": None}, INVALID_PARAMS),
        ({"method": "textDocument/hover", "params": [1]}, INVALID_PARAMS),
        ({"method": "textDocument/hover", "params": {**PLACE, "position": {"line": "one"}}}, INVALID_PARAMS),
        ({"method": "improv/moments"}, INVALID_PARAMS),
        ({"method": "workspace/executeCommand", "params": {"command": "improv.dance"}}, INVALID_PARAMS),
        ({"method": "textDocument/teleport"}, METHOD_NOT_FOUND),
        ({"method": 7}, INVALID_REQUEST),
        ({"jsonrpc": "1.0", "method": "textDocument/hover", "params": PLACE}, INVALID_REQUEST),
    ]
    requests = [{"id": 7 + number, **request} for number, (request, _) in enumerate(wrong)]
    codes = {7 + number: code for number, (_, code) in enumerate(wrong)}
    check(INITIALIZE, *requests, SHUTDOWN, EXIT, answers={1: None, **codes, 2: None}, code=0)


def test_what_is_no_message_is_answered_without_an_id() -> None:
    unreadable = [b"{", b"", b"\xff", b"[" * 100_000]
    invalid = [b"[]", b"7", b"{}"]
    codes = [(None, PARSE_ERROR)] * len(unreadable) + [(None, INVALID_REQUEST)] * len(invalid)
    assert answered(INITIALIZE, *unreadable, *invalid, SHUTDOWN, EXIT, code=0) == [(1, None), *codes, (2, None)]


def test_a_wrong_notification_or_answer_is_passed_over() -> None:
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


HEADERS = [
    b"Content-Length: %s\r\n\r\n{}" % (b"9" * 5_000),
    b"Content-Length: -2\r\n\r\n{}",
    b"Content-Length: 0x2\r\n\r\n{}",
    b"no header at all\r\n\r\n",
    b"x" * 100_000,
    b"Content-Length: 1\r\n\r\n" + framed(EXIT).partition(b"\r\n\r\n")[2] + framed(EXIT),
]


@pytest.mark.parametrize("header", HEADERS, ids=range(len(HEADERS)))
def test_a_stream_that_cannot_be_read_ends_the_server(header: bytes) -> None:
    ended = run(sent=framed(INITIALIZE) + header)
    (line,) = ended.stderr.decode().splitlines()
    assert (ended.returncode, line.startswith("improv-ls: ")) == (1, True)


def test_a_stream_that_cannot_be_read_stops_the_robots() -> None:
    with Client(QUIET) as client:
        client.open(URI, "r $ repeat left\n")
        client.save(URI)
        client.wait_for_line("▶")
        stages = descendants(client.process.pid)
        assert stages
        assert client.process.stdin
        assert client.process.stderr
        client.process.stdin.write(HEADERS[0])
        client.process.stdin.flush()
        assert client.process.wait(LIMIT) == 1
        wait_until_gone(stages, LIMIT)
        (line,) = client.process.stderr.read().decode().splitlines()
        assert line.startswith("improv-ls: ")


def test_the_command_line() -> None:
    assert run("--version").stdout.decode() == f"improv-ls, version {__version__}\n"
    helped = run("--help")
    assert (helped.returncode, helped.stderr) == (0, b"")
    assert helped.stdout.startswith(b"Usage: improv-ls")
    served = run("--stdio", sent=framed(INITIALIZE) + framed(SHUTDOWN) + framed(EXIT))
    assert (served.returncode, len(told(served.stdout))) == (0, 2)
    for arguments in (["--tcp"], ["--stdio", "dance.improv"], ["--stdio", "--port=7"]):
        wrong = run(*arguments)
        assert (wrong.returncode, wrong.stdout) == (2, b"")
        assert wrong.stderr.decode() == f"improv-ls: unknown argument {arguments[-1]!r}; see improv-ls --help\n"
