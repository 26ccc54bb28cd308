"""The likeliest slips: their messages, and the programs after each fix."""

from __future__ import annotations

import pytest

from improv_core.program.analysis import analyze
from improv_core.robots.config import read_robots
from tests.program.drawing import check, check_all
from tests.program.test_fixes import fixed


def check_fixes(before: str, *after: str, robots: str = "") -> None:
    """Check that the fixes of the first diagnostic make these programs, each without errors of the same code."""
    analysis = analyze(before, read_robots(robots))
    problem = analysis.diagnostics[0]
    made = [fixed(analysis, fix) for fix in problem.fixes]
    assert made == list(after)
    for program in made:
        assert problem.code not in [each.code for each in analyze(program, read_robots(robots)).diagnostics]


def test_slips_have_advice() -> None:
    check_all("""
        r $ forward 2
                    ^ missing-unit: `forward 2` needs a unit, such as `2m`
        r $ rest 2
                 ^ missing-unit: `rest` takes no measure: write `repeat 2 rest`
        r $ (forward left) 3/2
                           ^^^ syntax: write `scale 3/2 ( … )`: the number comes first
        r $ repeat forward 4
                           ^ missing-unit: `forward 4` needs a unit, such as `4m`
        r $ halfleft 45
            ^^^^^^^^^^^ missing-unit: `halfleft` takes no measure: write `left 45deg`
        Beat 60
        ^^^^^^^ syntax: write `beat 60` to set the tempo
        turtle1: forward
               ^ syntax: write `$` instead of `:`
        anna, bob,cy $ forward
            ^ syntax: separate robots with spaces, without `,`
        forward left
        ^^^^^^^^^^^^ syntax: write a robot or a name before the movement: `r $ …` or `name = …`
        r $ wait Turn
            ^^^^ unknown-name: `wait` is not defined: did you mean `rest`?
                 ^^^^ unknown-name: `Turn` is not defined: did you mean `left` or `right`?
        s $ repeat forward left
                           ^^^^ never-performed: `repeat` repeats only `forward`, forever: put everything that it should repeat in `( )`
        t $ repeat reverse forward left right
                                   ^^^^^^^^^^ never-performed: `repeat` repeats only one movement, forever: put everything that it should repeat in `( )`
        u $ repeat (forward left) right
                                  ^^^^^ never-performed: the movement before this never ends: give its `repeat` a number, or remove this
        turtle2 = left
        ^^^^^^^ unused-name: nothing uses `turtle2`: if it is a robot, write `turtle2 $ …`
    """)


