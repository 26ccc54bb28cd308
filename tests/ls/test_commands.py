"""The commands that show the page, play again, give the cue, and hold keys."""

from __future__ import annotations

import threading
from collections.abc import Iterator
from pathlib import Path
from typing import Any
from urllib.parse import urlsplit

import pytest

from improv_ls import performance
from tests.ls.client import LIMIT, QUIET, TOLD, Client, Message
from tests.open_page import token_behind

URI = "file:///dance.improv"


@pytest.fixture
def client() -> Iterator[Client]:
    with Client(QUIET) as client:
        yield client


def test_the_saved_program_plays_again(client: Client) -> None:
    client.command("restart")
    assert client.wait_for_line("improv.restart") == (
        "improv.restart: nothing has been played yet; save a program or use improv.play"
    )
    played = client.play(URI, "r $ forward\n")
    client.change(URI, 2, {"text": "r $ lft\n"})
    client.command("restart")
    assert client.wait_for_line("▶") == played


def test_the_cue_is_given() -> None:
    with Client(QUIET, TOLD) as waiting:
        nobody = "improv.cue: no robot waits for the cue"
        waiting.command("cue")
        waiting.wait_for_line(nobody)
        waiting.play(URI, "r $ repeat left\n")
        waiting.command("cue")
        waiting.wait_for_line(nobody)
        waiting.change(URI, 2, {"text": "beat 240\nr $ until cue (repeat left)\n"})
        waiting.save(URI)
        waiting.wait_for_line("▶")
        waiting.wait("improv/transport", lambda params: params["state"] == "playing")
        assert waiting.command("cue") is None
        waiting.wait("improv/transport", lambda params: params["state"] == "ended")


def test_a_recording_becomes_words(client: Client, tmp_path: Path) -> None:
    client.command("transcribe", "walk.csv")
    client.wait_for_line("improv.transcribe: expected the full paths of recordings or drawings")
    table = tmp_path / "walk.csv"
    table.write_text("t,x,y,heading\n" + "".join(f"{number / 20},{number / 10},0,0\n" for number in range(21)))
    assert client.command("transcribe", str(table)) == "walk at 0 0\n\nwalk $ forward\n"
    client.wait_for_line("walk is at most 0 cm and 0° off")
    assert client.command("transcribe", str(tmp_path / "none.csv")) is None
    client.wait_for_line(f"{tmp_path / 'none.csv'}: ")


def test_the_server_says_how_to_calibrate(client: Client, tmp_path: Path) -> None:
    client.command("calibrate")
    client.wait_for_line("improv.calibrate: list your robots in improv.toml first")
    (tmp_path / "improv.toml").write_text("[robots.bert]\n[robots.anna]\n")
    client.open((tmp_path / "dance.improv").as_uri(), "anna $ left\n")
    client.command("calibrate")
    line = client.wait_for_line("calibrate NAME")
    assert line.startswith(f"in a terminal in {tmp_path}, run `")
    assert line.endswith("improv calibrate NAME` (one of anna, bert)")


def test_the_key_of_a_sense_is_held_until_it_is_released(tmp_path: Path) -> None:
    (tmp_path / "improv.toml").write_text('[senses.go]\nkey = "g"\n[senses.halt]\nkey = "h"\n')
    uri = (tmp_path / "dance.improv").as_uri()
    with Client(QUIET, TOLD) as waiting:
        waiting.command("key", "g")
        waiting.wait_for_line("improv.key: nothing plays; save a program first")
        waiting.open(uri, "r $ repeat (until go (repeat left) until not go (repeat forward))\n")

        def wait_until_lit(start: int, end: int) -> None:
            waiting.wait("improv/lit", lambda lit: lit["ranges"] == [[0, start, 0, end]])

        waiting.save(uri)
        wait_until_lit(29, 33)  # nobody has touched that key, so it is not held
        for wrong in ("x", "G", ""):
            waiting.command("key", wrong)
            waiting.wait_for_line("improv.key: expected the key of a sense, one of g, h")
        waiting.command("key", "g")
        waiting.wait_for_line("g is held; the same command releases it")
        wait_until_lit(56, 63)
        waiting.command("key", "g")
        waiting.wait_for_line("g is released")
        wait_until_lit(29, 33)
        for _ in range(2):  # a stop releases it, too
            waiting.command("key", "g")
            waiting.wait_for_line("g is held")
            waiting.command("stop")
            waiting.wait("improv/transport", lambda params: params["state"] == "stopped")
            waiting.save(uri)
            waiting.wait("improv/transport", lambda params: params["state"] == "playing")


