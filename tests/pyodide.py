"""Stand-in for the npm package `pyodide`, for tests in which no browser runs Python."""

from __future__ import annotations

import zipfile
from pathlib import Path

from improv_core.website.build import LIBRARY, PYODIDE


def imitate(folder: Path) -> Path:
    """Make the folder, with small files."""
    folder.mkdir()
    for name in PYODIDE:
        (folder / name).write_text("")
    with zipfile.ZipFile(folder / LIBRARY, "w") as library:
        library.writestr("re/__init__.py", "")
        library.writestr("unittest/mock.py", "")
    return folder
