"""Checks of `improv doctor` for editors: they must find the language server and be new enough."""

from __future__ import annotations

import re
import shutil
from collections.abc import Iterator, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

from improv_core.commands.finding import Finding, absent, good
from improv_core.ipc.child import output
from improv_core.storage.atomic_write import real

VERSION_LIMIT = 10.0
"""Seconds a program may take to report its version."""


def server(path: str, scripts: Path) -> Finding:
    """Report whether editors find our language server on the PATH."""
    found, own = shutil.which("improv-ls", path=path), scripts / "improv-ls"
    if not found:
        return absent("improv-ls is not on the PATH", f"add {scripts} to it, for editors")
    if real(Path(found)) != real(own):
        return absent(f"{found} is another Improv's", f"put {scripts} before it on the PATH")
    return good(f"improv-ls for editors: {found}")


def editors(path: str) -> Iterator[Finding]:
    """Report the installed editors with an Improv extension, and those that are too old."""
    programs = {
        name: next(filter(None, (shutil.which(each, path=path) for each in commands)), None)
        for name, (commands, _) in EDITORS.items()
    }
    with ThreadPoolExecutor() as pool:
        versions = dict(zip(programs, pool.map(_version, programs.values()), strict=True))
    for name, program in programs.items():
        least, version = EDITORS[name][1], versions[name]
        if program and not version:
            yield absent(f"{name} does not report its version", f"make sure `{program} --version` works")
        elif version and version < least:
            yield absent(f"{name} {_dotted(version)}", f"Improv needs {_dotted(least)} or newer")
        elif version:
            yield good(f"{name} {_dotted(version)}")
    if missing := [name for name, program in programs.items() if not program]:
        yield absent(f"no {', no '.join(missing)}", "any editor works with `improv watch FILE`")


EDITORS: Mapping[str, tuple[Sequence[str], tuple[int, ...]]] = {
    "VS Code": (("code", "codium"), (1, 91)),
    "Neovim": (("nvim",), (0, 10)),
    "Helix": (("hx", "helix"), (25, 7)),
    "Emacs": (("emacs",), (30,)),
    "Vim": (("vim",), (9,)),
}
"""Commands of each editor, and the oldest version that its extension supports."""


def _version(program: str | None) -> tuple[int, ...]:
    """Return the version a program reports; empty if there is none."""
    if not program:
        return ()
    try:
        printed = output([program, "--version"], VERSION_LIMIT)
    except OSError:
        return ()
    said = re.search(rb"\d+(\.\d+)+", printed)
    return tuple(map(int, said[0].split(b"."))) if said else ()


def _dotted(version: Sequence[int]) -> str:
    return ".".join(map(str, version))