def test_the_page_can_be_shown_before_anything_plays(client: Client) -> None:
    urls = [client.command("page"), *client.wait_for_page()]
    client.play(URI, "r $ forward\n")
    urls.append(client.command("page"))
    urls += client.wait_for_page(2)[1:]
    assert len(set(urls)) == 4
    assert {opens(url) for url in urls} == {True}
    assert {opens(url) for url in urls} == {False}


def opens(url: str) -> bool:
    """Return whether a URL opens the page."""
    assert url.startswith("http://127.0.0.1:")
    assert len(f"page: {url}") <= 80
    return bool(token_behind(url))


def test_the_page_keeps_its_port_when_the_server_starts_again_in_its_folder(tmp_path: Path) -> None:
    def port(client: Client) -> int | None:
        return urlsplit(str(client.command("page"))).port

    with Client(QUIET, folders=[tmp_path]) as client:
        usual = port(client)
    with Client(QUIET, folders=[tmp_path]) as client, Client(QUIET, folders=[tmp_path]) as another:
        assert port(client) == usual
        assert port(another) != usual


@pytest.mark.parametrize("without", [{"capabilities": {}}, {"screen": False}])
def test_an_editor_that_can_not_show_the_page_gets_its_address(without: Any) -> None:
    """Without a screen, Helix answers that it has shown the page, and then its line about the browser hides the
    address."""
    with Client(QUIET, **without) as client:
        assert opens(client.command("page"))
        assert opens(client.wait_for_line("page").removeprefix("page: "))
        assert client.shown == []


@pytest.mark.parametrize(
    "refusal",
    [{}, {"result": {"success": False}}, {"result": None}, {"error": {"code": -32603, "message": "no browser"}}],
)
def test_if_the_editor_fails_to_show_the_page_its_address_is_given(refusal: Message) -> None:
    with Client({"backend": "sim"}) as client:
        client.replies["window/showDocument"] = refusal
        client.open(URI, "r $ forward\n")
        client.save(URI)
        (url,) = client.wait_for_page()
        said = client.wait_for_line("page").removeprefix("page: ")
        assert said != url  # others may have seen that one
        assert opens(said)
        assert opens(client.command("page"))


def test_a_save_that_waits_for_real_robots_says_so(monkeypatch: pytest.MonkeyPatch) -> None:
    is_known = threading.Event()

    def find(setting: str | None, *, proves: bool) -> None:
        is_known.wait(LIMIT)

    monkeypatch.setattr(performance, "SLOW", 0.0)
    monkeypatch.setattr(performance, "find_ros_python", find)
    with Client({**QUIET, "backend": "auto"}) as client:
        client.open(URI, "r $ forward\n")
        client.save(URI)
        assert client.wait_for_line("ROS 2").startswith("dance.improv waits until ROS 2 and the standby process")
        is_known.set()
        assert client.wait_for_line("▶").endswith("simulator")


@pytest.mark.parametrize("python", ["/nowhere/python", "/nowhere\n/python"])
def test_without_a_stage_there_is_no_page_and_one_line_says_why(python: str) -> None:
    with Client({"backend": "ros", "ros": {"python": python}}) as client:
        assert client.command("page") is None
        assert client.wait_for_line("/nowhere").startswith("Improv can't play: ")
