"""Words for body parts and poses in editors."""

from __future__ import annotations

import pytest

from improv_core.ide.rename import RefusalError, renamable, rename
from improv_core.ide.signature_help import signature
from tests.ide.cursor import at_cursor
from tests.ide.test_completion import offered
from tests.ide.test_hover import check as check_hover

PUPPET = "ada is puppet\n"


def labels(program: str) -> list[str]:
    return [item.label for item in offered(program).items]


def test_body_parts_are_offered_to_robots_that_have_them() -> None:
    words = ["head", "left_arm", "right_arm", "arms", "to"]
    assert [each for each in labels(f"{PUPPET}ada $ |>") if each in words] == words
    assert "head" not in labels("ada $ |>")
    assert labels(f"{PUPPET}head = left\nada $ |>").count("head") == 1


def test_poses_are_offered_after_to_unless_it_is_hidden() -> None:
    assert labels(f"{PUPPET}ada $ head to |>") == ["start", "high", "wide"]
    assert labels("ada $ head to |>") == ["start"]
    assert "high" not in labels(f"{PUPPET}to (m) = m\nada $ to |>")


def test_hovers_describe_the_motion_of_joints() -> None:
    check_hover(
        f"{PUPPET}ada $ he|>ad (left left right)",
        "head (left left right)",
        "3 beats",
        "head_yaw between 0° and 60°, ends at 30°",
        "left moves head_yaw",
    )
    check_hover(f"{PUPPET}ada $ left_arm to hi|>gh", "to high", "left_shoulder_pitch at 150°")
    check_hover(f"{PUPPET}ada $ head le|>ft", "left", "1 beat")


def test_names_of_poses_are_not_renamed_with_names() -> None:
    analysis, offset = at_cursor(f"{PUPPET}hi|>gh = left\nada $ high left_arm to high\n")
    edits = rename(analysis, renamable(analysis, offset), "tall")
    assert len(edits) == 2


@pytest.mark.parametrize(("marked", "why"), [("he|>ad left", "improv.toml"), ("head t|>o start", "a word of")])
def test_words_that_no_program_defines_can_not_be_renamed_there(marked: str, why: str) -> None:
    analysis, offset = at_cursor(f"{PUPPET}ada $ {marked}")
    with pytest.raises(RefusalError, match=why):
        renamable(analysis, offset)


def test_signatures_show_the_operand() -> None:
    found = signature(*at_cursor(f"{PUPPET}ada $ head |>"))
    assert found
    assert found.label == "head movement"
    found = signature(*at_cursor(f"{PUPPET}ada $ head to |>"))
    assert found
    assert found.label == "to POSE"
