"""Diagnostics of errors, and their places."""

from __future__ import annotations

import pytest

from improv_core.diagnostics import Severity
from improv_core.program.analysis import analyze
from improv_core.program.reader import Reader
from improv_core.score.movement import ENDLESS, Movement
from improv_core.syntax.nodes import Node
from tests.program.drawing import check, check_all


def errors(text: str) -> list[str]:
    """Return the codes of the errors in a program."""
    return [each.code for each in analyze(text).diagnostics if each.severity is Severity.ERROR]


def test_syntax_errors_advise_what_to_write() -> None:
    check("""
        x = reflect left
                    ^^^^ syntax: write a plane after `reflect`: `sagittal` mirrors left and right, `frontal` front and back
        x = fast forward
                 ^^^^^^^ syntax: write a number after `fast`, such as `fast 2 movement`
        x = forward ||
                    ^^ syntax: write a movement after `||`
        x = forward 3 left
                    ^ missing-unit: `forward 3` needs a unit, such as `3m`
        x = forward, left
                   ^ syntax: remove `,`: separate movements with spaces
        x = YZ forward
            ^^ syntax: write `reflect` before `YZ`
        x =
          ^ syntax: write a movement after `=`
        x 2 = forward
          ^ syntax: `2` is not a valid name: use letters, digits, and `_`, starting with a letter or `_`
        = forward
        ^ syntax: write a name before `=`
        $ forward
        ^ syntax: write a robot's name before `$`
        r $ forward $ left
                    ^ syntax: remove `$` or start a new line before it
        turtle1 repeat 4 forward
        ^^^^^^^ syntax: write `$` after the robot's name: `turtle1 $ …`
        beat
        ^^^^ syntax: write a number after `beat`, such as `beat 60`
        turtle1 $ forward 😀
                          ^ syntax: remove `😀`, a grinning face, U+1F600: it is not part of the language
    """)


def test_brackets_are_marked_themselves() -> None:
    check("""
        x = (forward [left)
                     ^ unclosed-bracket: close this bracket with `]`
        y = forward left)
                        ^ unmatched-bracket: remove this `)` or add the bracket it should close
        z = (forward left]
                         ^ unmatched-bracket: write `)` here to close `(`
        r $ (x
            ^ unclosed-bracket: close this bracket with `)`
          y
        beat 60
    """)


def test_names_must_be_defined_above() -> None:
    check("""
        r $ foward
            ^^^^^^ unknown-name: `foward` is not defined: did you mean `forward`?
        r $ spin
            ^^^^ used-before-definition: `spin` is not defined until line 3: move its definition above this line
        spin = left left
        r $ spn Left
            ^^^ unknown-name: `spn` is not defined: did you mean `spin`?
                ^^^^ unknown-name: `Left` is not defined: did you mean `left`?
        r $ qqq
            ^^^ unknown-name: `qqq` is not defined: write `qqq = …` above this line
        me = me left
             ^^ used-before-definition: `me` is used in its own definition: define it first, above line 6
        me = me left
    """)


def test_numbers_must_make_sense() -> None:
    check("""
        beat 0
             ^ bad-number: write the tempo as a number above 0
        r $ repeat -1 left
                   ^^ bad-number: write the number after `repeat` as a number above 0
        r $ fast 0 left
                 ^ bad-number: write the number after `fast` as a number above 0
        r $ slow 1/0 left
                 ^^^ bad-number: write the number after `slow` without dividing by 0
        r $ scale 1111111111111111111111111111111 left
                  ^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^ bad-number: write the number after `scale` with at most 30 characters
        r $ repeat 0 left
        r $ repeat 4/2 left
    """)


def test_words_and_robots() -> None:
    check("""
        YZ $ left
        ^^ reserved-name: `YZ` is a reserved word: choose another name, or write it after `$`
        my-robot größe _r $ left
        ^^^^^^^^ bad-robot-name: `my-robot` is not a valid robot name: use a to z, digits, and `_`, starting with a letter
                 ^^^^^ bad-robot-name: `größe` is not a valid robot name: use a to z, digits, and `_`, starting with a letter
                       ^^ bad-robot-name: `_r` is not a valid robot name: use a to z, digits, and `_`, starting with a letter
        größe = left
        _r = größe
    """)


