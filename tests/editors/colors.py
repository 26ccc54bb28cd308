"""A program with every kind of word, and its colors in an editor without a server or a grammar."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

_LINES = """\
beat:beat 60:number #:comment why:comment
poly:name n:parameter ( m:parameter ) =:operator ramp:transformer 2:number *:operator n 1.5:number m
---:scene finale:title #:comment why:comment
r:robot s:robot $:operator reflect:transformer YZ:plane poly 4:number left:primitive
||:operator if:conditional not:conditional near up:primitive else:conditional until:transformer cue [ right:primitive ]
x:name =:operator 3:number /:operator 2:number fit:transformer #:comment a:comment /:comment b:comment =:comment
room:opening 6:number 4.5:number #:comment =:comment $:comment
bar:opening 3:number
ada:robot at:robot at:opening -1:number +.5:number facing:opening 90:number /:operator 2:number #:comment why:comment
at:robot is:robot at:opening circle:choice 1.5:number around:opening -0:number 2:number facing:opening in:choice
gus:robot at:opening grid:choice 2:number
---:scene
ada:robot at:robot circle:robot is:opening nao-v6:profile #:comment why:comment
is:robot is:opening is:profile
at:robot circle:robot $:operator room 3:number ||:operator bar 3:number
room:name n:parameter =:operator ( left:primitive (
bar 3:number
at 1:number line ) at circle 2:number
at circle 2:number ( room 3:number
at:name =:operator bar 3:number
r:robot $:operator if:conditional near up:primitive
else:conditional at 3:number up:primitive
||:operator at circle 2:number
"""
_WORDS = [[word.partition(":")[::2] for word in line.split()] for line in _LINES.splitlines()]
PROGRAM = "".join(" ".join(word for word, _ in line) + "\n" for line in _WORDS)


def expected(colors: Mapping[str, str], plain: str = "") -> list[list[str]]:
    """Return each word of the program and its color, given the color of each kind. Words of no kind are plain."""
    return [[word, colors[kind] if kind else plain] for line in _WORDS for word, kind in line]


SCRIPT = """\
filetype plugin on
syntax on
edit!
let s:found = []
for s:row in range(1, line('$'))
  let [s:word, s:column, s:end] = matchstrpos(getline(s:row), '\\S\\+')
  while s:column >= 0
    call add(s:found, [s:word, synIDattr(synID(s:row, s:column + 1, 1), 'name')])
    let [s:word, s:column, s:end] = matchstrpos(getline(s:row), '\\S\\+', s:end)
  endwhile
endfor
call writefile([json_encode(s:found)], $IMPROV_COLORS)
qall!
"""
"""A script that writes each word and its syntax group, in Vim and in Neovim."""


def in_vim_syntax() -> list[list[str]]:
    """Return the words and groups that SCRIPT writes for a program that `improv.vim` colors."""
    kinds = {kind for line in _WORDS for _, kind in line}
    found = expected({kind: f"improv{kind.capitalize()}" for kind in kinds})
    head = len(_WORDS[0]) + next(index for index, (word, _) in enumerate(_WORDS[1]) if word == "=")
    return [
        [word, "improvHead" if place < head and word in "()" else color] for place, (word, color) in enumerate(found)
    ]


def written(folder: Path) -> tuple[Path, Path, dict[str, str]]:
    """Write the program and the script to files. Return their paths, and variables that name the script's output."""
    program, script = folder / "colors.improv", folder / "colors.vim"
    program.write_text(PROGRAM)
    script.write_text(SCRIPT)
    return program, script, {"IMPROV_COLORS": str(folder / "colors.json")}
