"""Files that come with Improv: the dances of the gallery with their pictures, the pages of the tutorial, and songs."""

from __future__ import annotations

import json
import re
from collections.abc import Mapping
from functools import lru_cache
from importlib import resources
from importlib.resources.abc import Traversable
from pathlib import Path

from improv_core.page.guide import guide
from improv_core.preview.window import body_of
from improv_core.program.analysis import analyze
from improv_core.program.compiler import score_of
from improv_core.program.files import ENDING
from improv_core.program.room import prediction_of
from improv_core.robots.config import FILE_NAME, read_robots
from improv_core.score.music import is_song
from improv_core.score.svg import picture
from improv_core.stage.dry_run import predict

THUMBNAIL = 150.0
"""Pixels of the longer side of a picture: about as many as the page shows, so that its lines are no hairlines."""
LEFT_OUT = ("senses/bump",)
"""Programs that can't play on a website, because robots don't bump into anything there."""


@lru_cache
def examples(*, alone: bool = False) -> bytes:
    """Return the programs of the gallery, as JSON: those without an `improv.toml` first, starting with the simplest.
    Only those, if they are to play `alone`. Takes seconds."""
    return json.dumps([_example(*each) for each in _programs() if not (alone and each[2])]).encode()


@lru_cache
def guide_files() -> Mapping[str, bytes]:
    """Return the pages of the tutorial and the exercises, as JSON, and their pictures, by their paths."""
    docs = _repository_folder("docs")
    pages = guide(*((docs / name).read_text(encoding="utf-8") for name in ("tutorial.md", "lesson.md")))
    pictures = {name for page in pages for name in re.findall(r'src="([^"]+)"', page["html"])}
    files = {name: docs.joinpath(*name.split("/")).read_bytes() for name in sorted(pictures)}
    return {"guide.json": json.dumps(pages).encode(), **files}


def songs() -> Mapping[str, bytes]:
    """Return the songs of the gallery, by the paths at which the page looks for songs that an `improv.toml` names."""
    inside = [
        each for folder in _repository_folder("examples").iterdir() if folder.is_dir() for each in folder.iterdir()
    ]
    return {f"songs/{each.name}": each.read_bytes() for each in inside if is_song(each.name)}


def _programs() -> list[tuple[str, Traversable, str]]:
    """Return the folder, the file, and the `improv.toml` of each program."""
    root = _repository_folder("examples")
    folders = {"": root, **{each.name: each for each in root.iterdir() if each.is_dir()}}
    found = [
        (folder, each, (inside / FILE_NAME).read_text(encoding="utf-8") if folder else "")
        for folder, inside in folders.items()
        for each in inside.iterdir()
        if each.name.endswith(ENDING) and f"{folder}/{each.name.removesuffix(ENDING)}" not in LEFT_OUT
    ]
    return sorted(found, key=lambda each: (each[2], len(each[1].read_bytes())))


def _example(folder: str, path: Traversable, toml: str) -> Mapping[str, object]:
    text, name = path.read_text(encoding="utf-8"), path.name.removesuffix(ENDING)
    analysis = analyze(text, read_robots(toml))
    score = score_of(analysis)
    drawn = picture(score, THUMBNAIL, prediction=prediction_of(analysis, score, predict))
    bodies = [body for part in score.parts.values() if (body := body_of(part, score))]
    named = f"{name} ({folder})" if folder else name
    return {"name": named, "text": text, "toml": toml, "picture": drawn, "bodies": bodies}


def _repository_folder(name: str) -> Traversable:
    """Return a folder of the repository that the wheel contains."""
    ours = resources.files("improv_core.page") / name
    return ours if ours.is_dir() else Path(__file__).parents[2] / name
