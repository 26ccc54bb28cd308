"""The tutorial, the exercises, and the gallery on the website."""

from __future__ import annotations

import json
import re
from pathlib import Path

import pytest
from playwright.sync_api import Page, expect

from improv_core.page.gallery import examples
from improv_core.page.guide import guide
from improv_core.program.analysis import analyze
from improv_core.robots.config import read_robots
from tests.axe import Violations
from tests.page.conftest import Keep, wait
from tests.website.conftest import open_site

DOCS = Path(__file__).parents[2] / "docs"
TUTORIAL, LESSON = ((DOCS / name).read_text(encoding="utf-8") for name in ("tutorial.md", "lesson.md"))
PAGES = guide(TUTORIAL, LESSON)


def test_marks_become_html_and_links_only_words() -> None:
    tutorial = """# Title
## 1. Get Improv
Run it.

## 2. Two <things>
See [there](there.md), **press** `a < b`,
*now*:

```improv
ada $ (left || right)
```
```text
ada $ lft
```
- one
- two
  more

<img src="images/x.svg" alt="x">
"""
    (page,) = guide(tutorial, "# A lesson\n\n## Exercises\nWrite.\n")
    assert (page["part"], page["title"]) == ("Tutorial", "Two <things>")
    assert page["html"].splitlines() == [
        "<p>See there, <b>press</b> <code>a &lt; b</code>,",
        "<i>now</i>:</p>",
        '<pre class="program">ada $ (left || right)',
        "</pre>",
        "<pre>ada $ lft",
        "</pre>",
        "<ul><li>one</li><li>two",
        "  more</li></ul>",
        '<img src="images/x.svg" alt="x">',
    ]


def test_all_steps_and_exercises_are_there_with_their_programs_and_pictures() -> None:
    assert [page["title"] for page in PAGES if page["part"] == "Exercises"] == re.findall(
        r"^### \d+\. (.*)$", LESSON, re.MULTILINE
    )
    assert [page["title"] for page in PAGES if page["part"] == "Tutorial"][:2] == ["Play", "Change it"]
    html = "".join(page["html"] for page in PAGES)
    assert html.count('<pre class="program">') == (TUTORIAL + LESSON).count("```improv")
    assert html.count("<img ") == (TUTORIAL + LESSON).count("<img ")
    assert not re.search(r"\*\*|```|\]\(", html)


def test_the_programs_of_the_gallery_play_there() -> None:
    for example in json.loads(examples()):
        assert analyze(example["text"], read_robots(example["toml"])).ok, example["name"]
        assert example["picture"].startswith("<svg")


@pytest.mark.slow("axe looks at the page in five states")
def test_the_tutorial_stands_beside_the_stage_and_its_programs_play(
    violations: Violations, address: str, page: Page, keep: Keep
) -> None:
    open_site(page, address)
    for name in ("Examples", "Share"):
        page.get_by_role("button", name=name).click()
        expect(page.locator("dialog img:visible").first).to_be_visible()
        assert violations(page) == [], name
        page.keyboard.press("Escape")
        expect(page.locator("dialog[open]")).to_have_count(0)
    page.get_by_role("button", name="Tutorial").click()
    card = page.get_by_role("dialog", name="Tutorial")
    expect(page.get_by_label("Page", exact=True)).to_have_value("1. Play")
    card.get_by_role("button", name="Next page").click()
    card.get_by_role("button", name="Play this").click()
    wait(page, "improv.robots.turtle1?.x > 0.3")
    expect(page.locator("#text")).to_have_value(re.compile("repeat 8"))
    for width, height in ((1280, 800), (768, 1024), (390, 844)):
        page.set_viewport_size({"width": width, "height": height})
        expect(card.get_by_role("button", name="Next page")).to_be_in_viewport(ratio=1)
        # The program that the tutorial explains, but for the fraction of a pixel by which browsers clip its edges.
        expect(page.locator("#paper")).to_be_in_viewport(ratio=0.99)
        expect(page.get_by_role("button", name="Stop")).to_be_in_viewport(ratio=1)
        assert page.evaluate("document.documentElement.scrollWidth <= innerWidth")
        assert violations(page) == [], width
        keep(page, f"site-guide-{width}.png")
    page.get_by_label("Page", exact=True).select_option("1. Stairs")
    card.get_by_text("A solution").click()
    card.get_by_role("button", name="Play this").click()
    wait(page, "improv.robots.ada?.x > 0.3")
    card.get_by_role("button", name="Close").click()
    expect(card).to_be_hidden()
    page.get_by_role("button", name="Tutorial").click()
    expect(page.get_by_label("Page", exact=True)).to_have_value("1. Stairs")
    card.get_by_role("button", name="Close").click()

    page.get_by_role("button", name="Examples").click()
    page.get_by_role("button", name="roamer (senses)").click()
    wait(page, "improv.robots.anna?.x !== undefined")
    page.get_by_role("button", name="Share").click()
    expect(page.get_by_label("improv.toml", exact=True)).to_have_value(re.compile("size = \\[16, 14\\]"))
