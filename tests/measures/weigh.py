"""Lines of each package, of the page's folders, and of tests; words of documents."""

from __future__ import annotations

import subprocess
from collections import Counter
from collections.abc import Iterator
from pathlib import Path, PurePosixPath

CODE = {".py", ".js", ".mjs", ".lua", ".el"}
PAGE = {".js", ".css", ".html"}


def table(root: Path) -> Iterator[str]:
    """Yield one row for each package or folder, then the sums. Only files that git tracks count, with all their
    lines."""
    amounts: Counter[tuple[str, str]] = Counter()
    files: Counter[tuple[str, str]] = Counter()
    tracked = subprocess.check_output(["git", "-C", str(root), "ls-files", "-z"], text=True).split("\0")
    for name in filter(None, tracked):
        if key := _kind(PurePosixPath(name)):
            text = (root / name).read_text(encoding="utf-8")
            amounts[key] += len(text.split()) if key[0] == "docs, words" else text.count("\n")
            files[key] += 1
    for key in sorted(amounts):
        yield f"{amounts[key]:7} {files[key]:4} files  {': '.join(filter(None, key))}"
    for kind in sorted({kind for kind, _ in amounts}):
        yield f"{sum(amount for key, amount in amounts.items() if key[0] == kind):7} {'':10}  {kind}, all"


def _kind(path: PurePosixPath) -> tuple[str, str] | None:
    """Return the kind of a file, and the package or folder in whose row it counts; None if it isn't counted."""
    top, end = path.parts[0], path.suffix
    if top == "improv_core" and end in PAGE and "static" in path.parts:
        return "page files", "/".join(path.parts[path.parts.index("static") + 1 : -1]) or "."
    if top in {"improv_core", "improv_ls"} and end == ".py":
        return "Python", path.parts[1] if top == "improv_core" and len(path.parts) > 2 else top
    if top == "tests" and end in CODE:
        return "tests", path.parts[1] if len(path.parts) > 2 else "."
    if top == "docs" and end == ".md":
        return "docs, words", ""
    return None
