"""The website with its Python in the tests' own process, where that starts at once. The rest is as people have it: the
page, its messages to its worker, and the home that answers. Only test_website.py starts Python in a browser."""

from __future__ import annotations

import asyncio
import json
import re
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from aiohttp import web

from improv_core.website.browser_session import BrowserBackend

WORKER = """// Passes on what the page says, to where Python runs.
const socket = new WebSocket("ws://127.0.0.1:PORT")
const opened = new Promise((done) => (socket.onopen = done))
onmessage = async ({ data }) => {
  await opened
  socket.send(JSON.stringify(data))
}
socket.onmessage = ({ data }) => postMessage(JSON.parse(data))
"""


@contextmanager
def homes() -> Iterator[int]:
    """Yield the port of a server on a thread, on which each worker finds its own home."""
    loop = asyncio.new_event_loop()
    thread = threading.Thread(target=loop.run_forever)
    thread.start()
    application = web.Application()
    application.router.add_get("/", _welcome)
    runner = web.AppRunner(application, shutdown_timeout=0.1)  # 0 would be no limit

    async def start() -> int:
        await runner.setup()
        site = web.TCPSite(runner, "127.0.0.1", 0)
        await site.start()
        return int(runner.addresses[0][1])

    yield asyncio.run_coroutine_threadsafe(start(), loop).result()
    asyncio.run_coroutine_threadsafe(runner.cleanup(), loop).result()
    loop.call_soon_threadsafe(loop.stop)
    thread.join()
    loop.close()


def run_natively(site: Path, port: int) -> None:
    """Have the worker of a website that was built use one of `homes`, and have browsers keep nothing of it."""
    (site / "worker.js").write_text(WORKER.replace("PORT", str(port)), encoding="utf-8")
    keep_nothing(site)


def keep_nothing(site: Path) -> None:
    """Have browsers keep nothing of a website: to load all files for later is almost half the work of opening it."""
    worker = site / "service-worker.js"
    worker.write_text(re.sub(r'"files": \[.*?\]', '"files": []', worker.read_text()))


async def _welcome(request: web.Request) -> web.WebSocketResponse:
    socket = web.WebSocketResponse(max_msg_size=0)
    await socket.prepare(request)
    said: asyncio.Queue[dict[str, Any]] = asyncio.Queue()
    home = BrowserBackend(
        lambda text: said.put_nowait({"message": text}), lambda number: said.put_nowait({"obeyed": number})
    )

    async def tell() -> None:
        while True:
            await socket.send_json(await said.get())

    async def serve(text: str, toml: str, revision: str, beat: float) -> None:
        try:
            await home.serve(text, toml, int(revision), beat, lambda: said.put_nowait({"ready": True}))
        except Exception as error:
            said.put_nowait({"problem": repr(error)})

    tasks = [asyncio.create_task(tell())]
    async for message in socket:
        asked = json.loads(message.data)
        if "program" in asked:
            tasks.append(asyncio.create_task(serve(**asked["program"])))
        elif "request" in asked:
            home.hear(asked["request"])
        elif "toml" in asked:
            home.use(asked["toml"])
        else:
            code = asked["draw"].get("code")
            said.put_nowait({"drawn": home.code(code) if code else home.paths()})
    for task in tasks:
        task.cancel()
    await home._playback.close()  # the dance ends with its page, as a worker does
    return socket
