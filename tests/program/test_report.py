"""What is told of a program in a line."""

from pathlib import Path

from improv_core.diagnostics import Diagnostic
from improv_core.program.analysis import analyze
from improv_core.program.report import as_annotation, summary
from improv_core.text import LineIndex, Span


def test_summary() -> None:
    program = "beat 30\nturtle1 $ repeat 8 forward\nturtle2 $ slow 4 left\n"
    assert summary(analyze(program)) == "turtle1 8 beats · turtle2 4 beats, 16.0 s at beat 30"
    assert summary(analyze("r1 $ left\nr2 $ repeat left")) == "r1 1 beat · r2 ∞, endless at beat 60"
    assert summary(analyze("# nothing")) == "no robot plays"


def test_github_accepts_no_columns_of_a_place_on_several_lines() -> None:
    several = Diagnostic("empty-group", Span(1, 5), "50% is empty")
    assert as_annotation(Path("/a,b.improv"), LineIndex("abc\ndef"), several) == (
        "::warning title=empty-group,file=/a%2Cb.improv,line=1,endLine=2"
        "::/a,b.improv:1:2: warning[empty-group] 50%25 is empty"
    )
