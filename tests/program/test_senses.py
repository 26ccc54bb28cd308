"""Programs that react: diagnostics about their senses, and the senses that their robots read."""

from __future__ import annotations

import json

import pytest

from improv_core.program.analysis import analyze
from improv_core.program.compiler import score_of
from improv_core.program.script import ScriptError, read_script
from improv_core.robots.config import read_robots
from improv_core.score.performer import Performer
from improv_core.score.score_json import from_json, to_json
from improv_core.score.senses import BuiltIn, Topic
from tests.program.drawing import check, check_all

TWO_ROBOTS = """
[robots.anna]
profile = "turtlebot3_burger"
[robots.bo]
profile = "sensing"
[profiles.sensing]
base = "turtlebot3_burger"
near = 0.5
"""
BUMPER = """
[senses.bump]
topic = "bumper"
message = "std_msgs/Bool"
"""


def test_right_reactions_have_no_diagnostics() -> None:
    check(
        """
        roam = repeat ((until near repeat forward) [left left])
        dodge (m) = pause near m
        r $ until cue roam
        ---
        r $ dodge (forward left) if bump backward else ()
        r $ (until not near repeat left) until near (repeat backward || repeat scale 2 forward)
        near = left
        r $ near
        """
    )


def test_conditions_name_senses() -> None:
    check("""
        r $ until left
                  ^^^^ syntax: write a sense after `until`, such as `cue`
        r $ until naer repeat left
                  ^^^^ unknown-sense: `naer` is not a sense: did you mean `near`?
        x = if fire left else right
               ^^^^ unknown-sense: `fire` is not a sense: add `[senses.fire]` to improv.toml
        r $ x
    """)


def test_words_that_need_a_fixed_length() -> None:
    needs = "needs a fixed length, but senses decide how long"
    check(f"""
        r $ reverse until near repeat forward
            ^^^^^^^ open-length: `reverse` {needs} `until` lasts: move `reverse` inside `until`
        r $ fit 4 (if near left else right)
            ^^^ open-length: `fit` {needs} `if` lasts: move `fit` inside `if`
        d = pause near (left left)
        r $ chance 1/2 d ease d
            ^^^^^^ open-length: `chance` {needs} `d` lasts: move `chance` inside `d`
                         ^^^^ open-length: `ease` {needs} `d` lasts: move `ease` inside `d`
        r $ choose (d left)
            ^^^^^^ open-length: `choose` {needs} `d` lasts: choose among others
        back (m) = retrograde m
        r $ back (left d)
                 ^^^^^^^^ open-length: in `back`: `retrograde` {needs} `m` lasts: move `retrograde` inside `m`
    """)


def test_a_repeat_that_freezes_once_something_is_near() -> None:
    turn = "it stands here until what is near goes away: to turn away, turn outside `until`:"
    check(
        f"""
        room 6 4
        waits = until near (repeat forward)
        a $ repeat (until near (forward forward))
            ^^^^^^ may-stall: {turn} `repeat (until near (repeat forward) left)`
        b $ repeat (waits until near (repeat left))
            ^^^^^^ may-stall: {turn} `repeat (until near (repeat forward) left)`
        c $ repeat (until bump (repeat forward))
            ^^^^^^ may-stall: {turn} `repeat (until bump (repeat forward) left)`
        d $ repeat 9 waits
        e $ repeat (waits left)
        f $ repeat (until not near (repeat left))
        g $ repeat (waits until not near (repeat left))
        """,
        hints=True,
    )


def test_an_until_that_watches_one_word() -> None:
    check_all("""
        room 6 4
        r $ until near forward left
            ^^^^^^^^^^^^^^^^^^ short-reach: `until` watches `forward` alone, for one beat at most: write `repeat` before it, or brackets around all that it should watch
        r $ repeat 3 until near forward
                     ^^^^^^^^^^^^^^^^^^ short-reach: `until` watches `forward` alone, for one beat at most: write `repeat` before it
        r $ (until near forward) left until near (forward left)
    """)  # noqa: E501


def test_near_looks_ahead() -> None:
    check("""
        x = repeat backward
        r $ until near x
                  ^^^^ looks-ahead: `near` looks only ahead, and this goes backward: declare a sense that looks there in improv.toml
        r $ pause near repeat 4 (strafeleft left)
                  ^^^^ looks-ahead: `near` looks only ahead, and this goes sideways: declare a sense that looks there in improv.toml
        r $ until near repeat 900 (backward left)
                  ^^^^ looks-ahead: `near` looks only ahead, and this goes backward: declare a sense that looks there in improv.toml
        r $ until near repeat 4 left until not near repeat 4 backward until near repeat (backward forward)
        r $ until near choose (left forward) until near repeat choose (forward left)
    """)  # noqa: E501


