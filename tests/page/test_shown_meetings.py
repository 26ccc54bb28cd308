"""Meetings are marked on the stage and on the timeline, and a click goes to that beat."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, cast

from playwright.sync_api import Page, expect

from improv_core.page.server import Viewer
from improv_core.protocol.page_messages import MeetingsMessage
from tests.page.conftest import Commands, Keep, asked, at, wait
from tests.page.looks import PIXEL

PROGRAM = "ada at -4 0\nbo at 4 0 facing 180\nada bo $ repeat 4 forward\n"
MEETINGS: MeetingsMessage = {
    "type": "meetings",
    "generation": 1,
    "from": 0.0,
    "to": 4.0,
    "all": True,
    "assumes": False,
    "meetings": [
        {
            "robots": ["ada", "bo"],
            "beat": 1.85,
            "distance": 0.0,
            "more": 0,
            "poses": [[-0.3, 0, 0, 0], [0.3, 0, 0, 3.14]],
        }
    ],
    "hits": [{"robot": "bo", "thing": "wall 1", "beat": 3.5, "pose": [-3.0, 0, 0, 3.14]}],
}
MARK = "201,42,42"


def test_a_click_on_a_mark_or_near_it_seeks_there(
    still: Callable[..., Page], viewer: Viewer, commands: Commands, keep: Keep
) -> None:
    page = still(PROGRAM)
    expect(page.get_by_role("button", name="1 meeting ahead")).to_be_visible()  # as the server has found by now
    viewer.publish(cast(Any, MEETINGS))
    button = page.get_by_role("button", name="2 meetings ahead")
    expect(button).to_have_attribute("title", "beat 2: ada and bo meet, 0.00 m apart\nbeat 4: bo hits wall 1")
    mark = at(page, 0, 0)
    wait(page, f"({PIXEL})(0.03, 0) === '{MARK}'")  # beside its exclamation point
    keep(page, "page-meetings.png")

    page.mouse.click(*mark)
    assert asked(commands) == {"type": "seek", "beat": 1.85}
    page.mouse.move(*mark)
    expect(page.locator("#stage")).to_have_attribute("title", "beat 2: ada and bo meet, 0.00 m apart")
    page.mouse.down()
    page.mouse.move(mark[0] + 60, mark[1], steps=3)
    page.mouse.up()  # the view was moved: no click
    button.click()
    assert asked(commands) == {"type": "seek", "beat": 1.85}  # the first one ahead
    line = page.locator("#playline").bounding_box()
    assert line
    page.mouse.click(line["x"] + 1.85 / 4 * line["width"] + 4, line["y"] + 40)  # near its mark on the timeline
    assert asked(commands) == {"type": "seek", "beat": 1.85}
