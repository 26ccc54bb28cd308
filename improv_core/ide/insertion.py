"""Write the words for a gesture into a program: at the cursor, or as a robot's line."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from fractions import Fraction
from typing import NamedTuple

from improv_core.diagnostics import Edit, applied
from improv_core.ide.bending import Word, poses_at
from improv_core.ide.cursor import cursor
from improv_core.program.analysis import Analysis
from improv_core.program.compiler import score_of
from improv_core.program.program import Placed
from improv_core.score.motion import Pose
from improv_core.score.movement import Source
from improv_core.score.primitives import rest_text
from improv_core.text import Span


class Gap(NamedTuple):
    """A place for words within a movement: the offset, and what has to stand around them."""

    offset: int
    before: str
    after: str

    def filled(self, words: str) -> Edit:
        return Edit(Span(self.offset, self.offset), f"{self.before}{words}{self.after}")


def gap_at(analysis: Analysis, offset: int) -> Gap | None:
    """Return the place behind the word that the cursor touches, and its measure; None if it is in no movement."""
    text = analysis.text
    placed = analysis.statement_at(len(text[:offset].rstrip(" \t")))
    sign = placed.statement.sign if placed else None
    if not placed or not sign or placed.statement.kind not in ("DOLLAR", "EQUAL") or offset - placed.start < sign.end:
        return None
    found = cursor(analysis, offset)
    word = next((each for each in found.around if isinstance(each, Word)), None) if found else None
    touched = [each for each in placed.statement.tokens if each.start < offset - placed.start <= each.end]
    at = placed.start + word.span.end if word else placed.start + touched[-1].end if touched else offset
    before, after = text[at - 1 : at], text[at : at + 1]
    return Gap(at, "" if before in " ([" else " ", "" if not after or after in " \r\n)]" else " ")


def poses_in(analysis: Analysis, gap: Gap) -> Mapping[str, Pose]:
    """Return the poses in which robots get to a place within a movement: none if no robot does, or while the program
    has errors."""
    probed = analysis.edited(gap.offset, gap.offset, gap.filled("rest").text)
    placed = probed.statement_at(gap.offset + len(gap.before))
    if not placed or not analysis.ok or not probed.ok:
        return {}
    start = gap.offset + len(gap.before) - placed.start
    return poses_at(score_of(probed), Source(probed.statement_ids[placed.index], Span(start, start + len("rest"))))


def as_line(analysis: Analysis, robot: str, words: str, begin: Fraction = Fraction(0)) -> Iterator[Edit]:
    """Yield the edits that have a robot play words in the last scene, instead of what it plays there from a beat on."""
    scene = len(analysis.scenes)
    first = (analysis.scenes[-1] if analysis.scenes else -1) + 1
    below = [analysis.placed(index) for index in range(first, len(analysis.statements))]
    played = (each for each in below if each.statement.kind == "DOLLAR")
    lines = [each for each in played if robot in [head.text for head in each.statement.heads]]
    text, end = analysis.text, "\r\n" if "\r\n" in analysis.text else "\n"
    kept = begin - Fraction(analysis.begins[scene]) if scene < len(analysis.begins) else begin
    if kept > 0:
        words = f"{_until(analysis, lines, robot, kept)} {words}"
    for number, line in enumerate(lines):
        sign, code = line.statement.sign, Span(line.start, line.start + line.statement.tokens[-1].end)
        assert sign
        if number:
            yield _without(analysis, line, robot)
        elif len(line.statement.heads) == 1:
            yield Edit(Span(line.start + sign.end, code.end), f" {words}")
        else:
            yield _without(analysis, line, robot)
            newline = text.find("\n", code.end)
            at = len(text) if newline < 0 else newline - (text[newline - 1] == "\r")
            yield Edit(Span(at, at), f"{end}{robot} $ {words}")
    if not lines:
        at = len(text) - len(end) * text.endswith(end)
        yield Edit(Span(at, at), f"{end if at else ''}{robot} $ {words}")


def _without(analysis: Analysis, line: Placed, robot: str) -> Edit:
    """Return the edit after which a robot no longer plays a line: without its name, or without the line."""
    heads = line.statement.heads
    if len(heads) == 1:
        return Edit(analysis.lines.whole(line.span), "")
    index = next(index for index, each in enumerate(heads) if each.text == robot)
    is_last = index + 1 == len(heads)
    cut = heads[index - 1].end if is_last else heads[index].start
    stop = heads[index].end if is_last else heads[index + 1].start
    return Edit(Span(line.start + cut, line.start + stop), "")


def _until(analysis: Analysis, lines: Sequence[Placed], robot: str, beats: Fraction) -> str:
    """Return words for the first beats of what a robot plays in lines, with a rest if it plays for less."""
    words, left = list[str](), beats
    for line in lines:
        played, sign = analysis.played.get(line.index), line.statement.sign
        if not played or not sign or not left:
            continue
        code = line.statement.text[sign.end : line.statement.tokens[-1].end].strip()
        part = dict(played.parts)[robot]
        if part.open or part.duration > left:
            cut = _performed(analysis, line, f" ({code} || {rest_text(left)})")
            return " ".join([*words, cut.strip()])
        words.append(f"({code})" if "||" in code else code)
        left -= Fraction(part.duration)
    return " ".join([*words, *([rest_text(left)] if left else [])])


def _performed(analysis: Analysis, line: Placed, words: str) -> str:
    """Return words in place of those of a line, without any that are never performed there."""
    assert line.statement.sign
    start = line.start + line.statement.sign.end
    probed = analysis.edited(start, line.start + line.statement.tokens[-1].end, words)
    lost = [each for each in probed.diagnostics if each.code == "never-performed" and each.fixes]
    edits = [edit for each in lost for edit in each.fixes[0].edits if start <= edit.span.start < start + len(words)]
    here = [Edit(edit.span.shifted(-start), edit.text) for edit in edits]
    return re.sub(r"(?<=\S) +(?=[)\]]| )", "", applied(words, here))
