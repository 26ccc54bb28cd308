"""A song that pages play with a dance. Standard library only."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import PurePosixPath

CONTENT_TYPES = {
    ".wav": "audio/wav",
    ".mp3": "audio/mpeg",
    ".ogg": "audio/ogg",
    ".flac": "audio/flac",
    ".m4a": "audio/mp4",
}
"""The endings of the names of files that pages can play, and their types."""


@dataclass(frozen=True, slots=True)
class Music:
    """A song. Beat 0 of the dance is `first_beat` seconds after the beginning of its file; `volume` is from 0 to 1.

    `file` is written relative to `folder`, which holds an `improv.toml`. It is empty if people choose one on the page;
    `folder` is empty if there are no files. With `count_in`, a bar is counted before the dance begins.
    """

    file: str = ""
    folder: str = ""
    first_beat: float = 0.0
    volume: float = 1.0
    count_in: bool = False


def is_song(file: str) -> bool:
    """Return whether the name of a file ends as that of a song does."""
    return PurePosixPath(file).suffix.lower() in CONTENT_TYPES


def is_inside(file: str) -> bool:
    """Return whether a path, as it is written, stays in the folder that it starts from."""
    path = PurePosixPath(file)
    return not path.is_absolute() and ".." not in path.parts and not set(file) & set("\\:\0")
