"""The lines of an `improv.toml` that put a robot's start somewhere else, as one edit of that file."""

from __future__ import annotations

from collections.abc import Iterable

from improv_core.diagnostics import Edit
from improv_core.text import Span
from improv_core.toml_text import Entry, read_toml


def place(text: str, robot: str, x: float, y: float, heading: float, cast: Iterable[str]) -> Edit | None:
    """The edit after which a robot starts at x, y (metres) with this heading (degrees).

    Where no robot is listed yet, all of the `cast` are: a list says which robots there are. None where the file can't
    be read, or has the start in a form of its own.
    """
    toml = read_toml(text)
    if toml.diagnostics:
        return None
    start = f"{{ x = {_number(x)}, y = {_number(y)}, heading = {_number(heading)} }}"
    if known := toml.entries.get(("robots", robot, "start")):
        return Edit(known.value, start) if _is_inline(text, known) else None
    if section := toml.entries.get(("robots", robot)):
        if _is_inline(text, section):
            return None
        end = text.find("\n", section.key.end)
        line = f"start = {start}\n"
        return Edit(Span(end + 1, end + 1), line) if end >= 0 else Edit(Span(len(text), len(text)), f"\n{line}")
    others = () if toml.data.get("robots") else [name for name in cast if name != robot]
    sections = [f"[robots.{robot}]\nstart = {start}\n", *(f"[robots.{name}]\n" for name in others)]
    gap = "" if not text else "\n" if text.endswith("\n") else "\n\n"
    return Edit(Span(len(text), len(text)), gap + "\n".join(sections))


def _is_inline(text: str, entry: Entry) -> bool:
    return text[entry.value.start] == "{"


def _number(value: float) -> str:
    return f"{round(value, 2) + 0.0:g}"
