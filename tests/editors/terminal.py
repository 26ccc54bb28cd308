"""A terminal (tmux) with an editor in it."""

from __future__ import annotations

import re
import subprocess
from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path

from tests.needs import need
from tests.waiting import until


@dataclass(frozen=True, slots=True)
class Cell:
    """A letter on the screen, and its colors: `2;R;G;B`, or `5;N` for a color of the terminal; empty for its own."""

    letter: str
    color: str = ""
    background: str = ""


def written(file: Path) -> str:
    """Wait until a file has text, and return it."""
    until(lambda: file.exists() and file.stat().st_size > 0, lambda: f"nothing has written {file}")
    return file.read_text(encoding="utf-8").strip()


class Terminal:
    """A command in its own terminal, which ends with it: `type` keys by their names, `write` a text, `see` a text on
    the screen."""

    def __init__(
        self, socket: Path, command: list[str], env: Mapping[str, str], size: tuple[int, int] = (120, 24)
    ) -> None:
        self._tmux = [need("tmux"), "-S", str(socket), "-f", "/dev/null", "-u"]
        columns, lines = map(str, size)
        self._run("new-session", "-d", "-x", columns, "-y", lines, *command, env={**env, "COLORTERM": "truecolor"})

    def __enter__(self) -> Terminal:
        return self

    def __exit__(self, *failure: object) -> None:
        if failure[0] is not None:
            self._run("kill-server")

    def type(self, *keys: str) -> None:
        self._run("send-keys", *keys)

    def write(self, text: str) -> None:
        self._run("send-keys", "-l", text)

    def see(self, text: str, there: bool = True) -> None:
        """Wait until the text is on the screen, or no longer there."""
        until(
            lambda: (text in self.screen()) is there,
            lambda: f"{text!r} {'is not' if there else 'is still'} on the screen:\n{self.screen()}",
        )

    def screen(self, colors: bool = False) -> str:
        """Return the text of the screen, with or without the terminal's color sequences."""
        return self._run("capture-pane", "-p", *(["-e", "-N"] if colors else []))

    def background(self, word: str) -> str:
        """Return the background color of the first such word."""
        for line in cells(self.screen(colors=True)):
            start = "".join(cell.letter for cell in line).find(word)
            if start >= 0:
                found = {cell.background for cell in line[start : start + len(word)]}
                assert len(found) == 1, f"{word} has parts of different colors: {found}"
                return found.pop()
        raise AssertionError(f"{word!r} is not on the screen:\n{self.screen()}")

    def _run(self, *words: str, env: Mapping[str, str] | None = None) -> str:
        return subprocess.run([*self._tmux, *words], env=env, check=True, capture_output=True, text=True).stdout


def cells(screen: str) -> list[list[Cell]]:
    """Return the letters of a captured screen, line by line, without its color sequences."""
    lines: list[list[Cell]] = []
    pen = Cell("")
    for line in screen.splitlines():
        lines.append([])
        for sequence, letter in re.findall(r"\x1b\[([\d;]*)m|(.)", line):
            if letter:
                lines[-1].append(replace(pen, letter=letter))
            else:
                pen = _set(pen, sequence)
    return lines


def _set(pen: Cell, sequence: str) -> Cell:
    for code in re.findall(r"[34]8;(?:2;\d+;\d+;\d+|5;\d+)|\d+", sequence or "0"):
        kind = code.split(";")[0]
        if code == "0":
            pen = Cell("")
        elif code == "7":
            pen = replace(pen, color=pen.background, background=pen.color)
        elif kind in ("38", "39"):
            pen = replace(pen, color=code[3:])
        elif kind in ("48", "49"):
            pen = replace(pen, background=code[3:])
        elif re.fullmatch("[39][0-7]", code):
            pen = replace(pen, color=f"5;{int(code[1:]) + 8 * (code[0] == '9')}")
        elif re.fullmatch("(4|10)[0-7]", code):
            pen = replace(pen, background=f"5;{int(code[-1]) + 8 * code.startswith('10')}")
    return pen
