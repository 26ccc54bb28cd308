"""The song of a dance, as the page's server serves it: its clients and its folder."""

from __future__ import annotations

import http.client
import os
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from urllib.parse import quote, urlsplit

import pytest

from improv_core.outputs.simulator.simulator import Simulator
from improv_core.page import song_file
from improv_core.page.server import PageServer
from improv_core.page.song_file import SongError, open_song
from improv_core.program.analysis import analyze
from improv_core.program.compiler import score_of
from improv_core.score.music import Music
from tests.page.conftest import LIMIT, TOKEN

SONG = bytes(range(256)) * 8


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """A folder with a song, and files around it that must not get out."""
    (tmp_path / "secret.wav").write_bytes(b"secret")
    folder = tmp_path / "dances"
    (folder / "sounds").mkdir(parents=True)
    (folder / "song.wav").write_bytes(SONG)
    (folder / "sounds" / "deep.ogg").write_bytes(SONG)
    (folder / "notes.txt").write_bytes(b"secret")
    return folder


@pytest.fixture
def playing(folder: Path) -> Iterator[PageServer]:
    """Run a page's server with a dance whose song is song.wav."""
    viewer = PageServer(0, Simulator().snapshot, lambda command: None, token=TOKEN)
    show(viewer, Music("song.wav", str(folder)))
    yield viewer
    viewer.close()


def show(viewer: PageServer, music: Music | None) -> None:
    viewer.show(replace(score_of(analyze("ada $ forward")), music=music), 1)


def ask(viewer: PageServer, token: str = TOKEN, path: str = "/song", **headers: str) -> http.client.HTTPResponse:
    connection = http.client.HTTPConnection("127.0.0.1", urlsplit(viewer.address).port or 0, timeout=LIMIT)
    sent = {name.replace("_", "-"): value for name, value in headers.items()}
    connection.request("GET", f"{path}?token={quote(token)}", headers=sent)
    return connection.getresponse()


def check(viewer: PageServer, music: Music | None, line: str) -> None:
    """Check the line that the server sends if there is no song."""
    show(viewer, music)
    answer = ask(viewer)
    assert (answer.headers["Content-Type"], answer.read().decode()) == ("text/plain; charset=utf-8", line)


def test_a_page_with_its_token_gets_the_song(playing: PageServer) -> None:
    answer = ask(playing)
    assert (answer.status, answer.headers["Content-Type"], answer.read()) == (200, "audio/wav", SONG)


def test_nobody_gets_the_song_without_the_token(playing: PageServer) -> None:
    assert ask(playing, token="another").status == 403
    assert ask(playing, Origin="http://example.org").status == 403
    assert ask(playing, Host="example.org").status == 403


def test_a_page_that_has_the_song_is_not_sent_it_again_until_it_changes(playing: PageServer, folder: Path) -> None:
    tag = ask(playing).headers["ETag"]
    assert (ask(playing, If_None_Match=tag).status, ask(playing, If_None_Match=tag).read()) == (304, b"")
    (folder / "song.wav").write_bytes(SONG[1:])
    assert ask(playing, If_None_Match=tag).read() == SONG[1:]


def test_a_song_may_be_deeper_in_the_folder_or_empty(playing: PageServer, folder: Path) -> None:
    show(playing, Music("sounds/deep.ogg", str(folder)))
    assert ask(playing).read() == SONG
    (folder / "sounds" / "deep.ogg").write_bytes(b"")
    assert (ask(playing).status, ask(playing).read()) == (200, b"")


def test_nothing_from_outside_of_the_folder_is_sent(playing: PageServer, folder: Path) -> None:
    (folder / "link.wav").symlink_to(folder.parent / "secret.wav")
    (folder / "links").symlink_to(folder.parent)
    (folder / "text.wav").symlink_to(folder / "notes.txt")
    (folder / "own.wav").symlink_to(folder / "song.wav")
    for file in ("link.wav", "links/secret.wav"):
        line = f"{file} is a link out of the folder of improv.toml: put the song itself there."
        check(playing, Music(file, str(folder)), line)
    check(playing, Music("text.wav", str(folder)), "text.wav can't be played.")
    for file in ("../secret.wav", str(folder.parent / "secret.wav"), "notes.txt"):
        check(playing, Music(file, str(folder)), f"{file} can't be played.")
    show(playing, Music("own.wav", str(folder)))
    assert ask(playing).read() == SONG


@pytest.mark.parametrize("swapped", ["sounds", "sounds/deep.ogg"])
def test_a_link_that_replaces_the_found_file_is_not_followed(
    folder: Path, monkeypatch: pytest.MonkeyPatch, swapped: str
) -> None:
    outside, found = folder.parent / "outside", os.path.realpath
    (outside / "sounds").mkdir(parents=True)
    (outside / "sounds" / "deep.ogg").write_bytes(b"secret")
    with open_song(Music("sounds/deep.ogg", str(folder))).file as song:
        assert song.read() == SONG

    def found_and_swapped(path: str, *, strict: bool) -> str:
        real = found(path, strict=strict)
        if real.endswith("deep.ogg"):
            (folder / swapped).rename(folder / "before")
            (folder / swapped).symlink_to(outside / swapped)
        return real

    monkeypatch.setattr(os.path, "realpath", found_and_swapped)
    with pytest.raises(SongError, match=r"^sounds/deep.ogg can't be read"):
        open_song(Music("sounds/deep.ogg", str(folder)))


def test_one_line_says_why_there_is_no_song(playing: PageServer, folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    check(playing, None, "This dance has no song.")
    check(playing, Music(), "This dance has no song.")
    check(playing, Music("song.wav"), "This dance has no song.")
    gone = "gone.wav is not beside improv.toml: put it there, and play again."
    check(playing, Music("gone.wav", str(folder)), gone)
    (folder / "folder.wav").mkdir()
    check(playing, Music("folder.wav", str(folder)), "folder.wav is not a file.")
    check(playing, Music("\0.wav", str(folder)), "\\x00.wav can't be played.")
    (folder / "loop.wav").symlink_to(folder / "loop.wav")
    check(playing, Music("loop.wav", str(folder)), "loop.wav can't be read: Too many levels of symbolic links.")
    os.mkfifo(folder / "pipe.wav")
    check(playing, Music("pipe.wav", str(folder)), "pipe.wav is not a file.")
    monkeypatch.setattr(song_file, "MAX_BYTES", 1024)
    large = "song.wav has more than 0 MB: save it as MP3, or take a part of it."
    check(playing, Music("song.wav", str(folder)), large)


def test_a_page_can_ask_for_the_time(playing: PageServer) -> None:
    assert float(ask(playing, path="/time").read()) > 1e9
    assert ask(playing, token="another", path="/time").status == 403
