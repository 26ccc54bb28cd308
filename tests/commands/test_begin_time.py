"""The time at which a program begins: a text → the time, and in words."""

from __future__ import annotations

from datetime import datetime, timezone

import pytest

from improv_core.commands.begin_time import countdown, in_words, moment

NOW = datetime(2026, 11, 24, 20, 0, 30)


@pytest.mark.parametrize(
    ("text", "begins", "words"),
    [
        ("20:15", datetime(2026, 11, 24, 20, 15), "20:15:00 today"),
        ("20:00:31", datetime(2026, 11, 24, 20, 0, 31), "20:00:31 today"),
        ("20:00:30", datetime(2026, 11, 25, 20, 0, 30), "20:00:30 tomorrow"),
        ("08:00", datetime(2026, 11, 25, 8), "08:00:00 tomorrow"),
        ("2026-11-24T20:15", datetime(2026, 11, 24, 20, 15), "20:15:00 today"),
        ("2026-12-01 20:15:00", datetime(2026, 12, 1, 20, 15), "20:15:00 on 2026-12-01"),
    ],
)
def test_local_times_are_read(text: str, begins: datetime, words: str) -> None:
    found = moment(text, NOW)
    assert found.replace(tzinfo=None) == begins
    assert in_words(found, NOW) == words


@pytest.mark.parametrize("text", ["2026-12-01T20:15:00+01:00", "2026-12-01T19:15Z", "2026-12-01T14:15-05:00"])
def test_absolute_times_are_the_same_wherever_the_machine_is(text: str) -> None:
    assert moment(text, NOW) == datetime(2026, 12, 1, 19, 15, tzinfo=timezone.utc)


@pytest.mark.parametrize(
    "text", ["", "soon", "20", "2015", "24:01", "20:15+01:00", "2026-12-01", "nan", "1e300", "9" * 400]
)
def test_other_texts_are_no_times(text: str) -> None:
    with pytest.raises(ValueError, match="is no time: write 20:15, or"):
        moment(text, NOW)


def test_an_absolute_time_that_has_passed() -> None:
    with pytest.raises(ValueError, match="2026-11-24T19:00 has passed: it is 2026-11-24 20:00:30"):
        moment("2026-11-24T19:00", NOW)


@pytest.mark.parametrize(
    ("seconds", "words"),
    [(-1, "0:00"), (0.4, "0:00"), (59.6, "1:00"), (299, "4:59"), (3899, "1:04:59"), (1e9, "277777:46:40")],
)
def test_the_countdown_is_in_hours_minutes_and_seconds(seconds: float, words: str) -> None:
    assert countdown(seconds) == words
