"""Time from the bytes of a MIDI cable: through mido's parser, to the anchors for a stage."""

from __future__ import annotations

from collections.abc import Iterable
from itertools import chain

import pytest
from mido.parser import Parser

from improv_core.music.midi import chosen
from improv_core.music.midi_time import MidiTime, heard
from improv_core.score.peer_clock import Anchor

TICK, START, CONTINUE, STOP = b"\xf8", b"\xfa", b"\xfb", b"\xfc"
NOISE = b"\x90\x3c\x40"
"""A note: other messages don't matter."""
Cable = Iterable[tuple[float, bytes]]
"""Bytes and their times."""


def at_bar(number: int) -> bytes:
    return bytes([0xF2, number * 16 % 128, number * 16 // 128])


def ticks(tempo: float, since: float, count: int) -> Cable:
    return [(since + tick * 60 / tempo / 24, TICK) for tick in range(count)]


def told(cable: Cable) -> list[Anchor]:
    parser, time, anchors = Parser(), MidiTime(), list[Anchor]()
    for at, data in cable:
        parser.feed(data)
        for message in parser:
            time, anchor = heard(time, message.type, getattr(message, "pos", 0), at)
            anchors += [anchor] if anchor else []
    return anchors


def check(cable: Cable, at: float, beat: float, tempo: float) -> Anchor:
    latest = told(cable)[-1]
    assert latest.phase_at(at) == pytest.approx(beat, abs=0.01)
    assert latest.rate * 60 == pytest.approx(tempo, rel=0.001)
    return latest


def test_24_ticks_are_a_beat() -> None:
    check(ticks(120, 0, 240), at=5, beat=10, tempo=120)
    check(ticks(87.5, 3, 240), at=3 + 10 * 60 / 87.5, beat=10, tempo=87.5)


def test_anchors_come_ten_times_a_second_once_the_tempo_is_known() -> None:
    anchors = told(ticks(120, 0, 480))
    assert anchors[0].at <= 0.5
    assert 80 <= len(anchors) <= 100


def test_the_tick_after_a_start_is_beat_0() -> None:
    *_, last = told([*ticks(120, 0, 100), (2.09, START), (2.1, TICK)])
    assert (last.at, last.phase, last.jumps) == (2.1, 0, 1)
    check([*ticks(120, 0, 100), (3, START), *ticks(120, 3.1, 100)], at=3.1 + 2, beat=4, tempo=120)


def test_a_stop_counts_at_once_and_a_continue_resumes_there() -> None:
    before = [*ticks(120, 0, 97), (2.01, STOP)]
    stands = told(before)[-1]
    assert (stands.at, stands.rate) == (2.01, 0)
    assert stands.phase == pytest.approx(97 / 24)
    idle = [*before, *ticks(120, 2.02, 50)]
    assert told(idle)[-1] == stands, "many send ticks while they stand"
    check([*idle, (4, CONTINUE), *ticks(120, 4.5, 50)], at=4.5 + 1, beat=97 / 24 + 2, tempo=120)


def test_a_song_position_sets_where_a_continue_resumes() -> None:
    cable = [*ticks(120, 0, 100), (3, STOP), (3.1, at_bar(9)), (3.2, CONTINUE), *ticks(120, 3.3, 60)]
    check(cable, at=3.3 + 1, beat=9 * 4 + 2, tempo=120)


def test_other_messages_on_the_cable_change_nothing() -> None:
    cable = [*ticks(120, 0, 240)]
    mixed = chain.from_iterable([(at, NOISE + data), (at, NOISE)] for at, data in cable)
    assert told(mixed) == told(cable)


def test_a_song_keeps_playing_while_its_ticks_are_lost() -> None:
    cable = [*ticks(120, 0, 240), *ticks(120, 6.01, 240)]
    assert check(cable, at=6.01 + 2, beat=12 + 4, tempo=120).jumps == 0


def test_a_stop_counts_before_any_tick() -> None:
    assert told([(1, STOP)]) == [Anchor(1, 0, 0, 0)]


@pytest.mark.parametrize(
    ("wanted", "found"), [("", "Midi Through"), ("IAC", "IAC Bus 1"), ("IAC Bus 2", "IAC Bus 2"), ("USB", None)]
)
def test_the_input_is_the_first_with_that_beginning(wanted: str, found: str | None) -> None:
    assert chosen(["Midi Through", "IAC Bus 1", "IAC Bus 2"], wanted) == found
    assert chosen([], wanted) is None
