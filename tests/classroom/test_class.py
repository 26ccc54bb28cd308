"""A class as children and teacher use it: over HTTP, with a stage that plays."""

from __future__ import annotations

import asyncio
import errno
import json
import logging
import os
import re
import signal
import socket
import subprocess
import sys
import threading
import urllib.request
from collections.abc import AsyncIterator, Callable, Collection, Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import asynccontextmanager, suppress
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import aiohttp
import pytest

from improv_core.classroom import roster
from improv_core.classroom.checker import HEAVY, LONG, DanceReader, embody, look, prepare
from improv_core.classroom.children import ChildrenError, check_site
from improv_core.classroom.kept import Folder
from improv_core.classroom.messages import DanceRead, FromChildren, read
from improv_core.classroom.roster import LONGEST_DANCE, new_code
from improv_core.classroom.student_server import File, StudentServer, files_of
from improv_core.classroom.turns import Turns, next_child
from improv_core.commands.class_room import Class
from improv_core.commands.terminal import performance
from improv_core.session.start import Options
from improv_core.website.build import HEAD, MARK
from tests.commands.command_line import run
from tests.processes import ours
from tests.stage_on_thread import USED, StageOnThread

LIMIT = 60.0
WORST = "\x01\n" * 49_999
FILES = {"/": File(b"<html>", None, "text/html"), "/large": File(bytes(8_000_000), None, "application/zip")}


class ChildrenOnThread:
    """The children's server on a thread, on which it starts quickly. test_processes.py tests its process."""

    def __init__(self, folder: Path) -> None:
        self.code, self._folder = new_code(), folder
        self._listening = socket.create_server(("127.0.0.1", 0))
        self.address = "http://{}:{}/".format(*self._listening.getsockname())
        self._serves = threading.Event()
        self._thread = threading.Thread(target=self._run)

    def listen(self, hear: Callable[[FromChildren], None], ended: Callable[[str], None]) -> None:
        folder = self._kept = Folder(self._folder)
        self._server = StudentServer(self._listening, FILES, self.code, folder, hear)
        self.code = self._server.code
        self._thread.start()
        assert self._serves.wait(LIMIT)

    def remove(self, numbers: Collection[int]) -> None:
        self._loop.call_soon_threadsafe(self._server.remove, [*numbers])

    def close(self) -> None:
        self._loop.call_soon_threadsafe(self._serving.cancel)
        self._thread.join()
        self._listening.close()
        if self._kept._lock is not None:
            os.close(self._kept._lock)  # as the end of its process does

    def _run(self) -> None:
        with suppress(asyncio.CancelledError):
            asyncio.run(self._serve())

    async def _serve(self) -> None:
        self._loop = asyncio.get_running_loop()
        self._serving = asyncio.ensure_future(self._server.serve())
        self._serves.set()
        await self._serving


class Pages:
    """A class and the requests of its pages."""

    def __init__(
        self, held: Class, http: aiohttp.ClientSession, live: aiohttp.ClientWebSocketResponse, base: str
    ) -> None:
        self.held, self._http, self.live, self._base = held, http, live, base
        self.token = ""
        self.address = held.children.address

    async def post(self, what: str, body: str | bytes, **headers: str) -> tuple[int, dict[str, str]]:
        headers = {"Origin": self.address.rstrip("/"), **headers}
        async with self._http.post(f"{self.address}class/{what}", data=body, headers=headers) as answer:
            return answer.status, json.loads(await answer.text()) if answer.content_type == "application/json" else {}

    async def join(self, name: str, **headers: str) -> str:
        status, answer = await self.post("join", json.dumps({"code": self.held.children.code, "name": name}), **headers)
        assert status == 200, answer
        return answer["secret"]

    async def send(self, secret: str, text: str | bytes, **headers: str) -> tuple[int, dict[str, str]]:
        return await self.post("send", text, Authorization=f"Bearer {secret}", **headers)

    async def dance(self, number: int, count: int) -> tuple[int, bytes]:
        """Request a child's dance as the teacher's page does."""
        about = {"token": self.token}
        async with self._http.get(f"{self._base}/dance/{number}/{count}", params=about) as answer:
            return answer.status, await answer.read()

    async def hear_dance(self, is_it: Callable[[Any], bool]) -> Any:
        """Wait for the next news of a child whose latest dance is such a one, and return them."""
        return await self.hear(
            lambda message: message["type"] == "child" and message["latest"] and is_it(message["latest"])
        )

    async def hear_ok(self) -> Any:
        """Wait until a dance was read that can be played."""
        return await self.hear_dance(lambda latest: latest["ok"])

    async def hear(self, is_it: Callable[[Any], bool]) -> Any:
        """Wait for the next message of this kind to the teacher's page."""
        async with asyncio.timeout(LIMIT):
            while True:
                message = await self.live.receive_json()
                if is_it(message):
                    return message

    async def stop(self, token: str, origin: str | None = None) -> int:
        headers = {"Origin": origin or self._base}
        async with self._http.post(f"{self._base}/stop", params={"token": token}, headers=headers) as answer:
            return answer.status


