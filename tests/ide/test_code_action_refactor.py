"""Refactorings: the program before and after, with the selection in `<…>`; the dance stays the same."""

from __future__ import annotations

from fractions import Fraction
from functools import partial

from hypothesis import assume, given
from hypothesis import strategies as st

from improv_core.diagnostics import applied
from improv_core.ide.code_action import Action
from improv_core.ide.code_action_refactor import refactorings
from improv_core.program.analysis import Analysis, analyze
from improv_core.program.compiler import compiled
from improv_core.score.performance import SenseSpan
from improv_core.text import Span
from tests.ide.cursor import CURSOR
from tests.random_programs import written

CHANGING = ("Wrap in [ ]", "Wrap in slow", "Other dice", "Write")


def offered(program: str) -> tuple[Analysis, list[Action]]:
    if CURSOR in program:
        start = end = program.index(CURSOR)
        program = program.replace(CURSOR, "")
    else:
        start, end = program.index("<"), program.index(">") - 1
        program = program.replace("<", "").replace(">", "")
    analysis = analyze(program)
    return analysis, refactorings(analysis, Span(start, end))


def check(title: str, before: str, after: str) -> None:
    """Check that the only action with this title turns one program into the other and keeps the dance."""
    analysis, actions = offered(before)
    (action,) = [each for each in actions if each.title.startswith(title)]
    assert applied(analysis.text, action.edits) == after
    if not title.startswith(CHANGING):
        assert compiled(analyze(after))["robots"] == compiled(analysis)["robots"]


extract = partial(check, "Extract to a name")
extract_phrase = partial(check, "Extract to a phrase")
inline = partial(check, "Inline")


def check_not(title: str, program: str) -> None:
    assert [each.title for each in offered(program)[1] if each.title.startswith(title)] == []


def test_a_movement_gets_a_name() -> None:
    extract("r $ <forward left> up", "forward_left = forward left\nr $ forward_left up")
    extract("r $ |>[up down] up", "up_down = [up down]\nr $ up_down up")
    extract("r $ le|>ft up left", "my_left = left\nr $ my_left up left")
    extract("r $ <repeat 4 (forward left)>", "repeat_forward_left = repeat 4 (forward left)\nr $ repeat_forward_left")
    extract("x = up\nr $ <x x x x>", "x = up\nphrase = x x x x\nr $ phrase")
    extract("phrase = up\nr $ <up up up up> phrase", "phrase = up\nphrase_2 = up up up up\nr $ phrase_2 phrase")
    extract("  r $ <left || up>", "  left_up = left || up\n  r $ left_up")
    extract("\ufeffr$(left)<[up]>up # 🐢\r\n", "\ufeffmy_up = [up]\r\nr$(left)my_up up # 🐢\r\n")
    extract("r $ up <left > ", "my_left = left\nr $ up my_left  ")


def test_a_movement_over_lines_gets_brackets() -> None:
    extract("r $ (up\n  <left # l\n  down>)", "left_down = (left # l\n  down)\nr $ (up\n  left_down)")
    extract("r $ <(left\n  up)>", "left_up = (left\n  up)\nr $ left_up")
    extract("r $ (<(left)\n  up> up)", "left_up = ((left)\n  up)\nr $ (left_up up)")


def test_part_of_a_selection_grows_to_whole_items() -> None:
    extract("r $ up (left <|| do>wn)", "left_down = left || down\nr $ up (left_down)")


def test_items_that_a_bracket_counts_are_left_alone() -> None:
    for program in ("r $ [<left up> down]", "r $ [<left up>]", "r $ [<left up || down>]", "r $ [<left up> || down]"):
        check_not("Extract", program)
        check_not("Wrap", program)
    extract("r $ [<left || up>]", "left_up = left || up\nr $ [left_up]")
    check_not("Extract", "x = up\nr $ |>x")
    check_not("Extract", "r $ (<left>")


def test_a_name_is_written_out() -> None:
    inline("x = left up\nr $ |>x down", "r $ left up down")
    inline("x = left up # both\ns $ up\nr $ reverse |>x", "s $ up\nr $ reverse (left up)")
    inline("x = left up\nr $ [|>x down]", "r $ [(left up) down]")
    inline("x = left || up\nr $ |>x down", "r $ (left || up) down")
    inline("x = left || up\nr $ [|>x]", "r $ [(left || up)]")
    inline("x = (left\n  up)\nr$[up]|>x[up]", "r$[up](left\n  up)[up]")
    check("Inline x here", "x = left up\nr $ |>x x", "x = left up\nr $ left up x")
    check("Inline x everywhere", "|>x = left up\nr $ x fast 2 x", "r $ left up fast 2 (left up)")
    inline("x = left up\nr $ if near |>x else up", "r $ if near (left up) else up")
    inline("x = left up\nr $ if near up else |>x down", "r $ if near up else (left up) down")
    inline("x = up\nx = |>x left\nr $ x", "x = up left\nr $ x")


