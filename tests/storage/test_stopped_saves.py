"""Saves around a stop: decisions that don't depend on clocks."""

from __future__ import annotations

import asyncio
from pathlib import Path

import pytest

from improv_core.safety.stops import Stops
from improv_core.storage.stopped_saves import Seen, StopWitness, Verdict, decide, is_shared, look

OLD = Seen((1, 9, 100, 100), b"r $ left\n")
SAME = Seen((1, 9, 200, 200), b"r $ left\n")
"""Saved again, with the same contents."""
NEW = Seen((2, 10, 5, 5), b"r $ right\n")
GONE = Seen(None, None)


@pytest.mark.parametrize(
    ("handled", "at_stop", "now", "shared", "told", "verdict"),
    [
        (OLD, None, NEW, False, False, Verdict.PLAY),  # nothing was stopped
        (OLD, None, OLD, False, False, Verdict.PLAY),  # its robots have changed
        (OLD, None, NEW, True, False, Verdict.PLAY),
        (OLD, OLD, NEW, False, False, Verdict.PLAY),  # with any times
        (NEW, NEW, OLD, False, False, Verdict.PLAY),
        (OLD, OLD, SAME, False, False, Verdict.PLAY),
        (OLD, OLD, OLD, False, False, Verdict.ONLY_ROBOTS),
        (OLD, OLD, OLD, True, True, Verdict.ONLY_ROBOTS),
        (OLD, NEW, NEW, False, False, Verdict.DROP),
        (OLD, NEW, NEW, True, False, Verdict.DROP),
        (OLD, SAME, SAME, False, False, Verdict.DROP),
        (NEW, NEW, SAME, False, False, Verdict.PLAY),  # the save after a dropped one
        (OLD, SAME, NEW, False, False, Verdict.SAVE_AGAIN),  # it may have been half written at the stop
        (OLD, GONE, NEW, False, False, Verdict.SAVE_AGAIN),
        (OLD, OLD, NEW, True, False, Verdict.SAVE_AGAIN),  # the drive may show an old save late
        (NEW, OLD, SAME, True, True, Verdict.PLAY),
        (NEW, GONE, SAME, False, True, Verdict.PLAY),
    ],
)
def test_states_of_the_file_decide_what_plays(
    handled: Seen, at_stop: Seen | None, now: Seen, shared: bool, told: bool, verdict: Verdict
) -> None:
    assert decide(handled, at_stop, now, shared=shared, told=told) is verdict


def test_a_save_with_the_same_contents_is_another_state(tmp_path: Path) -> None:
    path = tmp_path / "dance.improv"
    path.write_text("r $ left\n")
    before = look(path)
    assert look(path) == before
    new = path.with_suffix(".new")
    new.write_text("r $ left\n")
    new.rename(path)
    assert look(path) != before
    path.unlink()
    assert look(path) == GONE


def test_the_latest_stop_counts_and_a_pause_does_not(tmp_path: Path) -> None:
    path = tmp_path / "dance.improv"
    path.write_text("r $ left\n")
    stops = Stops()
    witness = StopWitness(stops, path)
    stops.stop({"type": "pause"})
    assert asyncio.run(witness.since(0)) is None
    for text in ("r $ right\n", "r $ forward\n"):
        path.write_text(text)
        stops.stop()
        seen = asyncio.run(witness.since(0))
        assert seen == look(path)
    assert asyncio.run(witness.since(2)) is None


@pytest.mark.parametrize(
    ("path", "shared"), [("/home/a.improv", False), ("/home/net/a.improv", True), ("/home/netto/a.improv", False)]
)
def test_shared_drives_are_recognized(path: str, shared: bool, tmp_path: Path) -> None:
    mounts = tmp_path / "mountinfo"
    mounts.write_text(
        "22 1 8:1 / / rw,relatime shared:1 - ext4 /dev/sda1 rw\n"
        "30 22 0:40 / /home/net rw,relatime shared:2 master:1 - nfs4 server:/home rw\n"
    )
    assert is_shared(Path(path), mounts) == shared