@pytest.fixture(autouse=True)
def stage_on_thread(monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture) -> Iterator[None]:
    """Run the stage on a thread. test_pages.py starts the command with its processes. No test may leave a traceback in
    the terminal."""
    monkeypatch.setattr(USED, StageOnThread)
    yield
    assert not [each for each in caplog.get_records("call") if each.levelno >= logging.ERROR]


@asynccontextmanager
async def a_class(folder: Path | None = None) -> AsyncIterator[Pages]:
    with TemporaryDirectory() as new:
        async with _a_class(folder or Path(new, "dances")) as pages:
            yield pages


@asynccontextmanager
async def _a_class(folder: Path) -> AsyncIterator[Pages]:
    async with performance(Options(backend="sim"), browser=False, quiet=True, hears_keys=False) as performing:
        held = Class(performing, ChildrenOnThread(folder))  # type: ignore[arg-type]
        teaching = asyncio.create_task(held.teach())
        try:
            async with aiohttp.ClientSession() as http:
                link = held.teacher.link()
                base = link.partition("/?")[0]
                async with asyncio.timeout(LIMIT):
                    while True:  # until it accepts connections
                        try:
                            async with http.get(link) as answer:
                                page = await answer.text()
                                break
                        except aiohttp.ClientConnectionError:
                            await asyncio.sleep(0)
                found = re.search(r'name="improv-token" content="(.+?)"', page)
                assert found
                async with http.get(link) as answer:  # a ticket opens the page once
                    assert found[1] not in await answer.text()
                live = await http.ws_connect(f"{base}/live", params={"token": found[1]}, headers={"Origin": base})
                pages = Pages(held, http, live, base)
                pages.token = found[1]
                yield pages
        finally:
            performing.interrupted.set()
            await teaching


async def test_a_dance_is_sent_looked_at_played_and_stopped() -> None:
    async with a_class() as pages:
        secret = await pages.join("Ada <b>")
        shown = await pages.hear(lambda message: message["type"] == "child")
        assert (shown["name"], shown["here"], shown["latest"]) == ("Ada <b>", True, None)
        assert (await pages.send(secret, "r $ repeat (forward left)\n"))[0] == 200
        shown = await pages.hear_ok()
        assert shown["latest"]["picture"].startswith("<svg")
        await pages.live.send_json({"type": "play", "numbers": [shown["number"]]})
        await pages.hear(lambda message: message == {"type": "playing", "line": "Ada <b>"})
        playback = pages.held.desk._playback
        assert playback.state.is_on
        before = playback.stops.stopped
        assert await pages.stop("wrong") == 403
        assert await pages.stop(pages.token, "http://evil.example") == 403
        assert playback.stops.stopped == before
        assert await pages.stop(pages.token) == 204
        assert playback.stops.stopped == before + 1
        await pages.hear(lambda message: message == {"type": "playing", "line": "Stopped"})


async def test_a_stop_works_while_the_event_loop_is_busy() -> None:
    async with a_class() as pages:
        stops = pages.held._performing.stops
        asked = urllib.request.Request(f"{pages._base}/stop?token={pages.token}", b"", {"Origin": pages._base})
        pressing = threading.Thread(target=lambda: urllib.request.urlopen(asked, timeout=LIMIT).close())
        before = stops.stopped
        pressing.start()
        pressing.join(LIMIT)  # nothing else runs on the event loop
        assert stops.stopped == before + 1


async def test_a_command_from_before_a_stop_that_is_obeyed_after_it_plays_nothing() -> None:
    async with a_class() as pages:
        await pages.send(await pages.join("Ada"), "r $ forward")
        await pages.hear_ok()
        asked = pages.held._performing.stops.count
        await pages.stop(pages.token)
        pages.held.desk.take({"type": "play", "numbers": [1]}, asked)
        await pages.hear(lambda message: message == {"type": "playing", "line": "Stopped before it began"})


