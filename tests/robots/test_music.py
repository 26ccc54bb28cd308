"""The section `[music]` of an `improv.toml`."""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path

import pytest

from improv_core.program.analysis import analyze
from improv_core.program.compiler import score_of
from improv_core.robots.config import Robots, read_robots
from improv_core.score.music import Music
from improv_core.score.score_json import from_json, to_json


def check(text: str, music: Music | None, *messages: str) -> Robots:
    """Compare the section of an improv.toml in /dances, and its diagnostics."""
    robots = read_robots(text, Path("/dances/improv.toml"))
    assert robots.music == music
    assert [each.message for each in robots.diagnostics] == list(messages)
    return robots


def test_a_song_is_beside_the_file_or_deeper() -> None:
    check("", None)
    check(
        '[music]\nfile = "sounds/Song.WAV"\nfirst_beat = -0.5\nvolume = 0.25',
        Music("sounds/Song.WAV", "/dances", -0.5, 0.25),
    )
    check("[music]\nfirst_beat = 0.35", Music("", "/dances", 0.35))


UNPLAYABLE = "pages can't play this: write a file that ends in `.wav`, `.mp3`, `.ogg`, `.flac`, or `.m4a`"
ELSEWHERE = 'pages can\'t get this: put the song beside this file, and write its name: `"song.mp3"`'


@pytest.mark.parametrize(
    ("message", "files"),
    [
        (UNPLAYABLE, ("song", "song.txt", ".wav")),
        (ELSEWHERE, ("../song.mp3", "/song.mp3", "a/../../song.mp3", "C:/song.mp3", "a\\\\..\\\\song.mp3")),
    ],
)
def test_a_song_that_pages_cannot_play_is_a_warning_and_the_dance_plays(message: str, files: Sequence[str]) -> None:
    for file in files:
        assert check(f'[music]\nfile = "{file}"', Music("", "/dances"), message).ok


def test_a_score_takes_the_song_to_the_stage() -> None:
    robots = read_robots('[music]\nfile = "song.ogg"\nfirst_beat = 0.35', Path("/dances/improv.toml"))
    score = score_of(analyze("ada $ forward", robots))
    assert from_json(json.loads(json.dumps(to_json(score)))).music == score.music == Music("song.ogg", "/dances", 0.35)


def test_a_score_with_a_song_of_another_kind_is_refused() -> None:
    score = json.loads(json.dumps(to_json(score_of(analyze("ada $ forward", read_robots("[music]"))))))
    with pytest.raises(ValueError, match="volume"):
        from_json({**score, "music": {**score["music"], "volume": "loud"}})
