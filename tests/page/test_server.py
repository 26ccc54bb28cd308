"""The page's server: its refusals, its messages, and its independence from slow clients."""

from __future__ import annotations

import asyncio
import contextlib
import http.client
import json
import os
import queue
import socket
import subprocess
import sys
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from fractions import Fraction
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any
from urllib.parse import quote, urlsplit

import aiohttp
import pytest

from improv_core.outputs.simulator.simulator import Simulator
from improv_core.page import connections, own_machine, routes
from improv_core.page.answers import MAX_BEATS
from improv_core.page.routes import MAX_BYTES, NO_TOKEN
from improv_core.page.server import PageServer
from improv_core.program.analysis import analyze
from improv_core.program.compiler import score_of
from improv_core.protocol.commands import PageRequest
from improv_core.protocol.drawn import Bump, Snapshot
from improv_core.protocol.editing import MAX_PAGES
from improv_core.protocol.page_messages import AskWindow
from improv_core.protocol.robot_messages import RobotInstant
from improv_core.protocol.tickets import Tickets, issue
from improv_core.score.motion import STILL, Pose, Twist
from improv_core.score.score import Score
from improv_core.score.svg import plot
from tests.open_page import token_behind
from tests.page.conftest import LIMIT, TOKEN, Commands, asked, link, part, transport
from tests.safety.stages import Stages

UPGRADE = {
    "Connection": "Upgrade",
    "Upgrade": "websocket",
    "Sec-WebSocket-Version": "13",
    "Sec-WebSocket-Key": "AAAAAAAAAAAAAAAAAAAAAA==",
}
NOBODY: Callable[[], Snapshot] = Snapshot


def ask(viewer: PageServer, path: str, **headers: str) -> http.client.HTTPResponse:
    """Return the answer to a request with exactly these headers; `_` in their names is `-`."""
    connection = http.client.HTTPConnection("127.0.0.1", urlsplit(viewer.address).port or 0, timeout=LIMIT)
    connection.putrequest("GET", path, skip_host="Host" in headers)
    for name, value in headers.items():
        connection.putheader(name, value)
    connection.endheaders()
    return connection.getresponse()


def own(viewer: PageServer) -> tuple[str, str]:
    """Return the server's own host, and the header that authorizes a request."""
    return urlsplit(viewer.address).netloc, f"token={quote(TOKEN)}"


def opened(viewer: PageServer, query: str) -> str:
    """Return the token of the page that a query opens; empty if it opens none."""
    return token_behind(f"{viewer.address}?{query}")


def test_a_ticket_opens_the_page_once(viewer: PageServer) -> None:
    first, second = (urlsplit(link(viewer)).query for _ in range(2))
    assert opened(viewer, second) == TOKEN
    assert opened(viewer, first) == TOKEN  # several may be out at once
    for used in (first, second):
        assert opened(viewer, used) == ""


def test_nothing_but_a_ticket_opens_the_page(viewer: PageServer) -> None:
    ticket = urlsplit(link(viewer)).query
    forged = (
        *(f"ticket={each}" for each in ("", "-", "1-2-3", "%C3%A9", quote(TOKEN), issue("another token"))),
        ticket.replace("=", "=1"),
        f"{ticket[:-1]}{'1' if ticket[-1] == '0' else '0'}",
        own(viewer)[1],
        "",
    )
    for query in forged:
        assert opened(viewer, query) == ""
    assert opened(viewer, ticket) == TOKEN


@pytest.mark.skipif(not hasattr(os, "getuid") or os.getuid() != 0, reason="only root can be another user")
@pytest.mark.parametrize("host", ["127.0.0.1", "::ffff:127.0.0.1"])
def test_a_ticket_in_the_process_list_is_useless_to_another_user(viewer: PageServer, host: str) -> None:
    """As soon as a browser is started, another user may be faster than it."""
    url = f"{viewer.address}?ticket={issue(TOKEN, own=True)}"
    where = urlsplit(url)
    asked = f"GET /?{where.query} HTTP/1.1\r\nHost: {where.netloc}\r\nConnection: close\r\n\r\n".encode()
    read = f"""
import encodings.idna, os, socket
os.setuid(1234)
thief = socket.create_connection(({host!r}, {where.port}))
thief.sendall({asked!r})
print(thief.makefile().read())
"""
    thief = subprocess.run([sys.executable, "-c", read], capture_output=True, text=True, timeout=LIMIT, check=True)
    assert NO_TOKEN in thief.stdout
    assert token_behind(url) == TOKEN  # the browser is not too late
    assert token_behind(url) == ""


