"""The lenses above a program and above its scenes. No line moves while somebody types."""

from __future__ import annotations

from improv_core.ide.code_lens import MAX_SCENES, lenses
from improv_core.program.analysis import analyze
from improv_core.program.program import scene_ids

SCENES = "beat 30\nr $ up\n---\nr $ repeat 4 up\ns $ left\n---\n\n"


def check(program: str, *expected: str) -> None:
    """Check the lenses: `line: text → the scenes that it plays`."""
    analysis = analyze(program)
    found = [
        f"{lens.line}: {lens.text} → {f'{lens.only.first} to {lens.only.last}' if lens.only else 'all'}"
        for lens in lenses(analysis, scene_ids(analysis))
    ]
    assert found == list(expected)


def test_a_program_has_one_lens_with_its_length() -> None:
    check("beat 30\nx = up\nr $ repeat 4 up left # 🐢\ns $ up\n", "0: ▶ play · 5 beats, 10.0 s → all")
    check("r $ repeat up", "0: ▶ play · ∞ → all")
    for nothing in ("", "\n", "$ up", "x = lft"):
        check(nothing, "0: ▶ play → all")


def test_a_lens_says_that_a_word_is_missing() -> None:
    for program in ("\nr $ repeat 4 (up lft)", "\nx = lft\ns $ up\nr $ repeat 4 (up x)"):
        check(program, "0: ▶ play · `lft` in line 2 is not defined → all")
    check("r $ pause near", "0: ▶ play · line 1 has an error → all")
    check("r $ up\nx = (\ns $ x", "0: ▶ play · line 2 has an error → all")
    check(
        "r $ lft\n---\nr $ up",
        "0: ▶ play · `lft` in line 1 is not defined → all",
        "1: ▶ scene 2 · 1 beat, 1.0 s → 1 to 1",
    )


def test_each_further_scene_has_a_lens() -> None:
    check(
        SCENES,
        "0: ▶ play · 5 beats, 10.0 s → all",
        "2: ▶ scene 2 · 4 beats, 8.0 s → 1 to 1",
        "2: ▶ from here → 1 to 2",
        "5: ▶ scene 3 · 0 beats, 0.0 s → 2 to 2",
    )


def test_no_line_gets_a_lens_while_somebody_types() -> None:
    now = analyze("")
    scenes = scene_ids(now)
    for place, key in enumerate(SCENES):
        now = now.edited(place, place, key)
        assert [lens.line for lens in lenses(now, scenes)] == [0], now.text
    scenes = scene_ids(now)
    for key in "r $ up\n":
        now = now.edited(0, 0, key)
        lines = [2 + now.text.count("\n") - SCENES.count("\n"), 5 + now.text.count("\n") - SCENES.count("\n")]
        assert sorted({lens.line for lens in lenses(now, scenes)}) == [0, *lines]


def test_only_the_first_scenes_get_a_lens() -> None:
    analysis = analyze("r $ up\n---\n" * 3 * MAX_SCENES)
    assert len(list(lenses(analysis, scene_ids(analysis)))) == 1 + 2 * MAX_SCENES
