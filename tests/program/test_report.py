"""What is told of a program in a line."""

from improv_core.program.analysis import analyze
from improv_core.program.report import summary


def test_summary() -> None:
    program = "beat 30\nturtle1 $ repeat 8 forward\nturtle2 $ slow 4 left\n"
    assert summary(analyze(program)) == "turtle1 8 beats · turtle2 4 beats, 16.0 s at beat 30"
    assert summary(analyze("r1 $ left\nr2 $ repeat left")) == "r1 1 beat · r2 ∞, endless at beat 60"
    assert summary(analyze("# nothing")) == "no robot plays"
