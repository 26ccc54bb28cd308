"""The tutorial and the exercises as pages beside the stage, as HTML.

Only the Markdown of these two documents is known: headings, paragraphs, lists, programs, pictures, and details.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from html import escape
from typing import TypedDict

NOT_HERE = ("Get Improv", "Keep it", "Where to go next")
"""Sections of the tutorial about a computer on which Improv is installed."""
_BLOCK = re.compile(
    r"""^```(?P<kind>\w+)\n(?P<code>.*?)^```$ | ^(?P<html><.*?>)$
      | ^(?P<list>-[ ].*?)(?=\n\n|\Z) | ^(?P<text>\S.*?)(?=\n\n|\Z)""",
    re.VERBOSE | re.DOTALL | re.MULTILINE,
)
_INLINE = re.compile(r"`(?P<code>[^`]+)`|\*\*(?P<bold>[^*]+)\*\*|\*(?P<italic>[^*]+)\*|\[(?P<link>[^\]]+)\]\([^)]*\)")


class GuidePage(TypedDict):
    """A page: the document it belongs to, its title, and its HTML, in which `pre.program` can be played."""

    part: str
    title: str
    html: str


def guide(tutorial: str, lesson: str) -> list[GuidePage]:
    """Return the pages of the tutorial and of the exercises of the lesson, which are Markdown."""
    steps = [each for each in _sections(tutorial, "##") if each[0] not in NOT_HERE]
    exercises = _sections(lesson.partition("\n## Exercises\n")[2], "###")
    return [
        {"part": part, "title": title, "html": _html(text)}
        for part, pages in (("Tutorial", steps), ("Exercises", exercises))
        for title, text in pages
    ]


def _sections(text: str, level: str) -> list[tuple[str, str]]:
    """Return the titles of sections, without their numbers, and the text below each."""
    _, *sections = re.split(rf"^{level} (?:\d+\. )?", text, flags=re.MULTILINE)
    return [(title, below) for title, _, below in (each.partition("\n") for each in sections)]


def _html(text: str) -> str:
    return "\n".join(_blocks(text))


def _blocks(text: str) -> Iterator[str]:
    for found in _BLOCK.finditer(text):
        if found["code"]:
            name = ' class="program"' if found["kind"] == "improv" else ""
            yield f"<pre{name}>{escape(found['code'])}</pre>"
        elif found["list"]:
            items = re.split(r"^- ", found["list"], flags=re.MULTILINE)[1:]
            yield f"<ul>{''.join(f'<li>{_inline(item)}</li>' for item in items)}</ul>"
        elif found["html"]:
            yield found["html"]
        else:
            yield f"<p>{_inline(found['text'])}</p>"


def _inline(text: str) -> str:
    """Show only the words of links: they lead to documents that are not here."""
    parts, end = [], 0
    for found in _INLINE.finditer(text):
        parts.append(escape(text[end : found.start()]))
        kind = found.lastgroup or ""
        tag = {"code": "code", "bold": "b", "italic": "i"}.get(kind)
        words = escape(found[kind])
        parts.append(f"<{tag}>{words}</{tag}>" if tag else words)
        end = found.end()
    return "".join([*parts, escape(text[end:])]).strip()