def test_one_beat_for_a_document() -> None:
    analysis = check("""
        r $ forward
        beat 90
        beat 30
        ^^^^^^^ duplicate-beat: line 2 already sets the tempo: remove this `beat`
    """)
    assert analysis.tempo == 90


@pytest.mark.parametrize("wrap", ["(%s)", "[%s]", "reverse %s", "repeat 2 %s", "(left %s || rest)", "[left %s right]"])
def test_deep_nesting_is_reported_and_never_raises(wrap: str) -> None:
    def nested(levels: int) -> str:
        return "r $ " + wrap.split("%s")[0] * levels + "left" + wrap.split("%s")[1] * levels

    assert errors(nested(200)) == []
    assert errors(nested(201)) == ["too-deep"]
    assert errors(nested(4_000)) == ["too-deep"]
    assert errors(nested(100_000)) == ["syntax"]  # too long to be read at all


@pytest.mark.parametrize(
    "term", ["repeat 2 (left right)", "reverse [left]", "if s (left) else (right)", "choose (left)"]
)
def test_terms_beside_one_another_are_not_nested(term: str) -> None:
    assert "too-deep" not in errors("r $ (" + f"{term} " * 300 + ")")


@pytest.mark.parametrize("line", ["x = x || left right", "x = x || x", "x = [x || left x]", "x = repeat (x || x)"])
def test_voices_are_bounded_through_names(line: str) -> None:
    assert set(errors("x = forward left\n" + f"{line}\n" * 250 + "r $ x")) == {"too-deep"}


def test_as_many_voices_as_may_play_at_once() -> None:
    check("r $ " + " || ".join(["forward"] * 250))
    (diagnostic,) = analyze("r $ " + " || ".join(["forward"] * 251)).diagnostics
    assert diagnostic.message == "251 voices play at once here, and 250 is the most: use fewer"


def test_the_lines_of_a_robot_make_no_fraction_too_long() -> None:
    lines = [f"r $ {f'fast 1.{odd:028} ' * 10}left" for odd in range(1, 20)]
    assert errors("\n".join(lines[:4])) == []
    assert errors("\n".join(lines[:4] + ["q" + line[1:] for line in lines[4:8]])) == []
    analysis = analyze("\n".join([*lines, "r $ forward"]))
    assert {(each.code, each.span.start > sum(map(len, lines[:4]))) for each in analysis.diagnostics} == {
        ("bad-number", True)
    }
    assert len(analysis.diagnostics) == 15
    assert analysis.robots["r"].duration == analyze("\n".join([*lines[:4], "r $ forward"])).robots["r"].duration
    shorter = analysis.edited(0, len(lines[0]), "r $ left")
    assert shorter.diagnostics == analyze(shorter.text).diagnostics
    assert len(shorter.diagnostics) == 14


def test_fractions_cannot_be_blown_up() -> None:
    nested = "r $ " + "fast 1.000000001 " * 199 + "left"
    (diagnostic,) = analyze(nested).diagnostics
    assert diagnostic.code == "bad-number"
    assert diagnostic.message == "these numbers make a fraction too long to compute exactly: use simpler ones"
    doubled = "x = left\n" + "x = x x\n" * 5000
    assert set(errors(doubled)) == {"bad-number"}


def test_an_error_affects_no_other_line() -> None:
    analysis = analyze("x = (forward\ny = left left\nr $ y\nr2 $ repeat\nr3 $ repeat y ]\n")
    assert errors(analysis.text) == ["unclosed-bracket", "syntax", "unmatched-bracket"]
    assert analysis.robots["r"].duration == 2
    assert analysis.robots["r3"].duration == ENDLESS
    assert analysis.meanings[0].movement.duration == 1


