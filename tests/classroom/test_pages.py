"""The pages of a class in a browser: a child's and the teacher's."""

from __future__ import annotations

import json
import urllib.error
import urllib.request

import pytest
from playwright.sync_api import Page, expect

from tests.axe import violations
from tests.classroom.conftest import Running
from tests.page.conftest import Keep


def send(address: str, what: str, body: str, secret: str = "") -> dict[str, str]:
    headers = {"Origin": address.rstrip("/"), "Authorization": f"Bearer {secret}"}
    asked = urllib.request.Request(f"{address}class/{what}", body.encode(), headers)
    while True:
        try:
            with urllib.request.urlopen(asked, timeout=60) as answer:
                return dict(json.load(answer))
        except urllib.error.HTTPError as problem:
            if problem.code != 429:  # a child may send once a second
                raise


@pytest.mark.slow("starts a class with its stage, and a browser")
def test_a_child_joins_and_sends_and_the_teacher_plays_and_stops(running: Running, page: Page, keep: Keep) -> None:
    _, address, code, teacher = running
    page.goto(f"{address}#class={code}")
    page.keyboard.press("Escape")
    expect(page.locator("#class")).to_be_hidden()
    page.get_by_role("button", name="Send", exact=True).click()
    page.get_by_label("Your name").press_sequentially("Ada <img>")
    assert violations(page) == []
    page.get_by_role("button", name="Join").click()
    expect(page.locator("#handed-in")).to_have_text("You are in the class as Ada <img>.")
    assert page.evaluate("location.hash") == ""
    page.locator("#text").fill("r $ repeat (forward left)\n")
    page.get_by_role("button", name="Send", exact=True).click()
    expect(page.locator("#handed-in")).to_contain_text("Sent at")
    for width, height in ((1280, 800), (390, 844)):
        page.set_viewport_size({"width": width, "height": height})
        expect(page.get_by_role("button", name="Save and play")).to_be_in_viewport(ratio=1)
        assert page.evaluate("document.documentElement.scrollWidth <= innerWidth")
        keep(page, f"class-child-{width}.png")

    secret = send(address, "join", json.dumps({"code": code, "name": "Bo"}))["secret"]
    send(address, "send", "s $ forwrd", secret)
    page.goto(teacher)
    expect(page.locator("#children li")).to_have_count(2)
    expect(page.locator("#children .name").first).to_have_text("Ada <img>")
    expect(page.locator("#children li").first.locator("img")).to_be_visible()
    expect(page.locator("#children .wrong .line")).to_contain_text("line 1: ")
    page.get_by_label("Choose Bo").check()
    expect(page.get_by_role("button", name="Play the chosen")).to_be_disabled()  # it has an error
    page.get_by_label("Choose Ada").check()
    page.get_by_role("button", name="Play the chosen").click()
    expect(page.locator("#playing")).to_have_text("Ada <img>")
    for width, height in ((1280, 800), (390, 844)):
        page.set_viewport_size({"width": width, "height": height})
        expect(page.get_by_role("button", name="Stop")).to_be_in_viewport(ratio=1)
        assert page.evaluate("document.documentElement.scrollWidth <= innerWidth")
        assert violations(page) == []
        keep(page, f"class-teacher-{width}.png")
    page.locator("#children .look").first.click()
    expect(page.locator("#front-text")).to_have_text("r $ repeat (forward left)")
    expect(page.locator("#front-stop")).to_be_in_viewport(ratio=1)
    page.locator("#front-stop").click()  # the dance covers the other one
    expect(page.locator("#playing")).to_have_text("Stopped")
    page.get_by_role("button", name="Play it").click()
    expect(page.locator("#playing")).to_have_text("Ada <img>")
    page.locator("#children .look").first.click()
    assert violations(page) == []
    lost = [1, 2]
    page.route("**/stop?*", lambda route: route.abort("connectionreset") if lost and lost.pop() else route.continue_())
    page.keyboard.press("Escape")  # also while a dance is in front, even if the connection breaks twice
    expect(page.locator("#playing")).to_have_text("Stopped")
    page.reload()  # the token is kept for this tab
    expect(page.locator("#children li")).to_have_count(2)
    page.locator("#children .look").last.click()
    expect(page.locator("#front-real")).to_be_hidden()  # this class has no real robots
    send(address, "send", "s $ backward", secret)
    expect(page.locator("#front-line")).to_contain_text("Bo has sent another dance.")
    expect(page.locator("#front-text")).to_have_text("s $ forwrd")  # the dance in front stays
    page.get_by_role("button", name="Close").click()
    hidden = "# \x1b\u202e\r\ns $ backward\r\n"
    send(address, "send", hidden, secret)
    expect(page.locator("#children .line").last).to_contain_text("s 1 beat")
    page.locator("#children .look").last.click()
    expect(page.locator("#front-text")).to_have_text("# \\u{1b}\\u{202e}\ns $ backward\n")
    with page.expect_download() as download:
        page.get_by_role("button", name="Save as a file").click()
    assert download.value.path().read_bytes() == hidden.encode()  # the page shows escapes, but doesn't save them
    page.get_by_role("button", name="Send out", exact=True).click()
    expect(page.locator("#children li")).to_have_count(1)
    page.get_by_label("Choose Ada").check()
    page.get_by_role("button", name="Send out the chosen").click()
    expect(page.locator("#children li")).to_have_count(0)
    expect(page.get_by_role("button", name="Send out the chosen")).to_be_disabled()


@pytest.mark.slow("starts a class with its stage, and a browser")
def test_a_problem_with_joining_is_gone_once_a_child_has_joined(running: Running, page: Page) -> None:
    page.goto(f"{running.address}#class={running.code}")
    refused = {"problem": "write your name with letters"}
    page.route("**/class/join", lambda route: route.fulfill(json=refused), times=1)
    page.get_by_role("button", name="Join").click()
    expect(page.locator("#class-line")).to_have_text("write your name with letters")
    page.get_by_label("Your name").fill("Ada")
    page.get_by_role("button", name="Join").click()
    expect(page.locator("#handed-in")).to_have_text("You are in the class as Ada.")
    expect(page.locator("#class-line")).to_be_empty()  # the dialog opens again if the child has to join again
