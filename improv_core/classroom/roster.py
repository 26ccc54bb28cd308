"""Who is in a class, and what they may send: decided here, from the time that is given."""

from __future__ import annotations

import hmac
import secrets
import unicodedata
from collections.abc import Mapping
from dataclasses import dataclass, field, replace

from improv_core.program.compiler import LONGEST_TEXT

MOST_CHILDREN = 40
LONGEST_NAME = 24
LONGEST_DANCE = LONGEST_TEXT // 2
"""Characters of a dance: as many as the page's editor takes."""
PERIOD = 1.0
"""Seconds that a child waits until it can send again."""
MOST_GUESSES = 60
"""Wrong codes in a minute, of all pages together. Beyond that, nobody can join until the minute is over."""
LETTERS = "ABCDEFGHJKLMNPQRSTUVWXYZ23456789"
"""What a room's code is made of: nothing that looks like something else."""


class ForbiddenError(Exception):
    """A child can't do this. The message is one line for it, and `status` the one of HTTP."""

    def __init__(self, status: int, message: str) -> None:
        super().__init__(message)
        self.status = status


@dataclass(frozen=True, slots=True)
class Member:
    """A child's page. `sent` is when it sent a dance last, in seconds."""

    number: int
    name: str
    sent: float = -PERIOD


@dataclass(frozen=True, slots=True)
class Room:
    """A class: its code, its members by their secrets, how many have ever joined, and how many wrong codes came in the
    minute since `minute`, in seconds."""

    code: str
    members: Mapping[str, Member] = field(default_factory=dict)
    joined: int = 0
    guesses: int = 0
    minute: float = 0.0


def new_code() -> str:
    """A code that nobody guesses: one of a thousand million."""
    return "".join(secrets.choice(LETTERS) for _ in range(6))


def guess(room: Room, code: str, now: float) -> tuple[Room, bool]:
    """The room after somebody has typed a code, and whether that is right. Raises ForbiddenError after too many."""
    if now - room.minute >= 60:
        room = replace(room, guesses=0, minute=now)
    if room.guesses >= MOST_GUESSES:
        raise ForbiddenError(429, "too many wrong codes: wait a minute")
    if hmac.compare_digest(code.strip().upper().encode(), room.code.encode()):
        return room, True
    return replace(room, guesses=room.guesses + 1), False


def join(room: Room, name: str, secret: str) -> tuple[Room, Member]:
    """The room with another child, which has this secret, and that child. Raises ForbiddenError if it can't come in."""
    if len(room.members) >= MOST_CHILDREN:
        raise ForbiddenError(409, f"this class is full ({MOST_CHILDREN}): ask your teacher")
    shown = shown_name(name)
    if not shown:
        raise ForbiddenError(400, "write your name with letters")
    taken = {each.name for each in room.members.values()}
    own, number = shown, 2
    while own in taken:
        own, number = f"{shown} {number}", number + 1
    member = Member(room.joined + 1, own)
    return replace(room, members={**room.members, secret: member}, joined=member.number), member


def send(room: Room, secret: str, text: str, now: float) -> tuple[Room, Member]:
    """The room after a child has sent a dance, and that child. Raises ForbiddenError if it may not, or not yet."""
    member = room.members.get(secret)
    if member is None:
        raise ForbiddenError(403, "join the class first")
    if now - member.sent < PERIOD:
        raise ForbiddenError(429, "you have just sent one: wait a second")
    if len(text) > LONGEST_DANCE:
        raise ForbiddenError(413, f"this dance is longer than {LONGEST_DANCE:,} characters")
    member = replace(member, sent=now)
    return replace(room, members={**room.members, secret: member}), member


def without(room: Room, number: int) -> Room:
    """The room without a child: its page has to join again."""
    return replace(room, members={key: each for key, each in room.members.items() if each.number != number})


def shown_name(name: str) -> str:
    """A name that was typed, short and on one line, without control characters and characters that don't show."""
    plain = "".join(
        " " if char.isspace() else char
        for char in unicodedata.normalize("NFC", name[:1_000])
        if char.isspace() or unicodedata.category(char)[0] != "C"
    )
    return " ".join(plain.split())[:LONGEST_NAME].strip()
