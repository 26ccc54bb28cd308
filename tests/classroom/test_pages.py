"""The pages of a class in a browser: a child's and the teacher's."""

from __future__ import annotations

import json
import os
import signal
import urllib.error
import urllib.request
from zipfile import ZipFile

import pytest
from playwright.sync_api import Page, expect

from improv_core.classroom.roster import PERIOD
from tests.axe import Violations
from tests.classroom.conftest import Running, started
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
def test_a_child_joins_and_sends_and_reads_whether_its_dance_arrived(
    violations: Violations, running: Running, page: Page, keep: Keep
) -> None:
    page.goto(f"{running.address}#class={running.code}")
    page.keyboard.press("Escape")
    expect(page.locator("#class")).to_be_hidden()
    page.get_by_role("button", name="Send", exact=True).click()
    page.get_by_label("Your name").press_sequentially("Ada <img>")
    assert violations(page) == []
    page.locator("#text").evaluate("(text) => { text.value = 'r $ left' }")
    page.get_by_role("button", name="Join").click()  # the child wanted to send, and needn't tap again
    expect(page.locator("#handed-in")).to_contain_text("Ada <img>: Sent at")
    sent = page.evaluate("Date.now()")
    assert page.evaluate("location.hash") == ""
    page.locator("#text").fill("r $ repeat (forward left)\n")
    expect(page.locator("#handed-in")).to_contain_text("Changed since you sent it at")
    page.route("**/class/send", lambda route: route.abort("connectionreset"), times=1)
    page.get_by_role("button", name="Send", exact=True).click()
    expect(page.locator("#handed-in")).to_contain_text("Not received: the class doesn't answer")
    assert violations(page) == []
    page.wait_for_function("([sent, period]) => Date.now() - sent > 1000 * period", arg=[sent, PERIOD])
    page.get_by_role("button", name="Send", exact=True).click()
    expect(page.locator("#handed-in")).to_contain_text("Sent at")
    page.close()
    page = page.context.new_page()  # with neither a save nor a link
    page.goto(running.address)
    expect(page.locator("#text")).to_have_value("r $ repeat (forward left)\n")
    expect(page.locator("#versions")).to_be_hidden()
    expect(page.locator("#handed-in")).to_contain_text("Ada <img>: Sent at")
    for width, height in ((1280, 800), (768, 1024), (390, 844)):
        page.set_viewport_size({"width": width, "height": height})
        tops = [page.get_by_role("button", name=name, exact=True).bounding_box() for name in ("Share", "Send")]
        assert len({top and top["y"] for top in tops}) == 1, width
        expect(page.get_by_role("button", name="Save and play")).to_be_in_viewport(ratio=1)
        assert page.evaluate("document.documentElement.scrollWidth <= innerWidth")
        keep(page, f"class-child-{width}.png")


@pytest.mark.slow("starts a class with its stage, and a browser")
def test_the_tutorial_leaves_the_word_buttons_free_on_a_phone(running: Running, page: Page) -> None:
    assert page.context.browser
    phone = page.context.browser.new_context(viewport={"width": 390, "height": 844}, has_touch=True, is_mobile=True)
    child = phone.new_page()
    child.goto(f"{running.address}#class={running.code}")
    child.get_by_label("Your name").fill("Ada Lovelace")
    child.get_by_role("button", name="Join").tap()
    child.locator("#text").fill("ada $ forward\n")
    child.get_by_role("button", name="Send", exact=True).tap()
    expect(child.locator("#handed-in")).to_contain_text("Sent at")
    child.locator("#text").fill("ada $ forward left\n")
    expect(child.locator("#handed-in")).to_contain_text("Changed since")  # in two lines
    child.get_by_role("button", name="Tutorial").tap()
    child.get_by_role("button", name="left", exact=True).tap(trial=True)
    expect(child.locator("#highlight div").first).to_be_in_viewport(ratio=1)
    phone.close()


