"""Links to the page that explains the code of a diagnostic."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cache
from pathlib import Path

_PAGES = (
    Path(__file__).parent / "diagnostics.md",  # as installed
    Path(__file__).parent.parent / "docs" / "diagnostics.md",  # in a clone of the repository
)
_HEADING = "## "


def href(code: str) -> str | None:
    """Return the URL of the section about a code in the page that came with this version; None if there is none.

    It is a file: an editor opens it at the line, also without a network, and over SSH on the server's machine.
    """
    return _sections().get(code)


@cache
def _sections() -> Mapping[str, str]:
    for page in _PAGES:
        if page.is_file():
            lines = enumerate(page.read_text(encoding="utf-8").splitlines(), 1)
            return {
                line.removeprefix(_HEADING): f"{page.as_uri()}#L{number}"
                for number, line in lines
                if line.startswith(_HEADING)
            }
    return {}
