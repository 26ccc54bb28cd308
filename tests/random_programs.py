"""Random programs of all that robots perform: dice, senses, body parts, scenes, and movements that take no time."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from hypothesis import strategies as st

from improv_core.program.analysis import analyze
from improv_core.program.compiler import score_of
from improv_core.robots.config import read_robots
from improv_core.score.score import Score

TOML = """
[profiles.nod]
base = "puppet"
[profiles.nod.body.head]
left = { joint = "yaw", degrees = 30 }
up = { joint = "pitch", degrees = 20 }
[profiles.nod.body.head.poses]
aside = { left = 60 }
[profiles.nod.joints.yaw]
min = -70
max = 80
[profiles.nod.joints.pitch]
[robots.a]
profile = "nod"
[robots.b]
profile = "nod"
[senses.hold]
key = "h"
"""
WORDS = st.sampled_from(["forward", "left", "halfright", "straferight", "up", "down", "rest", "head left", "head down"])
NUMBERS = st.sampled_from(["2", "3", "3/2", "1/2", "7/3"])
POSES = st.sampled_from(["head to aside", "head to start"])
CLOSED_WORDS = WORDS | st.just("()") | POSES


def _closed(inner: st.SearchStrategy[str]) -> st.SearchStrategy[str]:
    """Generate movements that end, and that no sense decides."""
    return st.one_of(
        _of_several(inner),
        st.builds("repeat {} ({})".format, st.integers(0, 4), inner),
        st.builds("{} {} ({})".format, st.sampled_from(["fast", "slow"]), NUMBERS, inner),
        st.builds("ease ({})".format, inner),
        st.builds("ramp {} {} ({})".format, st.sampled_from(["0", "1/2", "2"]), NUMBERS, inner),
        st.builds("shuffle ({} {} {})".format, WORDS, inner.map("({})".format), WORDS),
        st.builds("choose ({} {} {})".format, WORDS, WORDS, WORDS),
        st.builds("chance 1/2 ({})".format, inner),
        st.builds("seed {} ({})".format, NUMBERS, inner),
    )


def _of_several(inner: st.SearchStrategy[str]) -> st.SearchStrategy[str]:
    return st.one_of(
        st.lists(inner, min_size=1, max_size=3).map(" ".join).map("({})".format),
        st.builds("({} || {})".format, inner, inner.map(_of_base)),
        st.builds("[{} {}]".format, inner, inner),
    )


def _of_base(movement: str) -> str:
    """Return a movement without body parts: another voice would disturb a pose, which then gets one command, at its
    beginning."""
    for words, other in (("head to aside", "up"), ("head to start", "rest"), ("head ", "")):
        movement = movement.replace(words, other)
    return movement


CONDITIONS = st.sampled_from(["near", "not near", "hold", "not hold"])


def _open(inner: st.SearchStrategy[str], conditions: st.SearchStrategy[str]) -> st.SearchStrategy[str]:
    """Generate movements that senses may decide, or that never end."""
    return st.one_of(
        _of_several(inner),
        st.builds("repeat {} ({})".format, st.integers(0, 4), inner),
        st.builds("repeat ({})".format, inner),
        st.builds("{} {} ({})".format, st.sampled_from(["fast", "slow"]), NUMBERS, inner),
        st.builds("until {} ({})".format, conditions, inner),
        st.builds("pause {} ({})".format, conditions, inner),
        st.builds("if {} ({}) else ({})".format, conditions, inner, inner),
    )


def written(words: Sequence[str], forms: Iterable[str], most: int) -> st.SearchStrategy[str]:
    """Generate movements of at most this many words. In a form, `{0}` and `{1}` are movements."""

    def larger(inner: st.SearchStrategy[str]) -> st.SearchStrategy[str]:
        return st.one_of(*(st.builds(form.format, *[inner] * (1 + ("{1}" in form))) for form in forms))

    return st.recursive(st.sampled_from(words), larger, max_leaves=most)


SHORTEST = 1 / 12
"""The fewest beats that a word lasts."""
closed = st.recursive(CLOSED_WORDS, _closed, max_leaves=4)


def movements(conditions: st.SearchStrategy[str] = CONDITIONS) -> st.SearchStrategy[str]:
    return st.recursive(closed, lambda inner: _open(inner, conditions), max_leaves=4)


def programs(conditions: st.SearchStrategy[str] = CONDITIONS, most_scenes: int = 2) -> st.SearchStrategy[str]:
    """Generate programs of two robots with bodies that don't change so often that playing them takes long."""
    lines = st.builds("{} $ {}".format, st.sampled_from(["a", "b", "a b"]), movements(conditions))
    scenes = st.lists(lines, min_size=1, max_size=2).map("\n".join)
    return st.lists(scenes, min_size=1, max_size=most_scenes).map("\n---\n".join).filter(_is_calm)


def _is_calm(text: str) -> bool:
    bounds = [scene.bounds for part in score_of_text(text).parts.values() for scene in part.scenes]
    return all(min(each.peak.shortest, each.body.peak.shortest) >= SHORTEST for each in bounds)


def score_of_text(text: str) -> Score:
    """Return the score of a program at one beat a second. Statements that never play are no errors."""
    analysis = analyze(f"beat 60\n{text}\n", read_robots(TOML))
    assert analysis.ok, (text, analysis.diagnostics)
    return score_of(analysis)
