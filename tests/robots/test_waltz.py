"""The dance with music in the gallery: its script makes its song, which is as long as the dance."""

from __future__ import annotations

import runpy
import wave
from pathlib import Path

from improv_core.program.compiler import score_of
from improv_core.program.files import analyze_file
from improv_core.score.music import Music

FOLDER = Path(__file__).parents[2] / "examples" / "music"


def test_the_script_makes_the_song() -> None:
    made = runpy.run_path(str(FOLDER / "make_waltz.py"))["waltz"]()
    with wave.open(str(FOLDER / "waltz.wav"), "rb") as file:
        kept = file.readframes(file.getnframes())
    assert len(made) == len(kept)
    assert all(abs(one - two) <= 1 for one, two in zip(made, kept, strict=True))  # systems round sines differently


def test_the_dance_is_as_long_as_its_song_and_names_it() -> None:
    analysis = analyze_file(FOLDER / "waltz.improv")
    assert analysis.diagnostics == ()
    score = score_of(analysis)
    assert score.music == Music("waltz.wav", str(FOLDER), 0.25, 0.8)
    with wave.open(str(FOLDER / "waltz.wav"), "rb") as file:
        seconds = file.getnframes() / file.getframerate()
    assert 0.25 + score.seconds(score.beats) < seconds < 0.25 + score.seconds(score.beats + 3)
