"""A folder with modules that must not be imported: each notes its name if it is."""

from __future__ import annotations

from pathlib import Path

import pytest

MODULES = ("venv", "ensurepip", "pip", "rclpy", "geometry_msgs", "json", "sitecustomize", "usercustomize")
PYTHONPATHS = ("", ":lib:/nowhere:.")
"""Values of PYTHONPATH: none, and one that lets Python import from the current folder in all the ways that an `export`
does."""


class Traps:
    """A folder that people may open or stand in, with foreign modules."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self._notes = folder / "imported"
        for where in (folder, folder / "lib"):
            where.mkdir(exist_ok=True)
            for name in MODULES:
                note = f"with open({str(self._notes)!r}, 'a') as notes:\n    notes.write({name!r} + ' ')\n"
                (where / f"{name}.py").write_text(note)

    def enter(self, monkeypatch: pytest.MonkeyPatch, pythonpath: str) -> None:
        """Work in this folder, with a PYTHONPATH that leads here."""
        monkeypatch.chdir(self.folder)
        monkeypatch.setenv("PYTHONPATH", pythonpath)

    @property
    def imported(self) -> list[str]:
        """The modules that were imported nevertheless."""
        return self._notes.read_text().split() if self._notes.exists() else []
