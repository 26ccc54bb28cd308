"""The messages about a program that somebody writes on the page. Standard library only."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Literal, TypedDict

from improv_core.stage.fields import Count, StartPoseJson, Text


class ProgramSource(TypedDict):
    """The program as it stands in its file at `path`, which pages may edit. `revision` names this version of it.

    Its lines end in \\n here, whatever the line ends in the file are. `start_poses` are where robots start next if
    somebody has moved them on a page.
    """

    type: Literal["source"]
    path: str
    text: str
    revision: str
    start_poses: Mapping[str, StartPoseJson]


class Analyze(TypedDict):
    """Asks for the colors and problems of a page's text. The page numbers its texts."""

    type: Literal["analyze"]
    number: Count
    text: Text


class Complete(TypedDict):
    """Asks what may be written at an offset of the text with this number."""

    type: Literal["complete"]
    number: Count
    offset: Count


class Explain(TypedDict):
    """Asks what is at an offset of the text with this number."""

    type: Literal["explain"]
    number: Count
    offset: Count


class Write(TypedDict):
    """Save this text, which is an edit of a revision of the file, and play it."""

    type: Literal["write"]
    number: Count
    text: Text
    revision: Text


AskEditor = Analyze | Complete | Explain | Write
"""What a page asks for while somebody edits the program on it."""


class TextEdit(TypedDict):
    """Replaces the text between two offsets."""

    start: int
    end: int
    text: str


class TextFix(TypedDict):
    """Fixes of the same `kind` may be made together; one whose kind is empty is made alone."""

    title: str
    kind: str
    edits: Sequence[TextEdit]


class TextProblem(TypedDict):
    """A diagnostic of a text or, if `file` is given, of that file, at its `line` (counted from 1)."""

    start: int
    end: int
    file: str
    line: int
    severity: str
    message: str
    fixes: Sequence[TextFix]


class Analyzed(TypedDict):
    """`colors` has three numbers for each colored word: characters since the end of the last one, length, and kind.

    `problems` are the first of `count`.
    """

    type: Literal["analyzed"]
    number: int
    colors: Sequence[int]
    problems: Sequence[TextProblem]
    count: int


class OfferedWord(TypedDict):
    word: str
    about: str


class Completed(TypedDict):
    """The words that may replace the text between two offsets, best first."""

    type: Literal["completed"]
    number: int
    start: int
    end: int
    words: Sequence[OfferedWord]


class Explained(TypedDict):
    """What stands between two offsets, in words, and its path as SVG."""

    type: Literal["explained"]
    number: int
    start: int
    end: int
    text: str
    picture: str


class Written(TypedDict):
    """The text with this number was saved as `revision`, or `problem` says in one line why not."""

    type: Literal["written"]
    number: int
    revision: str
    problem: str


EditorAnswer = Analyzed | Completed | Explained | Written


class Answer(TypedDict):
    """An answer for one page, the one with this number."""

    type: Literal["answer"]
    page: int
    answer: EditorAnswer
