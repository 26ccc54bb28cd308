"""The song that pages play: opened only in the folder of its improv.toml."""

from __future__ import annotations

import asyncio
import os
import stat
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, BinaryIO

from improv_core.plain import message as in_plain_text
from improv_core.score.music import CONTENT_TYPES, Music, is_inside, is_song

if TYPE_CHECKING:
    from aiohttp import web

MAX_BYTES = 128 * 1024 * 1024
"""The largest file. As browsers decode it, a song takes several times as much memory."""


class SongError(Exception):
    """There is no song to play. The message is one line for people."""


@dataclass(frozen=True, slots=True)
class Song:
    """An open file, its type, and a tag that changes whenever the file does."""

    file: BinaryIO
    content_type: str
    tag: str


def open_song(music: Music | None) -> Song:
    """Open the file of a song, which may take as long as the disk does. Raises SongError."""
    if not music or not music.file or not music.folder:
        raise SongError("This dance has no song.")
    name = in_plain_text(music.file)
    if not is_song(music.file) or not is_inside(music.file):
        raise SongError(f"{name} can't be played.")
    try:
        folder = Path(os.path.realpath(music.folder, strict=True))
        path = Path(os.path.realpath(folder / music.file, strict=True))
        if not path.is_relative_to(folder):
            raise SongError(f"{name} is a link out of the folder of improv.toml: put the song itself there.")
        if not is_song(path.name):
            raise SongError(f"{name} can't be played.")
        opened = _opened(folder, path.relative_to(folder))
    except FileNotFoundError:
        raise SongError(f"{name} is not beside improv.toml: put it there, and play again.") from None
    except (OSError, ValueError) as problem:
        reason = getattr(problem, "strerror", None) or "its name is not valid"
        raise SongError(f"{name} can't be read: {reason}.") from None
    try:
        about = os.fstat(opened)
        if not stat.S_ISREG(about.st_mode):
            raise SongError(f"{name} is not a file.")
        if about.st_size > MAX_BYTES:
            raise SongError(f"{name} has more than {MAX_BYTES // 1024**2} MB: save it as MP3, or take a part of it.")
        file = os.fdopen(opened, "rb")
    except BaseException:
        os.close(opened)
        raise
    tag = f'"{about.st_mtime_ns:x}-{about.st_size:x}"'
    return Song(file, CONTENT_TYPES[path.suffix.lower()], tag)


def _opened(folder: Path, inside: Path) -> int:
    """Open a file in a folder, by a path without links. If a part of the path becomes a link meanwhile, it is not
    followed, as far as the system can open a file from a folder. Raises OSError."""
    flags = os.O_RDONLY | getattr(os, "O_NONBLOCK", 0) | getattr(os, "O_NOFOLLOW", 0) | getattr(os, "O_BINARY", 0)
    if os.open not in os.supports_dir_fd:
        return os.open(folder / inside, flags)
    *folders, name = inside.parts
    place = os.open(folder, os.O_RDONLY)
    try:
        for part in folders:
            deeper = os.open(part, os.O_RDONLY | os.O_DIRECTORY | os.O_NOFOLLOW, dir_fd=place)
            os.close(place)
            place = deeper
        return os.open(name, flags, dir_fd=place)
    finally:
        os.close(place)


async def serve(request: web.Request, music: Music | None) -> web.StreamResponse:
    """Answer with the song, with 304 if the page has it already, or with a line of text if there is none to play. For
    an error status, browsers would report an error of the page."""
    from aiohttp import web

    try:
        song = await asyncio.to_thread(open_song, music)
    except SongError as problem:
        return web.Response(text=str(problem))
    with song.file:
        headers = {"ETag": song.tag}
        if request.headers.get("If-None-Match") == song.tag:
            return web.Response(status=304, headers=headers)
        answer = web.Response(body=song.file, headers=headers, content_type=song.content_type)
        answer.force_close()  # so that an incomplete song, if the file becomes shorter, doesn't look complete
        await answer.prepare(request)
        await answer.write_eof()
        return answer
