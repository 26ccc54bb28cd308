"""A start dragged on the page becomes an edit of improv.toml that the editor is asked to make."""

from __future__ import annotations

import asyncio
from pathlib import Path
from typing import Any
from urllib.parse import urlsplit

import aiohttp
import pytest

from tests.ls.client import Client

CAPABILITIES = {
    "workspace": {"applyEdit": True, "workspaceEdit": {"resourceOperations": ["create"]}},
    "window": {"showDocument": {"support": True}},
}
PLACE = {"type": "place", "robot": "anna", "x": 1.5, "y": -2, "heading": 90}


def drag(page: str, message: dict[str, Any]) -> None:
    """Send what a page sends."""

    async def send() -> None:
        address = urlsplit(page)
        origin = f"{address.scheme}://{address.netloc}"
        live = f"{origin}/live?{address.query}"
        async with aiohttp.ClientSession() as session, session.ws_connect(live, headers={"Origin": origin}) as socket:
            await socket.send_json(message)

    asyncio.run(send())


@pytest.mark.parametrize(
    ("before", "changes"),
    [
        (
            None,
            [
                {"kind": "create"},
                {"at": [0, 0, 0, 0], "text": "[robots.anna]\nstart = { x = 1.5, y = -2, heading = 90 }\n"},
            ],
        ),
        (
            "[robots.anna]\nstart = { x = 3 } # 🐢\n",
            [{"at": [1, 8, 1, 17], "text": "{ x = 1.5, y = -2, heading = 90 }"}],
        ),
    ],
)
def test_the_editor_is_asked_to_write_it(tmp_path: Path, before: str | None, changes: list[dict[str, Any]]) -> None:
    program, robots = tmp_path / "dance.improv", tmp_path / "improv.toml"
    if before:
        robots.write_text(before, encoding="utf-8")
    with Client({"backend": "sim"}, capabilities=CAPABILITIES) as client:
        client.open(program.as_uri(), "anna $ forward\n")
        client.save(program.as_uri())
        drag(client.wait_for_page()[0], PLACE)
        edit = client.wait("workspace/applyEdit")["edit"]
    found = []
    for change in edit["documentChanges"]:
        assert change.get("uri", change.get("textDocument", {}).get("uri")) == robots.as_uri()
        if "kind" in change:
            found.append({"kind": change["kind"]})
            continue
        (text,) = change["edits"]
        start, end = text["range"]["start"], text["range"]["end"]
        place = [start["line"], start["character"], end["line"], end["character"]]
        found.append({"at": place, "text": text["newText"]})
    assert found == changes
    assert (robots.read_text(encoding="utf-8") if before else None) == before  # never behind the editor's back
