"""The outline of an improv.toml, a line for each entry: name, kind, and value."""

from __future__ import annotations

from improv_core.ide.robots_file.structure import outline
from tests.ide.test_document_symbol import drawn


def check(text: str, *lines: str) -> None:
    assert [line for entry in outline(text) for line in drawn(entry, "")] == list(lines)


def test_sections_and_their_keys() -> None:
    check(
        "[profiles.rover] # mine\nstep = 0.5\n\n[robots.anna]\nprofile = 'rover'\nstart = { x = 1,\ty = 2 }\n[world]\n",
        "profiles.rover: profile",
        "  step: key 0.5",
        "robots.anna: robot",
        "  profile: key 'rover'",
        "  start: key { x = 1, y = 2 }",
        "world: section",
    )


def test_keys_above_all_sections_and_keys_with_dots() -> None:
    check(
        "world.size = [\n  6,\n  4,\n]\n[robots]\nanna.profile = 'husky'\n",
        "world.size: key [ 6, 4, ]",
        "robots: section",
        "  anna.profile: key 'husky'",
    )


def test_tables_of_an_array_and_a_long_value() -> None:
    check(
        "[[world.circles]]\nx = 1\n[[world.circles]]\nx = 2\n[ros]\nstop = '/" + "a" * 60 + "'\n",
        "world.circles: section",
        "  x: key 1",
        "world.circles: section",
        "  x: key 2",
        "ros: section",
        "  stop: key '/" + "a" * 37 + "…",
    )
