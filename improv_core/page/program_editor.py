"""Answers for a page on which a person edits a program: colors, problems with fixes, completion, and hovers."""

from __future__ import annotations

import math
from collections import OrderedDict
from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import lru_cache, partial
from typing import NamedTuple, TypeVar

from improv_core.diagnostics import Diagnostic, Edit, Fix, Severity
from improv_core.ide.bending import handle_at
from improv_core.ide.code_action import REMOVABLE
from improv_core.ide.completion import complete
from improv_core.ide.hover import hover
from improv_core.ide.insertion import gap_at, poses_in
from improv_core.ide.placing import UNPLACED
from improv_core.ide.semantic_tokens import colored, fragments
from improv_core.page.program_changes import edits_of, is_first_beat
from improv_core.page.text_preview import TextPreview
from improv_core.program import room
from improv_core.program.analysis import Analysis, analyze
from improv_core.program.compiler import starts_of
from improv_core.program.joint_check import check_joints
from improv_core.protocol.editing import (
    MAX_PAGES,
    Analyze,
    Analyzed,
    AskHandle,
    AskPreview,
    Change,
    ChangeEdits,
    Complete,
    Completed,
    EditorAnswer,
    Explain,
    Explained,
    FirstProblems,
    Preview,
    PreviewedPath,
    RoomChecked,
    ShownHandle,
    TextProblem,
)
from improv_core.protocol.fields import StartPoseJson
from improv_core.robots.config import FILE_NAME, Robots
from improv_core.score.encounters import RoomResults
from improv_core.slices import unless
from improv_core.stage import dry_run
from improv_core.text import LineIndex, difference

T = TypeVar("T")
MAX_PREVIEWS = 10
"""Texts of a page whose paths are kept: somebody may type this many keys before the page has the paths of the first."""
MAX_PROBLEMS = 100
MAX_WORDS = 50
REHEARSES = "this rehearsal doesn't begin at {}: leave out --from and --only to move {}"


class _PageText(NamedTuple):
    """A page's latest text, and the numbers of its colors."""

    number: int
    analysis: Analysis
    colors: list[int]


