"""The frames of a link, line by line."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from improv_core.hosts.frames import (
    CHUNK,
    DOWN,
    LONGEST_DOWN,
    WINDOW,
    FrameError,
    Incoming,
    LinkFrame,
    Outgoing,
    RemoteTimes,
    time_in,
)


def all_of(outgoing: Outgoing) -> list[bytes]:
    frames = []
    while frame := outgoing.next():
        frames.append(frame)
    return frames


def take_all(incoming: Incoming, data: bytes) -> None:
    for at in range(0, len(data), 65_536):
        incoming.take(data[at : at + 65_536])


def test_a_line_travels_in_chunks_and_no_more_than_fit_into_the_window() -> None:
    outgoing, line = Outgoing(), b"x" * (2 * WINDOW)
    outgoing.put(line, is_score=True)
    sent = all_of(outgoing)
    assert sent[0] == b"l\n"
    assert {len(frame) for frame in sent[1:]} == {CHUNK + 2}
    assert sum(len(frame) - 1 for frame in sent[1:]) == pytest.approx(WINDOW, abs=CHUNK)
    outgoing.acknowledge(CHUNK)
    assert len(all_of(outgoing)) == 1
    outgoing.acknowledge(WINDOW)
    outgoing.acknowledge(WINDOW)
    sent += all_of(outgoing)
    assert sent[-1].startswith(b"M")


def test_a_stop_goes_before_the_rest_of_a_long_line_even_if_the_window_is_full() -> None:
    outgoing = Outgoing()
    outgoing.put(b"x" * (2 * WINDOW))
    outgoing.next()
    outgoing.put_first(b"s1\n")
    outgoing.put_first(b"s2\n")
    assert [outgoing.next(), outgoing.next()] == [b"s1\n", b"s2\n"]
    all_of(outgoing)
    outgoing.put_first(b"s3\n")
    assert all_of(outgoing) == [b"s3\n"]


def test_it_rests_once_no_line_waits_and_all_have_arrived() -> None:
    outgoing = Outgoing()
    assert outgoing.rests
    outgoing.put(b"x" * CHUNK)
    assert not outgoing.rests
    all_of(outgoing)
    assert not outgoing.rests
    outgoing.acknowledge(CHUNK + 1)
    assert outgoing.rests


def test_at_the_end_only_urgent_frames_are_sent() -> None:
    outgoing = Outgoing()
    outgoing.put(b"x" * WINDOW)
    outgoing.next()
    outgoing.put_first(b"s1\n")
    outgoing.forget()
    assert all_of(outgoing) == [b"s1\n"]


@given(st.lists(st.binary(max_size=3 * CHUNK).map(lambda line: line.replace(b"\n", b" "))), st.integers(1, 5_000))
def test_lines_arrive_as_they_were_sent_however_they_are_cut(lines: list[bytes], cut: int) -> None:
    outgoing, incoming = Outgoing(), Incoming(DOWN, LONGEST_DOWN)
    arrived, begun, data = [], b"", b""
    for line in lines:
        outgoing.put(line)
    while frame := outgoing.next():
        data += frame
        outgoing.acknowledge(len(frame))
    for at in range(0, len(data), cut):
        for frame_in in incoming.take(data[at : at + cut]):
            begun += frame_in.rest
            if frame_in.letter == "M":
                arrived.append(begun)
                begun = b""
    assert arrived == lines


@pytest.mark.parametrize(
    ("data", "problem"),
    [
        (b"Welcome to Ubuntu!\n", "it sent something that isn't from a stage"),
        (b"\n", "it sends an empty line"),
        (b"s" * (LONGEST_DOWN + 1), "it sends a line of more than 1 MB"),
        (b"\x00\xff", "it sent something that isn't from a stage"),
    ],
)
def test_garbage_is_refused_with_a_reason(data: bytes, problem: str) -> None:
    incoming = Incoming(DOWN, LONGEST_DOWN)
    assert incoming.take(b"s1\ns2") == [LinkFrame("s", b"1")]
    incoming.take(b"\n")
    with pytest.raises(FrameError, match=f"^{problem}$"):
        take_all(incoming, data)


def test_an_answer_arrives_as_it_was_sent() -> None:
    answer = RemoteTimes(7, 10**15, 10**15 + 1, 1_700_000_000_123_456_789, 5)
    (frame,) = Incoming(b"c", 1_000).take(answer.frame())
    assert time_in(frame.rest) == answer


@pytest.mark.parametrize(
    "rest", [b"", b"1 2 3 4", b"1 2 3 4 x", b"1 2 3 4 -5", b"9" * 30 + b" 1 2 3 4", b"1 2 3 4 5 6"]
)
def test_anything_else_is_no_answer(rest: bytes) -> None:
    with pytest.raises(FrameError):
        time_in(rest)
