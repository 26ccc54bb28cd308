"""Characters of other keyboards: they play as meant or are errors, and fixes never make another dance of a program."""

from __future__ import annotations

import json
import random
import re
from collections.abc import Iterable, Mapping, Sequence
from functools import cache
from pathlib import Path
from typing import Any

import pytest

from improv_core.ide.code_action import fix_all
from improv_core.program.analysis import Analysis, analyze
from improv_core.program.compiler import compiled
from improv_core.robots.config import read_robots
from improv_core.syntax.characters import ACCEPTED, FULL_WIDTH, SPACES, UNSEEN
from improv_core.syntax.formatter import format_text
from tests.ide.cursor import preferred

TESTS = Path(__file__).parents[1]
BODIES: dict[str, Any] = json.loads((TESTS / "bodies.json").read_text(encoding="utf-8"))
EVERY = [
    *((case["program"], "") for case in json.loads((TESTS / "conformance.json").read_text(encoding="utf-8"))["cases"]),
    *((case["program"], group["toml"]) for group in (BODIES, BODIES["poses"]) for case in group["cases"]),
]
MAX_BEATS = 30


@cache  # each worker collects this file, and one runs it
def every_program() -> Sequence[tuple[str, str]]:
    return [(text, robots) for text, robots in EVERY if analyze(text, read_robots(robots)).ok]


def played(analysis: Analysis) -> Mapping[str, Any]:
    robots: Mapping[str, Any] = compiled(analysis, MAX_BEATS)["robots"]
    return robots


def assert_alike(one: Mapping[str, Any], other: Mapping[str, Any]) -> None:
    """Check that the robots play the same. An endless part is cut off at a beat that depends on how it is written."""
    assert list(one) == list(other)
    for robot in one:
        parts = [dict(one[robot]), dict(other[robot])]
        lists = [part.pop("segments") for part in parts]
        if parts[0].get("truncated") and parts[1].get("truncated"):
            shared = min(map(len, lists)) - 1
            lists = [each[:shared] for each in lists]
            for part in parts:
                part.pop("joints", None), part.pop("range", None)
        assert lists[0] == lists[1]
        assert parts[0] == parts[1]


def pressed(analysis: Analysis, dice: random.Random) -> Analysis:
    """Return the program after all fixes that the key or saving applies."""
    for _ in range(200):
        found = [*preferred(analysis), *(action.edits for action in fix_all(analysis))]
        if not found:
            return analysis
        for edit in reversed(dice.choice(found)):
            analysis = analysis.edited(*edit.span, edit.text)
    raise AssertionError(f"fixes never end: {analysis.text}")


OF_OURS: dict[str, list[str]] = {}
for stand_in, ours in ACCEPTED.items():
    OF_OURS.setdefault(ours, []).append(stand_in)
DIGITS = {digit: full for full, digit in FULL_WIDTH.items() if digit.isdigit()}
Kind = tuple[str, Sequence[str] | Mapping[str, Sequence[str]]]
ALIKE: list[Kind] = [
    (r"[ \t]", [*SPACES, *(f" {char}" for char in UNSEEN), *(f"{char} " for char in UNSEEN)]),
    (r"[-*/$=()\[\]]", OF_OURS),
    (r"\|\|", ["｜｜", "|｜"]),
    (r"(?<![\w.])[0-9](?!\w)", DIGITS),
    (r"(?<=\d)\.(?=\d)", ["．"]),
]
"""Patterns and the characters that stand for them in every place."""
NOT_ALIKE: list[Kind] = [
    (r"(?<=\d)\.(?=\d)", [",", "，", "٫"]),
    (r"\.", [",", "·", "。"]),
    (
        r"(?<![\w./*])(?:1/2|3/2|1/4)(?![\w./])",
        {"1/2": ["½", "50%", "0,5", "5e-1", "½ "], "3/2": ["1½", "1 ½", "150%", "15e-1", "1 1/2"], "1/4": ["¼"]},
    ),
    (r"[0-9]", {str(digit): [chr(zero + digit) for zero in (0x660, 0x966, 0x1D7CE)] for digit in range(10)}),
    (r"[123]", {"1": ["¹", "①"], "2": ["²", "②"], "3": ["³", "③"]}),
    (
        r"\b(60|90|2|3)\b",
        {"60": ["6e1", "60,000", "6.0e1"], "90": ["90º", "90˚"], "2": ["2e0", "2,000"], "3": ["3e0", "3,0"]},
    ),
    (r"(?<![\w.])-(?=[\d.])", ["–", "—", "‐"]),
    (r"---", ["—", "–", "—-", "--", "– – –", "───"]),
    (r"[ \t]+", ["\ufeff", ",", ", ", "\u200b", "\u00ad", "\u202e", " “", "’", " . ", "!", " · ", ";", "、"]),
    (r" (?=[0-9(\[])|(?<=[a-z]) (?=left|right|forward|up)", [""]),
    (r"(?<=\w)(?=\w)", ["\u200b", "\u200d", "\u00ad", "’", "·"]),
    (
        r"[()\[\]*/$=]|\|\|",
        {
            "(": ["{", "❨", "〈", "‹", " ‹ ", ""],
            ")": ["}", "❩", "〉", "›", " › "],
            "[": ["⟦", "【", "‹ "],
            "]": ["⟧", "】", " ›", ""],
            "*": ["∗", "⋅", "·", "x"],
            "/": ["∕", "∶", ":", "|"],
            "$": ["﹩", "§", ":", "S", ""],
            "=": ["﹦", ":=", "==", "≔", ""],
            "||": ["‖", "∥", "|", "¦", "ǁ", "& "],
        },
    ),
    (r"\n", ["\u2028", "\u2029"]),
    (
        r"\b(left|right|forward|repeat)\b",
        {
            "left": ["turn left", "ｌｅｆｔ", "left,", "“left”", "Left", "left turn"],
            "right": ["turn right", "rotate right", "rıght", "right."],
            "forward": ["go forward", "ｆｏｒｗａｒｄ", "forward;", "FORWARD", "step forward"],
            "repeat": ["loop", "Repeat", "repeat:"],
        },
    ),
]
"""Patterns and the characters that may stand for them, but also for other things."""