@pytest.mark.parametrize(
    ("before", "after"),
    [
        ("r $ left forward 2", ["r $ left forward 2m", "r $ left repeat 2 forward"]),
        ("r $ reverse [up [left]] 2", ["r $ reverse repeat 2 [up [left]]", "r $ reverse scale 2 [up [left]]"]),
        ("r $ (up # 2 times\n  2)", ["r $ (up # 2 times\n  2m)", "r $ (repeat 2 up # 2 times\n  )"]),
        ("r $ left 90", ["r $ left 90deg"]),
        ("r $ left -90", ["r $ right 90deg"]),
        ("r $ right 45", ["r $ right 45deg"]),
        ("r $ left 180", ["r $ left 180deg"]),
        ("r $ halfright -30", ["r $ left 30deg"]),
        ("r $ forward -1", ["r $ backward 1m"]),
        ("r $ -1 forward", ["r $ backward"]),
        ("r $ up -1/2 left", ["r $ down 1m/2 left"]),
        ("r $ up -2", ["r $ down 2m"]),
        ("r $ (up left) -1", ["r $ retrograde (up left)"]),
        ("r $ (up left) -2", ["r $ repeat 2 retrograde (up left)", "r $ scale 2 retrograde (up left)"]),
        ("r $ forward 1", ["r $ forward 1m", "r $ repeat 1 forward"]),
        ("r $ 1 forward", ["r $ forward"]),
        ("r $ forward 0", ["r $ rest"]),
        ("r $ rest -2", []),
        ("r $ (up) 0", []),
        ("r $ forward 3/0", []),
        ("r $ repeat forward -2", ["r $ repeat backward 2m"]),
        ("r $ repeat forward 4", ["r $ repeat forward 4m", "r $ repeat 4 forward"]),
        ("r $ up 2*3 (left)", ["r $ up 2m*3 (left)", "r $ repeat 2*3 up (left)"]),
        ("r $ 3/2 (left) up", ["r $ scale 3/2 (left) up"]),
        ("r $ 90 left", ["r $ left 90deg"]),
        ("r $ 30 left", ["r $ left 30deg"]),
        ("x = up\nr $ x 2 up", ["x = up\nr $ repeat 2 x up", "x = up\nr $ scale 2 x up"]),
        ("f n = repeat n up\nr $ up", ["r $ up"]),
        ("BEAT 60\nr $ left", ["beat 60\nr $ left"]),
        ("tempo 90\nr $ left", ["beat 90\nr $ left"]),
        ("r: left", ["r $ left"]),
        ("anna, bob,cy , di $ up", ["anna bob cy  di $ up"]),
        ("forward left", ["turtle1 $ forward left"]),
        ("r square left", ["turtle1 $ r square left"]),
        ("r left", ["r $ left"]),
        ("r $ mirror left", ["r $ reflect sagittal left"]),
        ("r $ reflect left", ["r $ reflect sagittal left"]),
        ("r $ fast left", ["r $ fast 2 left"]),
        ("r $ ramp 1 left", ["r $ ramp 1 2 left"]),
        ("r $ ramp 1 2* left", []),
        ("beat 30*x\nr $ left", []),
        ("Tempo 30*2\nr $ left", ["beat 30*2\nr $ left"]),
        ("r $ accelerate (left up)", ["r $ ramp 1/2 2 (left up)"]),
        ("r $ circle 60cm left", ["r $ left 360deg radius 60cm left"]),
        ("r $ star", ["star = repeat 5 (forward left 144deg)\nr $ star"]),
        ("r $ stop", ["r $ rest"]),
        ("r $ turn", ["r $ left", "r $ right"]),
        ("r $ repeat forward left up", ["r $ repeat (forward left up)", "r $ repeat forward "]),
        ("x = left", ["x $ left", ""]),
        ("x = left\nr $ up", ["r $ up", "x $ left\nr $ up"]),
        ("turtle1 = left\nr $ up", ["turtle1 $ left\nr $ up", "r $ up"]),
        ("r $ square 2m", ["r $ repeat 4 (forward 2m left)"]),
        ("r $ wait 2 beats up", ["r $ repeat 2 rest up"]),
        ("r $ wait 2*3 up", ["r $ rest 2*3 up"]),
        ("r $ accelerate 4 (left up)", ["r $ fit 4 ramp 1/2 2 (left up)"]),
        ("r $ speed up (left)", ["r $ ramp 1/2 2 (left)"]),
        ("r $ faster 3 up", ["r $ fast 3 up"]),
        ("r $ turn around", ["r $ left 180deg"]),
        ("r $ step left", ["r $ strafeleft"]),
        ("r $ up 4 beats", ["r $ slow 4 up", "r $ repeat 4 up"]),
        ("r $ repeat up 4 times", ["r $ repeat 4 up"]),
        ("r $ repeat (4 up left)", ["r $ repeat 4 (up left)"]),
        ("r $ rest 2s", ["r $ repeat 2 rest"]),
        ("r $ 4 times (up left)", ["r $ repeat 4 (up left)"]),
        ("r $ (up left) 4 times", ["r $ repeat 4 (up left)"]),
        ("r $ repeat 4x (up left)", ["r $ repeat 4 (up left)"]),
        ("r s $ canon 4 beats (up left)", ["r s $ canon 4 (up left)"]),
        ("r $ repeat four (up left)", ["r $ repeat 4 (up left)"]),
        ("r $ up*4", ["r $ repeat 4 up", "r $ scale 4 up"]),
        ("r $ 4*up", ["r $ repeat 4 up", "r $ scale 4 up"]),
        ("r $ left90", ["r $ left 90deg"]),
        ("r $ up then left", ["r $ up left"]),
        ("r $ up and left", ["r $ up  left", "r $ up || left"]),
        ("r $ up + left", ["r $ up  left", "r $ up || left"]),
        ("r $ choose (up | left)", ["r $ choose (up  left)"]),
        ("r $ until wall repeat forward", ["r $ until near repeat forward"]),
        ("r is puppet\nr $ left arm up", ["r is puppet\nr $ left_arm up"]),
        ("r is puppet\nr $ arms high", ["r is puppet\nr $ arms to high"]),
        ("r is a puppet\nr $ up", ["r is puppet\nr $ up"]),
        ("r is puppet\nhop(n) = scale n*2 up\nr $ hop 2", ["r is puppet\nhop n = scale n*2 up\nr $ hop 2"]),
        ("tempo = 90\nr $ up", ["beat 90\nr $ up"]),
        ("90 bpm\nr $ up", ["beat 90\nr $ up"]),
        ("beat90\nr $ up", ["beat 90\nr $ up"]),
        ("r -> up", ["r  $ up"]),
        ("hop: up\nr $ hop", ["hop = up\nr $ hop"]),
        ("intro:\nr $ up", ["--- intro\nr $ up"]),
        ("r $ 1.5m up", ["r $ up 1.5m"]),
        ("r $ (left up) x 4", []),
        ("r $ left/2", ["r $ scale 1/2 left"]),
        ("r $ up 10 steps", ["r $ repeat 10 up"]),
        ("r $ pause 2 up", []),
        ("r $ speed 2 up", ["r $ fast 2 up"]),
        ("r at 1,2\nr $ up", ["r at 1 2\nr $ up"]),
        ("r at 1,5 2\nr $ up", ["r at 1.5 2\nr $ up"]),
        ("r $ up\nhop = up\nr hop", ["r $ up\nhop = up\nr $ hop"]),
        ("let hop = up\nr $ hop", ["hop = up\nr $ hop"]),
        ("my hop = up\nr $ my_hop", ["my_hop = up\nr $ my_hop"]),
        ("bars 3\nr $ up", ["bar 3\nr $ up"]),
        ("room 6 by 4\nr $ up", ["room 6   4\nr $ up"]),
        ("r starts at 1 2\nr $ up", ["r at 1 2\nr $ up"]),
        ("r.up", ["r $up"]),
        ("r $ up\nscene 2\nr $ up", ["r $ up\n--- scene2\nr $ up"]),
    ],
)
def test_fixes_of_slips(before: str, after: list[str]) -> None:
    check_fixes(before, *after)