def test_real_robots_need_a_source_of_their_senses() -> None:
    check(
        """
        x = until near repeat left
        anna $ x until bump repeat left
        ^^^^ missing-sense: outside the simulator, nothing senses `near` for `anna`: add `[senses.near]` to improv.toml, or set `near` in its profile
                       ^^^^ missing-sense: outside the simulator, nothing senses `bump` for `anna`: add `[senses.bump]` to improv.toml
        bo $ x until cue repeat left
        bo anna $ if bump left else right
                     ^^^^ missing-sense: outside the simulator, nothing senses `bump` for `bo` and 1 more: add `[senses.bump]` to improv.toml
        """,  # noqa: E501
        robots=TWO_ROBOTS,
    )
    check("anna bo $ until bump repeat left", robots=TWO_ROBOTS + BUMPER)


def test_with_senses_only_unreachable_words_are_marked() -> None:
    """Check that only movements that can never be reached are marked."""
    check(
        """
        room 6 4
        r $ (until near repeat forward) left (if near repeat left else right) forward
        r $ (until near (forward forward)) || (left left left)
                                                         ^^^^ never-performed: 1 of these 3 beats is never performed: make the movement alongside longer, or remove this
        r $ repeat (until near (forward left)) (left right)
            ^^^^^^ may-stall: it stands here until what is near goes away: to turn away, turn outside `until`: `repeat (until near (repeat forward) left)`
                                               ^^^^^^^^^^^^ never-performed: the movement before this never ends: give its `repeat` a number, or remove this
        """,  # noqa: E501
        hints=True,
    )
    check("room 6 4\nr $ until cue repeat left\n---\nr $ pause near repeat 4 left\n---\nr $ left", hints=True)


def test_a_part_lists_the_senses_it_reads() -> None:
    program = "x = until near repeat left\nanna $ x\n---\nanna $ if bump left else (until fire right)\nbo $ left"
    parts = score_of(analyze(program, read_robots(TWO_ROBOTS + BUMPER))).parts
    assert parts["anna"].senses == {"near": BuiltIn("near"), "bump": Topic("/anna/bumper", "std_msgs/Bool")}
    assert parts["bo"].senses == {}


DEEP = 249


@pytest.mark.slow("performs the deepest movement there may be")
def test_the_deepest_open_movement_is_performed() -> None:
    chain = "".join(f"x{level + 1} = x{level} left\n" for level in range(DEEP - 1))
    text = "room 6 4\nx0 = until near repeat forward\n" + chain + f"r $ (x{DEEP - 1})\n"
    analysis = analyze(text)
    assert [each.code for each in analysis.diagnostics] == []
    score = from_json(json.loads(json.dumps(to_json(score_of(analysis)))))
    performer = Performer(score.parts["r"].movement)
    performer.settle(lambda sense: True)
    performer.advance(1)
    performer.settle(lambda sense: True)
    assert performer.performed(lambda sense: True)[0].yaw == 1
    end = len(text)
    too_deep = analysis.edited(end, end, f"y = x{DEEP - 1} left left\nr $ y left")
    assert [each.code for each in too_deep.diagnostics] == ["too-deep"]


@pytest.mark.parametrize(
    ("script", "message"),
    [
        ("[", "this is not JSON: Expecting value: line 1 column 2 (char 1)"),
        ("[" * 100_000, "this is not JSON: "),
        ("{}", "write a list, such as"),
        ('[{"sense": "near"}]', "entry 1: write `sense`, `from`, and perhaps `to` and `robot`, and nothing else"),
        ('[{"sense": "near", "from": 0}, 3]', "entry 2: write `sense`, `from`"),
        ('[{"sense": 3, "from": 0}]', "entry 1: write"),
        ('[{"sense": "near", "from": "0"}]', "entry 1: write"),
        ('[{"sense": "near", "from": NaN}]', "entry 1: write"),
        ('[{"sense": "near", "from": 0, "to": 1e400}]', "entry 1: write"),
        ('[{"sense": "near", "from": 0, "til": 1}]', "entry 1: write"),
        ('[{"sense": "near", "from": 2, "to": 1}]', "entry 1: `to` is before `from`: swap them"),
    ],
)
def test_errors_in_scripts(script: str, message: str) -> None:
    with pytest.raises(ScriptError) as error:
        read_script(script)
    assert str(error.value).startswith(message)
    assert "\n" not in str(error.value)
