"""OSC messages as bytes (python-osc imported lazily)."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

MAX_BYTES = 4096
"""The most bytes of a datagram that is read. Those of music programs fit into a network's 1,500."""
Argument = str | int | float | bool | None


class OscMessage(NamedTuple):
    """An address, its arguments, and the Unix time at which it is due. Arguments of unsupported types are None."""

    address: str
    arguments: Sequence[Argument]
    due: float


class BrokenError(Exception):
    """A datagram isn't OSC."""


def read(datagram: bytes) -> list[OscMessage]:
    """Return the messages in a datagram, in the order of their times. Messages without a time, or with one that has
    passed, are due now. Raises BrokenError."""
    from pythonosc.osc_packet import OscPacket

    try:
        packet = OscPacket(datagram)
    except Exception as error:  # also errors of other libraries, for bytes that aren't text and for deep bundles
        raise BrokenError from error
    return [OscMessage(each.message.address, _plain(each.message.params), each.time) for each in packet.messages]


def plain(address: str, arguments: Sequence[Argument]) -> bytes:
    """A message without a time."""
    from pythonosc.osc_message_builder import build_msg

    return build_msg(address, [*arguments]).dgram


def written(messages: Sequence[tuple[str, Sequence[Argument]]], due: float) -> bytes:
    """A bundle of messages that are due at a Unix time."""
    from pythonosc.osc_bundle_builder import OscBundleBuilder
    from pythonosc.osc_message_builder import build_msg

    seconds: Any = due  # its documentation allows this, its types don't
    bundle = OscBundleBuilder(seconds)
    for address, arguments in messages:
        bundle.add_content(build_msg(address, [*arguments]))
    return bundle.build().dgram


def _plain(arguments: Sequence[object]) -> list[Argument]:
    return [each if isinstance(each, str | int | float) else None for each in arguments]