def test_words_of_logo_become_measures() -> None:
    check("""
        r $ fd 100 arc 90
            ^^ unknown-name: `fd` is not defined: write `forward 100cm`
                   ^^^ unknown-name: `arc` is not defined: write `arc = left 90deg radius 1m` above this line
    """)
    logo = analyze("r $ REPEAT 4 [FD 100 RT 90]")
    assert fixed(logo, logo.diagnostics[0].fixes[0]) == "r $ repeat 4 (FD 100 RT 90)"
    check_fixes("r $ RT 90", "r $ right 90deg")
    check_fixes("r $ turn 30", "r $ left 30deg", "r $ right 30deg")


def test_figures_robots_and_measures_are_no_unknown_movements() -> None:
    check("""
        ada $ heart
              ^^^^^ unknown-name: `heart` is not defined: write `heart = forward 70cm left 180deg radius 35cm right 90deg left 180deg radius 35cm forward 70cm` above this line
        bo $ mirror ada
             ^^^^^^ unknown-name: `mirror` is not defined: did you mean `reflect sagittal`?
                    ^^^ unknown-name: `ada` is a robot, not a movement: name the movement that both perform, and write that name here
        cy $ dot 60cm
             ^^^ unknown-name: `dot` is not defined: write `dot = …` above this line
                   ^^ unknown-name: `60cm` is a measure: write it behind a word such as `forward`, `left`, or `radius`
        di $ left 360 radius 60 cm
                  ^^^ missing-unit: `left 360` needs a unit, such as `360deg`
                             ^^^^^ missing-unit: write the unit directly behind the number: `radius 60cm`
        speed 2
        ^^^^^^^ syntax: write `beat 120` to set the tempo, or `fast 2` before a movement to double its speed
    """)


def test_words_that_ask_for_an_idea_get_its_idiom() -> None:
    check("""
        bo $ follow ada
             ^^^^^^ unknown-name: `follow` is not defined: name a movement that all play, and have each follow the one before it: `ada bo $ canon 2 name`
                    ^^^ unknown-name: `ada` is not defined: write `ada = …` above this line
        bo $ face
             ^^^^ unknown-name: `face` is not defined: turn by an angle, such as `left 45deg`, or start the robot that way: `ada at 0 0 facing 90`
        ramp 4 up
        ^^^^^^^^^ syntax: write a robot or a name before the movement: `bo $ …` or `name = …`
        song "x.mp3"
        ^^^^^^^^^^^^ syntax: set the song in improv.toml: under `[music]`, write `file = "x.mp3"`
        ada bo in ring
        ^^^^^^^^^^^^^^ syntax: write `at` and a formation or a place: `ada at circle 1.5`, or `ada at -1 0 facing 90`
        forward $ bo
        ^^^^^^^ reserved-name: `forward` is a reserved word: choose another name, or write it after `$`
                  ^^ unknown-name: `bo` is a robot, not a movement: name the movement that both perform, and write that name here
        bo $ repeat (forward until near)
                                       ^ syntax: write the movement after the sense: `until near (repeat forward)`
    """)


