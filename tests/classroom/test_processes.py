"""A class in its processes: floods of children and strangers, and processes that end."""

from __future__ import annotations

import asyncio
import os
import re
import signal
import socket
import sys
import threading
import urllib.request
from collections.abc import Iterator
from pathlib import Path

import aiohttp
import pytest

from improv_core.classroom.children import Children, ChildrenError
from improv_core.ipc.stage_process import Stage
from improv_core.page.connections import MAX_PER_ADDRESS
from improv_core.session.state import HERE, StageKey
from tests.classroom.conftest import Running
from tests.classroom.test_class import WORST, a_class, make_site

LIMIT = 60.0
SOON = 3.0
"""Seconds, with room for a busy machine: a stop took more than 30 s here."""
CHILDREN = 40


async def send_forever(address: str, code: str, sent: threading.Event) -> None:
    """Act as all children, and send the worst dance without a pause."""
    own = {"Origin": address.rstrip("/")}

    async def child(http: aiohttp.ClientSession, number: int) -> None:
        async with http.post(f"{address}class/join", json={"code": code, "name": "Ada"}, headers=own) as answer:
            bearer = {**own, "Authorization": f"Bearer {(await answer.json())['secret']}"}
        while True:
            async with http.post(f"{address}class/send", data=WORST, headers=bearer) as answer:
                if answer.status == 200 and number == CHILDREN - 1:
                    sent.set()

    try:
        async with aiohttp.ClientSession(connector=aiohttp.TCPConnector(limit=0)) as http:
            await asyncio.gather(*(child(http, number) for number in range(CHILDREN)))
    except aiohttp.ClientError:
        pass  # the class is over


@pytest.mark.slow("starts a class with its stage, and floods it")
def test_forty_children_who_send_the_worst_text_delay_neither_a_stop_nor_the_end(running: Running) -> None:
    process, address, code, teacher = running
    sent = threading.Event()
    flood = threading.Thread(target=lambda: asyncio.run(send_forever(address, code, sent)))
    flood.start()
    assert sent.wait(LIMIT)
    base = teacher.partition("/?")[0]
    with urllib.request.urlopen(teacher, timeout=SOON) as page:
        text = page.read().decode()
    token = re.search(r'name="improv-token" content="(.+?)"', text)
    assert token
    for _ in range(5):
        stop = urllib.request.Request(f"{base}/stop?token={token[1]}", b"", {"Origin": base})
        with urllib.request.urlopen(stop, timeout=SOON) as answer:
            assert answer.status == 204
    process.send_signal(signal.SIGINT)
    assert process.wait(SOON) == 130
    flood.join()


@pytest.fixture
def children(tmp_path: Path) -> Iterator[Children]:
    make_site(tmp_path)
    (tmp_path / "large.wasm").write_bytes(os.urandom(8_000_000))
    children = Children(tmp_path, tmp_path / "dances", "127.0.0.1", 0)
    yield children
    children.close()


def pid_of(children: Children) -> int:
    child = children._helper._child
    assert child
    return child.pid


def used(pid: int) -> int:
    """The memory of a process in bytes."""
    found = re.search(r"VmRSS:\s+(\d+) kB", Path(f"/proc/{pid}/status").read_text())
    assert found
    return int(found[1]) * 1024


@pytest.mark.slow("opens hundreds of connections")
@pytest.mark.skipif(sys.platform != "linux", reason="reads /proc")
def test_strangers_who_read_nothing_of_a_large_file_fill_no_memory_and_shut_nobody_out(children: Children) -> None:
    before = used(pid_of(children))
    host = children.address.removeprefix("http://").rstrip("/")
    name, port = host.split(":")
    silent = []
    for _ in range(MAX_PER_ADDRESS + 50):
        connection = socket.create_connection((name, int(port)))
        connection.sendall(f"GET /large.wasm HTTP/1.1\r\nHost: {host}\r\n\r\n".encode())
        silent.append(connection)
    with urllib.request.urlopen(f"{children.address}large.wasm", timeout=LIMIT) as answer:
        assert len(answer.read()) == 8_000_000
    assert used(pid_of(children)) - before < 300_000_000  # rather than 8 MB for each
    for each in silent:
        each.close()


def test_an_address_that_is_in_use_is_one_line(tmp_path: Path) -> None:
    make_site(tmp_path)
    with socket.create_server(("127.0.0.1", 0)) as taken, pytest.raises(ChildrenError, match="can't be used: Address"):
        Children(tmp_path, tmp_path / "dances", "127.0.0.1", taken.getsockname()[1])


@pytest.mark.slow("a stage starts twice")
async def test_a_class_continues_when_its_stage_ends() -> None:
    async with a_class() as pages:
        performing = pages.held._performing
        await pages.send(await pages.join("Ada"), "r $ repeat forward")
        await pages.hear_ok()
        stage = performing.playback._stages[StageKey(HERE, "simulator")]
        assert isinstance(stage, Stage)
        stage._child.kill()
        async with asyncio.timeout(LIMIT):
            await performing.broken.wait()
        await pages.live.send_json({"type": "play", "numbers": [1]})
        await pages.hear(lambda message: message == {"type": "playing", "line": "Ada"})


def test_the_end_of_the_childrens_process_is_reported(children: Children) -> None:
    why: list[str] = []
    ended = threading.Event()

    def note(line: str) -> None:
        why.append(line)
        ended.set()

    children.listen(lambda news: None, note)
    os.kill(pid_of(children), signal.SIGKILL)
    assert ended.wait(LIMIT)
    assert why == ["the children's server has ended: it was killed"]