@pytest.mark.slow("starts a class with its stage, and a browser")
def test_the_teacher_looks_at_dances_and_plays_and_stops_them(
    violations: Violations, running: Running, page: Page, keep: Keep
) -> None:
    process, address, code, teacher = running
    for name, text in (("Ada <img>", "r $ repeat (forward left)\n"), ("Bo", "s $ forwrd")):
        secret = send(address, "join", json.dumps({"code": code, "name": name}))["secret"]
        send(address, "send", text, secret)
    page.goto(teacher)
    expect(page.locator("#children li")).to_have_count(2)
    expect(page.locator("#children .name").first).to_have_text("Ada <img>")
    expect(page.locator("#children li").first.locator("img")).to_be_visible()
    expect(page.locator("#children .wrong")).to_contain_text("line 1: ")
    page.get_by_label("Choose Bo").check()
    expect(page.get_by_role("button", name="Play the chosen")).to_be_disabled()  # it has an error
    page.get_by_label("Choose Ada").check()
    page.get_by_role("button", name="Play the chosen").click()
    expect(page.locator("#playing")).to_have_text("Ada <img> (without Bo: no dance that plays)")
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
    page.keyboard.press("Escape")
    expect(page.locator("#front")).to_be_hidden()  # as with every card, that is all
    expect(page.locator("#playing")).to_have_text("Ada <img>")
    page.keyboard.press("Escape")  # arrives even if the connection breaks twice
    expect(page.locator("#playing")).to_have_text("Stopped")
    os.kill(process.pid, signal.SIGSTOP)  # as Ctrl-Z in its terminal does
    page.keyboard.press("Escape")
    expect(page.locator("#playing")).to_have_text("The stop is not answered: run `improv stop` in a terminal.")
    os.kill(process.pid, signal.SIGCONT)
    expect(page.locator("#playing")).to_have_text("Stopped")
    page.reload()  # the token is kept for this tab
    expect(page.locator("#children li")).to_have_count(2)
    page.locator("#children .look").last.click()
    expect(page.locator("#front-real")).to_be_hidden()  # this class has no real robots
    expect(page.locator("#front-text")).to_have_text("s $ forwrd")
    send(address, "send", "s $ backward", secret)
    expect(page.locator("#front-line")).to_contain_text("Bo has sent another dance.")
    expect(page.get_by_role("button", name="Play it")).to_be_disabled()  # nothing plays unseen
    expect(page.locator("#front-text")).to_have_text("s $ forwrd")  # it stays
    page.get_by_role("button", name="Close").click()
    hidden = "# \x1b\u202e\r\ns $ backward\r\n"
    send(address, "send", hidden, secret)
    expect(page.locator("#children .line").last).to_contain_text("s 1 beat")
    page.locator("#children .look").last.click()
    expect(page.locator("#front-text")).to_have_text("# \\u{1b}\\u{202e}\ns $ backward\n")
    with page.expect_download() as download:
        page.get_by_role("button", name="Save as a file").click()
    assert download.value.path().read_bytes() == hidden.encode()  # the page shows escapes, but doesn't save them
    page.get_by_role("button", name="Send out…", exact=True).click()
    expect(page.locator("#sure")).to_contain_text("Send out Bo?")
    page.get_by_role("button", name="Keep").click()
    expect(page.locator("#children li")).to_have_count(2)
    page.get_by_role("button", name="Send out…", exact=True).click()
    page.get_by_role("button", name="Send out", exact=True).click()
    expect(page.locator("#children li")).to_have_count(1)
    page.get_by_label("Choose Ada").uncheck()  # a tick outlives loading the page again, too
    page.get_by_role("button", name="Choose all").click()
    page.get_by_role("button", name="Send out the chosen").click()
    page.get_by_role("button", name="Send out", exact=True).click()
    expect(page.locator("#children li")).to_have_count(0)
    expect(page.get_by_role("button", name="Send out the chosen")).to_be_hidden()


@pytest.mark.slow("starts a class with its stage, and a browser")
def test_a_tick_and_the_last_dance_that_plays_outlive_the_next_ones(running: Running, page: Page, keep: Keep) -> None:
    process, address, code, teacher = running
    page.goto(teacher)
    expect(page.get_by_role("img", name="QR code")).to_be_in_viewport(ratio=1)
    assert page.get_by_role("img", name="QR code").evaluate("(code) => code.clientWidth > innerHeight / 2")
    secret = send(address, "join", json.dumps({"code": f"{code[:3]} {code[3:]}", "name": "Анна"}))["secret"]
    expect(page.locator("#children li")).to_have_count(1)
    assert page.get_by_role("img", name="QR code").evaluate("(code) => code.clientWidth < 200")
    page.get_by_label("Choose Анна").check()
    look = page.locator("#children .look")
    expect(look).to_have_text("Аннаhas sent nothing yet")
    expect(look).to_be_disabled()
    keep(page, "class-teacher-nothing-sent.png")
    send(address, "send", "r $ left", secret)
    expect(page.locator("#children .line").first).to_contain_text("r 1 beat")
    expect(look).to_be_enabled()
    send(address, "send", "r $ lft", secret)
    expect(page.locator("#children .wrong")).to_contain_text("The latest: line 1: ")
    expect(page.get_by_label("Choose Анна")).to_be_checked()
    expect(page.locator("#children img")).to_be_visible()  # of the one that plays
    page.get_by_role("button", name="Play the chosen").click()
    expect(page.locator("#playing")).to_have_text("Анна")
    with page.expect_popup() as opened:
        page.get_by_role("button", name="Open the stage").click()
    expect(opened.value.get_by_role("button", name="Mute Анна")).to_be_visible()  # Anna is the name of her robot
    opened.value.close()
    page.locator("#children .look").click()
    expect(page.locator("#front-text")).to_have_text("r $ lft")
    page.get_by_role("button", name="The last one that plays").click()
    expect(page.locator("#front-text")).to_have_text("r $ left")
    with page.expect_download() as download:
        page.get_by_role("button", name="Close").click()
        page.get_by_role("button", name="Save all dances").click()
    with ZipFile(download.value.path()) as saved:
        assert {name: saved.read(name) for name in saved.namelist()} == {
            "001-Анна.improv": b"r $ left",
            "001-Анна-latest.improv": b"r $ lft",
        }
    page.goto("about:blank")  # the next class would refuse its old token
    process.terminate()
    process.communicate(timeout=60)
    with started(process.args) as again:  # the class continues
        page.goto(again.teacher)
        expect(page.get_by_label("Choose Анна")).to_be_checked()
        expect(page.get_by_role("button", name="Play the chosen")).to_be_enabled()


