"""Programs with which Improv exchanges OSC messages: `[osc]` in an `improv.toml`."""

from __future__ import annotations

import pytest

from improv_core.robots.config import read_robots
from improv_core.score.osc import Osc, Peer
from tests.robots.drawing import check

QLAB = Peer("127.0.0.1", 9000)


@pytest.mark.parametrize(
    ("written", "expected"),
    [
        ("", None),
        ("[osc]\nlisten = 7000", Osc(listen=Peer("127.0.0.1", 7000))),
        ('[osc]\nlisten = 7000\nhost = "192.168.1.2"', Osc(listen=Peer("192.168.1.2", 7000))),
        ('[osc]\nsend = ["127.0.0.1:4560"]\ntime_tags = false', Osc((Peer("127.0.0.1", 4560),), time_tags=False)),
        (
            '[osc]\nsend = ["127.0.0.1:9000", "td.local:1"]\nlisten = 7000',
            Osc((QLAB, Peer("td.local", 1)), Peer("127.0.0.1", 7000)),
        ),
    ],
)
def test_osc_is_off_by_default(written: str, expected: Osc | None) -> None:
    assert check(written).osc == expected


@pytest.mark.parametrize(
    ("osc", "away"),
    [
        (Osc((QLAB, Peer("localhost", 1)), Peer("127.0.1.1", 7000)), None),
        (Osc((QLAB, Peer("10.0.0.7", 1))), Peer("10.0.0.7", 1)),
        (Osc(listen=Peer("0.0.0.0", 7000)), Peer("0.0.0.0", 7000)),
    ],
)
def test_peers_on_other_machines_are_recognized(osc: Osc, away: Peer | None) -> None:
    assert osc.away == away


def test_wrong_values_are_marked() -> None:
    check("""
        [osc]
        listen = 7000
        host = "here"
               ^^^^^^ robots: write `host` as an IPv4 address of this machine, such as `"127.0.0.1"`
        send = ["127.0.0.1:7000", "127.0.0.1", "a:0"]
                ^^^^^^^^^^^^^^^^ robots: Improv itself listens on this port: send to another one
                                  ^^^^^^^^^^^ robots: write a host and a port: `"127.0.0.1:9000"`
                                               ^^^^^ robots: write a host and a port: `"127.0.0.1:9000"`
    """)
    check("""
        [osc]
        host = "127.0.0.1"
        ^^^^ robots: `host` sets where Improv listens: add `listen`, a port
        [senses.kick]
        osc = "a kick"
              ^^^^^^^^ robots: write `osc` as one word of letters, digits, `_`, and `-`
        [senses.snare]
        osc = "snare"
        timeout = 1
        ^^^^^^^ robots: OSC messages decide this sense, so `timeout` has no effect: remove it
    """)


def test_sonic_pi_reads_no_bundles() -> None:
    found = read_robots('[osc]\nsend = ["127.0.0.1:4560"]')
    assert found.ok
    line = "Sonic Pi, which listens on 4560, reads no bundles: add `time_tags = false`"
    assert [each.message for each in found.diagnostics] == [line]
