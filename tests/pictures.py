"""The pictures of paths in the documents, as `improv plot` draws them. `python -m tests.pictures` draws them again.

A picture in a link shows the target of the link. A picture in the cell of a table shows the code above it there, with
the names of the program above. Any other picture shows the program above it in its section, with the `improv.toml`
there. If there is no program above it, it shows the one below it: the solution of an exercise. If the name of a picture
ends in `-timeline`, it has the timeline too.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path

from improv_core.program.analysis import Analysis, analyze
from improv_core.program.compiler import score_of
from improv_core.program.files import analyze_file
from improv_core.program.room import prediction_of
from improv_core.robots.config import read_robots
from improv_core.score.svg import picture, plot
from improv_core.stage.dry_run import predict

DOCS = Path(__file__).parent.parent / "docs"
SIZE = 280.0
"""The longer side of a plot, in pixels: pages show it as it is, so that names can be read."""
SMALL = 170.0
"""The longer side of a picture in a table."""
_PICTURE = re.compile(
    r"(?:`(?P<code>[^`\n]+)`<br>|(?P<link>\[))?"
    r'<img src="(?P<file>images/[\w/-]+\.svg)"[^>]*>'
    r"(?(link)\]\((?P<target>[^)]+)\))"
)


def pictures() -> Iterator[tuple[Path, str]]:
    """Yield each picture's file, and its expected content."""
    for page in sorted(DOCS.glob("*.md")):
        for section in re.split(r"^(?=##+ )", page.read_text(encoding="utf-8"), flags=re.MULTILINE):
            for found in _PICTURE.finditer(section):
                yield DOCS / found["file"], _drawn(section, found)


def _drawn(section: str, found: re.Match[str]) -> str:
    if found["target"]:
        return _plot(analyze_file(DOCS / found["target"]), found["file"])
    above = section[: found.start()]
    program = (_blocks("improv", above) or _blocks("improv", section)[:1])[-1]
    if found["code"]:
        names = "".join(line for line in program.splitlines(keepends=True) if "$" not in line)
        return picture(score_of(analyze(f"{names}robot $ {found['code']}")), SMALL) + "\n"
    return _plot(analyze(program, read_robots("".join(_blocks("toml", above)))), found["file"])


def _blocks(kind: str, text: str) -> list[str]:
    return re.findall(rf"^```{kind}\n(.*?)^```", text, re.DOTALL | re.MULTILINE)


def _plot(analysis: Analysis, file: str) -> str:
    timeline = file.endswith("-timeline.svg")
    score = score_of(analysis)
    prediction = prediction_of(analysis, score, predict)
    return plot(score, timeline=timeline, size=SIZE, prediction=prediction) + "\n"


if __name__ == "__main__":
    for path, drawn in pictures():
        path.parent.mkdir(exist_ok=True)
        path.write_text(drawn, encoding="utf-8")
        print(path.relative_to(DOCS.parent))
