"""Reads the section `[music]` of an `improv.toml`: the song that pages play."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from improv_core.robots.toml_reading import TomlReading
from improv_core.score.music import CONTENT_TYPES, Music, is_inside, is_song


def read_music(reading: TomlReading, table: Mapping[str, Any], path: Path | None) -> Music:
    """Read the section in the file at `path`. Without a valid `file`, there is no song: a dance plays without its song,
    so this is only a warning."""
    values = reading.values(("music",), table)
    file = values.get("file", "")
    if file and not is_song(file):
        reading.warn_value(("music", "file"), f"pages can't play this: write a file that ends in {_endings()}")
        file = ""
    elif not is_inside(file):
        reading.warn_value(
            ("music", "file"), 'pages can\'t get this: put the song beside this file, and write its name: `"song.mp3"`'
        )
        file = ""
    folder = str(path.parent) if path and path.is_absolute() else ""  # otherwise, there is no file
    song = values.get("first_beat", 0.0), values.get("volume", 1.0), values.get("count_in", False)
    return Music(file, folder, *song)


def _endings() -> str:
    *others, last = (f"`{each}`" for each in CONTENT_TYPES)
    return f"{', '.join(others)}, or {last}"