async def test_several_play_together_and_a_wrong_one_is_shown() -> None:
    async with a_class() as pages:
        for name, text in (("Ada", "r $ forward"), ("Bo", "beat 30\nr $ left"), ("Cy", "r $ forwrd")):
            await pages.send(await pages.join(name), text)
        done: dict[str, Any] = {}
        while len(done) < 3:
            shown = await pages.hear_dance(lambda latest: latest["ok"] is not None)
            done[shown["name"]] = shown
        assert done["Cy"]["latest"]["line"].startswith("line 1: ")
        await pages.live.send_json({"type": "play", "numbers": [each["number"] for each in done.values()]})
        playing = await pages.hear(lambda message: message.get("line", "").startswith("Ada + Bo"))
        assert "without Cy: no dance that plays" in playing["line"]
        assert "Bo keeps its speed" in playing["line"]
        played = pages.held.desk._playback.state.played
        assert played
        assert [*played.score.parts] == ["Ada", "Bo"]
        shown_program: Any = pages.held.desk._playback.state.kept["program"]
        assert shown_program["names"] == {"Ada": "Ada", "Bo": "Bo"}
        await pages.live.send_json({"type": "remove", "numbers": [done["Cy"]["number"], done["Bo"]["number"]]})
        for name in ("Cy", "Bo"):
            gone = {"type": "gone", "number": done[name]["number"]}
            await pages.hear(gone.__eq__)


async def test_the_teachers_line_shows_whether_dances_play_or_have_ended() -> None:
    async with a_class() as pages:
        for name, text in (("Ada", "r $ repeat forward"), ("Bo", "r $ fast 8 forward")):
            await pages.send(await pages.join(name), text)
            await pages.hear_ok()
        playback = pages.held.desk._playback
        playing: dict[str, Any] = {"type": "play", "numbers": [1]}
        await pages.live.send_json(playing)
        await pages.hear({"type": "playing", "line": "Ada"}.__eq__)
        stops = playback.stops  # as by `improv stop`, or on the page of the stage
        asks: list[tuple[Callable[[], None], str]] = [
            (lambda: stops.stop({"type": "pause"}), "Ada: paused"),
            (lambda: playback.ask({"type": "resume"}, stops.count), "Ada"),
            (stops.stop, "Stopped"),
            (lambda: playback.ask({"type": "restart"}, stops.count), "Ada"),
        ]
        for ask, line in asks:
            ask()
            await pages.hear({"type": "playing", "line": line}.__eq__)
        await pages.live.send_json({**playing, "numbers": [2]})
        for line in ("Reading Bo", "Bo", "Bo: ended"):
            assert (await pages.hear(lambda message: message["type"] == "playing"))["line"] == line


async def test_the_terminal_names_robots_that_bump_as_the_teacher_knows_them(monkeypatch: pytest.MonkeyPatch) -> None:
    async with a_class() as pages:
        said: asyncio.Queue[str] = asyncio.Queue()
        monkeypatch.setattr(pages.held._performing.screen, "complain", said.put_nowait)
        for name, text in (("ly", "r $ rest"), ("علی", "r s $ forward\nr at 0 0\ns at 0.6 0 facing 180")):
            await pages.send(await pages.join(name), text)
            await pages.hear_ok()
        await pages.live.send_json({"type": "play", "numbers": [1, 2]})
        async with asyncio.timeout(LIMIT):
            assert (await said.get()).startswith("improv: علی: r bumped into علی: s: start them farther apart")


@pytest.mark.parametrize(
    ("what", "body", "headers", "status"),
    [
        ("join", {"code": "WRONG1", "name": "Eve"}, {}, 403),
        ("join", {"code": "WRONG1"}, {}, 400),
        ("join", ["WRONG1"], {}, 400),
        ("join", {"code": "\ud800", "name": "Eve"}, {}, 400),
        ("join", {"code": "x" * 2_000, "name": "Eve"}, {}, 413),
        ("join", {"code": "WRONG1", "name": "Eve"}, {"Content-Encoding": "gzip"}, 415),
        ("send", "r $ left", {"Authorization": "Bearer guessed"}, 403),
        ("send", "", {"Origin": "http://evil.example"}, 403),
        ("send", "", {"Host": "evil.example"}, 403),
        ("stop", {}, {}, 404),
    ],
)
async def test_forbidden_requests_of_children_are_refused(
    what: str, body: Any, headers: dict[str, str], status: int
) -> None:
    async with a_class() as pages:
        assert (await pages.post(what, body if what == "send" else json.dumps(body), **headers))[0] == status