@pytest.mark.slow("starts a class with its stage, and a browser")
def test_a_new_tab_is_the_same_child_and_an_old_ticket_opens_nothing(running: Running, page: Page, keep: Keep) -> None:
    process, address, code, teacher = running
    page.goto(f"{address}#class={code}")
    refused = {"problem": "write your name with letters"}
    page.route("**/class/join", lambda route: route.fulfill(json=refused), times=1)
    page.get_by_role("button", name="Join").click()
    expect(page.locator("#class-line")).to_have_text("write your name with letters")
    page.get_by_label("Your name").fill("🦖")
    page.get_by_role("button", name="Join").click()
    expect(page.locator("#handed-in")).to_have_text("🦖: Not sent yet.")
    expect(page.locator("#class-line")).to_be_empty()  # the dialog opens again if the child has to join again
    tab = page.context.new_page()
    tab.goto(f"{address}#class={code}")  # the QR code once more
    expect(tab.locator("#handed-in")).to_have_text("🦖: Not sent yet.")
    expect(tab.locator("#class")).to_be_hidden()
    tab.get_by_role("button", name="Send", exact=True).click()
    expect(tab.locator("#handed-in")).to_contain_text("🦖: Sent at")
    tab.get_by_role("button", name="Not 🦖?").click()
    tab.get_by_label("Your name").fill("Bo")
    tab.get_by_role("button", name="Join").click()
    for each in (tab, page):
        expect(each.locator("#handed-in")).to_contain_text("Bo: ")
    third = page.context.new_page()
    third.goto(f"{address}#class={code}")
    expect(third.locator("#handed-in")).to_contain_text("Bo: ")
    with third.expect_request("**/class/here", timeout=20_000):  # its next regular sign is due after 30 s
        tab.goto(teacher)
    expect(tab.locator("#children .name")).to_have_text(["🦖", "Bo"])
    expect(tab.locator("#children .when").first).to_contain_text("not here")
    expect(tab.locator("#count")).to_have_text("1 child is here. 1 was here before.")
    page.goto("about:blank")
    third.close()
    expect(tab.locator("#count")).to_have_text("Nobody is here. 2 were here before.")
    expect(tab.get_by_label("Choose Bo")).to_be_visible()  # the code doesn't take the place of the dances again
    keep(tab, "class-teacher-closed-pages.png")
    third = page.context.new_page()
    third.goto(address)
    expect(tab.locator("#count")).to_have_text("1 child is here. 1 was here before.")
    tab.get_by_label("Choose Bo").check()
    tab.get_by_role("button", name="Send out the chosen").click()
    tab.get_by_role("button", name="Send out", exact=True).click()
    expect(tab.locator("#children .name")).to_have_text(["🦖"])
    third.evaluate("document.dispatchEvent(new Event('visibilitychange'))")  # it asks now rather than within 30 s
    expect(third.locator("#handed-in")).to_have_text("You are no longer in the class: tap Send to join again.")
    third.get_by_role("button", name="Send", exact=True).click()
    expect(third.get_by_label("Your name")).to_have_value("Bo")
    expect(third.get_by_label("Code of the room")).to_have_value("")  # one tap doesn't bring Bo back
    keep(third, "class-join-again.png")
    third.close()
    page.goto(teacher)
    expect(page.locator("#playing")).to_have_text("This address opens the page once. The terminal shows another one.")
    assert process.stdout
    page.goto(process.stdout.readline().split()[1])  # teacher: URL (opens once)
    expect(page.locator("#children .name")).to_have_text(["🦖"])
    tab.close()