def test_a_name_is_not_inlined_where_its_words_mean_something_else() -> None:
    program = "x = up\ny = x left\nx = down\nr $ |>y x"
    check_not("Inline", program)
    check_not("Inline", program.replace("|>", "").replace("y =", "|>y ="))
    check_not("Inline", "r $ |>x")
    check_not("Inline", "|>x = up")
    check_not("Inline", "x = (up\nr $ |>x")


def test_a_repeat_is_unrolled() -> None:
    check("Unroll", "r $ |>repeat 3 forward", "r $ forward forward forward")
    check("Unroll", "r $ re|>peat 2 (forward left) up", "r $ forward left forward left up")
    check("Unroll", "r $ reverse |>repeat 2 (forward left)", "r $ reverse (forward left forward left)")
    check("Unroll", "r $ [|>repeat 2 up down]", "r $ [(up up) down]")
    check("Unroll", "r $ |>repeat 2 (up || left)", "r $ (up || left) (up || left)")
    check("Unroll", "r $ |>repeat 2 (up\n left)", "r $ (up\n left) (up\n left)")
    for program in ("r $ |>repeat up", "r $ |>repeat 0 up", "r $ |>repeat 33 up", "r $ |>repeat 3/2 up"):
        check_not("Unroll", program)


def test_repeated_items_are_folded() -> None:
    check("Fold into repeat 3", "r $ up forward for|>ward forward left", "r $ up repeat 3 forward left")
    check("Fold into repeat 2", "r $ <forward left forward left> up", "r $ repeat 2 (forward left) up")
    check("Fold into repeat 2", "r $ <forward left  forward left>", "r $ repeat 2 (forward left)")
    check("Fold into repeat 2", "r $ |>(up left) (up  left)", "r $ repeat 2 (up left)")
    check_not("Fold", "r $ [up u|>p]")
    check_not("Fold", "r $ <up left up>")
    check_not("Fold", "r $ (up # one\nu|>p)")


def test_titles_of_wrapping_describe_its_effect() -> None:
    check("Wrap in ( )", "r $ up <left down>", "r $ up (left down)")
    check("Wrap in ( )", "r $ repeat 2 |>left", "r $ repeat 2 (left)")
    check("Wrap in [ ]", "r $ up <left down>", "r $ up [left down]")
    check("Wrap in slow 2", "r$|>(left)up", "r$slow 2 (left)up")


def test_a_movement_with_a_number_becomes_a_phrase() -> None:
    extract_phrase(
        "r $ |>repeat 5 (forward scale 4/5 left) up", "phrase n = repeat n (forward scale 4/n left)\nr $ phrase 5 up"
    )
    extract_phrase("n = up\nr $ <fast 2 up n>", "n = up\nfast_up_n k = fast k up n\nr $ fast_up_n 2")
    extract_phrase("r $ re|>peat 2*3 up", "repeat_up n = repeat n*3 up\nr $ repeat_up 2")
    check_not("Extract to a phrase", "r $ <up left>")
    check_not("Extract to a phrase", "f n = fast n up\nr $ |>f 2")


def test_extracting_words_with_parameters_passes_them_on() -> None:
    extract(
        "f n (m) = <repeat n m> left\nr $ f 2 up",
        "my_repeat n (m) = repeat n m\nf n (m) = my_repeat n m left\nr $ f 2 up",
    )
    extract_phrase(
        "f n (m) = <slow 2 m fast n up>\nr $ f 2 up",
        "slow_fast_up k n (m) = slow k m fast n up\nf n (m) = slow_fast_up 2 n m\nr $ f 2 up",
    )
    check_not("Extract", "r s $ |>canon 2 up")


def test_a_phrase_is_written_out() -> None:
    poly = "poly n = repeat n (forward scale 4/n left)\n"
    inline(f"{poly}r $ |>poly 5 up", "r $ repeat 5 (forward scale 4/5 left) up")
    inline(f"{poly}r $ pol|>y 3/2*2", "r $ repeat 3/2*2 (forward scale 4/3*2/2 left)")
    check("Inline poly here", f"{poly}r $ poly 3 |>poly 4", f"{poly}r $ poly 3 repeat 4 (forward scale 4/4 left)")
    check(
        "Inline poly everywhere",
        f"|>{poly}r $ poly 1\nf n = poly n\nr $ f 2",
        """\
r $ repeat 1 (forward scale 4/1 left)
f n = repeat n (forward scale 4/n left)
r $ f 2""",
    )
    inline("f (m) = m rest m\nr $ fast 2 |>f (up left)", "r $ fast 2 ((up left) rest (up left))")
    inline("f (m) (k) = m || k\nr $ up |>f left fast 2 up", "r $ up (left || fast 2 up)")
    check_not("Inline", "|>f (m) = m m\nr $ f f up f up")  # one use is the argument of another
    check_not("Inline", "x = up\nf (m) = m x\ng (x) = |>f x\nr $ g up")
    check_not("Inline", "f (m) = m m\nr $ |>f")
    check_not("Inline", "f (m) = |>m m")


