"""The members of a class, and limits for what they send: pure decisions, with the time passed in."""

from __future__ import annotations

import hmac
import re
import secrets
import unicodedata
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field, replace

from improv_core.program.compiler import LONGEST_TEXT

MAX_CHILDREN = 40
MAX_SHOWN = 2 * MAX_CHILDREN
"""The most children that the teacher sees: those in the class, and those who were."""
LONGEST_NAME = 24
LONGEST_DANCE = LONGEST_TEXT // 2
"""The most characters of a dance: as many as the page's editor takes."""
PERIOD = 1.0
"""Seconds before a child can send again."""
SILENT = 90.0
"""Seconds without news of a child's page after which the child isn't here any more. A hidden page of Chromium asks once
a minute."""
MINUTE = 60.0
MAX_GUESSES = 60
"""Wrong codes from one address in a minute. After that, nobody there can join until the minute is over."""
MAX_JOINS = MAX_CHILDREN
"""Right codes from one address in a minute: a whole class may share an address."""
LETTERS = "ABCDEFGHJKLMNPQRSTUVWXYZ23456789"
"""The characters of a room's code: no two look alike."""
JOINERS = re.compile("[\u200c\u200d\u180b-\u180d\u180f\ufe00-\ufe0f\U000e0020-\U000e007f\U000e0100-\U000e01ef]")
"""Invisible characters that names need: Persian words, emoji of several parts, and variants of characters."""
INVISIBLE = re.compile(
    "[\u00ad\u034f\u061c\u115f\u1160\u17b4\u17b5\u180b-\u180f\u200b-\u200f\u202a-\u202e\u2060-\u206f\u3164"
    "\ufe00-\ufe0f\ufeff\uffa0\ufff0-\ufff8\U0001bca0-\U0001bca3\U0001d173-\U0001d17a\U000e0000-\U000e0fff]"
)
"""Unicode's default-ignorable characters."""
SEPARATOR = re.compile("[\\W_]")
"""Characters of a code that was typed that don't count: spaces and dashes."""
BLANK = re.compile("[\\s\u2800\U0001d159]+")
"""Invisible characters that have a width."""


class ForbiddenError(Exception):
    """A child isn't allowed to do this. The message is one line for the child, and `status` is HTTP's."""

    def __init__(self, status: int, message: str) -> None:
        super().__init__(message)
        self.status = status


@dataclass(frozen=True, slots=True)
class Member:
    """A child's page and its browser. `sent` is the time of its latest dance, in seconds."""

    number: int
    name: str
    browser: str
    count: int = 0
    """The number of dances it has sent."""
    good: int = 0
    """The latest of them that can be played."""
    sent: float = -PERIOD
    seen: float = -SILENT
    """The time at which its page was last known to be open, in seconds."""


@dataclass(frozen=True, slots=True)
class Tries:
    """The counts of codes that came from an address in the minute since `minute`, in seconds."""

    minute: float
    wrong: int = 0
    right: int = 0


@dataclass(frozen=True, slots=True)
class Room:
    """A class: its code, its members by their secrets, the number that ever joined, and the tries of each address.

    Children who were members are `away`, the latest ones last. Their dances wait for them.
    """

    code: str
    members: Mapping[str, Member] = field(default_factory=dict)
    away: Sequence[Member] = ()
    joined: int = 0
    tries: Mapping[str, Tries] = field(default_factory=dict)


def new_code() -> str:
    """Return a code that is hard to guess: one of a thousand million."""
    return "".join(secrets.choice(LETTERS) for _ in range(6))


def guess(room: Room, address: str, code: str, now: float) -> tuple[Room, bool]:
    """Return the room after a code has come from an address, and whether it is right. Raises ForbiddenError after too
    many."""
    recent = {each: tries for each, tries in room.tries.items() if now - tries.minute < MINUTE}
    tries = recent.get(address, Tries(now))
    if tries.wrong >= MAX_GUESSES:
        raise ForbiddenError(429, "too many wrong codes: wait a minute")
    if tries.right >= MAX_JOINS:
        raise ForbiddenError(429, "too many have joined just now: wait a minute")
    typed = SEPARATOR.sub("", code).upper()
    is_right = hmac.compare_digest(typed.encode(), room.code.encode())
    tries = replace(tries, wrong=tries.wrong + (not is_right), right=tries.right + is_right)
    return replace(room, tries={**recent, address: tries}), is_right


