"""Writes the position of beat 0 in the song into the `improv.toml` that names the song."""

from __future__ import annotations

from pathlib import Path

from improv_core.program.files import ReadError, read_bytes
from improv_core.robots.config import FILE_NAME, find_robots_file
from improv_core.robots.edits import set_first_beat
from improv_core.storage.atomic_write import why
from improv_core.storage.compare_and_swap import swap_text


def write_first_beat(folder: Path, seconds: float) -> str:
    """Write `first_beat` into the `improv.toml` of the programs in a folder. If it can't be written, return one line
    and leave the file as it is."""
    path = find_robots_file(folder)
    by_hand = f"write `first_beat = {round(seconds, 3):g}` into it yourself"
    if not path:
        return f"there is no {FILE_NAME}: {by_hand}"
    try:
        before = read_bytes(path).decode("utf-8-sig")
        made = set_first_beat(before, seconds)
        if made is None:
            return f"{FILE_NAME} has no section [music] that can be changed: {by_hand}"
        if not swap_text(path, before, made):
            return f"another program has just changed {FILE_NAME}: try again"
    except OSError as problem:
        return f"{FILE_NAME}: {why(problem)}: {by_hand}"
    except (ReadError, UnicodeDecodeError):
        return f"{FILE_NAME}: it can't be read: {by_hand}"
    return ""
