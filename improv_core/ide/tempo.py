"""Write the tempo of a program, which people tap on the page, into its line with `beat`."""

from __future__ import annotations

from improv_core.diagnostics import Edit
from improv_core.program.analysis import Analysis
from improv_core.text import Span


def in_tempo(analysis: Analysis, tempo: float) -> tuple[Edit, ...]:
    """Return the edits that give a program this tempo, in beats per minute. A new line is above all others."""
    written = f"{tempo:.10g}"
    statements = [analysis.placed(index) for index in range(len(analysis.statements))]
    for line in statements:
        if line.statement.sign and line.statement.sign.type == "BEAT":
            tokens = line.statement.tokens
            start = line.start + tokens[0].end
            return (Edit(Span(start, line.start + tokens[-1].end), f" {written}"),)
    first = next((line for line in statements if line.statement.sign), None)
    at = analysis.text.rfind("\n", 0, first.start) + 1 if first else len(analysis.text)
    gap = "\n" if not first and analysis.text and not analysis.text.endswith("\n") else ""
    return (Edit(Span(at, at), f"{gap}beat {written}\n"),)
