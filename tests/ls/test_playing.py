"""State of the performance, according to the messages of stages."""

from __future__ import annotations

from improv_core.program.analysis import analyze
from improv_core.protocol.messages import State, TransportMessage
from improv_core.protocol.robot_messages import RobotInstant
from improv_core.score.movement import near
from improv_ls.documents import Document
from improv_ls.playing import Playing, prepare
from tests.session import story

URI = "file:///dances/dance.improv"


def transport(generation: int, state: State = "playing", beat: float = 0.0) -> TransportMessage:
    return story.at(state, generation, beat, beat, tempo=60.0, performed=beat, restarted=0)


def sent(playing: Playing, generation: int, text: str) -> Document:
    prepared = prepare(Document(URI, None, analyze(text)), None)
    playing.sent(generation, prepared)
    return prepared.document


def plays(playing: Playing, beat: float = 0.0) -> str:
    """Return the word of the robot that plays at a beat."""
    assert playing.replay
    score, moment = playing.replay.score, playing.replay.now("r", near(beat))
    assert moment
    source = moment.sources[-1]
    return score.text[slice(*source.span.shifted(score.offsets[source.statement]))]


def test_the_stages_messages_decide_what_plays() -> None:
    playing = Playing({})
    first = sent(playing, 1, "r $ until cue (left)\n---\nr $ up\n")
    playing.follow(transport(1))
    assert (playing.document, plays(playing)) == (first, "left")
    second = sent(playing, 2, "r $ right\n")
    playing.follow(transport(1, beat=1))
    assert playing.document == first
    playing.follow({**transport(1, beat=2), "begins": {"r": 2.0}, "scene": {"index": 1, "begins": 2.0}})
    assert plays(playing, 2) == "up"
    for generation in (2, 3):  # the page restarts it
        playing.follow(transport(generation))
        assert (playing.document, plays(playing)) == (second, "right")


def test_senses_count_until_playback_jumps() -> None:
    playing = Playing({})
    sent(playing, 1, "r $ until near (repeat forward) repeat left\n")

    def sense(value: bool, beat: float) -> None:
        instant: RobotInstant = {"generation": 1, "robot": "r", "beat": beat, "performed": beat, "wall": 0}
        playing.sensed({"type": "sensed", "sense": "near", "value": value, **instant})

    playing.follow(transport(1))
    sense(False, 0)
    sense(True, 2)
    playing.follow(transport(1, beat=3))
    assert [plays(playing, beat) for beat in (2.5, 3)] == ["until", "left"]
    playing.follow({**transport(1, beat=1), "monotonic": 3.0})
    sense(False, 1)
    assert [plays(playing, beat) for beat in (1, 3)] == ["forward", "forward"]


def test_nothing_plays_once_the_stage_is_gone() -> None:
    playing = Playing({})
    sent(playing, 1, "r $ left\n")
    playing.follow(transport(1))
    playing.gone()
    assert (playing.state, playing.transport) == ("stopped", None)


def test_a_replaced_stage_is_ignored_once_the_new_one_plays() -> None:
    playing = Playing({})
    playing.follow(transport(1))
    assert not playing.is_old(transport(1, "stopped"))  # nothing else plays yet
    playing.follow(transport(2))
    assert playing.is_old(transport(1, "stopped"))
