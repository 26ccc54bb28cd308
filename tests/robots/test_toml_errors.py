"""Errors drawn under an `improv.toml` that is not TOML, and the other errors still found in it."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from improv_core.robots.config import read_robots
from tests.robots.drawing import check


@pytest.mark.parametrize(
    "drawn",
    [
        """
        [robots.a]
        profile = turtlesim
                  ^^^^^^^^^ syntax: write a value: a number, "text", [a list] or { a table }
        """,
        """
        [robots.a]
        profile = "turtlesim
                            ^ syntax: close the string with the same quote it starts with
        topic = "/a"
        """,
        """
        [profiles.a]
        step = 0.2m
                  ^ syntax: remove this or start a new line with it
        """,
        """
        [profiles.a]
        step 0.2
             ^^^ syntax: write `=` and a value after the key
        """,
        """
        [profiles.a]
        step = 0.2
        step = 0.3
        ^^^^^^^^^^ syntax: this key already has a value: remove one of them
        """,
        """
        [robots.a]
        [robots.a]
        ^^^^^^^^^^ syntax: this section already exists above: merge the two
        """,
        """
        [robots.a]
        start = { x = 1, x = 2 }
                         ^^^^^ syntax: this key already has a value: remove one of them
        """,
        """
        [robots.a]
        start = { x = 1, y = 2, }
                                ^ syntax: write a key here, or remove the comma before it
        """,
        """
        [robots.a]
        start = { x = 1
                       ^ syntax: close the table with `}`, on the line where it starts
        }
        """,
        """
        [robots.a]
        topic = "\\cmd_vel"
                 ^^ syntax: write `\\\\` for one backslash
        """,
        """
        [robots.a
                 ^ syntax: close the section name with `]`
        """,
        """
        [profiles.a]
        motions = ["turn"
                         ^ syntax: close the list with `]`
        # nothing follows
        """.replace("# nothing follows", ""),
        """
        !
        ^ syntax: write `key = value` or `[section]`
        """,
    ],
)
def test_syntax_errors_are_marked_and_leave_no_robots(drawn: str) -> None:
    assert check(drawn).robots == {}


@pytest.mark.parametrize(
    "drawn",
    [
        """
        [robots.a]
        profile = turtlesim
                  ^^^^^^^^^ syntax: write a value: a number, "text", [a list] or { a table }
        topik = "/a"
        ^^^^^ robots: `topik` is not valid here: did you mean `topic`?
        [world]
        size = [6]
               ^^^ robots: write `size` as 2 numbers in meters, such as `[6, 4]`
        walls = [[0, 0, 1, 1]
                             ^ syntax: close the list with `]`
        circles = 3
                  ^ robots: write `circles` as a list, such as `[{ x = 1, y = 0, radius = 0.3 }]`
        """,
        """
        robts = 1
        ^^^^^ robots: `robts` is not valid here: did you mean `robots`?
        [robots.a] x
                   ^ syntax: remove this or start a new line with it
        topik = "below a wrong header, nobody knows what it is for"
        y
         ^ syntax: write `=` and a value after the key
        [robots.b]
        message = "Twst"
                  ^^^^^^ robots: `Twst` is not valid here: did you mean `Twist`?
        """,
        """
        [robots.a]
        profile = "husky"
        profile = "jackal"
        ^^^^^^^^^^^^^^^^^^ syntax: this key already has a value: remove one of them
        [robots.a] # twice
        ^^^^^^^^^^ syntax: this section already exists above: merge the two
        start = { x = "below a repeated section, nothing is read" }
        [ros]
        node = '''
        [robots.a]
        topic = 1
        ''' x
            ^ syntax: remove this or start a new line with it
        """,
    ],
)
def test_a_syntax_error_hides_no_other_error(drawn: str) -> None:
    assert check(drawn).robots == {}


@pytest.mark.parametrize(
    "drawn",
    [
        """
        [profiles.rover]
        step = 0.2m
                  ^ syntax: remove this or start a new line with it
        commanded_step = 9
        noise = 0.1
        [robots.a]
        profile = "rovr"
        follow = true
        [formation]
        shape = line
                ^^^^ syntax: write a value: a number, "text", [a list] or { a table }
        """,
    ],
)
def test_a_broken_table_causes_no_follow_up_errors(drawn: str) -> None:
    assert check(drawn).robots == {}


def test_line_ends_of_other_systems_move_nothing() -> None:
    text = "\ufeff# 🐢\r\n[robots.a]\r\ntopic = 1\r\nstart = {\r\n"
    number, bracket = read_robots(text).diagnostics
    assert (number.code, number.span) == ("robots", (text.index("1"), text.index("1") + 1))
    assert (bracket.code, bracket.span) == ("syntax", (text.index("{") + 1,) * 2)
    (diagnostic,) = read_robots(text[: text.index("start")]).diagnostics
    assert (diagnostic.code, diagnostic.span) == ("robots", (text.index("1"), text.index("1") + 1))


NAMES = (
    "robots profiles world ros namespace use_sim_time reset a b base step motions start x topic senses message below"
)
keys = st.sampled_from([*NAMES.split(), "from", "timeout", "key", ""])
VALUES = r'1 1e999 -0 nan true "a" "turtlesim" "/a" "sensor_msgs/LaserScan" 07:32:00 "\n"'
anything = st.recursive(
    st.sampled_from(VALUES.split()),
    lambda inner: (
        st.lists(inner, max_size=2).map(lambda items: f"[{','.join(items)}]")
        | st.dictionaries(keys, inner, max_size=3).map(
            lambda table: "{" + ",".join(f'"{key}"={value}' for key, value in table.items()) + "}"
        )
    ),
)


@given(st.dictionaries(keys, anything, max_size=4), st.text(max_size=3))
def test_no_text_raises(table: dict[str, str], end: str) -> None:
    text = "\n".join(f'"{key}" = {value}' for key, value in table.items()) + end
    found = read_robots(text)
    for diagnostic in found.diagnostics:
        assert 0 <= diagnostic.span.start <= diagnostic.span.end <= len(text)
        assert len(diagnostic.message.splitlines()) == 1