@pytest.mark.parametrize(
    ("text", "headers", "status"),
    [
        ("x" * 800_000, {}, 413),
        ("x" * (LONGEST_DANCE + 1), {}, 413),
        (b"\xff", {}, 400),
        ("r $ left", {"Content-Encoding": "deflate"}, 415),
    ],
)
async def test_a_dance_that_is_not_text_or_too_long_is_refused(
    text: str | bytes, headers: dict[str, str], status: int
) -> None:
    async with a_class() as pages:
        assert (await pages.send(await pages.join("Ada"), text, **headers))[0] == status


async def test_the_dance_of_a_stranger_is_refused_before_any_of_it_is_read() -> None:
    async with a_class() as pages:
        host = pages.address.removeprefix("http://").rstrip("/")
        reader, writer = await asyncio.open_connection(*host.split(":"))
        asked = f"POST /class/send HTTP/1.1\r\nHost: {host}\r\nOrigin: http://{host}\r\nContent-Length: 400000\r\n\r\n"
        writer.write(asked.encode())
        async with asyncio.timeout(LIMIT):
            assert await reader.readline() == b"HTTP/1.1 403 Forbidden\r\n"
        writer.close()


@pytest.mark.parametrize(
    "lines",
    [
        "GET / HTTP/1.1\r\nA: " + "x" * 20_000,
        "POST /stop HTTP/1.1\r\nTransfer-Encoding: chunked\r\n\r\nzz",
        "POST /stop HTTP/1.1\r\nContent-Length: 1x",
        "POST /dance HTTP/1.1\r\nHost: localhost\r\nContent-Encoding: gzip\r\nContent-Length: 4\r\n\r\nnone",
    ],
)
async def test_a_malformed_request_leaves_no_traceback_in_the_terminal(lines: str) -> None:
    async with a_class() as pages:
        reader, writer = await asyncio.open_connection(*pages.address.removeprefix("http://").rstrip("/").split(":"))
        writer.write(f"{lines}\r\n\r\n".encode())
        async with asyncio.timeout(LIMIT):
            assert b" 40" in await reader.readline()
        writer.close()


@pytest.mark.parametrize(
    "lines", ["GET /large HTTP/1.1", "POST /class/join HTTP/1.1\r\nOrigin: http://HOST\r\nContent-Length: 9\r\n\r\n{"]
)
async def test_a_browser_that_leaves_in_the_middle_is_no_error(lines: str) -> None:
    async with a_class() as pages:
        host = pages.address.removeprefix("http://").rstrip("/")
        for _ in range(5):
            _, writer = await asyncio.open_connection(*host.split(":"))
            first, _, rest = lines.replace("HOST", host).partition("\r\n")
            writer.write(f"{first}\r\nHost: {host}\r\n{rest}\r\n".encode())
            await writer.drain()
            await pages.join("Ada")  # the earlier request has arrived
            writer.transport.abort()
            await pages.join("Ada")


async def test_a_browser_that_joins_again_keeps_one_place() -> None:
    async with a_class() as pages:
        body = json.dumps({"code": pages.held.children.code, "name": "Ada"})
        own = {"Origin": pages.address.rstrip("/")}
        async with pages._http.post(f"{pages.address}class/join", data=body, headers=own) as answer:
            first, cookie = (await answer.json())["secret"], answer.cookies["improv-class"]
        assert (cookie["httponly"], cookie["samesite"], cookie["path"]) == (True, "Strict", "/class")
        second = await pages.join("Bo", Cookie=f"improv-class={cookie.value}")
        assert await pages.hear(lambda message: message["type"] == "gone") == {"type": "gone", "number": 1}
        assert (await pages.hear(lambda message: message["type"] == "child"))["name"] == "Bo"
        assert (await pages.send(first, "r $ left"))[0] == 403
        assert (await pages.send(second, "r $ left"))[0] == 200


