"""Scenes, canons, and the other words of language 2: their diagnostics."""

from __future__ import annotations

from improv_core.program.analysis import analyze
from improv_core.program.compiler import compiled
from tests.program.drawing import check, check_all


def test_a_robot_ends_after_its_last_scene_whatever_others_sense() -> None:
    for word in ("slow 2 left", "until near slow 2 left"):
        analysis = analyze(f"a b $ [left up]\n---\na b $ left\n---\nb $ {word}\n---\nb $ left\n")
        robots = compiled(analysis)["robots"]
        assert {robot: each["beats"] for robot, each in robots.items()} == {"a": "2", "b": "5"}


def test_scenes_without_a_robot_have_no_effect() -> None:
    check_all("""
        x = left
        ---
        ^^^ no-effect: no robot plays above this line: remove it
        r $ x
        ---
        ^^^ no-effect: no robot plays in this scene: remove this line
        beat 60
        ---
        r $ x
        ---
        ^^^ no-effect: no robot plays in this scene: remove this line
    """)


def test_a_scene_stands_on_a_line_of_its_own() -> None:
    check("""
        --- r $ left
            ^ syntax: remove `r` or start a new line before it
        r $ left --- up
                 ^^^ syntax: write `---` on a line of its own
        r $ (left
            ^ unclosed-bracket: close this bracket with `)`
        ---
        r $ left
    """)


def test_scenes_are_bounded() -> None:
    assert analyze("r $ up\n---\n" * 499 + "r $ up").ok
    analysis = analyze("r $ up\n---\n" * 501 + "r $ up")
    assert [(each.code, each.message) for each in analysis.diagnostics] == [
        ("too-large", "this program has more than 500 scenes: remove some")
    ] * 2
    assert len(analysis.parts["r"]) == 500


def test_canon_stands_in_lines_of_several_robots() -> None:
    check_all("""
        round (m) = canon 2 m
                    ^^^^^ misplaced-canon: `canon` needs the robots of a line: write it after `$`, before the name
        r s $ round left
        r $ canon 2 left
            ^^^^^^^ no-effect: `canon` needs several robots before `$`: add one or remove `canon 2`
        r r $ canon 0 left
              ^^^^^^^ no-effect: `canon` needs several robots before `$`: add one or remove `canon 0`
        r s $ canon -1 left
                    ^^ bad-number: write the number after `canon` as a number above 0
    """)


def test_numbers_out_of_range_are_marked() -> None:
    check("""
        r $ chance 3/2 left chance 0 left chance 1 left
                   ^^^ bad-number: write the number after `chance` as a number above 0 and at most 1
                                   ^ bad-number: write the number after `chance` as a number above 0 and at most 1
        r $ ramp 0 0 left ramp 0 1 left ramp 1 0 left
                 ^^^ bad-number: write a number above 0 after `ramp`: with two zeros it never moves
        r $ fit 0 left seed 0 choose (left right) slow 2/0/3 left
                ^ bad-number: write the number after `fit` as a number above 0
                            ^ bad-number: write the number after `seed` as a number above 0
                                                       ^^^^^ bad-number: write the number after `slow` without dividing by 0
        r $ repeat 3*1/2 left repeat 3*2/2 left
                   ^^^^^ bad-number: write the number after `repeat` as a whole number: 0, 1, 2, …
    """)


def test_an_endless_movement_has_no_length_to_change() -> None:
    check("""
        x = repeat left
        r $ fit 2 x
            ^^^ open-length: `fit` needs a movement that ends: `x` never ends
        r $ ramp 1 2 (left repeat up)
            ^^^^ open-length: `ramp` needs a movement that ends: give `repeat` a number
        r $ ease repeat up
            ^^^^ open-length: `ease` needs a movement that ends: give `repeat` a number
        r $ chance 1/2 x choose (x repeat up)
    """)


def test_words_without_effect_are_marked() -> None:
    check_all("""
        p = left right
        r $ fast 1 left slow 2/2 left scale 1 left repeat 1 left
            ^^^^^^ no-effect: `fast 1` changes nothing: remove it or use another number
                                      ^^^^^^^ no-effect: `scale 1` changes nothing: remove it or use another number
        r $ choose p choose [left right] shuffle left accumulate ((left))
                     ^^^^^^ no-effect: there is one item to choose here: write several in brackets or remove `choose`
                                         ^^^^^^^ no-effect: there is one item to shuffle here: write several in brackets or remove `shuffle`
                                                      ^^^^^^^^^^ no-effect: there is one item to accumulate here: write several in brackets or remove `accumulate`
        r $ seed 3 p seed 3 shuffle p
            ^^^^^^ no-effect: nothing in it throws dice, so `seed` changes nothing: remove `seed 3`
    """)


def test_the_items_of_a_choice_are_equally_long() -> None:
    check("""
        p = left slow 2 right
        r $ choose p
            ^^^^^^ uneven-choice: the items of `choose` differ in length (1 beat, 2 beats): give them one length with `fit`
        r $ choose (left repeat up)
            ^^^^^^ uneven-choice: the items of `choose` differ in length (1 beat, ∞): give them one length with `fit`
        r $ choose (left [up up] ease down)
    """)