class PageEditor:
    """The text on each page, analyzed for the robots of `improv.toml`. Offsets count code points.

    `write_first_beat` writes the time of the first beat in a song into `improv.toml`, and returns the problem, if any.
    """

    def __init__(self, robots: Robots, write_first_beat: Callable[[float], str]) -> None:
        self.robots = robots
        """The robots for which later requests are answered; may be replaced."""
        self._write_first_beat = write_first_beat
        self._texts: OrderedDict[int, _PageText] = OrderedDict()  # by page
        self._latest = analyze("", robots)
        self._known: RoomResults | None = None  # of meetings
        self._preview = TextPreview()
        self._previewed: dict[int, dict[int, Mapping[str, PreviewedPath | None]]] = {}  # by page and number of the text
        self._predict = dry_run.Predictions()

    def answer(
        self, page: int, ask: Analyze | Complete | Explain | AskHandle | Change, *, rehearses: bool = False
    ) -> EditorAnswer | None:
        """Return the answer to a page's question; None if there is none. `rehearses` is as in `change`."""
        match ask["type"]:
            case "analyze":
                return self.analyze(page, ask)
            case "complete":
                return self.complete(page, ask)
            case "explain":
                return self.explain(page, ask)
            case "handle":
                return self.handle(page, ask)
            case "change":
                return self.change(page, ask, rehearses=rehearses)

    def analysis(self, text: str) -> Analysis:
        """Analyze a text, starting from the latest analysis."""
        if self._latest.config is not self.robots:
            self._latest = self._latest.with_robots(self.robots).settled()
        if text != self._latest.text:
            self._latest = self._latest.edited(*difference(self._latest.text, text)).settled()
        return self._latest

    def analyze(self, page: int, ask: Analyze) -> Analyzed:
        """Return the problems of a page's text and the colors that the page doesn't have, and keep the text."""
        before, text = self._texts.pop(page, None), self.analysis(ask["text"])
        known = before.colors if before and before.number == ask.get("known") else []
        colors = list(_colors(text))
        self._texts[page] = _PageText(ask["number"], text, colors)
        if len(self._texts) > MAX_PAGES:
            oldest, _ = self._texts.popitem(last=False)
            self._previewed.pop(oldest, None)
        first, end, new = difference(known, colors)
        return {
            "type": "analyze",
            "number": ask["number"],
            "colors": {"first": first, "last": len(known) - end, "new": new},
            **self._problems(text, text.diagnostics),
            "starts": _starts(text),
        }

    def previews(self, page: int, ask: AskPreview) -> Iterator[Preview]:
        """Yield the paths of a page's text that it doesn't have, and all again once it is known what robots sense: that
        may take a second. None follow once the page has another text."""
        if analysis := self._text(page, ask["number"]):
            sent = self._previewed.setdefault(page, {})
            known = sent.get(ask.get("known", -1), {})
            answers = self._preview.answers(ask["number"], analysis, self._predict)
            while preview := self._unless_edited(page, ask["number"], partial(next, answers, None)):
                sent.setdefault(ask["number"], preview["robots"])  # of two answers, the page may have only the first
                if len(sent) > MAX_PREVIEWS:
                    del sent[next(iter(sent))]
                robots = {name: None if known.get(name) is path else path for name, path in preview["robots"].items()}
                yield preview | {"robots": robots}

    def check_room(self, page: int, ask: Analyze) -> RoomChecked | None:
        """Return the problems of a page's text with meetings, collisions, and motions that joints can't make.

        May take a second. None if there are no such problems, or if the page has another text by then.
        """
        analysis = self._text(page, ask["number"])
        if not analysis:
            return None
        answer = partial(self._check_room, analysis, ask["number"])
        return self._unless_edited(page, ask["number"], answer)

    def _check_room(self, analysis: Analysis, number: int) -> RoomChecked | None:
        report = room.check(analysis, self._known, self._predict)
        found = [*(report.diagnostics if report else ()), *check_joints(analysis)]
        self._known = report.known if report else self._known
        if not found:
            return None
        return {"type": "check", "number": number, **self._problems(analysis, [*analysis.diagnostics, *found])}

    def _unless_edited(self, page: int, number: int, work: Callable[[], T | None]) -> T | None:
        """Return the result of work on a page's text; None as soon as the page has another one."""
        found = unless(lambda: not self.has(page, number), work)
        return found if self.has(page, number) else None

    def complete(self, page: int, ask: Complete) -> Completed | None:
        """Return the words that fit at an offset: those that begin with the letters there, or if none does, contain
        them.

        None if the page has another text, or no word may be there.
        """
        analysis = self._text(page, ask["number"])
        found = complete(analysis, min(ask["offset"], len(analysis.text))) if analysis else None
        if not analysis or not found:
            return None
        begun = analysis.text[found.span.start : found.span.end].lower()
        fitting = [item for item in found.items if begun in item.label.lower()]
        items = [item for item in fitting if item.label.lower().startswith(begun)] or fitting
        return {
            "type": "complete",
            "number": ask["number"],
            "start": found.span.start,
            "end": found.span.end,
            "words": [{"word": item.label, "about": item.detail} for item in items[:MAX_WORDS]],
        }

    def explain(self, page: int, ask: Explain) -> Explained | None:
        """Return the hover at an offset. None if the page has another text, or there is no hover."""
        analysis = self._text(page, ask["number"])
        found = hover(analysis, min(ask["offset"], len(analysis.text)), pictures=True) if analysis else None
        if not found:
            return None
        return {
            "type": "explain",
            "number": ask["number"],
            "start": found.span.start,
            "end": found.span.end,
            "text": found.plain,
            "picture": found.picture,
        }

    def handle(self, page: int, ask: AskHandle) -> ShownHandle | None:
        """Return the handle of the movement at an offset. None if the page has another text."""
        analysis = self._text(page, ask["number"])
        if not analysis:
            return None
        offset = min(ask["offset"], len(analysis.text))
        found = handle_at(analysis, offset)
        gap = gap_at(analysis, offset) if ask["draws"] else None
        pens = poses_in(analysis, gap) if gap else {}
        return {
            "type": "handle",
            "number": ask["number"],
            "offset": ask["offset"],
            "robot": found.robot if found else "",
            "text": found.text if found else "",
            "place": found and _millimeters(found.place),
            "others": [_millimeters(each) for each in found.others] if found else [],
            "pens": {robot: _millimeters((pose.x, pose.y)) for robot, pose in pens.items()},
        }

    def _problems(self, analysis: Analysis, found: Sequence[Diagnostic]) -> FirstProblems:
        problems = _problems(found, analysis.lines, self.robots)[:MAX_PROBLEMS]
        return {"problems": problems, "count": len(found) + len(self.robots.diagnostics)}

    def change(self, page: int, ask: Change, *, rehearses: bool = False) -> ChangeEdits | None:
        """Return the edits that make a change, after a change of `improv.toml` none. None if the page has another text.

        While it `rehearses` with robots at their places in the middle of the program, the page shows these places,
        which are no starts, and the song begins elsewhere, too.
        """
        change = ask["change"]
        if is_first_beat(change):
            problem = REHEARSES.format("beat 1", "the song") if rehearses else self._write_first_beat(change["value"])
            return _moved(ask["number"], (), problem)
        analysis = self._text(page, ask["number"])
        if not analysis:
            return None
        if rehearses and change["type"] in ("place", "arrange"):
            return _moved(ask["number"], (), REHEARSES.format("the starts", "them"))
        edits = edits_of(analysis, change)
        return _moved(ask["number"], edits or (), UNPLACED if edits is None else "")

    def has(self, page: int, number: int) -> bool:
        """Return whether this is the text of a page, and no newer one has come."""
        return self._text(page, number) is not None

    def _text(self, page: int, number: int) -> Analysis | None:
        text = self._texts.get(page)
        return text.analysis if text and text.number == number else None


