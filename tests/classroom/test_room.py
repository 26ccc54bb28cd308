"""Who is in a class, and what they may send."""

from __future__ import annotations

import pytest

from improv_core.classroom.roster import (
    LONGEST_DANCE,
    MOST_CHILDREN,
    MOST_GUESSES,
    ForbiddenError,
    Room,
    guess,
    join,
    new_code,
    send,
    shown_name,
    without,
)

ROOM = Room("ABC234")


def joined(*names: str) -> Room:
    room = ROOM
    for number, name in enumerate(names):
        room, _ = join(room, name, f"secret {number}")
    return room


def status_of(problem: pytest.ExceptionInfo[ForbiddenError]) -> int:
    return problem.value.status


@pytest.mark.parametrize(
    ("typed", "shown"),
    [
        ("Maria", "Maria"),
        ("  José  Luis\n", "José Luis"),
        ("阿明", "阿明"),
        ("a\u202eb\u200b\x00c\x1b[31m", "abc[31m"),  # what steers or hides text
        ("x" * 99, "x" * 24),
        ("\u202e\x07 ", ""),
    ],
)
def test_names_are_those_typed_without_what_does_not_show(typed: str, shown: str) -> None:
    assert shown_name(typed) == shown


def test_two_children_with_one_name_are_told_apart() -> None:
    assert [each.name for each in joined("Ada", "Ada", "Ada").members.values()] == ["Ada", "Ada 2", "Ada 3"]


@pytest.mark.parametrize(("code", "right"), [("ABC234", True), (" abc234 ", True), ("ABC23", False), ("é", False)])
def test_only_who_knows_the_code_comes_in(code: str, right: bool) -> None:
    assert guess(ROOM, code, 0.0)[1] == right


def test_nobody_can_guess_for_long() -> None:
    room = ROOM
    for _ in range(MOST_GUESSES):
        room, right = guess(room, "?", 5.0)
        assert not right
    with pytest.raises(ForbiddenError, match="too many wrong codes: wait a minute") as problem:
        guess(room, room.code, 6.0)
    assert status_of(problem) == 429
    assert guess(room, room.code, 66.0)[1]


def test_a_full_class_and_an_empty_name_are_refused() -> None:
    full = joined(*("x" for _ in range(MOST_CHILDREN)))
    with pytest.raises(ForbiddenError, match="this class is full") as problem:
        join(full, "one more", "secret")
    assert status_of(problem) == 409
    with pytest.raises(ForbiddenError, match="write your name with letters"):
        join(ROOM, "\u200b", "secret")


def test_a_secret_sends_for_its_own_child_only() -> None:
    room = joined("Ada", "Bo")
    _, member = send(room, "secret 1", "r $ forward", 0.0)
    assert member.name == "Bo"
    for secret in ("", "secret 2", "Ada"):
        with pytest.raises(ForbiddenError, match="join the class first") as problem:
            send(room, secret, "r $ forward", 0.0)
        assert status_of(problem) == 403


def test_a_child_sends_once_in_a_second_and_nobody_waits_for_another() -> None:
    room, _ = send(joined("Ada", "Bo"), "secret 0", "", 10.0)
    with pytest.raises(ForbiddenError, match="wait a second") as problem:
        send(room, "secret 0", "", 10.9)
    assert status_of(problem) == 429
    send(room, "secret 1", "", 10.9)
    send(room, "secret 0", "", 11.0)


def test_a_dance_has_a_longest_length() -> None:
    room = joined("Ada")
    send(room, "secret 0", "x" * LONGEST_DANCE, 0.0)
    with pytest.raises(ForbiddenError, match="longer than 100,000 characters") as problem:
        send(room, "secret 0", "x" * (LONGEST_DANCE + 1), 0.0)
    assert status_of(problem) == 413


def test_who_was_sent_out_can_send_nothing() -> None:
    with pytest.raises(ForbiddenError, match="join the class first"):
        send(without(joined("Ada"), 1), "secret 0", "", 0.0)


def test_codes_have_no_letters_that_look_alike() -> None:
    assert {*"".join(new_code() for _ in range(200))}.isdisjoint("IO01")
