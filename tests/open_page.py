"""A browser's use of a URL that opens the page: it gets a token, and with it the page's WebSocket. Also its drawing."""

from __future__ import annotations

import re
from collections.abc import AsyncIterator, Callable
from contextlib import asynccontextmanager
from http.client import HTTPConnection
from typing import Any
from urllib.parse import quote, urlsplit
from urllib.request import urlopen

from aiohttp import ClientSession, ClientWebSocketResponse

CALMLY = """{
  const draw = requestAnimationFrame.bind(window)
  window.requestAnimationFrame = (then) => setTimeout(() => draw(then), 60)
}"""
"""Has a page draw about 15 times a second, which is a quarter of the work."""
LIMIT = 60


def token_behind(url: str) -> str:
    """Return the page's token; empty if the URL does not open the page, or no longer."""
    with urlopen(url, timeout=LIMIT) as answer:
        (token,) = re.findall(r'<meta id="token" name="improv-token" content="(.*?)">', answer.read().decode())
    return str(token)


def live_behind(url: str) -> str:
    """Return the address of the page's WebSocket, which may be used any number of times."""
    token = token_behind(url)
    assert token, f"{url} has been used"
    return f"http://{urlsplit(url).netloc}/live?token={quote(token)}"


def stop_by(live: str) -> tuple[int, str]:
    """Send the stop of a page, or repeat it. Return the status of the answer, and its text."""
    home, _, token = live.partition("/live?")
    connection = HTTPConnection(urlsplit(live).netloc, timeout=LIMIT)
    connection.request("POST", f"/stop?{token}&page=p&number=1", headers={"Origin": home})
    answer = connection.getresponse()
    return answer.status, answer.read().decode()


@asynccontextmanager
async def connected(live: str) -> AsyncIterator[ClientWebSocketResponse]:
    """Open a page's WebSocket at this address."""
    origin = live.partition("/live")[0]
    async with ClientSession() as session, session.ws_connect(live, origin=origin) as page:
        yield page


async def heard(page: ClientWebSocketResponse, fits: Callable[[Any], bool]) -> Any:
    """Wait for the next message to a page that fits."""
    async for message in page:
        if fits(told := message.json()):
            return told
    raise AssertionError("the page was closed")
