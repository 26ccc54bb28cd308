"""Scenes as people choose and name them."""

from __future__ import annotations

from dataclasses import dataclass

from improv_core.program.analysis import Analysis


@dataclass(frozen=True, slots=True)
class Scenes:
    """The scenes from `first` to `last`, counted from 0."""

    first: int
    last: int


def scene_called(analysis: Analysis, scene: int) -> str:
    """Return a name for a scene, counted from 0: `scene 2`, or `scene bow` if that is its name."""
    names = analysis.scene_names
    return f"scene {(names[scene] if scene < len(names) else '') or scene + 1}"