def test_cut_off_words_are_reported() -> None:
    check_all("""
        s $ (repeat left) forward [right right]
                          ^^^^^^^^^^^^^^^^^^^^^ never-performed: the movement before this never ends: give its `repeat` a number, or remove this
        r $ reverse (forward left || right)
                             ^^^^ never-performed: 1 of these 2 beats is never performed: make the movement alongside longer, or remove this
        r $ reverse (forward left) || right
                     ^^^^^^^ never-performed: 1 of these 2 beats is never performed: make the movement alongside longer, or remove this
        r $ [forward left right || slow 2 left]
        r $ fast 2 (forward left right rest) || rest
                                 ^^^^^^^^^^ never-performed: 2 of these 4 beats are never performed: make the movement alongside longer, or remove this
        r $ repeat 3 (forward left) || rest rest rest
        r $ repeat 3 (forward left) || rest
                              ^^^^ never-performed: 1 of these 2 beats is never performed: make the movement alongside longer, or remove this
        r $ forward || () || []
                       ^^ empty-group: `()` is empty: write a movement in it or remove it
                             ^^ empty-group: `[]` is empty: write a movement in it or remove it
        r $ [left slow 2 left forward || up down]
                              ^^^^^^^ never-performed: 1 of these 4 beats is never performed: make the movement alongside longer
        t $ [left repeat left forward] up
            ^^^^^^^^^^^^^^^^^^^^^^^^^^ bracket-not-a-beat: this bracket never ends
                              ^^^^^^^ never-performed: `repeat` repeats only `left`, forever: put everything that it should repeat in `( )`
                                       ^^ never-performed: the movement before this never ends: give its `repeat` a number, or remove this
        r $ [(left forward || left) up]
                   ^^^^^^^ never-performed: 1 of these 2 beats is never performed: make the movement alongside longer, or remove this
        r $ slow 2 (left (forward right || slow 3/2 left))
                          ^^^^^^^^^^^^^ cut-short: `||` ends with its shortest side, so 0.5 of these 2 beats are never performed: repeat the shorter side, or write `( )` around both
        r $ repeat 4 forward || left
            ^^^^^^^^^^^^^^^^ cut-short: `||` ends with its shortest side, so 3 of these 4 beats are never performed: repeat the shorter side, or write `( )` around both
        r $ repeat 4 forward || repeat left
        r $ repeat 4 forward || rest
        r $ until near slow 2 left || left
        r $ slow 2 (left repeat 2 forward left) || repeat 4 rest
                                          ^^^^ never-performed: 2 of these 4 beats are never performed: make the movement alongside longer, or remove this
        r $ repeat left
        r $ right
        ^^^^^^^^^ never-performed: line 18 never ends, so this is never performed: give its `repeat` a number
    """)


def test_the_length_of_a_series_may_be_too_large_although_those_of_its_items_are_not() -> None:
    factors = "fast 1.000000001 " * 30, "fast 1.000000003 " * 30
    (wrong,) = analyze(f"r $ {factors[0]}(forward || left) {factors[1]}(left || up)").diagnostics
    assert wrong.code == "bad-number"


def test_items_that_dice_may_choose_are_performed() -> None:
    check_all("""
        late (m) = ease (left m)
        t $ choose (repeat left repeat right)
        s $ shuffle (repeat left up repeat (up || right right))
                                                        ^^^^^ never-performed: 1 of these 2 beats is never performed: make the movement alongside longer
        r $ rest || late up
    """)


def test_unused_names_are_reported() -> None:
    check_all("""
        x = forward
        ^ unused-name: nothing uses `x`: use it below or remove this line
        x = left
        x = x right
        y = left
        ^ unused-name: nothing uses `y`: use it below or remove this line
        r $ x
    """)


def test_a_misspelled_name_is_one_problem_and_not_an_unused_definition_too() -> None:
    check_all("""
        square = repeat 4 (forward left)
        r $ sqare
            ^^^^^ unknown-name: `sqare` is not defined: did you mean `square`?
    """)


def test_brackets_that_are_not_a_beat_report_their_length() -> None:
    check_all("""
        r $ [forward [left left] forward]
        r $ [(forward left) right]
            ^^^^^^^^^^^^^^^^^^^^^^ bracket-not-a-beat: this bracket takes 3/2 beats, not one
        r $ [rest || slow 2 rest]
        r $ [repeat rest]
            ^^^^^^^^^^^^^ bracket-not-a-beat: this bracket never ends
        r $ [left frwd]
                  ^^^^ unknown-name: `frwd` is not defined: did you mean `forward`?
    """)


def test_the_time_to_find_cut_off_sides_grows_only_with_their_number(monkeypatch: pytest.MonkeyPatch) -> None:
    looked, look = list[Node](), Reader.movement_made

    def note(reader: Reader, node: Node) -> Movement:
        looked.append(node)
        return look(reader, node)

    monkeypatch.setattr(Reader, "movement_made", note)
    sides = 200
    found = analyze(f"r $ {'left forward || ' * (sides - 1)}repeat 3 (forward left)\n").diagnostics
    assert [each.code for each in found] == ["cut-short"]
    assert len(looked) < 20 * sides
