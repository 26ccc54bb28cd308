"""The timeline below a picture of a dance, as SVG: a bar for each moment, beats, and scenes. Standard library only."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from html import escape

from improv_core.score.movement import ENDLESS, Source
from improv_core.score.score import Score
from improv_core.score.strokes import ENDLESS_BEATS, MAX_STROKES, pictured
from improv_core.score.suppositions import certain_beats
from improv_core.score.walk import walk

_HEAD, _ROW = 14.0, 30.0
"""The heights of the beats' row, and of a robot's, in pixels."""
_LETTER = 6.0
"""The approximate width of a letter in the beats' row."""
_QUIET = "#808080"


def drawn_beats(score: Score) -> float:
    """Return the number of beats that pictures show of a score."""
    longest = pictured(score).beats
    return float(ENDLESS_BEATS if longest == ENDLESS else max(longest, 1))


def bars(score: Score, colors: Mapping[str, str], left: float, top: float, width: float) -> tuple[str, float]:
    """Return a row for each robot, with a bar for each moment as wide as it lasts, and the total height."""
    assumed, score = score, pictured(score)
    beats = drawn_beats(score)
    height = _HEAD + len(score.parts) * _ROW
    shapes = [*_beat_row(score, beats, left, top, width, height)]
    for place, (name, part) in enumerate(score.parts.items()):
        y = top + _HEAD + 12 + place * _ROW
        shapes.append(f'<text x="{left:g}" y="{y:.1f}" fill="{colors[name]}">{escape(name)}</text>')
        doubtful = certain_beats(assumed.parts[name].movement, part.movement, MAX_STROKES)
        for count, moment in enumerate(walk(part.movement)):
            if moment.start >= beats or count == MAX_STROKES:
                break
            x = left + float(moment.start) / beats * width
            wide = max(min(float(moment.duration), beats - float(moment.start)) / beats * width - 1, 0.5)
            faint = 0.2 if not any(moment.velocity) else 0.8 if moment.start < doubtful else 0.4
            title = " || ".join(_words(score, moment.sources)) or "rest"
            shapes.append(
                f'<rect x="{x:.1f}" y="{y + 3:.1f}" width="{wide:.1f}" height="10" rx="2"'
                f' fill="{colors[name]}" fill-opacity="{faint}"><title>{escape(title)}</title></rect>'
            )
    return "".join(shapes), height + 12


def _beat_row(score: Score, beats: float, left: float, top: float, width: float, height: float) -> Iterator[str]:
    """Yield lines where scenes and bars begin, and the names of scenes and numbers of beats that have room."""
    named = [score.scene_names[index] if index < len(score.scene_names) else "" for index in range(score.scenes)]
    shown = [name or f"scene {number}" for number, name in enumerate(named, 1)] if len(named) > 1 or any(named) else []
    begins = [*map(float, score.scene_begins), beats]
    labels = {
        begin: name if (end - begin) / beats * width > len(name) * _LETTER else ""
        for begin, end, name in zip(begins, begins[1:], shown[score.scene :], strict=False)
    }
    step = 1
    while step / beats * width < (len(f"{beats:.0f}") + 2) * _LETTER:
        step *= 2
    taken = [(beat, beat + (len(name) + 2) * _LETTER / width * beats) for beat, name in labels.items() if beat < beats]
    for number in range(0, int(beats), step):
        if not any(begin - step < number < end for begin, end in taken):
            labels[float(number)] = str(number + 1)
    if score.bar and score.bar / beats * width > _LETTER:
        labels = {**dict.fromkeys(map(float, range(0, int(beats) + 1, score.bar)), ""), **labels}
    for beat, label in labels.items():
        if beat < beats:
            x = left + beat / beats * width
            is_bar = score.bar and beat % score.bar == 0
            faint = 0.8 if is_bar else 0.3
            yield f'<path d="M{x:.1f} {top:.1f}v{height:.1f}" stroke="{_QUIET}" stroke-opacity="{faint}"/>'
            if label:
                yield f'<text x="{x + 2:.1f}" y="{top + 9:.1f}" fill="{_QUIET}" font-size="10">{escape(label)}</text>'


def _words(score: Score, sources: Sequence[Source]) -> list[str]:
    placed = [(score.offsets[statement], span) for statement, span in sources if statement in score.offsets]
    return [score.text[start + span.start : start + span.end] for start, span in placed]