async def test_a_child_is_here_until_its_page_is_closed_or_silent(monkeypatch: pytest.MonkeyPatch) -> None:
    async with a_class() as pages:

        async def is_here() -> bool:
            return bool((await pages.hear(lambda message: message["type"] == "child"))["here"])

        signed = {"Authorization": f"Bearer {await pages.join('Ada')}"}
        assert await is_here()
        for what, expected in (("left", False), ("here", True)):
            assert (await pages.post(what, "", **signed))[0] == 204
            assert await is_here() == expected
        assert (await pages.post("left", "", Authorization="Bearer guessed"))[0] == 403
        monkeypatch.setattr(roster, "SILENT", 0.0)
        assert not await is_here()


async def test_the_teacher_gets_a_dance_unaltered_and_its_page_no_text_before() -> None:
    text = "# \x1b\u202e\u200d\r\n" + "x" * 20_000 + "\n\tr $ left"

    async with a_class() as pages:
        assert (await pages.send(await pages.join("Ada"), text))[0] == 200
        shown = await pages.hear_dance(lambda latest: latest["count"] == 1)
        assert {*shown} == {"type", "number", "name", "here", "latest", "good"}
        assert {*shown["latest"]} == {"count", "sent", "ok", "line", "picture"}
        assert await pages.dance(1, 1) == (200, text.encode())
        assert (await pages.dance(1, 2))[0] == (await pages.dance(2, 1))[0] == 404
        pages.token = "wrong"
        assert (await pages.dance(1, 1))[0] == 403


@pytest.mark.parametrize(
    "text",
    [
        "{}", "[]", "x", '{"type": "stop"}', '{"type": "play", "numbers": []}', '{"type": "play", "numbers": ["1"]}',
        json.dumps({"type": "play", "numbers": [1] * 81}), '{"type": "perform", "number": 1, "robot": "a"}',
        '{"type": "perform", "number": 1, "count": "1", "robot": "a"}',
        '{"type": "remove", "numbers": [1e300]}', "[" * 9_000,
    ],
)  # fmt: skip
def test_invalid_commands_of_the_teacher_are_dropped(text: str) -> None:
    assert read(text) is None


@pytest.mark.skipif(sys.platform == "win32", reason="Windows limits no process by the time of its processor")
@pytest.mark.parametrize(("text", "code"), [(WORST, -signal.SIGPROF), ("r $ forward", 0)])
def test_a_process_ends_once_a_dance_has_taken_too_much_processor_time(text: str, code: int) -> None:
    """It ends even if that takes long on a busy machine."""
    asked = "import sys; from improv_core.classroom.checker import *; answer(Question(look, [sys.stdin.read()], 0.25))"
    assert subprocess.run([sys.executable, "-c", asked], input=text, text=True).returncode == code


async def test_a_cancelled_question_delays_no_other_one() -> None:
    checker = DanceReader()
    given_up = [asyncio.ensure_future(checker.look(WORST)) for _ in range(50)]
    await asyncio.sleep(0)
    for each in given_up:
        each.cancel()
    found = await checker.look("r $ forward")
    checker.close()
    assert found
    assert found["ok"]
    assert all(each.cancelled() for each in given_up)


async def test_a_question_that_is_cancelled_before_a_thread_has_it_leaves_no_process() -> None:
    checker, begin = DanceReader(), threading.Event()
    loop = asyncio.get_running_loop()
    loop.set_default_executor(ThreadPoolExecutor(1))
    busy = loop.run_in_executor(None, begin.wait)
    given_up = asyncio.ensure_future(checker.look("r $ forward"))
    await asyncio.sleep(0)
    given_up.cancel()
    await asyncio.sleep(0)
    begin.set()
    await asyncio.wait([given_up])
    assert await busy
    assert not ours("improv_core.classroom.checker")


@pytest.mark.parametrize(("limit", "line"), [(LIMIT, "r 1 beat"), (0.001, HEAVY)])
async def test_a_heavy_dance_moves_to_the_process_for_heavy_dances(limit: float, line: str) -> None:
    found: asyncio.Queue[DanceRead] = asyncio.Queue()
    turns = Turns(found.put_nowait, quick=0.001, limit=limit)
    turns.put({"type": "handed", "number": 1, "count": 1, "sent": 0.0, "text": "# \n" * 9_000 + "r $ forward"})
    serving = asyncio.create_task(turns.serve())
    async with asyncio.timeout(LIMIT):
        assert (await found.get())["line"].startswith(line)
    serving.cancel()


