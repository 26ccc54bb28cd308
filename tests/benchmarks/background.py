"""Work beside a measurement: a dance in the simulator, its page in a browser, and a person who types."""

from __future__ import annotations

import threading
import time
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from random import Random

from tests.benchmarks.chromium import chromium
from tests.benchmarks.documents import edits, improv
from tests.benchmarks.servers import Server

TYPED_LINES = 1_000
KEYS_A_SECOND = 20
PLAYS = {"backend": "sim", "page": {"open": True}}
"""Options of a server that plays in the simulator, and asks its editor to show the page."""
_DANCE = "r1 r2 r3 $ repeat (forward left)\n"


@contextmanager
def busy_editor() -> Iterator[None]:
    """Type into a document of a thousand lines while a dance plays and its page is open."""
    ended = threading.Event()
    with Server(PLAYS) as server, chromium() as browser, ThreadPoolExecutor() as pool:
        server.open(_DANCE)
        server.save()
        page = browser.new_page(viewport={"width": 1280, "height": 800})
        page.goto(server.client.wait_for_page()[0])
        page.wait_for_selector("body[data-state=playing]")
        server.replace(improv(TYPED_LINES))
        typist = pool.submit(_type, server, ended)
        try:
            yield
        finally:
            ended.set()
        typist.result()
        if page.locator("body").get_attribute("data-state") != "playing":
            raise RuntimeError("the dance was stopped before the typing was: the machine is too busy for its stage")


def _type(server: Server, ended: threading.Event) -> None:
    """Type into the document, at times that are never in step with the measured events."""
    random = Random(2)
    due = time.monotonic()
    for edit in edits(improv(TYPED_LINES)):
        due += random.uniform(0.5, 1.5) / KEYS_A_SECOND
        if ended.wait(max(due - time.monotonic(), 0)):
            return
        server.change(edit)
