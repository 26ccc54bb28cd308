"""The tutorial, step by step, as people follow it: on the page of `improv edit`, and in a terminal."""

from __future__ import annotations

import json
import re
import shlex
from itertools import pairwise
from pathlib import Path

import pytest
from playwright.sync_api import BrowserContext, Page, expect

from improv_core.program.analysis import analyze
from improv_core.program.compiler import compiled
from tests.commands.command_line import run
from tests.page.conftest import wait
from tests.page.editing import Edit

ROOT = Path(__file__).parents[2]
TUTORIAL = (ROOT / "docs" / "tutorial.md").read_text(encoding="utf-8")


@pytest.mark.slow("plays the whole tutorial")
def test_each_step_does_what_the_tutorial_says(tmp_path: Path, window: BrowserContext) -> None:
    blocks = re.findall(r"^```(\w+)\n(.*?)^```(.*?)(?=^```|\Z)", TUTORIAL, re.M | re.S)
    (_, installing, _), (_, editing, _), (_, template, _), *steps = blocks
    assert installing.strip() in (ROOT / "README.md").read_text(encoding="utf-8")
    assert editing == ".venv/bin/improv edit\n"
    edited = Edit(tmp_path / "dance.improv", window)
    page = edited.page()
    expect(page.locator("#text")).to_have_value(template)
    latest = template
    _plays(page, latest, generation=1)
    expect(page.locator("#highlight .lit").first).to_be_visible()
    generation = 1
    for (kind, block, after), (_, below, _) in pairwise([*steps, ("", "", "")]):
        if kind == "improv":
            page.locator("#text").fill(block)
            latest, generation = block, generation + 1
            _plays(page, latest, generation)
        elif kind == "text" and " meets: " in block:
            _is_fixed_by_a_button(page, block, after, below)
        elif kind == "text":
            _is_fixed_by_a_button(page, block, after, latest, refused_in=generation)
            generation += 1
            _plays(page, latest, generation)
    page.keyboard.press("Escape")
    expect(page.locator("#state")).to_have_text("stopped")
    edited.close()
    assert (tmp_path / "dance.improv").read_text(encoding="utf-8") == latest
    reopening, plotting = (shlex.split(block) for kind, block, _ in steps if kind == "sh")
    assert reopening == [".venv/bin/improv", "edit", "dance.improv"]
    done = run(*(tmp_path / word if word.startswith("dance.") else word for word in plotting[1:]))
    assert (done.returncode, done.stderr) == (0, "")
    assert (tmp_path / "dance.svg").read_text(encoding="utf-8").startswith("<svg")


def _plays(page: Page, program: str, generation: int) -> None:
    """Press Ctrl+Enter, and wait until all robots of the program leave their starts."""
    page.locator("#text").press("Control+Enter")
    robots = compiled(analyze(program))["robots"]
    wait(
        page,
        f"improv.transport.generation === {generation} && Object.keys(improv.robots).join() === '{','.join(robots)}'",
    )
    starts = json.dumps({name: each["start"] for name, each in robots.items()})
    away = "([name, [x, y]]) => Math.hypot(improv.robots[name].x - x, improv.robots[name].y - y) > 0.1"
    page.evaluate("window.left = new Set()")
    wait(
        page,
        f"Object.entries({starts}).filter({away}).every(([name]) => left.add(name)) && left.size === {len(robots)}",
    )


def _is_fixed_by_a_button(page: Page, drawn: str, after: str, program: str, refused_in: int | None = None) -> None:
    """Check that the page shows the error, and that the button in the text after it makes this program.

    A program with an error doesn't play: the program of the generation `refused_in` keeps playing.
    """
    *lines, message = drawn.splitlines()
    page.locator("#text").fill("".join(f"{line}\n" for line in lines))
    if refused_in:
        page.locator("#text").press("Control+Enter")
    expect(page.locator("#diagnostics")).to_contain_text(message.partition(": ")[2])
    if refused_in:
        expect(page.get_by_role("alert").first).to_contain_text("can't play")
        assert page.evaluate("improv.transport.generation") == refused_in
    (button,) = re.findall(r"button \*\*([^*]*)\*\*", re.sub(r"\s+", " ", after))
    page.get_by_role("button", name=button).click()
    expect(page.locator("#text")).to_have_value(program)
