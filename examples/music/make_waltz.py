"""Makes waltz.wav, a click track with a tune for waltz.improv beside it: `python make_waltz.py`. Change its notes."""

from __future__ import annotations

import math
import wave
from pathlib import Path

RATE = 8_000
"""Samples a second: enough for a small file."""
TEMPO, BEATS_PER_BAR = 144, 3
FIRST_BEAT = 0.25
"""Seconds before the first note."""
BASS = "C G C G  F C G C  F C G C"
TUNE = "e5 g5 e5 d5  f5 e5 d5 c5  a5 g5 d5 c5"
NOTES = {"c": -9, "d": -7, "e": -5, "f": -4, "g": -2, "a": 0, "b": 2}
"""Half tones above a, of the same octave."""


def frequency(note: str, octave: int) -> float:
    """In hertz."""
    return 440 * 2 ** (NOTES[note.lower()] / 12 + octave - 4)


def add(song: list[float], beat: float, hertz: float, seconds: float, loud: float) -> None:
    """A tone that begins at a beat and fades away."""
    start = round((FIRST_BEAT + beat * 60 / TEMPO) * RATE)
    for place in range(round(seconds * RATE)):
        time = place / RATE
        tone = math.sin(2 * math.pi * hertz * time) + 0.3 * math.sin(4 * math.pi * hertz * time)
        song[start + place] += loud * tone * min(time / 0.004, 1) * math.exp(-4 * time / seconds)


def waltz() -> bytes:
    """The samples, one byte each, in steps of two: a third less once they are packed."""
    bars = BASS.split()
    beats = len(bars) * BEATS_PER_BAR
    song = [0.0] * round((FIRST_BEAT + (beats + 2) * 60 / TEMPO) * RATE)
    for bar, (bass, note) in enumerate(zip(bars, TUNE.split(), strict=True)):
        first = bar * BEATS_PER_BAR
        add(song, first, frequency(bass, 3), 0.5, 0.35)
        add(song, first, frequency(note[0], int(note[1])), 1.0, 0.22)
        for beat in range(BEATS_PER_BAR):
            add(song, first + beat, 1_568 if beat == 0 else 1_047, 0.05, 0.2)
            if beat:
                add(song, first + beat, frequency(bass, 4), 0.25, 0.12)
                add(song, first + beat, frequency(bass, 4) * 2 ** (4 / 12), 0.25, 0.12)
    return bytes(min(max(128 + 2 * round(63.5 * value), 0), 254) for value in song)


if __name__ == "__main__":
    with wave.open(str(Path(__file__).with_name("waltz.wav")), "wb") as file:
        file.setnchannels(1)
        file.setsampwidth(1)
        file.setframerate(RATE)
        file.writeframes(waltz())