def by_chance(text: str, kind: Kind, dice: random.Random, share: float) -> str:
    """Replace some matches of a pattern outside of comments by their stand-ins."""
    pattern, stand_ins = kind

    def written(match: re.Match[str]) -> str:
        if match[0].startswith("#") or dice.random() > share:
            return match[0]
        return dice.choice(stand_ins[match[0]] if isinstance(stand_ins, Mapping) else stand_ins)

    return re.sub(rf"#[^\r\n]*\n?|{pattern}", written, text)


def mixes(
    programs: Sequence[tuple[str, str]], seed: int, share: float, kinds: Iterable[Kind]
) -> list[tuple[str, str, str]]:
    """Yield each program, its robots, and the program as another keyboard may write it."""
    dice = random.Random(seed)
    found = []
    for text, robots in programs:
        other = text
        for kind in kinds:
            other = by_chance(other, kind, dice, share)
        found.append((text, robots, other))
    return found


def check_alike(programs: Sequence[tuple[str, str]], seed: int, share: float) -> None:
    for text, robots, other in mixes(programs, seed, share, ALIKE):
        given = read_robots(robots)
        analysis = analyze(other, given)
        assert analysis.ok, other
        assert_alike(played(analysis), played(analyze(text, given)))
        assert format_text(other) == format_text(text)


def check_pressing(programs: Sequence[tuple[str, str]], seed: int, share: float, kinds: Sequence[Kind]) -> int:
    """Press fixes until none is left. Return how many programs that other keyboards had changed play after that."""
    dice, plays = random.Random(seed), 0
    for text, robots, other in mixes(programs, seed, share, kinds):
        given = read_robots(robots)
        after = pressed(analyze(other, given), dice)
        if other == text or not after.ok:
            continue
        plays += 1
        try:
            assert_alike(played(after), played(analyze(text, given)))
        except AssertionError:
            raise AssertionError(f"{text!r}\nwritten {other!r}\nbecame {after.text!r}") from None
    return plays


def test_stand_ins_play_and_are_formatted_like_ours() -> None:
    check_alike(every_program()[::2], 1, 1)
    check_alike(every_program()[1::2], 2, 0.5)


def test_pressing_fixes_plays_the_same_or_leaves_an_error() -> None:
    plays = [
        check_pressing(random.Random(seed).sample(every_program(), 25), seed, 0.5, [k])
        for seed, k in enumerate(NOT_ALIKE)
    ]
    assert sum(plays) > 20


@pytest.mark.slow("tries every program with many stand-ins")
def test_no_program_becomes_another_dance() -> None:
    for number, kind in enumerate(NOT_ALIKE):
        check_pressing(every_program()[number % 3 :: 3], 0, 0.3, [kind])
    check_pressing(every_program(), 0, 0.05, NOT_ALIKE)