@pytest.mark.parametrize(
    ("waiting", "spent", "number"),
    [
        ([3, 1, 2], {}, 3),  # in turn
        ([3, 1, 2], {3: 9.0, 1: 0.2, 2: 0.1}, 2),  # a child with heavy dances waits until others have had as much
        ([3, 1], {3: 9.0}, 1),
    ],
)
def test_the_child_whose_dances_took_least_time_is_next(
    waiting: list[int], spent: dict[int, float], number: int
) -> None:
    assert next_child(waiting, spent) == number


async def test_a_class_that_ended_continues_with_its_dances_and_its_secrets(tmp_path: Path) -> None:
    async with a_class(tmp_path) as pages:
        code, secret = pages.held.children.code, await pages.join("Анна")
        for text in ("r $ left", "r $ lft"):
            while (await pages.send(secret, text))[0] == 429:
                pass  # once in a second
            await pages.hear_dance(lambda latest: latest["ok"] is not None)
    async with a_class(tmp_path) as pages:
        shown = await pages.hear_dance(lambda latest: latest["ok"] is False)
        counts = shown["good"]["count"], shown["latest"]["count"]
        assert (shown["name"], shown["here"], counts) == ("Анна", False, (1, 2))  # until its page says that it is open
        assert [await pages.dance(1, count) for count in (1, 2)] == [(200, b"r $ left"), (200, b"r $ lft")]
        assert pages.held.children.code == code
        assert (await pages.send(secret, "r $ right"))[0] == 200
        shown = await pages.hear_ok()
        assert (shown["here"], shown["good"]["count"]) == (True, 3)
        assert [name for name, _ in pages.held.desk.files()] == ["001-Анна.improv"]


async def test_a_dance_that_cannot_be_kept_arrives_and_the_teacher_reads_why(monkeypatch: pytest.MonkeyPatch) -> None:
    def full(*_: object) -> None:
        raise OSError(errno.ENOSPC, "No space left on device")

    async with a_class() as pages:
        secret = await pages.join("Ada")
        assert (await pages.hear(lambda message: message["type"] == "keeping"))["problem"] == ""
        with monkeypatch.context() as disk:
            disk.setattr(Folder, "add", full)
            assert (await pages.send(secret, "r $ left"))[0] == 200
            kept = await pages.hear(lambda message: message["type"] == "keeping")
            assert kept["problem"] == "what children send now is not kept: no space left on device"
        await pages.hear(lambda message: message["type"] == "keeping" and not message["problem"])


def test_the_score_of_several_has_the_names_of_children_and_their_meetings() -> None:
    ready = prepare([("Анна", "r $ repeat forward"), ("Bo", "a b $ rest\nb at 0 3\na at 0 0")])
    assert ready["names"] == {"Anna": "Анна", "Bo_a": "Bo: a", "Bo_b": "Bo: b"}
    assert prepare([("Анна", "r s $ rest\nr at 0 0\ns at 0.5 0")])["notes"] == ["Анна: r and Анна: s meet at beat 1"]
    (note,) = prepare([("Анна", "r $ repeat forward"), ("Bo", "r $ rest")])["notes"]
    assert note.startswith("Анна and Bo meet at beat ")
    assert prepare([("Ada", "r $ repeat 30 forward"), ("Bo", "r $ rest")])["notes"] == []


def test_problems_name_the_child_whose_dance_is_wrong() -> None:
    assert look("x = left")["line"] == "no robot plays anything yet"
    assert prepare([("Ada", "r $ left"), ("Bo", "r $ lft")])["problem"] == "Bo: it has errors: fix them first"
    assert prepare([("Ada", "r $ lft")])["problem"].startswith("Ada: line 1: ")


def test_a_dance_with_too_many_movements_is_not_played() -> None:
    """Sending it to a stage would block the event loop that receives the teacher's stop."""
    assert prepare([("Ada", "r $ " + "left right " * 4_000)])["problem"] == f"Ada: {LONG}"
    assert embody("Ada", "r $ " + "left right " * 4_000, "turtle1", ROBOTS)["problem"] == f"Ada: {LONG}"
    assert prepare([(f"Ada {number}", "r $ " + "left right " * 20) for number in range(40)])["score"]


ROBOTS = """
[robots.turtle1]
profile = "turtlesim"
[profiles.slow]
base = "turtlebot4"
step = 0.5
max_linear = 0.1
[robots.heavy]
profile = "slow"
"""


