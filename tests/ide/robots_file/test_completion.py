"""The items that are offered at the `|` in an improv.toml, best first."""

from __future__ import annotations

from textwrap import dedent

import pytest
from hypothesis import given
from hypothesis import strategies as st

from improv_core.ide.completion import Completion
from improv_core.ide.robots_file.completion import complete
from improv_core.ide.robots_file.hover import hover
from improv_core.ide.robots_file.references import declarations, symbol_at, uses
from improv_core.ide.robots_file.structure import flattened, folds, outline
from improv_core.robots.config import read_robots
from improv_core.robots.profiles import SOURCES
from improv_core.robots.schema import known
from improv_core.score.profiles import BUILT_IN
from improv_core.text import LineIndex
from tests.ide.test_document_symbol import drawn
from tests.robots.test_config import PAGE

PROFILES = [f'"{name}"' for name in BUILT_IN]
NAMES = [
    "robots",
    "profiles",
    "formation",
    "ros",
    "hosts",
    "on",
    "world",
    "clock",
    "preflight",
    "music",
    "senses",
    "osc",
]
SECTIONS = [f"[{name}]" for name in NAMES]


def completed(marked: str, robots: tuple[str, ...] = ()) -> tuple[str, Completion | None]:
    marked = dedent(marked).strip("\n")
    text = marked.replace("|", "")
    return text, complete(text, marked.index("|"), robots)


def check(marked: str, *labels: str, robots: tuple[str, ...] = ()) -> None:
    _, found = completed(marked, robots)
    assert found
    assert [item.label for item in found.items] == list(labels)


def test_sections_that_are_not_there() -> None:
    check("[|\n[world]\nsize = [6, 4]", *(name for name in NAMES if name != "world"))
    check("[ro|]", *NAMES)
    check(
        "[robots.anna]\nprofile = 'husky'\nstart = {}\nnamespace = 'a'\ntopic = 'a'\nmessage = 'auto'\nframe = 'a'\n"
        "reset = 'a'\nodom = 'a'\nodom_frame = 'own'\nbattery = 'a'\nhost = 'a'\n"
        "output = 'thymio'\naddress = 'a'\nnode = 1\nlink_patience = 1\nfollow = false\n|",
        *SECTIONS,
    )


def test_robots_of_programs_and_built_in_senses() -> None:
    check("[senses.|]\n[senses.near]\nkey = 'a'", "bump")


def test_keys_that_are_not_there() -> None:
    rest = (name for name, key in known(("robots", "a")).keys.items() if name not in ("topic", "joints", "settings"))
    check('[robots.anna]\ntopic = "/a"\npro|', *rest)
    check("[robots.anna]\nstart = { x = 1, | }", "y", "heading")
    check("[world]\ncircles = [{ radius = 1 }, { radius = 2, |", "x", "y")
    check("[ros]\ndeadman = { |", "topic", "button")
    keys = known(("profiles", "a")).keys
    check("[profiles.a]\nba|\n[profiles.b]\nstep = 1", *(name for name, key in keys.items() if not key.named))


def test_values_that_fit_a_key_are_offered() -> None:
    check("[robots.anna]\nprofile = |\n[profiles.rover]\nstep = 1", '"rover"', *PROFILES)
    check('[robots.anna]\nprofile = "turt|"', *PROFILES)
    check("[profiles.rover]\nbase = |", *PROFILES)
    check('[profiles.a]\nmotions = ["turn", |', '"forward"', '"strafe"', '"climb"')
    check("[ros]\nuse_sim_time = |", "true", "false")
    check("[profiles.a]\nquarter_turn = |", "90")
    check("[robots.anna]\nstart = |", "{ x = 0, y = 0, heading = 0 }")


def test_the_sections_and_keys_of_a_body() -> None:
    check("[profiles.a.|]", "body", "joints", "controllers")
    check("[profiles.a.body.|]")
    check("[profiles.a.body.head]\nmirror = 'x'\nparts = []\nup = {}\nleft = {}\n|", "forward", "strafeleft", *SECTIONS)
    _, found = completed("[profiles.a]\n|")
    assert found
    assert "joint_states" in [item.label for item in found.items]
    assert "body" not in [item.label for item in found.items]


def test_nothing_is_offered_for_unknown_keys() -> None:
    check("[robots.anna]\nwings = |")
    check("[rooms]\n|", *SECTIONS)
    assert completed("# |")[1] is None


def applied(marked: str, label: str) -> str:
    """Return the text after an item was chosen, without a cursor in it."""
    text, found = completed(marked)
    assert found
    (item,) = [item for item in found.items if item.label == label]
    return text[: found.span.start] + item.label + text[found.span.end :]


def test_a_value_replaces_its_quotes() -> None:
    after = '[robots.anna]\nprofile = "turtlesim"'
    for before in ('profile = "turt|"', 'profile = "turt|', "profile = turt|", "profile = |"):
        assert applied(f"[robots.anna]\n{before}", '"turtlesim"') == after


@pytest.mark.parametrize(
    ("marked", "label", "snippet"),
    [
        ("[robots.anna]\n|", "profile", 'profile = "$1"'),
        ("[robots.anna]\n|", "start", "start = ${1:{ x = 0, y = 0, heading = 0 \\}}"),
        ("[ros]\n|", "rejoin", 'rejoin = ${1|"continue","scene","return","next","pause"|}'),
        ("[robots.anna]\npro| = 'husky'", "profile", ""),
        ("[|", "robots", "robots.${1:name}]"),
        ("[|]", "world", "world"),
        ("|", "[world]", "[world]"),
    ],
)
def test_a_key_brings_its_value_as_a_snippet(marked: str, label: str, snippet: str) -> None:
    _, found = completed(marked)
    assert found
    assert [item.snippet for item in found.items if item.label == label] == [snippet]


def test_every_profile_has_a_source_that_the_page_names() -> None:
    assert SOURCES.keys() == BUILT_IN.keys() - {"puppet"}  # no machine
    assert all(source in PAGE.replace("\n", "") for source in SOURCES.values())


SIGNS = (
    '[ ] { } = , . # - \\ " \' """ 1 🐢 robots profiles world walls senses ros anna profile x turtlesim motions base'
)
TEXTS = st.lists(st.sampled_from([*SIGNS.split(), "\n", "\r\n", " "]), max_size=25).map("".join)


@given(TEXTS, st.integers(0, 60))
def test_no_text_raises(text: str, offset: int) -> None:
    offset = min(offset, len(text))
    complete(text, offset, ("anna",))
    hover(text, offset)
    if symbol := symbol_at(text, offset):
        assert symbol.span.holds(offset)
        assert all(text[slice(*span)] for span in (*declarations(text, symbol), *uses(text, symbol)))
    for entry in flattened(outline(text)):
        drawn(entry, "")
    lines = LineIndex(text)
    assert all(0 <= fold.first < fold.last < len(lines.starts) for fold in folds(lines))
    read_robots(text)
