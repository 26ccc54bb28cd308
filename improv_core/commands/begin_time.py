"""The time at which a program begins, as people write it: `20:15`, or an absolute time. Pure functions."""

from __future__ import annotations

from contextlib import suppress
from datetime import datetime, time, timedelta


def moment(text: str, now: datetime) -> datetime:
    """Read a time, in this zone unless it names another. A time of day is today, or tomorrow if it has passed. `now` is
    the local time, without a zone.

    Raises ValueError with a line for people.
    """
    with suppress(ValueError):
        of_day = time.fromisoformat(text)
        if ":" in text and of_day.tzinfo is None:
            today = datetime.combine(now.date(), of_day)
            return (today if today > now else today + timedelta(days=1)).astimezone()
    try:
        absolute = datetime.fromisoformat(text)
        if ":" not in text:
            raise ValueError
        found = absolute.astimezone()
    except (ValueError, OverflowError):
        raise ValueError(f"{text!r} is no time: write 20:15, or 2026-11-24T20:15:00+01:00") from None
    if found <= now.astimezone():
        raise ValueError(f"{text} has passed: it is {now:%Y-%m-%d %H:%M:%S}")
    return found


def in_words(begins: datetime, now: datetime) -> str:
    """Format a time as `20:15:00 today`, both in local time."""
    days = (begins.date() - now.date()).days
    day = {0: "today", 1: "tomorrow"}.get(days, f"on {begins:%Y-%m-%d}")
    return f"{begins:%H:%M:%S} {day}"


def countdown(seconds: float) -> str:
    """Format the time until then as `4:59`, or `1:04:59`."""
    left = max(round(seconds), 0)
    hours, minutes = left // 3600, left // 60 % 60
    return f"{hours}:{minutes:02}:{left % 60:02}" if hours else f"{minutes}:{left % 60:02}"
