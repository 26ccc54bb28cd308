"""Film a session in Neovim: `python -m tests.editors.neovim.film docs/images/neovim.gif`.

Needs tmux, Neovim 0.12 (`tests/editors/fetch.sh nvim-0.12`), `pip install pillow` and Debian's fonts-dejavu-core.
"""

from __future__ import annotations

import sys
import time
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from tempfile import TemporaryDirectory

from PIL import Image, ImageDraw, ImageFont

from tests.editors.editors import ROOT, find, nothing_left
from tests.editors.terminal import Cell, Terminal, cells

SIZE = (64, 11)
"""The size of the screen in columns and lines."""
KEY = 0.07
"""Seconds between two keys, as somebody types."""
FRAME = 0.1
"""Seconds between two looks at the screen."""
FONTS = Path("/usr/share/fonts/truetype/dejavu")
HEIGHT = 16
"""The size of a letter, in pixels."""
EDGE = 8
"""Pixels around the screen."""
COLOR, BACKGROUND = "2;224;226;234", "2;20;22;27"
INIT = f"""
vim.opt.runtimepath:prepend("{ROOT}/editors/neovim")
require("improv").setup {{
  cmd = {{ "{sys.executable}", "-m", "improv_ls" }},
  settings = {{ backend = "sim", page = {{ open = false }} }},
}}
vim.o.statusline = " %f%=%{{v:lua.require'improv'.statusline()}} "
vim.o.showmode, vim.o.ruler, vim.o.showcmd = false, false, false
vim.diagnostic.config {{ virtual_text = true, signs = false }}
"""
SCRIPT: tuple[tuple[str, float], ...] = (  # the typed keys, and the seconds to film after them
    ("i# Two robots, one square", 0.2),
    ("\n", 0.1),
    ("beat 90\n\n", 0.2),
    ("square = repeat 4 (forward left)\n", 0.3),
    ("turtle1 $ repeat square\n", 0.2),
    ("turtle2 $ repeat retrograde square", 0.3),
    ("\x1b:w\n", 6.0),
    ("2k0f(lcwforwrd\x1b", 0.8),
    (":w\n", 3.0),
    ("u", 0.6),
    ("jA || repeat (rest left)\x1b", 0.4),
    (":w\n", 5.0),
    (":ImprovHush\n", 1.5),
)


@dataclass(frozen=True, slots=True)
class Look:
    """The screen and the cursor at a time in seconds."""

    time: float
    screen: str
    cursor: tuple[int, int]


def main() -> None:
    with TemporaryDirectory() as folder, nothing_left() as env:
        init = Path(folder, "init.lua")
        init.write_text(INIT)
        (Path(folder) / "dance.improv").touch()
        env |= {f"XDG_{kind}_HOME": folder for kind in ("CONFIG", "DATA", "STATE", "CACHE")} | {"LANG": "C.UTF-8"}
        neovim = find("NVIM_0_12", "nvim-0.12/usr/bin/nvim")
        start = f"cd {folder} && exec {neovim} -i NONE -n -u {init} dance.improv"
        with Terminal(Path(folder, "tmux"), ["sh", "-c", start], env, SIZE) as terminal:
            terminal.see("Improv")
            looks = list(_session(terminal))
            terminal.write(":q\n")
    _save(looks, Path(sys.argv[1]))


def _session(terminal: Terminal) -> Iterator[Look]:
    for keys, pause in SCRIPT:
        for key in keys:
            terminal.write(key)
            yield from _look(terminal, KEY)
        yield from _look(terminal, pause)


def _look(terminal: Terminal, seconds: float) -> Iterator[Look]:
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        yield Look(time.monotonic(), terminal.screen(colors=True), terminal.cursor())
        time.sleep(max(min(FRAME, end - time.monotonic()), 0))


def _save(looks: list[Look], path: Path) -> None:
    changes = looks[:1] + [new for old, new in pairwise(looks) if (new.screen, new.cursor) != (old.screen, old.cursor)]
    frames = _with_one_palette([_drawn(look) for look in changes])
    times = [look.time for look in changes] + [changes[-1].time + 2.0]
    durations = [round((end - start) * 1000) for start, end in pairwise(times)]
    frames[0].save(path, save_all=True, append_images=frames[1:], duration=durations, loop=0, optimize=True)
    print(f"{path}: {len(frames)} frames, {sum(durations) / 1000:.0f} s, {path.stat().st_size // 1000} KB")


def _drawn(look: Look) -> Image.Image:
    fonts = [ImageFont.truetype(FONTS / f"DejaVuSansMono{kind}.ttf", HEIGHT - 1) for kind in ("", "-Bold")]
    width, height = round(fonts[0].getlength("m")), HEIGHT + 5
    image = Image.new("RGB", (SIZE[0] * width + 2 * EDGE, SIZE[1] * height + 2 * EDGE), _rgb(BACKGROUND))
    draw = ImageDraw.Draw(image)
    letters = []
    for row, line in enumerate(cells(look.screen)):
        for column, cell in enumerate(line + [Cell(" ")] * (SIZE[0] - len(line))):
            colors = _rgb(cell.color or COLOR), _rgb(cell.background or BACKGROUND)
            color, background = reversed(colors) if (column, row) == look.cursor else colors
            x, y = EDGE + column * width, EDGE + row * height
            draw.rectangle((x, y, x + width, y + height), background)
            letters.append(((x, y + 1), cell.letter, color, fonts[cell.bold]))
    for letter in letters:  # last, as some are wider than their cells
        draw.text(*letter)
    return image


def _with_one_palette(images: list[Image.Image]) -> list[Image.Image]:
    """Give all pictures one small palette, so that the file holds only the changes between them."""
    width, height = images[0].size
    few = images[:: len(images) // 8]
    together = Image.new("RGB", (width, height * len(few)))
    for index, image in enumerate(few):
        together.paste(image, (0, index * height))
    palette = together.quantize(64, dither=Image.Dither.NONE)
    return [image.quantize(palette=palette, dither=Image.Dither.NONE) for image in images]


def _rgb(color: str) -> tuple[int, int, int]:
    kind, *values = map(int, color.split(";"))
    if kind != 2:
        raise ValueError(f"{color} is a color of the terminal: the editor was to use its own")
    return values[0], values[1], values[2]


if __name__ == "__main__":
    main()
