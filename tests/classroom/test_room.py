"""The members of a class, and limits for what they send."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace

import pytest

from improv_core.classroom.roster import (
    MAX_CHILDREN,
    MAX_GUESSES,
    SILENT,
    ForbiddenError,
    Room,
    compared,
    guess,
    join,
    new_code,
    noticed,
    people,
    send,
    shown_name,
    without,
)
from improv_core.page.connections import (
    MAX_CONNECTIONS,
    MAX_PER_ADDRESS,
    STALL_LIMIT,
    OpenConnection,
    stalled,
    to_close,
)

ROOM = Room("ABC234")


def joined(*names: str) -> Room:
    room = ROOM
    for number, name in enumerate(names):
        room, _ = join(room, name, f"secret {number}", f"browser {number}")
    return room


def status_of(problem: pytest.ExceptionInfo[ForbiddenError]) -> int:
    return problem.value.status


@pytest.mark.parametrize(
    ("typed", "shown"),
    [
        ("Maria", "Maria"),
        ("  José  Luis\n", "José Luis"),
        ("阿明", "阿明"),
        ("a\u202eb\u200b\x00c\x1b[31m", "abc[31m"),  # characters that control or hide text
        ("x" * 99, "x" * 24),
        ("\u202e\x07 ", ""),
        ("\u2800", ""),  # nothing of these is visible
        ("\u3164\u115f\uffa0", ""),
        ("\u0301", ""),
        ("A\u034fda\u3164\u17b4\u2800", "Ada"),
        ("❤️", "❤️"),
        ("👩‍🚀", "👩‍🚀"),
        ("🏴󠁧󠁢󠁥󠁮󠁧󠁿", "🏴󠁧󠁢󠁥󠁮󠁧󠁿"),
        ("می‌خواهم", "می‌خواهم"),
        ("葛󠄀城", "葛󠄀城"),
    ],
)
def test_names_lose_their_invisible_characters(typed: str, shown: str) -> None:
    assert shown_name(typed) == shown


def test_children_with_the_same_name_get_numbers() -> None:
    assert [each.name for each in joined("Ada", "Ada", "Ada").members.values()] == ["Ada", "Ada 2", "Ada 3"]


@pytest.mark.parametrize("hidden", ["\u034f", "\u3164", "\ufe0f", "\u17b4", "\u200d", "\u200c", "\u2800", "\U000e0100"])
def test_a_name_with_hidden_characters_is_the_same_name(hidden: str) -> None:
    for name in (f"Ada{hidden}", f"{hidden}Ada"):
        assert compared([*joined("Ada", name).members.values()][1].name) == "Ada 2"


@pytest.mark.parametrize(
    ("code", "right"), [("ABC234", True), (" abc 234 ", True), ("ABC-234", True), ("ABC23", False), ("é", False)]
)
def test_only_the_right_code_lets_children_join(code: str, right: bool) -> None:
    assert guess(ROOM, "10.0.0.1", code, 0.0)[1] == right


def test_too_many_wrong_codes_block_only_their_address() -> None:
    room = ROOM
    for _ in range(MAX_GUESSES):
        room, right = guess(room, "10.0.0.1", "?", 5.0)
        assert not right
    with pytest.raises(ForbiddenError, match="too many wrong codes: wait a minute") as problem:
        guess(room, "10.0.0.1", room.code, 6.0)
    assert status_of(problem) == 429
    assert guess(room, "10.0.0.2", room.code, 6.0)[1]
    room, right = guess(room, "10.0.0.1", room.code, 66.0)
    assert right
    assert len(room.tries) == 1  # no tries of earlier minutes remain


def test_a_whole_class_can_join_from_one_address_but_not_again_and_again() -> None:
    room = ROOM
    for number in range(MAX_CHILDREN):
        room, _ = guess(room, "10.0.0.1", room.code, 5.0)
        room, _ = join(room, "Ada", f"secret {number}", f"browser {number}")
    with pytest.raises(ForbiddenError, match="wait a minute") as problem:
        guess(without(room, range(99)), "10.0.0.1", room.code, 6.0)
    assert status_of(problem) == 429


def sent(room: Room, secret: str) -> Room:
    return send(room, secret, 0.0)[0]


def present(room: Room) -> Mapping[int, tuple[str, bool]]:
    """The children of a room in which the pages of all members are open."""
    for secret in room.members:
        room = noticed(room, secret, 0.0)
    return people(room, 0.0)


def test_a_browser_has_one_place() -> None:
    room, before = join(joined("Ada"), "Ada", "own", "browser")
    room, after = join(room, "Bo", "other", "browser")
    assert present(room) == {1: ("Ada", True), 3: ("Bo", True)}  # "Ada 2" had sent nothing
    assert after.number > before.number
    with pytest.raises(ForbiddenError, match="join the class first"):
        send(room, "own", 0.0)
    full = joined(*("x" for _ in range(MAX_CHILDREN)))
    assert len(join(full, "Ada", "own", "browser 3")[0].members) == MAX_CHILDREN


@pytest.mark.parametrize(
    ("name", "browser", "everybody"),
    [
        ("A\u200dda", "browser 0", {1: ("A\u200dda", True), 2: ("Bo", True)}),  # the same child in another tab
        ("Cy", "browser 0", {1: ("Ada", False), 2: ("Bo", True), 3: ("Cy", True)}),  # the next child at a tablet
        ("Ada", "browser 9", {1: ("Ada", True), 2: ("Bo", True), 3: ("Ada 2", True)}),  # a stranger
    ],
)
def test_a_child_who_joins_again_keeps_its_place(
    name: str, browser: str, everybody: dict[int, tuple[str, bool]]
) -> None:
    room, _ = join(sent(joined("Ada", "Bo"), "secret 0"), name, "new", browser)
    assert present(room) == everybody


def test_a_child_who_was_away_comes_back_to_its_dances_from_any_browser() -> None:
    room = sent(sent(joined("Ada", "Ada"), "secret 0"), "secret 1")
    room = replace(room, members={}, away=[*room.members.values()])
    for number, browser in ((1, "x"), (2, "y"), (3, "z")):  # the third one is new
        room, member = join(room, "Ada", browser, browser)
        assert (member.number, member.count) == (number, int(number < 3))
    assert room.away == ()


def test_children_who_are_away_are_as_many_as_a_class() -> None:
    room = ROOM
    for number in range(MAX_CHILDREN + 5):
        room, _ = join(room, f"child {number}", f"secret {number}", "browser")
        room = sent(room, f"secret {number}")
    assert len(room.away) == MAX_CHILDREN
    assert room.away[-1].name == f"child {MAX_CHILDREN + 3}"


def test_a_full_class_and_an_empty_name_are_refused() -> None:
    full = joined(*("x" for _ in range(MAX_CHILDREN)))
    with pytest.raises(ForbiddenError, match="this class is full") as problem:
        join(full, "one more", "secret", "browser")
    assert status_of(problem) == 409
    with pytest.raises(ForbiddenError, match="write your name with letters"):
        join(ROOM, "\u200b", "secret", "browser")


def test_a_secret_sends_for_its_own_child_only() -> None:
    room = joined("Ada", "Bo")
    _, member = send(room, "secret 1", 0.0)
    assert (member.name, member.count) == ("Bo", 1)
    for secret in ("", "secret 2", "Ada"):
        with pytest.raises(ForbiddenError, match="join the class first") as problem:
            send(room, secret, 0.0)
        assert status_of(problem) == 403


def test_a_child_sends_once_in_a_second_and_nobody_waits_for_another() -> None:
    room, _ = send(joined("Ada", "Bo"), "secret 0", 10.0)
    with pytest.raises(ForbiddenError, match="wait a second") as problem:
        send(room, "secret 0", 10.9)
    assert status_of(problem) == 429
    send(room, "secret 1", 10.9)
    send(room, "secret 0", 11.0)


def test_a_child_is_here_while_its_page_is_open() -> None:
    room = joined("Ada", "Bo")
    assert [*people(room, 1_000.0).values()] == [("Ada", False), ("Bo", False)]  # after the class was started again
    room = noticed(room, "secret 0", 1_000.0)
    room, _ = send(room, "secret 1", 1_001.0)
    assert [here for _, here in people(room, 1_000.0 + SILENT - 1).values()] == [True, True]
    assert [here for _, here in people(room, 1_000.0 + SILENT).values()] == [False, True]
    room = noticed(room, "secret 0", 1_000.0 + SILENT)
    room = noticed(room, "secret 1", -SILENT)  # it was closed
    assert [here for _, here in people(room, 1_000.0 + SILENT).values()] == [True, False]
    with pytest.raises(ForbiddenError, match="join the class first"):
        noticed(room, "guessed", 0.0)


def test_a_removed_child_can_send_nothing() -> None:
    room = without(joined("Ada", "Bo", "Cy"), [1, 3])
    with pytest.raises(ForbiddenError, match="join the class first"):
        send(room, "secret 0", 0.0)
    assert send(room, "secret 1", 0.0)[1].name == "Bo"


def test_codes_have_no_letters_that_look_alike() -> None:
    assert {*"".join(new_code() for _ in range(200))}.isdisjoint("IO01")


def crowd(*counts: int) -> dict[int, OpenConnection]:
    """Connections from several addresses, this many from each. A lower key means longer without progress."""
    addresses = [f"10.0.0.{number}" for number, count in enumerate(counts) for _ in range(count)]
    return {key: OpenConnection(address, float(key)) for key, address in enumerate(addresses)}


@pytest.mark.parametrize(
    ("open_now", "address", "closed"),
    [
        (crowd(240), "10.0.0.0", None),  # 40 browsers behind one address
        (crowd(MAX_PER_ADDRESS, 1), "10.0.0.0", 0),  # one of its own
        (crowd(MAX_PER_ADDRESS, 1), "10.0.0.1", None),
        (crowd(6, MAX_PER_ADDRESS, MAX_CONNECTIONS - MAX_PER_ADDRESS - 6), "10.0.0.3", 6),  # of the largest crowd
        (crowd(6, 6), "10.0.0.0", None),
    ],
)
def test_the_connection_that_has_rested_longest_gives_way_to_a_new_one(
    open_now: dict[int, OpenConnection], address: str, closed: int | None
) -> None:
    assert to_close(open_now, address) == closed


def test_connections_that_must_stay_give_way_to_none() -> None:
    assert to_close({key: OpenConnection("a", math.inf) for key in range(MAX_PER_ADDRESS)}, "a") is None


def test_a_connection_on_which_nothing_progresses_is_closed() -> None:
    assert stalled({"old": OpenConnection("a", 0.0), "new": OpenConnection("a", 1.0)}, STALL_LIMIT) == ["old"]
