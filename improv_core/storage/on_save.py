"""The answer to an offer that is made once: saves continue the dance, in editors whose settings don't say it."""

from __future__ import annotations

from contextlib import suppress
from pathlib import Path
from typing import Literal, cast

from improv_core.storage.atomic_write import replacing
from improv_core.storage.history import folder

Answer = Literal["", "offered", "continue", "restart"]
"""Nothing yet; offered, without an answer; or what a save does with a dance."""


def read() -> Answer:
    """Return the answer that was kept; none if it can't be read."""
    with suppress(OSError, UnicodeError):
        kept = _file().read_text("utf-8").strip()
        if kept in ("offered", "continue", "restart"):
            return cast(Answer, kept)
    return ""


def keep(answer: Answer) -> None:
    """Keep an answer. If that fails, it counts for this session only."""
    with suppress(OSError):
        _file().parent.mkdir(0o700, parents=True, exist_ok=True)
        with replacing(_file(), private=True) as kept:
            kept.write(f"{answer}\n".encode())


def _file() -> Path:
    return folder().with_name("on_save")