@pytest.mark.skipif(not own_machine.TABLES[0].exists(), reason="only Linux tells whose connection it is")
@pytest.mark.parametrize("host", ["127.0.0.1", "::ffff:127.0.0.1"])
def test_the_user_of_a_connection_is_known_until_it_is_closed(host: str) -> None:
    with socket.create_server(("127.0.0.1", 0)) as server:
        own = server.getsockname()
        with socket.create_connection((host, own[1])) as client:
            accepted, address = server.accept()
            assert own_machine.user_of(address, own) == os.getuid()
            assert own_machine.user_of(("127.0.0.1", 1), own) == own_machine.NOBODY
        with accepted:
            assert client.fileno() == -1
            assert own_machine.user_of(address, own) == own_machine.NOBODY  # Linux lists it as root's


def test_a_system_that_reveals_nothing_refuses_nobody(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setattr(own_machine, "TABLES", (tmp_path / "none",))
    assert own_machine.user_of(("127.0.0.1", 1), ("127.0.0.1", 2)) is None


def test_a_users_own_ticket_is_refused_if_the_connection_belongs_to_nobody() -> None:
    mine = Tickets(TOKEN)
    ticket = issue(TOKEN, own=True)
    assert not mine.redeem(ticket, own_machine.NOBODY)
    assert mine.redeem(ticket, os.getuid())


def test_a_ticket_authorizes_nothing_else(viewer: PageServer) -> None:
    host, _ = own(viewer)
    for query in (urlsplit(link(viewer)).query, urlsplit(link(viewer)).query.replace("ticket", "token")):
        assert ask(viewer, f"/live?{query}", **UPGRADE, Origin=f"http://{host}").status == 403
        assert ask(viewer, f"/path.svg?{query}").status == 403
        assert ask(viewer, f"/token?{query}").status == 403
    assert ask(viewer, f"/token?{own(viewer)[1]}").status == 204


def test_no_ticket_survives_the_server_that_could_remember_it(viewer: PageServer) -> None:
    used, unused = (urlsplit(link(viewer)).query for _ in range(2))
    assert opened(viewer, used) == TOKEN
    viewer.close()
    again = PageServer(urlsplit(viewer.address).port or 0, NOBODY, lambda command: None, token=TOKEN)
    for query in (used, unused):
        assert opened(again, query) == ""
    assert ask(again, f"/token?{own(again)[1]}").status == 204  # an open page keeps working
    again.close()


def test_only_hosts_of_this_machine_are_answered(viewer: PageServer) -> None:
    host, token = own(viewer)
    local = host.replace("127.0.0.1", "localhost")
    assert ask(viewer, f"/?{token}", Host=local).status == 200
    assert ask(viewer, f"/?{token}", Host="127.0.0.1:1").status == 200  # through an editor's tunnel
    strangers = ("evil.example", f"evil.example:{local.split(':')[1]}", "127.0.0.1", "127.0.0.1:1.evil.example", "")
    for stranger in strangers:
        assert ask(viewer, f"/token?{token}", Host=stranger).status == 403
        assert ask(viewer, "/page.js", Host=stranger).status == 403


def test_the_websocket_needs_the_token_and_our_own_origin(viewer: PageServer) -> None:
    host, token = own(viewer)
    assert ask(viewer, f"/live?{token}", **UPGRADE, Origin=f"http://{host}").status == 101
    assert ask(viewer, "/live", **UPGRADE, Origin=f"http://{host}").status == 403
    assert ask(viewer, f"/live?{token}", **UPGRADE).status == 403
    for origin in ("http://evil.example", "null", f"https://{host}", f"http://{host}.evil.example"):
        assert ask(viewer, f"/live?{token}", **UPGRADE, Origin=origin).status == 403


def test_only_the_files_of_the_page_are_served(viewer: PageServer) -> None:
    _, token = own(viewer)
    assert ask(viewer, "/floor/motion.js").getheader("Content-Type") == "text/javascript; charset=utf-8"
    for path in ("/server.py", "/index.html", "/../server.py", "/%2e%2e/server.py", "//etc/passwd", f"/stage?{token}"):
        assert ask(viewer, path).status == 404


def test_the_page_may_load_nothing_from_elsewhere_but_may_be_framed(viewer: PageServer) -> None:
    answer = ask(viewer, f"/?{own(viewer)[1]}")
    policy = answer.getheader("Content-Security-Policy") or ""
    assert "default-src 'none'" in policy
    assert "script-src 'self'" in policy
    around = next(each for each in policy.split("; ") if each.startswith("frame-ancestors ")).split()
    assert set(around[1:]) == {
        *("vscode-webview:", "vscode-file:"),  # VS Code on a desktop
        *("http://127.0.0.1:*", "http://localhost:*", "https://*.vscode-cdn.net"),  # in a browser on this machine
    }
    assert answer.getheader("X-Frame-Options") is None
    assert answer.getheader("Referrer-Policy") == "no-referrer"


def test_a_taken_port_is_a_plain_error(viewer: PageServer) -> None:
    with pytest.raises(OSError, match="in use"):
        PageServer(urlsplit(viewer.address).port or 0, NOBODY, lambda command: None)


# Messages over the WebSocket


async def connected(viewer: PageServer, session: aiohttp.ClientSession) -> aiohttp.ClientWebSocketResponse:
    host, token = own(viewer)
    return await session.ws_connect(f"http://{host}/live?{token}", origin=f"http://{host}")


async def until(socket: aiohttp.ClientWebSocketResponse, wanted: Callable[[dict[str, Any]], bool]) -> dict[str, Any]:
    while True:
        message: dict[str, Any] = await socket.receive_json(timeout=LIMIT)
        if wanted(message):
            return message


def test_a_new_page_gets_published_messages_and_the_robots(viewer: PageServer, simulator: Simulator) -> None:
    simulator.prepare(Score(Fraction(60), {"ada": part("ada", Pose(1.0, 2.0))}), restart=True)
    simulator.send("ada", Twist(y=1 / 3), 0.0)
    simulator.advance(1.0)
    viewer.publish(transport(1, "playing"))
    viewer.publish(transport(2, "playing"))

    async def check() -> dict[str, dict[str, Any]]:
        async with aiohttp.ClientSession() as session:
            socket = await connected(viewer, session)
            messages = [await socket.receive_json(timeout=LIMIT) for _ in range(5)]
            return {message["type"]: message for message in messages}

    messages = asyncio.run(check())
    assert next(iter(messages)) == "time"
    assert messages["transport"]["generation"] == 2
    assert messages["robots"] == {"type": "robots", "robots": {"ada": {"radius": 0.3, "joints": []}}}
    assert messages["poses"] == {
        "type": "poses",
        "at": 1.0,
        "placed": 1,
        "poses": [[1.0, 2.3333, 0.0, 0.0]],
        "joints": {},
    }
    assert messages["trails"] == {
        "type": "trails",
        "placed": 1,
        "robots": {"ada": {"from": 0, "places": [[0.0, 1.0, 2.0, 0.0]]}},
    }


def test_each_page_gets_each_place_of_a_trail_once(viewer: PageServer, simulator: Simulator) -> None:
    simulator.prepare(Score(Fraction(60), {"ada": part("ada", Pose())}), restart=True)

    async def check() -> None:
        async def trail(socket: aiohttp.ClientWebSocketResponse) -> tuple[int, list[float]]:
            message = await until(socket, lambda message: message["type"] == "trails")
            drawn = message["robots"]["ada"]
            return drawn["from"], [place[0] for place in drawn["places"]]

        async with aiohttp.ClientSession() as session:
            first = await connected(viewer, session)
            assert await trail(first) == (0, [0.0])
            simulator.send("ada", Twist(1.0), 0.5)
            simulator.advance(1.0)
            assert await trail(first) == (1, [0.5])
            second = await connected(viewer, session)
            assert await trail(second) == (0, [0.0, 0.5])
            simulator.place({"ada": Pose(5.0)})
            assert await trail(first) == await trail(second) == (0, [1.0])

    asyncio.run(check())


def test_nothing_is_sent_while_nothing_changes(simulator: Simulator) -> None:
    simulator.prepare(Score(Fraction(60), {"ada": part("ada", Pose())}), restart=True)
    looks: queue.SimpleQueue[Snapshot] = queue.SimpleQueue()

    def look() -> Snapshot:
        looks.put(seen := simulator.snapshot())
        return seen

    viewer = PageServer(0, look, lambda command: None, token=TOKEN)

    async def check() -> None:
        async with aiohttp.ClientSession() as session:
            socket = await connected(viewer, session)
            await until(socket, lambda message: message["type"] == "trails")
            simulator.send("ada", STILL, 0.0)
            simulator.advance(1.0)
            while not looks.empty():
                looks.get()
            for _ in range(3):
                await asyncio.to_thread(looks.get, timeout=LIMIT)
            viewer.publish(transport(1, "playing"))
            assert (await socket.receive_json(timeout=LIMIT))["type"] == "transport"
            simulator.send("ada", Twist(z=1.0), 1.0)
            simulator.advance(2.0)
            poses = await until(socket, lambda message: message["type"] == "poses")
            assert poses["poses"] == [[0.0, 0.0, 1.0, 0.0]]

    asyncio.run(check())
    viewer.close()


def test_a_robot_standing_where_another_stood_is_reported_with_a_pose(viewer: PageServer, simulator: Simulator) -> None:
    async def check() -> None:
        async with aiohttp.ClientSession() as session:
            socket = await connected(viewer, session)
            for name in ("ada", "bo"):
                simulator.prepare(Score(Fraction(60), {name: part(name, Pose(1.0))}), restart=True)
                robots = await until(socket, lambda message: message["type"] == "robots" and message["robots"])
                assert list(robots["robots"]) == [name]
                assert (await socket.receive_json(timeout=LIMIT))["poses"] == [[1.0, 0.0, 0.0, 0.0]]

    asyncio.run(check())


def test_each_bump_is_reported_once_even_in_a_replayed_dance() -> None:
    bump = Bump(1.5, 0.25, 0.0, ("ada", "bo"))
    again = Bump(*bump)
    shown = Snapshot(bumps=(bump,))
    viewer = PageServer(0, lambda: shown, lambda command: None, token=TOKEN)

    async def check() -> None:
        nonlocal shown
        async with aiohttp.ClientSession() as session:
            first = await connected(viewer, session)
            told = {"at": 1.5, "x": 0.25, "y": 0.0, "robots": ["ada", "bo"], "thing": ""}
            assert await until(first, is_bumps) == {"type": "bumps", "past": True, "bumps": [told]}
            shown = Snapshot(bumps=(bump, Bump(2.0, 1.0, 1.0, ("ada",))))
            assert await times(first) == (False, [2.0])
            later = await connected(viewer, session)
            assert await times(later) == (True, [1.5, 2.0])
            shown = Snapshot(bumps=(again,))
            for socket in (first, later):
                assert await until(socket, is_bumps) == {"type": "bumps", "past": False, "bumps": [told]}
            shown = Snapshot(bumps=(again, Bump(3.0, 0.0, 0.0, ("bo",))))
            assert await times(first) == (False, [3.0])

    asyncio.run(check())
    viewer.close()


async def times(socket: aiohttp.ClientWebSocketResponse) -> tuple[bool, list[float]]:
    message = await until(socket, is_bumps)
    return message["past"], [bump["at"] for bump in message["bumps"]]


def is_bumps(message: dict[str, Any]) -> bool:
    return bool(message["type"] == "bumps")


def test_the_last_published_message_comes_before_the_end(viewer: PageServer) -> None:
    async def check() -> None:
        async with aiohttp.ClientSession() as session:
            socket = await connected(viewer, session)
            await until(socket, lambda message: message["type"] == "poses")
            viewer.publish({"type": "stopped"})
            await asyncio.to_thread(viewer.close)
            assert (await socket.receive_json(timeout=LIMIT)) == {"type": "stopped"}
            assert (await socket.receive(timeout=LIMIT)).type in (aiohttp.WSMsgType.CLOSED, aiohttp.WSMsgType.ERROR)

    asyncio.run(check())


# The picture


def test_the_picture_is_that_of_plot_and_is_given_to_those_with_the_token(viewer: PageServer) -> None:
    host, token = own(viewer)
    assert ask(viewer, f"/path.svg?{token}").status == 404  # nothing has been played
    for program in ("ada $ forward left forward", "ada $ left"):
        score = score_of(analyze(program))
        viewer.show(score, 1)
        answer = ask(viewer, f"/path.svg?{token}", Origin=f"http://{host}")
        assert answer.getheader("Content-Type") == "image/svg+xml; charset=utf-8"
        assert answer.read().decode() == plot(score)
    assert ask(viewer, "/path.svg").status == 403
    assert ask(viewer, f"/path.svg?{token}", Origin="http://evil.example").status == 403
    assert ask(viewer, f"/path.svg?{token}", Host="evil.example").status == 403


def test_only_known_commands_are_passed_on(viewer: PageServer, commands: Commands) -> None:
    async def check() -> None:
        async with aiohttp.ClientSession() as session:
            socket = await connected(viewer, session)
            for text in ("", "{", "[" * 4000, "7", "[]", "{}", '{"type": 7}', '{"type": ["stop"]}', '{"type": "load"}'):
                await socket.send_str(text)
            await socket.send_bytes(b'{"type": "stop"}')
            await socket.send_str(json.dumps({"type": "stop", "more": 1}))
            assert await asyncio.to_thread(asked, commands) == {"type": "stop"}
            with contextlib.suppress(ConnectionError):  # the server may hang up before it has all
                await socket.send_str("x" * (MAX_BYTES + 1))
            async for _ in socket:
                pass
            assert socket.close_code in {aiohttp.WSCloseCode.MESSAGE_TOO_BIG, aiohttp.WSCloseCode.ABNORMAL_CLOSURE}

    asyncio.run(check())
    assert commands.empty()


def answer_to(viewer: PageServer, query: str, **headers: str) -> http.client.HTTPResponse:
    """Send a stop as the page does, over its own connection."""
    host, token = own(viewer)
    connection = http.client.HTTPConnection(host, timeout=LIMIT)
    connection.request("POST", f"/stop?{token}&{query}", headers={"Origin": f"http://{host}", **headers})
    return connection.getresponse()


def press(viewer: PageServer, query: str, **headers: str) -> int:
    """Return the status of the answer to a stop."""
    return answer_to(viewer, query, **headers).status


def test_a_stop_over_its_own_connection_is_passed_on_once_and_confirmed_when_it_was_obeyed(
    viewer: PageServer, commands: Commands, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(routes, "CONFIRM_LIMIT", 0.05)
    stop: PageRequest = {"type": "stop", "direct": "page-1 1"}
    assert [press(viewer, "page=page-1&number=1") for _ in range(2)] == [202, 202]
    assert asked(commands) == stop
    monkeypatch.setattr(routes, "CONFIRM_LIMIT", LIMIT)
    with ThreadPoolExecutor() as pool:
        waiting = pool.submit(press, viewer, "page=page-1&number=1")
        viewer.publish({"type": "obeyed", "direct": "page-1 1"})
        assert waiting.result(LIMIT) == 204
    assert commands.empty()


@pytest.mark.parametrize(("hangs", "answer"), [("", (204, b"")), ("ros", (202, b"the real robots"))])
def test_a_stop_goes_straight_to_stages_and_to_the_parent_only_if_one_has_not_obeyed_soon(
    hangs: str, answer: tuple[int, bytes], commands: Commands, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(routes, "HEAD_START", 0.02 if hangs else LIMIT)
    monkeypatch.setattr(routes, "CONFIRM_LIMIT", LIMIT if not hangs else 0.5)
    monkeypatch.setattr(routes, "ASK_LIMIT", LIMIT if not hangs else 0.05)
    with TemporaryDirectory(dir="/tmp") as folder:
        stages = Stages(Path(folder, "7-abc"), "simulator", "ros", hangs=hangs)
        viewer = PageServer(0, NOBODY, commands.put, token=TOKEN, show=Path(folder, "7-abc"))
        for _ in range(2 if hangs else 1):  # the page sends it again
            said = answer_to(viewer, "page=p&number=1")
            assert (said.status, said.read()) == answer
        assert {(name, stop["direct"]) for name, stop in stages.stops} == {("ros", "p 1"), ("simulator", "p 1")}
        assert all("at" in stop for _, stop in stages.stops), "requests from before it are void"
        viewer.close()
        stages.close()
    if hangs:
        assert asked(commands) == {"type": "stop", "direct": "p 1"}
    assert commands.empty(), "stages report a stop that they have obeyed"


def test_a_stop_needs_the_token_our_own_origin_and_a_number(
    viewer: PageServer, commands: Commands, monkeypatch: pytest.MonkeyPatch
) -> None:
    assert press(viewer, "page=p&number=1", Origin="http://evil.example") == 403
    monkeypatch.setattr(routes, "CONFIRM_LIMIT", 0.0)
    assert press(viewer, "page=p&number=1") == 202
    for query in ("", "page=p", "number=1", "page=&number=1", "page=p&number=-1", "page=p&number=x", "page=a b"):
        assert press(viewer, quote(query, safe="=&")) == 400
    host, _ = own(viewer)
    connection = http.client.HTTPConnection(host, timeout=LIMIT)
    connection.request("POST", "/stop?token=wrong&page=p&number=2", headers={"Origin": f"http://{host}"})
    assert connection.getresponse().status == 403
    assert asked(commands) == {"type": "stop", "direct": "p 1"}
    assert commands.empty()


def test_a_request_sent_before_a_stop_that_arrives_after_it_does_not_play(
    viewer: PageServer, commands: Commands, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(routes, "CONFIRM_LIMIT", 0.0)
    host, token = own(viewer)
    write = {"type": "write", "number": 1, "text": "", "revision": ""}

    async def check() -> None:
        async with aiohttp.ClientSession() as session:
            socket = await session.ws_connect(f"http://{host}/live?{token}&page=p", origin=f"http://{host}")
            await until(socket, lambda message: message["type"] == "poses")
            await asyncio.to_thread(press, viewer, "page=p&number=1")
            for each in ({"type": "restart"}, write, {"type": "press", "number": 1}, {"type": "resume"}):
                await socket.send_json(each)
            await socket.close()

    asyncio.run(check())
    found: list[Any] = [commands.get(timeout=LIMIT) for _ in range(4)]
    assert [each["type"] for each in found] == ["page_opened", "stop", "editing", "resume"]
    _, stop, editing, resume = (each.get("at") for each in found)
    assert editing < stop < resume
    assert commands.empty()


def test_pages_in_frames_are_counted_as_they_come_and_go(viewer: PageServer, commands: Commands) -> None:
    host, token = own(viewer)

    async def told(session: aiohttp.ClientSession, *more: str) -> aiohttp.ClientWebSocketResponse:
        return await session.ws_connect(f"http://{host}/live?{'&'.join((token, *more))}", origin=f"http://{host}")

    async def check() -> list[Any]:
        async with aiohttp.ClientSession() as session:
            sockets = [await told(session, *more) for more in (["framed=true"], [], ["framed=true"])]
            found = [await asyncio.to_thread(commands.get, timeout=LIMIT) for _ in sockets]
            for socket in sockets:
                await socket.close()
            return found + [await asyncio.to_thread(commands.get, timeout=LIMIT) for _ in range(2)]

    assert [each.get("framed") for each in asyncio.run(check())] == [1, None, 2, 1, 0]
    assert commands.empty()


def test_a_page_that_floods_is_cut_off(viewer: PageServer, commands: Commands) -> None:
    async def check() -> None:
        async with aiohttp.ClientSession() as session:
            socket = await connected(viewer, session)
            with contextlib.suppress(ConnectionError):
                while True:
                    await socket.send_json({"type": "seek", "beat": 1})
            await connected(viewer, session)  # it may come back

    asyncio.run(check())


def test_a_page_that_asks_gets_the_next_beats(viewer: PageServer) -> None:
    viewer.show(score_of(analyze("ada $ repeat (forward left)")), 3)

    async def check() -> None:
        async with aiohttp.ClientSession() as session:
            asking, other = await connected(viewer, session), await connected(viewer, session)
            score = await until(asking, lambda message: message["type"] == "score")
            assert (score["generation"], score["beats"], list(score["robots"])) == (3, None, ["ada"])
            await asking.send_json({"type": "window", "generation": 2, "from": 0, "to": 4})  # of an earlier score
            await asking.send_json({"type": "window", "generation": 3, "from": 1, "to": 1e9})
            answer = await until(asking, lambda message: message["type"] == "window")
            assert (answer["generation"], answer["from"], answer["to"]) == (3, 1, 1 + MAX_BEATS)
            assert len(answer["robots"]["ada"]["moments"]) == MAX_BEATS
            assert answer["robots"]["ada"]["pose"] == [2.0, 0.0, 0.0, 0.0]
            viewer.publish(transport(3, "playing"))
            assert (await until(other, lambda message: message["type"] in ("window", "transport")))[
                "type"
            ] == "transport"

    asyncio.run(check())


def test_a_window_is_of_the_score_whose_generation_it_names(viewer: PageServer) -> None:
    """The window is right even while another score waits to take over, which is the only one that counts once it
    has."""
    casts = {1: "ada", 2: "bo"}
    for generation, robot in casts.items():
        viewer.show(score_of(analyze(f"{robot} $ forward")), generation)

    async def shown(generation: int) -> list[str] | None:
        question: AskWindow = {"type": "window", "generation": generation, "from": 0.0, "to": 4.0}
        answers = viewer._answers
        text = await answers.compute(lambda: answers.window(question))
        return None if text is None else list(json.loads(text)["robots"])

    assert [asyncio.run(shown(generation)) for generation in casts] == [["ada"], ["bo"]]
    viewer.publish(transport(2, "playing"))
    assert [asyncio.run(shown(generation)) for generation in casts] == [None, ["bo"]]


@pytest.mark.parametrize(("edges", "expected"), [((0.0,), "forward forward"), ((0.0, 2.0), "forward left")])
def test_senses_of_real_robots_come_before_their_jump(
    viewer: PageServer, edges: tuple[float, ...], expected: str
) -> None:
    """The simulator beside them is a tenth of a second behind."""
    program = "ada $ repeat (if near left else forward)\n"
    viewer.show(score_of(analyze(program)), 1)

    def sense(value: bool, performed: float, beat: float) -> None:
        instant: RobotInstant = {"generation": 1, "robot": "ada", "beat": beat, "performed": performed, "wall": 0}
        viewer.publish({"type": "sensed", "sense": "near", "value": value, **instant})

    for performed in edges:
        sense(performed > 0, performed, performed)
    viewer.publish(transport(1, "playing"))
    sense(False, 9.0, 9.0)
    sense(expected.endswith("left"), 10.0, 3.0)  # after a seek that the simulator has not reached
    viewer.publish({**transport(1, "playing", beat=3.0), "performed": 10.0})
    question: AskWindow = {"type": "window", "generation": 1, "from": 3.0, "to": 5.0}
    text = asyncio.run(viewer._answers.compute(lambda: viewer._answers.window(question)))
    words = [program[slice(*moment[-1][-1][1:])] for moment in json.loads(text or "")["robots"]["ada"]["moments"]]
    assert " ".join(words) == expected  # decisions at the beat of a jump assume that no sense is true


def test_a_page_that_does_not_read_delays_nobody(viewer: PageServer) -> None:
    host, token = own(viewer)
    stuck = socket.socket()
    stuck.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4096)
    stuck.connect(("127.0.0.1", urlsplit(viewer.address).port))
    headers = "".join(f"{name}: {value}\r\n" for name, value in UPGRADE.items())
    stuck.sendall(f"GET /live?{token} HTTP/1.1\r\nHost: {host}\r\nOrigin: http://{host}\r\n{headers}\r\n".encode())
    assert b" 101 " in stuck.recv(1024)

    async def check() -> None:
        async with aiohttp.ClientSession() as session:
            socket = await connected(viewer, session)
            for number in range(2000):  # far more than the system buffers for the stuck page
                viewer.publish({**transport(number, "playing"), "backend": "x" * 10_000})
            await until(socket, lambda message: message.get("generation") == 1999)

    asyncio.run(check())
    viewer.close()  # at once, although the stuck page still has not read
    stuck.close()


def test_the_number_of_pages_is_bounded(viewer: PageServer) -> None:
    async def check() -> None:
        async with aiohttp.ClientSession(connector=aiohttp.TCPConnector(limit=0)) as session:
            sockets = [await connected(viewer, session) for _ in range(MAX_PAGES)]
            with pytest.raises(aiohttp.WSServerHandshakeError) as refused:
                await connected(viewer, session)
            assert refused.value.status == 503
            await sockets.pop().close()
            viewer.publish(transport(5, "playing"))
            for each in sockets:
                await until(each, lambda message: message.get("generation") == 5)
            await connected(viewer, session)

    asyncio.run(check())


def test_publishing_and_closing_after_the_end_do_nothing(viewer: PageServer) -> None:
    viewer.close()
    viewer.publish(transport(1, "playing"))
    viewer.close()


# Connections


def silent(viewer: PageServer) -> socket.socket:
    """Open a connection that sends nothing."""
    where = urlsplit(viewer.address)
    return socket.create_connection((where.hostname, where.port or 0), timeout=LIMIT)


def is_closed(connection: socket.socket) -> bool:
    """Wait until the server has closed a connection."""
    try:
        return connection.recv(1) == b""
    except ConnectionResetError:
        return True


def test_a_connection_without_a_request_is_closed(monkeypatch: pytest.MonkeyPatch, viewer: PageServer) -> None:
    monkeypatch.setattr(connections, "STALL_LIMIT", 0.1)
    for sent in (b"", b"GET / HTTP/1.1\r\n"):
        connection = silent(viewer)
        connection.sendall(sent)
        assert is_closed(connection)


def test_a_connection_that_is_used_is_not_cut(monkeypatch: pytest.MonkeyPatch, viewer: PageServer) -> None:
    used = http.client.HTTPConnection(urlsplit(viewer.address).netloc, timeout=LIMIT)
    used.request("GET", "/page.js")
    assert used.getresponse().read()
    monkeypatch.setattr(connections, "STALL_LIMIT", 1.0)
    own = used.sock
    assert is_closed(silent(viewer))  # which was opened later
    used.request("GET", "/page.js")
    assert used.getresponse().read()
    assert used.sock is own
    used.close()


def test_connections_without_requests_keep_nobody_out(monkeypatch: pytest.MonkeyPatch, viewer: PageServer) -> None:
    most = 16
    monkeypatch.setattr(connections, "MAX_PER_ADDRESS", most)
    monkeypatch.setattr(connections, "STALL_LIMIT", 1000.0)

    async def check() -> None:
        async with aiohttp.ClientSession() as session:
            page = await connected(viewer, session)
            hanging = []
            for _ in range(2 * most):
                hanging.append(silent(viewer))
                await asyncio.to_thread(lambda: ask(viewer, "/page.js").read())  # the server has accepted it by then
            assert await asyncio.to_thread(opened, viewer, urlsplit(link(viewer)).query) == TOKEN
            for each in hanging[:most]:  # the oldest ones went first
                assert await asyncio.to_thread(is_closed, each)
            viewer.publish(transport(7, "playing"))
            await until(page, lambda message: message.get("generation") == 7)
            for each in hanging:
                each.close()

    asyncio.run(check())
