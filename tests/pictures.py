"""The pictures of paths in the documents, as `improv plot` draws them. `python -m tests.pictures` draws them again.

A picture shows the program above it, with the `improv.toml` above that, if there is one.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path

from improv_core.program.analysis import analyze
from improv_core.program.compiler import score_of
from improv_core.robots.config import read_robots
from improv_core.score.svg import plot

DOCS = Path(__file__).parent.parent / "docs"
_PROGRAM_AND_PICTURE = re.compile(
    r'(?:```toml\n([^`]*)```\n\n)?```improv\n([^`]*)```\n\n<img src="(images/[\w-]+\.svg)"'
)


def pictures() -> Iterator[tuple[Path, str]]:
    """Each picture's file, and what it must contain."""
    for page in sorted(DOCS.glob("*.md")):
        for robots, program, file in _PROGRAM_AND_PICTURE.findall(page.read_text(encoding="utf-8")):
            yield DOCS / file, plot(score_of(analyze(program, read_robots(robots)))) + "\n"


if __name__ == "__main__":
    for path, picture in pictures():
        path.write_text(picture, encoding="utf-8")
        print(path.relative_to(DOCS.parent))