def test_a_real_robot_gets_the_dance_of_one_robot_within_its_limits() -> None:
    ready = json.loads(json.dumps(embody("Ada", "at = forward\nr at 1 2\nr $ at left\n", "turtle1", ROBOTS)))
    assert ready["problem"] == ""
    assert ready["score"]
    assert [*ready["score"]["parts"]] == ["turtle1"]


@pytest.mark.parametrize(
    ("text", "robot", "problem"),
    [
        ("a b $ left", "turtle1", "Ada: a real robot can perform a dance for one robot, and this is one for 2"),
        ("r $ lft", "turtle1", "Ada: line 1: `lft` is not defined: did you mean `left`?"),
        ("r $ forward", "heavy", "Ada: heavy can't perform it: 0.5 m/s is over heavy's limit of 0.1 m/s: "),
        ("r $ up", "heavy", "Ada: heavy can't perform it: "),
    ],
)
def test_problems_of_a_real_robot_are_reported(text: str, robot: str, problem: str) -> None:
    ready = embody("Ada", text, robot, ROBOTS)
    assert ready["score"] is None
    assert ready["problem"].startswith(problem), ready["problem"]


async def test_the_teacher_plays_only_the_dance_in_front(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(roster, "PERIOD", 0.0)
    async with a_class() as pages:
        ada = await pages.join("Ada")
        for _ in range(2):
            assert (await pages.send(ada, "r $ forward"))[0] == 200
            await pages.hear_ok()
        perform = {"type": "perform", "number": 1, "count": 1, "robot": ""}
        await pages.live.send_json(perform)
        line = "Ada has sent another dance: look at it first"
        assert (await pages.hear(lambda message: message["type"] == "playing" and message["line"]))["line"] == line
        await pages.live.send_json({**perform, "count": 2})
        await pages.hear(lambda message: message == {"type": "playing", "line": "Ada"})


async def test_without_real_robots_none_performs() -> None:
    async with a_class() as pages:
        assert await pages.hear(lambda message: message["type"] == "robots") == {"type": "robots", "names": []}
        await pages.send(await pages.join("Ada"), "r $ forward")
        await pages.hear_ok()
        await pages.live.send_json({"type": "perform", "number": 1, "count": 1, "robot": "turtle1"})
        await pages.live.send_json({"type": "play", "numbers": [1]})
        await pages.hear(lambda message: message == {"type": "playing", "line": "Ada"})


def make_site(folder: Path, *more: str) -> None:
    """A folder that looks like a website of this version, with more files."""
    for name in (MARK, "website/class.js", "index.html", *more):
        (folder / name).parent.mkdir(exist_ok=True)
        (folder / name).write_text(HEAD)


def test_the_file_of_real_robots_has_to_be_right(tmp_path: Path) -> None:
    make_site(tmp_path)
    for text, said in (("[robots.ada]\nprofile = 1\n", "has errors"), ("[world]\n", "names no robots")):
        (tmp_path / "improv.toml").write_text(text)
        done = run("class", tmp_path, "--address", "127.0.0.1", "--robots", tmp_path / "improv.toml")
        assert (done.returncode, done.stdout) == (2, "")
        assert said in done.stderr


def test_the_site_is_served_with_the_mark_of_a_class_and_without_a_service_worker(tmp_path: Path) -> None:
    with pytest.raises(ChildrenError, match="is no website of this version: run `improv site"):
        check_site(tmp_path)
    make_site(tmp_path, "service-worker.js", "python.wasm", "waltz.wav")
    check_site(tmp_path)
    files = files_of(tmp_path)
    assert {*files} == {"/", "/website/class.js", "/index.html", "/python.wasm", "/waltz.wav"}
    assert files["/python.wasm"].content_type == "application/wasm"  # browsers compile nothing else
    assert files["/waltz.wav"].content_type == "audio/wav"
    assert b'name="improv-class"' in files["/"].data


@pytest.mark.parametrize("address", ["0.0.0.0", "224.0.0.1", "example.com", "::"])
def test_the_address_is_one_of_this_machine(address: str, tmp_path: Path) -> None:
    make_site(tmp_path)
    done = run("class", tmp_path, "--address", address)
    assert (done.returncode, done.stdout) == (2, "")
    assert address in done.stderr
    assert "--address" in run("class", tmp_path).stderr  # no address was confirmed
