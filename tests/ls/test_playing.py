"""What plays, according to the messages of stages."""

from __future__ import annotations

from improv_core.stage.messages import State, TransportMessage
from improv_ls.documents import opened
from improv_ls.playing import Playing

URI = "file:///dances/dance.improv"


def transport(generation: int, state: State = "playing", beat: float = 0.0) -> TransportMessage:
    return {
        "type": "transport",
        "generation": generation,
        "state": state,
        "backend": "simulator",
        "beat": beat,
        "performed": beat,
        "restarted": 0,
        "monotonic": 0.0,
        "wall": 0,
        "tempo": 60.0,
        "speed": 1.0,
        "beats": None,
        "muted": [],
        "soloed": [],
    }


def test_what_begins_is_a_program_or_a_scene() -> None:
    playing = Playing({})
    first, second = (opened(URI, None, f"r $ {word}\n") for word in ("left", "right"))
    playing.sent(1, first)
    assert playing.follow(transport(1)) == "program"
    playing.sent(2, second)
    assert (playing.follow(transport(1, beat=1)), playing.document) == (None, first)
    assert playing.follow({**transport(1, beat=2), "scene": {"index": 1, "begins": 2.0}}) == "scene"
    assert (playing.follow(transport(2)), playing.document) == ("program", second)
    assert (playing.follow(transport(3)), playing.document) == ("program", second)  # the page restarts it


def test_nothing_plays_once_the_stage_is_gone() -> None:
    playing = Playing({})
    playing.sent(1, opened(URI, None, "r $ left\n"))
    playing.follow(transport(1))
    playing.gone()
    assert (playing.state, playing.transport) == ("stopped", None)


def test_a_replaced_stage_is_ignored_once_the_new_one_plays() -> None:
    playing = Playing({})
    playing.follow(transport(1))
    assert not playing.is_old(transport(1, "stopped"))  # nothing else plays yet
    playing.follow(transport(2))
    assert playing.is_old(transport(1, "stopped"))