def _moved(number: int, edits: Sequence[Edit], problem: str) -> ChangeEdits:
    """Build the answer with the edits of the text with a number, or with a problem."""
    return {
        "type": "change",
        "number": number,
        "edits": [{"start": edit.span.start, "end": edit.span.end, "text": edit.text} for edit in edits],
        "problem": problem,
    }


def _millimeters(place: Sequence[float]) -> Sequence[float]:
    return [round(each, 3) for each in place]


def _starts(analysis: Analysis) -> Mapping[str, StartPoseJson]:
    """Return the start poses of a program without errors, in meters and degrees."""
    if not analysis.ok:
        return {}
    poses = starts_of(analysis)
    return {
        name: {"x": pose.x, "y": pose.y, "heading": math.degrees(pose.heading)}
        for name, pose in ((name, poses[name]) for name in analysis.all_robots)
    }


def _colors(analysis: Analysis) -> Iterator[int]:
    """Yield three integers for each colored word; the kinds are those of `semantic_tokens_legend`."""
    before = 0
    for offset, fragment in fragments(analysis):
        for start, end, kind, _ in _colored(fragment):
            yield from (offset + start - before, end - start, kind)
            before = offset + end


_colored = lru_cache(maxsize=10_000)(colored)


def _problems(found: Sequence[Diagnostic], lines: LineIndex, robots: Robots) -> list[TextProblem]:
    """Return the problems of the program and those of `improv.toml`, in which the page can fix nothing: the most severe
    first, in the order of their lines."""
    file, robot_lines = robots.path.name if robots.path else FILE_NAME, LineIndex(robots.text)
    problems = [_problem(each, lines) for each in found]
    problems += [
        {**_problem(each, robot_lines), "start": 0, "end": 0, "file": file, "fixes": []} for each in robots.diagnostics
    ]
    return sorted(problems, key=lambda each: (_ORDER.index(each["severity"]), each["file"], each["line"]))


_ORDER = [severity.value for severity in Severity]


def _kind(problem: Diagnostic, fix: Fix) -> str:
    """Name the group of fixes that may be made together: they remove idle text, or change the same word alike."""
    edits = [(edit.span, edit.text) for edit in fix.edits]
    if problem.code in REMOVABLE and not any(text for _, text in edits):
        return problem.code
    return f"{problem.code}: {fix.title}" if [span for span, _ in edits] == [problem.span] else ""


def _problem(problem: Diagnostic, lines: LineIndex) -> TextProblem:
    return {
        "start": problem.span.start,
        "end": problem.span.end,
        "file": "",
        "line": lines.number(problem.span.start),
        "severity": problem.severity.value,
        "message": problem.message,
        "fixes": [
            {
                "title": fix.title,
                "kind": _kind(problem, fix),
                "edits": [{"start": edit.span.start, "end": edit.span.end, "text": edit.text} for edit in fix.edits],
            }
            for fix in problem.fixes
        ],
    }
