"""Senses of robots on the page: chips, the cue, keys, and the area of `near`."""

from __future__ import annotations

from dataclasses import replace

import pytest
from playwright.sync_api import Page, expect

from improv_core.outputs.simulator.simulator import Simulator
from improv_core.page.server import PageServer
from improv_core.program.analysis import analyze
from improv_core.program.compiler import score_of
from improv_core.protocol.robot_messages import RobotInstant
from improv_core.score.senses import BuiltIn, Key, Senses, Topic
from tests.page.conftest import Commands, asked, link, transport, wait
from tests.page.looks import PIXEL

AHEAD = f"({PIXEL})(2.12, 0.15)"  # the color of the ground that only `near` covers
DARK = "245,232,221"  # while it senses nothing


@pytest.fixture
def senses() -> Senses:
    wall = Topic("/ada/scan", "sensor_msgs/LaserScan", below=1.5, start=-0.5, end=0.5)
    return {"near": BuiltIn("near"), "cue": BuiltIn("cue"), "wall": wall, "drop": Key("l")}


@pytest.fixture
def sensing(page: Page, viewer: PageServer, simulator: Simulator, senses: Senses) -> Page:
    """A page of a robot that reads all kinds of senses."""
    score = score_of(analyze("ada $ repeat (forward left)\n"))
    score = replace(score, parts={"ada": replace(score.parts["ada"], senses=senses)})
    simulator.prepare(score, restart=True)
    viewer.show(score, 1)
    viewer.publish(transport(1, "playing", beats=None))
    page.goto(link(viewer))
    wait(page, "window.improv?.known.ada > 0 && improv.robots.ada")
    return page


def sensed(viewer: PageServer, sense: str, value: bool | None) -> None:
    instant: RobotInstant = {"generation": 1, "robot": "ada", "beat": 1.0, "performed": 1.0, "wall": 1}
    viewer.publish({"type": "sensed", "sense": sense, "value": value, **instant})


def test_a_chip_shows_a_sense_and_its_area_lights_up(sensing: Page, viewer: PageServer) -> None:
    chip = sensing.locator(".chip", has_text="near")
    expect(chip).to_have_attribute("data-value", "silent")
    wait(sensing, f"{AHEAD} === '{DARK}'")
    sensed(viewer, "near", True)
    expect(chip).to_have_attribute("data-value", "on")
    expect(chip).to_have_accessible_name("ada near: true")
    wait(sensing, f"{AHEAD} !== '{DARK}'")
    sensed(viewer, "near", False)
    expect(chip).to_have_attribute("data-value", "off")
    wait(sensing, f"{AHEAD} === '{DARK}'")
    sensed(viewer, "near", None)
    expect(chip).to_have_attribute("data-value", "silent")

    expect(sensing.get_by_role("button", name="Cue")).to_be_visible()
    viewer.show(score_of(analyze("ada $ forward\n")), 2)  # the robot that senses nothing
    viewer.publish(transport(2, "playing"))
    expect(sensing.locator("#senses")).to_be_hidden()
    expect(sensing.get_by_role("button", name="Cue")).to_be_hidden()


def test_senses_are_forced_by_shift_and_a_click_and_given_by_a_button_and_keys(
    sensing: Page, commands: Commands
) -> None:
    chip = sensing.locator(".chip", has_text="wall")
    chip.click()  # without shift, nothing
    for value in (True, None):  # until the next time
        chip.click(modifiers=["Shift"])
        assert asked(commands) == {"type": "force", "robot": "ada", "sense": "wall", "value": value}
        expect(chip).to_have_attribute("data-forced", str(value is not None).lower())

    sensing.get_by_role("button", name="Cue").click()
    assert asked(commands) == {"type": "cue"}
    sensing.keyboard.press("c")
    assert asked(commands) == {"type": "cue"}

    sensing.keyboard.down("l")
    for _ in range(3):  # repeated while it is held
        assert asked(commands) == {"type": "key", "key": "l", "held": True}
    sensing.keyboard.up("l")
    while (command := asked(commands)) == {"type": "key", "key": "l", "held": True}:
        pass
    assert command == {"type": "key", "key": "l", "held": False}
    expect(sensing.locator("#timeline")).to_be_visible()  # which the key L hides otherwise
