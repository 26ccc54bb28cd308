"""The text of a hover at the `|` in an improv.toml."""

from __future__ import annotations

from textwrap import dedent

from improv_core.ide.robots_file.hover import hover

BURGER = "https://emanual.robotis.com/docs/en/platform/turtlebot3/features/#specifications"


def check(marked: str, expected: str) -> None:
    marked = dedent(marked).strip("\n")
    found = hover(marked.replace("|", ""), marked.index("|"))
    assert (found.plain if found else "") == dedent(expected).strip("\n")


def test_keys_are_described_with_their_units() -> None:
    check(
        "[profiles.rover]\nst|ep = 0.5",
        """
        step: the distance of forward
        in meters, from 0.001 to 100
        """,
    )
    check(
        "[robots.anna]\nstart = { x = 1, hea|ding = 90 }",
        """
        heading: the heading, counterclockwise from the x axis
        in degrees, from -360 to 360
        default: 0
        """,
    )
    check("[wor|ld]", "world: the simulator's walls and obstacles")
    check("[world]\nwalls = [[0, 0, 2, |0]]", "walls: a coordinate\nin meters, from -1000 to 1000\ndefault: 0")


def test_a_value_that_replaces_that_of_a_base() -> None:
    check(
        '[profiles.slow]\nbase = "turtlebot3_burger"\nmax_linear = 0|.1',
        f"""
        max_linear: the maximum speed in any direction
        in m/s, from 0.001 to 100
        default: no limit
        in the base `turtlebot3_burger`: 0.22 m/s
        source of the limits of `turtlebot3_burger`: {BURGER}
        """,
    )


def test_profiles_and_robots() -> None:
    burger = "a step of 0.2 m, at most 0.22 m/s and 2.84 rad/s; forward, turn; never stops by itself"
    source = f"source of the limits of `turtlebot3_burger`: {BURGER}"
    check('[robots.anna]\nprofile = "turtle|bot3_burger"', f"turtlebot3_burger (profile): {burger}\n{source}")
    check(
        '[robots.an|na]\nprofile = "turtlebot3_burger"',
        f"anna (robot, profile turtlebot3_burger): {burger}\nlistens on `/anna/cmd_vel`\n{source}",
    )
    check(
        "[profiles.ro|ver]\nstep = 0.5\nmotions = ['forward']", "rover (profile): a step of 0.5 m, no limits; forward"
    )
    check(
        '[robots.anna]\nprofile = "bur|ger"',
        "profile: the kind of robot: a built-in profile or one of yours\n"
        "default: a step of 2 m, no limits, all motions",
    )


def test_comments_and_invalid_keys_have_no_hover() -> None:
    check("# a com|ment", "")
    check("[rooms.bi|g]", "")
    check("[robots.anna]\nwings = tr|ue", "")