def test_a_word_is_suggested_only_if_most_of_its_letters_are_there() -> None:
    stretches = ("follow", "dance", "raise", "rechts", "beast", "sit", "past")
    suggested = [
        each.message.partition("did you mean")[1] for name in stretches for each in analyze(f"r $ {name}").diagnostics
    ]
    assert suggested == [""] * len(stretches)
    for name, word in (("reapt", "repeat"), ("eft", "left"), ("accum", "accumulate"), ("Rigth", "right")):
        assert f"did you mean `{word}`?" in analyze(f"r $ {name} up").diagnostics[0].message


def test_numbers_are_written_without_brackets_commas_and_sums() -> None:
    check("""
        poly n = repeat n (forward left)
        r $ poly(3)
                ^^^ syntax: write `3` without brackets: only movements can stand in them
        r $ ramp (1) 2 left
                 ^^^ syntax: write `1` without brackets: only movements can stand in them
        r $ ramp 1/2, 2 left
                    ^ syntax: remove `,`: separate numbers with spaces
        sides = 3
                ^ syntax: names stand for movements only: write `3` where you need it
        r $ repeat 3+1 left
                    ^^ syntax: numbers can be multiplied and divided, but not added or subtracted: write the result
    """)
    check_fixes("p n = repeat n left\nr $ p(3)\nr $ p 2", "p n = repeat n left\nr $ p 3\nr $ p 2")
    check_fixes("r $ ramp (1) 2 left", "r $ ramp 1 2 left")
    check_fixes("r $ ramp 1/2, 2 left", "r $ ramp 1/2 2 left")


def test_a_parameter_in_brackets_takes_no_number() -> None:
    check("""
        poly (n) = repeat 2 n
        r $ poly 3
            ^^^^ arguments: `poly` takes 1 movement, not 1 number: for a number, write `n` without brackets in its head
    """)


def test_a_lines_own_names_and_robots_are_taken_before_words_like_them() -> None:
    check("""
        dance = forward
        ada $ left
        dance
        ^^^^^ syntax: write a robot first: `ada $ dance`
        danse
        ^^^^^ syntax: write a robot first: `ada $ dance`
        dance left
        ^^^^^^^^^^ syntax: write a robot first: `ada $ dance …`
        reverse dance
        ^^^^^^^^^^^^^ syntax: write a robot or a name before the movement: `ada $ …` or `name = …`
    """)
    check_fixes("dance = forward\ndance left", "dance = forward\nturtle1 $ dance left")
    check_fixes("jump\njump = up", "turtle1 $ jump\njump = up")
    check_fixes("jump = up\njump", "jump = up\nbo $ jump", robots="[robots.bo]\n")


@pytest.mark.parametrize(
    ("before", "after"),
    [
        ("beat 120 ada $ left", "beat 120\nada $ left"),
        ("tempo 90*2  x = left", "beat 90*2\nx = left"),
        ("ada & bo $ left", "ada  bo $ left"),
        ("ada;bo + cy $ left", "ada bo  cy $ left"),
    ],
)
def test_stray_words_before_a_sign_are_removed(before: str, after: str) -> None:
    check_fixes(before, after)


def test_the_word_and_between_robots_gets_a_hint() -> None:
    check_all("""
        ada bo and cy $ left
               ^^^ robot-named-and: this makes a robot called `and`: separate robots with spaces only
        and ada $ left
        all $ left
        ^^^ robot-named-and: this makes a robot called `all`: list the names of all robots instead
    """)
    check_fixes("ada and bo $ left", "ada bo $ left")
    listed = "[robots.ada]\n[robots.bo]\n"
    check_fixes("ada and bo $ left", "ada bo $ left", robots=listed)
    assert analyze("ada and bo $ left", read_robots(f"{listed}[robots.and]\n")).diagnostics == ()


def test_lines_after_an_endless_one_are_marked() -> None:
    check_all("""
        ada bo $ repeat forward
        ada $ left
        ^^^^^^^^^^ never-performed: line 1 never ends, so this is never performed: give its `repeat` a number
        cy bo $ left
           ^^ never-performed: line 1 never ends, so `bo` never performs this: give its `repeat` a number
        dan $ until cue repeat left
        dan $ up
        ---
        cy $ repeat left
        ^^^^^^^^^^^^^^^^ never-performed: scene 1 above never ends, so this is never performed: give its `repeat` a number
    """)


def test_a_listed_robot_that_is_defined_is_meant_to_play() -> None:
    check_fixes("ada = left\nbo $ up", "ada $ left\nbo $ up", "bo $ up", robots="[robots.ada]\n[robots.bo]\n")
