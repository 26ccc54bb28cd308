"""Actions that play, mute, solo, and stop, at the cursor, `|`."""

from __future__ import annotations

from improv_core.ide.code_action_play import MAX_ROBOTS, PlayAction, play_actions
from improv_core.ide.rehearsal import Scenes
from improv_core.program.analysis import analyze

ALL = ["Play the program", "Stop all robots"]


def check(program: str, *expected: str, muted: str = "", soloed: str = "") -> None:
    """Check the titles; an action that plays only a part of the program shows it: `title → text`. Next to one that
    plays only a line is one that plays it among the others."""
    cursor, text = program.index("|"), program.replace("|", "", 1)
    found = play_actions(analyze(text), cursor, muted.split(), soloed.split())
    shown = [_shown(action, text) for action in found]
    assert shown == [title for each in expected for title in (*_among(each), each)]


def _among(title: str) -> list[str]:
    return [title.replace("only ", "")] if title.startswith("Play only this line") else []


def _shown(action: PlayAction, text: str) -> str:
    if isinstance(action.only, Scenes):
        return f"{action.title} → scenes {action.only.first} to {action.only.last}"
    return f"{action.title} → {text[slice(*action.only)]}" if action.only else action.title


def test_a_line_plays_alone_if_there_are_others() -> None:
    check("beat 30\nr $ repeat 4 up| left", *ALL)
    check("x = up\nr $ up|\nr $ left", "Play only this line (1 beat, 1.0 s) → r $", *ALL)
    check("r $ up\n  s $ lft|", "Play only this line → s $", *ALL, "Mute s", "Solo s")
    check("r $ up\n|\n", *ALL)
    check("$ |up")
    check("|")


def test_a_name_can_be_tried_at_its_definition_and_its_uses() -> None:
    check("x = repeat 2 |up", "Try x (2 beats, 2.0 s) → x =")
    check("x = up\ny = |x left\n", "Try x (1 beat, 1.0 s) → x =")
    check("x = up\nx = left\nr $ x| up\n", "Try x (1 beat, 1.0 s) → x =", *ALL)
    check("x = lft|", "Try x → x =")
    check("r $ sq|\nsq = up\n", *ALL)


def test_a_phrase_can_be_tried_once_something_gives_it_its_arguments() -> None:
    check("poly n = repeat n |up")
    check("poly n = repeat n| up\nr $ poly 4", "Try poly → poly n =", *ALL)
    check("poly n = repeat n up\nmore n = pol|y n")


def test_a_scene_plays_alone() -> None:
    program = "r $ up\n---\nr $ repeat 2 up\n"
    check(
        "|" + program,
        "Play only this line (1 beat, 1.0 s) → r $",
        "Play only scene 1 (1 beat, 1.0 s) → scenes 0 to 0",
        *ALL,
    )
    both = "Play only scene 2 (1 beat, 1.0 s) → scenes 1 to 1", "Play from scene 2 on → scenes 1 to 2"
    check("r $ up\n---\n|r $ up\n---\nr $ up\n", "Play only this line (1 beat, 1.0 s) → r $", *both, *ALL)
    second = "Play only scene 2 (2 beats, 2.0 s) → scenes 1 to 1"
    check(program.replace("---", "-|--"), second, *ALL)
    check(program + "|", second, *ALL)


def test_each_of_several_robots_can_be_muted_and_soloed() -> None:
    this = "Play only this line (1 beat, 1.0 s) → "
    program = "r $ up\ns t $ |up"
    check(program, f"{this}s t $", *ALL, "Mute s", "Solo s", "Mute t", "Solo t")
    check(program, f"{this}s t $", *ALL, "Unmute s", "Solo s", "Mute t", "Unsolo t", muted="s", soloed="t")
    many = list(play_actions(analyze("a b c d e $ up"), 3))
    assert len(many) == len(ALL) + 2 * MAX_ROBOTS
