"""Reads recordings and drawings by the endings of their names. One line says what is wrong with a file."""

from __future__ import annotations

from pathlib import Path

from improv_core.transcription.csv_source import read_csv
from improv_core.transcription.ros_source import read_recording
from improv_core.transcription.sources import Recording, SourceError
from improv_core.transcription.svg_source import read_svg

MAX_BYTES = 200_000_000
"""No larger file is read."""


def read_source(path: Path, seconds: float, scale: float | None) -> Recording:
    """Read a .csv, .svg, .mcap, or .db3 file. `seconds` and `scale` (meters per unit) are for drawings.

    Raises SourceError, and OSError if there is no such file.
    """
    kind = path.suffix.lower()
    if path.stat().st_size > MAX_BYTES:
        raise SourceError(f"{path}: it is larger than {MAX_BYTES // 1_000_000} MB: cut it")
    if kind in (".csv", ".tsv", ".txt"):
        return read_csv(path)
    if kind == ".svg":
        return read_svg(path, seconds, scale)
    if kind in (".mcap", ".db3"):
        return read_recording(path)
    raise SourceError(f"{path}: name a .csv, .svg, .mcap, or .db3 file")
