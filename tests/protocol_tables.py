"""The tables of docs/protocol.md, from the types of messages. `python -m tests.protocol_tables` writes them again."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from inspect import cleandoc
from pathlib import Path
from typing import Any

from improv_core.protocol.commands import COMMANDS, Conduct
from improv_core.protocol.decoding import by_type
from improv_core.protocol.messages import FromStage, ToStage
from improv_core.protocol.page_messages import ForPages
from improv_core.score.json_types import hints_of, required_of

FILE = Path(__file__).parent.parent / "docs" / "protocol.md"
TABLES: dict[str, Any] = {"To the stage": ToStage, "Messages for pages": ForPages, "From the stage": FromStage}
"""The messages in the table below each heading. Those from the stage are described only there."""


def text() -> str:
    """Return the whole document with tables of today."""
    document = FILE.read_text(encoding="utf-8")
    for heading, rows in {**{heading: _messages(heading) for heading in TABLES}, "Commands": _commands()}.items():
        found = re.search(rf"^##+ {heading}\n(?:[^|#\n].*\n|\n)*((?:\|.*\n)+)", document, re.MULTILINE)
        assert found, f"there is no table below {heading}"
        document = document[: found.start(1)] + "".join(f"{row}\n" for row in rows) + document[found.end(1) :]
    return document


def _messages(heading: str) -> Iterator[str]:
    yield "| type | fields | meaning |"
    yield "|---|---|---|"
    messages, described = by_type(TABLES[heading]), by_type(FromStage) if heading != "From the stage" else {}
    for kind, message in messages.items():
        if kind not in described:
            yield f"| `{kind}` | {_fields(message)} | {_meaning(message)} |"
    if same := [kind for kind in messages if kind in described]:
        yield f"| {_names(same)} | as [from the stage](#from-the-stage) | |"


def _fields(message: Any) -> str:
    fields = [name for name in hints_of(message) if name != "type"]
    required = _names([name for name in fields if name in required_of(message)])
    optional = _names([name for name in fields if name not in required_of(message)])
    return "; ".join(filter(None, [required, optional and f"optional: {optional}"]))


def _meaning(message: Any) -> str:
    """Return the first paragraph of a type's docstring, in one line."""
    return " ".join(cleandoc(message.__doc__ or "").partition("\n\n")[0].split()).replace("|", "\\|")


def _names(names: Sequence[str]) -> str:
    return ", ".join(f"`{name}`" for name in names)


def _commands() -> Iterator[str]:
    yield "| command | from | properties | makes void |"
    yield "|---|---|---|---|"
    for row in COMMANDS.values():
        properties = {
            "stops robots, ahead of all that waits": row.stops,
            "obeyed at once by the stage whose node it reaches": row.at_once and "ros" in row.by,
            "done by the parent": row.name not in by_type(Conduct),
            "kept for later stages": row.kept,
            "the simulator beside real robots gets what they sensed instead": row.as_sensed,
        }
        what = "; ".join(text for text, holds in properties.items() if holds)
        voids = " ".join(f"`{each}`" for each in sorted(row.voids))
        yield f"| `{row.name}` | {', '.join(row.by)} | {what} | {voids} |".replace("  ", " ")


if __name__ == "__main__":
    FILE.write_text(text(), encoding="utf-8")