def test_items_that_words_count_are_left_alone() -> None:
    for word in ("accumulate", "choose", "shuffle"):
        check_not("Unroll", f"r $ {word} (|>repeat 2 up left)")
        check_not("Fold", f"r $ {word} (up u|>p)")
        check_not("Fold", f"x = up u|>p left\nr $ {word} x")
        check_not("Extract", f"r $ {word} (<up left> up)")
        check_not("Wrap", f"r $ {word} (<up left> up)")
        inline(f"x = up left\nr $ {word} (|>x slow 2 up)", f"r $ {word} ((up left) slow 2 up)")


def test_another_seed_throws_other_dice() -> None:
    check("Other dice: seed 1", "r $ up |>choose (up left)", "r $ up seed 1 choose (up left)")
    check("Other dice: seed 4", "r $ seed 3 repeat 2 sh|>uffle (up left)", "r $ seed 4 repeat 2 shuffle (up left)")
    check("Other dice: seed 4", "r $ se|>ed 3 chance 1/2 up", "r $ seed 4 chance 1/2 up")
    check_not("Other dice", "r $ choose (u|>p left)")
    check_not("Other dice", "f n = seed n |>choose (up left)")


def test_lines_that_follow_each_other_become_a_canon() -> None:
    check(
        "Write 3 lines as canon 2",
        "a $ up left\nb $ |>rest rest up  left\n# last\nc $ repeat 4 rest up left\nd $ up\n",
        "a b c $ canon 2 (up left)\n# last\nd $ up\n",
    )
    check("Write 2 lines as canon 3", "a |>$ x\nb $ repeat 3 rest x\nx = up", "a b $ canon 3 x\nx = up")
    for program in (
        "a $ up|>\nb $ up",
        "a $ up|>\nb $ rest left",
        "a $ up|>\nb $ rest up\nc $ rest up",
        "a $ up|>\na $ rest up",
        "a $ rest up|>\nb $ rest rest up",
        "a $ up|>",
        "a b $ up|>\nc $ rest up",
    ):
        check_not("Write", program)


def test_nothing_outside_movements() -> None:
    for program in ("|>r $ left", "r |>$ left", "be|>at 60", "# |>", "r $ left  |>", "|>"):
        assert offered(program)[1] == []


SENSED = [SenseSpan("near", None, Fraction(3, 4), Fraction(5, 2)), SenseSpan("near", None, 5)]
FORMS = [
    "({0})",
    "({0} {1})",
    "[{0} {1}]",
    "({0} {0} || {1})",
    "[{0} || {1}]",
    "repeat 2 {0}",
    "reverse {0}",
    "fit 2 {0}",
]
FORMS += ["fast 3/2 {0}", "reflect YZ {0}", "choose ({0} {0})", "shuffle ({0} up {0})", "accumulate ({0} left {0})"]
FORMS += ["chance 1/2 {0}", "seed 3 {0}", "f 2 {0}", "g {0} (left {0})", "until near {0}", "pause not near {0}"]
FORMS += ["fit 2 {0}", "if near {0} else {1}"]
TERMS = written(["forward", "left", "up", "rest", "x", "y"], FORMS, 6)
BODIES = st.lists(TERMS, min_size=1, max_size=4).map(" ".join)
STATEMENTS = st.one_of(
    st.builds("{} = {}".format, st.sampled_from("xy"), BODIES),
    BODIES.map("r $ {}".format),
    BODIES.map("r s $ canon 1 ({})".format),
    st.just("---"),
    st.builds("h n (m) = {} repeat n m".format, BODIES),
)
PROGRAMS = st.lists(STATEMENTS, min_size=1, max_size=4).map(
    lambda lines: "\n".join(["x = up left", "y = x || left", "f n (m) = repeat n m x", "g (a) (b) = a y b a", *lines])
)


@given(PROGRAMS, st.data())
def test_refactorings_do_not_change_the_dance(program: str, data: st.DataObject) -> None:
    analysis = analyze(program)
    start = data.draw(st.integers(0, len(program)))
    end = data.draw(st.integers(start, len(program))) if data.draw(st.booleans()) else start
    actions = [each for each in refactorings(analysis, Span(start, end)) if not each.title.startswith(CHANGING)]
    assume(actions)
    action = data.draw(st.sampled_from(actions))
    after = analyze(applied(program, action.edits))
    for script in ([], SENSED):
        assert compiled(after, 200, script)["robots"] == compiled(analysis, 200, script)["robots"], action
    assert after.ok == analysis.ok, action
