"""Find the words that play at a beat, for editors that light them."""

from __future__ import annotations

from collections.abc import Callable
from itertools import islice
from typing import NamedTuple

from improv_core.program.analysis import Analysis
from improv_core.score.movement import Duration, Source, near
from improv_core.score.replay import Replay
from improv_core.text import Span, difference

MAX_WORDS = 2_000
"""The most words of a robot that are lit at once: those of names within names."""


class LitWords(NamedTuple):
    """The words that play, in the order of the text, and the beat until which they do; None if nothing changes."""

    spans: list[Span]
    until: Duration | None


class Places:
    """Finds the words of a program that plays in a later version of its text."""

    def __init__(self, played: Analysis, now: Analysis) -> None:
        self._now = now
        self._indices = {statement: index for index, statement in enumerate(now.statement_ids)}
        self._edited: dict[int, tuple[str, int]] = {}  # by statement: its old text, and the index of its new version
        known, index = set(played.statement_ids), -1
        for statement, was in zip(played.statement_ids, played.statements, strict=True):
            index = self._indices.get(statement, index + 1)
            if (
                statement not in self._indices
                and now.statement_ids[index : index + 1]
                and (now.statement_ids[index] not in known)
            ):
                self._edited[statement] = was.text, index

    def __call__(self, word: Source) -> Span | None:
        """Return the span of a word; None if it was edited or deleted since."""
        if (index := self._indices.get(word.statement)) is not None:
            return word.span.shifted(self._now.offsets[index])
        if word.statement not in self._edited:
            return None
        was, index = self._edited[word.statement]
        text, offset = self._now.statements[index].text, self._now.offsets[index]
        start, end, _ = difference(was, text)
        if word.span.start >= end:
            place = word.span.shifted(len(text) - len(was))
        elif word.span.end <= start:
            place = word.span
        else:
            return None
        beside = text[max(place.start - 1, 0) : place.start] + text[place.end : place.end + 1]
        return None if any(letter.isalnum() for letter in beside) else place.shifted(offset)


def lit_words(
    replay: Replay, beat: float, place: Callable[[Source], Span | None], is_muted: Callable[[str], bool]
) -> LitWords:
    """Return the words that robots play at a beat, except those of silent ones, in the current text."""
    at, until = near(max(beat, 0.0)), None
    spans: set[Span] = set()
    for robot in replay.score.parts:
        if is_muted(robot) or not (moment := replay.now(robot, at)):
            continue
        change = moment.start
        if change <= at:
            change += moment.duration
            spans.update(span for word in islice(moment.sources, MAX_WORDS) if (span := place(word)))
        until = change if until is None else min(until, change)
    return LitWords(sorted(spans), until)