def join(room: Room, name: str, secret: str, browser: str) -> tuple[Room, Member]:
    """Return the room with another child, which has this secret, and that child.

    A child who joins again from the same browser, or comes back, keeps its number and its dances. If another child
    joins from a browser, the previous one is away. Raises ForbiddenError if the child can't join.
    """
    others = {key: each for key, each in room.members.items() if each.browser != browser}
    if len(others) >= MAX_CHILDREN:
        raise ForbiddenError(409, f"this class is full ({MAX_CHILDREN}): ask your teacher")
    shown = shown_name(name)
    if not shown:
        raise ForbiddenError(400, "write your name with letters")
    taken = {compared(each.name) for each in others.values()}
    own, number = shown, 2
    while compared(own) in taken:
        own, number = f"{shown} {number}", number + 1
    left = [*room.away, *(each for key, each in room.members.items() if key not in others)]
    back = [each for each in left if compared(each.name) == compared(own)][-1:]
    member = Member(room.joined + 1, own, browser)
    joined = member.number
    if back:
        member, joined = replace(back[0], name=own, browser=browser), room.joined
    away = tuple(each for each in left if each.count and each not in back)[-MAX_CHILDREN:]
    return replace(room, members={**others, secret: member}, away=away, joined=joined), member


def send(room: Room, secret: str, now: float) -> tuple[Room, Member]:
    """Return the room after a child has begun to send a dance, and that child. Raises ForbiddenError if it may not, or
    not yet."""
    member = room.members.get(secret)
    if member is None:
        raise ForbiddenError(403, "join the class first")
    if now - member.sent < PERIOD:
        raise ForbiddenError(429, "you have just sent one: wait a second")
    member = replace(member, sent=now, seen=now, count=member.count + 1)
    return replace(room, members={**room.members, secret: member}), member


def noticed(room: Room, secret: str, seen: float) -> Room:
    """Return the room with the time at which a child's page was last known to be open. Raises ForbiddenError for one
    that isn't in the class."""
    if not (member := room.members.get(secret)):
        raise ForbiddenError(403, "join the class first")
    return replace(room, members={**room.members, secret: replace(member, seen=seen)})


def without(room: Room, numbers: Collection[int]) -> Room:
    """The room without these children: their pages have to join again."""
    members = {key: each for key, each in room.members.items() if each.number not in numbers}
    return replace(room, members=members, away=[each for each in room.away if each.number not in numbers])


def counted(room: Room, number: int, good: int) -> Room:
    """The room once a child's dance was read that can be played."""

    def read(member: Member) -> Member:
        return replace(member, good=good) if member.number == number else member

    return replace(room, members={key: read(each) for key, each in room.members.items()}, away=[*map(read, room.away)])


def people(room: Room, now: float) -> Mapping[int, tuple[str, bool]]:
    """Return the name of each child, by its number, and whether its page is open."""
    away = {each.number: (each.name, False) for each in room.away}
    return {**away, **{each.number: (each.name, now - each.seen < SILENT) for each in room.members.values()}}


def shown_name(name: str) -> str:
    """Shorten a typed name to one line, without characters that hide or turn text; "" if nothing of it is visible."""
    plain = "".join(
        char
        for char in BLANK.sub(" ", unicodedata.normalize("NFC", name[:1_000]))
        if JOINERS.match(char) or not (INVISIBLE.match(char) or unicodedata.category(char)[0] == "C")
    )
    shown = " ".join(plain.split())[:LONGEST_NAME].strip()
    return shown if any(unicodedata.category(char)[0] != "M" for char in compared(shown)) else ""


def compared(name: str) -> str:
    """A name without its invisible characters, so that names that look the same compare as equal."""
    return " ".join(unicodedata.normalize("NFC", INVISIBLE.sub("", name)).split())
