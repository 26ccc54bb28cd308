"""Bytes as they arrive, split anywhere, and the messages in them."""

from __future__ import annotations

from itertools import pairwise

import pytest
from hypothesis import given
from hypothesis import strategies as st

from improv_ls.arrivals import LONGEST_HEADER, Frames, FramingError


def check(pieces: list[bytes], *bodies: bytes) -> None:
    frames = Frames()
    assert [body for piece in pieces for body in frames.feed(piece)] == list(bodies)


def framed(body: bytes) -> bytes:
    return b"Content-Length: %d\r\n\r\n%s" % (len(body), body)


@given(st.lists(st.binary(max_size=40)), st.lists(st.integers(0, 500)))
def test_bytes_can_be_split_anywhere(bodies: list[bytes], cuts: list[int]) -> None:
    whole = b"".join(framed(body) for body in bodies)
    places = [0, *sorted(min(cut, len(whole)) for cut in cuts), len(whole)]
    check([whole[start:end] for start, end in pairwise(places)], *bodies)


@pytest.mark.parametrize(
    ("stream", "bodies"),
    [
        (b"content-length:2\r\n\r\n{}", [b"{}"]),
        (b"Content-Type: application/vscode-jsonrpc; charset=utf-8\r\nContent-Length: 2\r\n\r\n{}", [b"{}"]),
        (b"Content-Length: 2\r\nContent-Type: x\r\n\r\n{}", [b"{}"]),
        (b"Content-Length: 9\r\n\r\n{}", []),
    ],
)
def test_headers_give_the_length_in_any_valid_form(stream: bytes, bodies: list[bytes]) -> None:
    check([stream], *bodies)


@pytest.mark.parametrize(
    "header",
    [
        b"no header at all\r\n\r\n",
        b"Content-Length: -2\r\n\r\n",
        b"Content-Length: 2.0\r\n\r\n",
        b"Content-Length: 0x2\r\n\r\n",
        b"Content-Length: \r\n\r\n",
        b"Content-Length: " + b"9" * 5_000 + b"\r\n\r\n",
        b"}Content-Length: 2\r\n\r\n",
        b"x" * (LONGEST_HEADER + 1),
        b"x" * LONGEST_HEADER + b"\r\n\r\n",
    ],
)
def test_a_bad_header_is_an_error_after_the_messages_before_it(header: bytes) -> None:
    messages = Frames().feed(framed(b"{}") + header + framed(b"{}"))
    assert next(messages) == b"{}"
    with pytest.raises(FramingError):
        next(messages)
