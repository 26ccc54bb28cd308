"""The bodies on the page: figures, rows of the timeline, and lit words."""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import pytest
from playwright.sync_api import Page, expect

from improv_core.outputs.simulator.simulator import Simulator
from improv_core.preview.window import about, window
from improv_core.program.analysis import analyze
from improv_core.program.compiler import score_of
from improv_core.program.files import robots_from
from improv_core.robots.config import read_robots
from improv_core.score.joints import JointMotion
from improv_core.score.replay import Replay
from tests.axe import Violations
from tests.page.conftest import SCHEMES, Keep, box, next_frame, switch_to, wait
from tests.page.editing import Edit
from tests.robots.test_skeletons import TOML, URDF

FOUR = """ada bert carla dan is puppet
beat 60
ada carla $ slow 2 right_arm to high || head [up down]
bert dan $ head (left left right right) || arms (up [left right] to wide)
"""
LIFTER = """
[profiles.lifter]
step = 1
[profiles.lifter.body.lift]
up = { joint = "mast", meters = 0.1 }
[profiles.lifter.joints.mast]
min = 0
max = 0.5
[robots.bo]
profile = "lifter"
"""


def test_each_body_part_in_use_has_a_row_and_its_words_are_lit(still: Callable[..., Page]) -> None:
    page = still("ada is puppet\nada $ head (left right) || left_arm to high\nbo $ forward\n")
    names = page.locator("#robots-list li .name")
    expect(names).to_have_text(["ada", "head", "left arm", "bo"])
    expect(page.locator("#score-text .lit.moving")).to_have_text(["left", "to", "high", "forward"])
    small = box(page, "#bodies .puppet")
    page.get_by_role("button", name="Present").click()
    expect(page.locator("#bodies .gauges")).to_be_hidden()
    wait(page, f"document.querySelector('#bodies .puppet').clientHeight > {1.3 * small['height']}")


@pytest.mark.slow("a browser on a busy machine")
def test_a_robot_with_a_urdf_is_a_stick_figure_that_turns_by_dragging_and_by_keys(
    page: Page, still: Callable[..., Page], simulator: Simulator, keep: Keep, tmp_path: Path
) -> None:
    (tmp_path / "r.urdf").write_text(URDF)
    still("ada $ head left\n", robots_from(TOML, tmp_path / "improv.toml"))
    figure = page.get_by_role("img", name="ada: drag it")

    def seen() -> str | None:
        return page.locator("#bodies .sticks .moving").get_attribute("d")

    wait(page, "document.querySelector('#bodies .sticks .moving').getAttribute('d')")
    before = seen()
    where = box(page, "#bodies .sticks")
    page.mouse.move(where["x"] + 50, where["y"] + 50)
    page.mouse.down()
    page.mouse.move(where["x"] + 90, where["y"] + 60)
    page.mouse.up()
    dragged = seen()
    figure.press("ArrowLeft")
    assert len({before, dragged, seen()}) == 3
    figure.dblclick()
    assert seen() == before
    simulator.send_joints("ada", {"lift": JointMotion(0.0, 0.1)}, 0.0)
    simulator.advance(1.0)
    wait(page, f"document.querySelector('#bodies .sticks .moving').getAttribute('d') !== {json.dumps(before)}")
    keep(page, "stick-figure.png")


def test_a_score_lists_the_joints_of_a_robot_and_its_moving_parts() -> None:
    score = score_of(analyze("bo $ lift up\nada is puppet\nada $ arms up\nturtle1 $ forward\n", read_robots(LIFTER)))
    robots = about(score, 1, takes_start_poses=False)["robots"]
    mast = {"name": "mast", "axis": "z", "sign": 1, "slides": True, "min": 0.0, "max": 0.5, "start": 0.0}
    assert robots["bo"]["body"] == [{"name": "lift", "joints": [mast], "moves": True}]
    moves = [(part["name"], part["moves"]) for part in robots["ada"]["body"]]
    assert moves == [("head", False), ("left_arm", True), ("right_arm", True)]
    assert robots["turtle1"]["body"] == []


def test_a_window_has_the_moves_of_each_body_part() -> None:
    program = "ada is puppet\nbeat 60\nada $ head (left right) || forward up\n"
    told = window(Replay(score_of(analyze(program))), 0.0, 4.0)["ada"]

    def spoken(moments: Sequence[Sequence[Any]]) -> list[tuple[float, str]]:
        line = program.splitlines()[2]
        return [(start, " ".join(line[begin:end] for _, begin, end in words)) for start, *_, words in moments]

    assert spoken(told["moments"]) == [(0.0, "forward"), (1.0, "up")]
    assert {part: spoken(moments) for part, moments in told["body"].items()} == {
        "head": [(0.0, "left"), (1.0, "right")]
    }
    assert [math.copysign(1, yaw) for *_, yaw, _ in told["body"]["head"]] == [1, -1]


@pytest.mark.slow("edits on a page")
def test_a_body_beside_the_editor_leaves_the_stage_room_for_its_tools(edit: Callable[[str], Edit]) -> None:
    page = edit("ada is puppet\nada $ head left\n").page()
    page.keyboard.press("Control+Enter")
    expect(page.locator("#bodies svg").first).to_be_visible()
    for width in (721, 740, 900, 1000):
        page.set_viewport_size({"width": width, "height": 900})
        next_frame(page)
        hall, tools = box(page, "#hall"), box(page, "#tools")
        assert hall["x"] < tools["x"], width
        assert page.evaluate(
            "(({ scrollWidth, offsetWidth }) => scrollWidth <= offsetWidth)(document.getElementById('tools'))"
        )


@pytest.mark.slow("axe looks at three sizes and two colors")
def test_axe_finds_nothing_and_no_size_covers_the_floor(
    violations: Violations, page: Page, still: Callable[..., Page], keep: Keep
) -> None:
    page.emulate_media(color_scheme="light")
    still(FOUR)
    for width, height in ((1280, 800), (390, 844), (683, 384)):
        page.set_viewport_size({"width": width, "height": height})
        expect(page.locator("#bodies-list > li")).to_have_count(4)
        floor, bodies = (box(page, name) for name in ("#hall", "#bodies"))
        assert floor["width"] * floor["height"] > (0.3 if height > width or width > 1000 else 0.2) * width * height
        assert bodies["x"] >= floor["x"] + floor["width"] or bodies["y"] + bodies["height"] <= floor["y"], "beside it"
        for scheme in SCHEMES:
            switch_to(page, scheme)
            assert violations(page) == [], f"{width}, {scheme}"
            keep(page, f"bodies-{width}-{scheme}.png")
