"""Requests, messages from stages, and the acts that follow, in words: no process, no event loop, no clock."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from improv_core.ipc.stage_process import Gone, Heard
from improv_core.program.analysis import analyze
from improv_core.program.compiler import score_of
from improv_core.protocol.commands import PageOpened, PageRequest
from improv_core.protocol.messages import Pressed, Ready, State, ToStage, TransportMessage
from improv_core.score.score import Score
from improv_core.session.acts import Act, Announce, Failed, HearClock, Now, Send, SendScore, Start
from improv_core.session.on_report import on_report
from improv_core.session.on_request import StageRequest, on_request
from improv_core.session.state import HERE, Output, PlayScore, SessionState, StageKey

DANCE = score_of(analyze("r $ repeat forward\n"))
READY: Mapping[Output, Ready] = {
    "ros": {"type": "ready", "protocol": 3, "sink": "ROS 2", "real": True},
    "simulator": {"type": "ready", "protocol": 3, "sink": "simulator", "real": False, "page": "http://127.0.0.1:8123/"},
    "page": {"type": "ready", "protocol": 3, "sink": "page", "real": False, "page": "http://127.0.0.1:8123/"},
}
GONE: Gone = {"type": "gone", "message": "it exited"}
FAILED: Failed = {"type": "failed", "message": "no ROS"}
NOW = 1000.0
"""The time of all requests."""

From = tuple[Output, Heard | Failed]
"""A message of a stage; its start, or its end; or that it could not be started."""
Event = From | PlayScore | StageRequest | PageRequest | PageOpened


def play(score: Score = DANCE, **how: Any) -> PlayScore:
    return PlayScore(score, "dance.improv", 0, **how)


def at(state: State, generation: int, beat: float = 0.0, monotonic: float = 500.0, **known: Any) -> TransportMessage:
    """Return a stage's position in the score of a generation."""
    transport: TransportMessage = {
        "type": "transport",
        "generation": generation,
        "restarted": generation,
        "state": state,
        "backend": "fake",
        "tempo": 120.0,
        "speed": 1.0,
        "beats": None,
        "beat": beat,
        "performed": beat / 2,
        "muted": [],
        "soloed": [],
        "monotonic": monotonic,
        "wall": 0.0,
    }
    transport.update(known)  # type: ignore[typeddict-item]
    return transport


class Story:
    """A session from when its stages have started. `acts` are those that followed from the latest event."""

    def __init__(self, *names: Output) -> None:
        self.state = SessionState()
        self.acts: list[Act] = []
        self.pressed: Pressed = {"type": "pressed", "topics": [], "count": 0}
        self._stopped = 0
        self._open(*names)

    def __call__(self, event: Event, stops: int = 0, stopped: int = 0) -> list[str]:
        """Return the acts that follow from an event, in words. Scores to send are sent."""
        self._stopped += isinstance(event, dict) and event["type"] == "stop"
        now = Now(NOW, stops=stops, stopped=stopped or self._stopped, pressed=self.pressed)
        if isinstance(event, tuple):
            name, message = event
            self.state, self.acts = on_report(self.state, StageKey(HERE, name), message, now)
        else:
            self.state, self.acts = on_request(self.state, event, now)
        for act in [*self.acts]:
            if isinstance(act, SendScore) and act.asked:
                self.state, more = on_report(self.state, act.to[0], {"type": "loaded", "play": act.play}, now)
                self.acts += more
        return [in_words(act) for act in self.acts]

    def sent(self, name: Output) -> list[Any]:
        """The messages that the latest event sent to a stage."""
        return [unpacked(act.message) for act in self.acts if isinstance(act, Send) and act.to.output == name]

    @property
    def score(self) -> SendScore:
        """The score that the latest event sent."""
        (sent,) = (act for act in self.acts if isinstance(act, SendScore))
        return sent

    def _open(self, *names: Output) -> None:
        for name in names or ("ros", "simulator"):
            assert self((name, READY[name])) == []
        self.state = self.state.opened(["ros", "simulator"])

    @classmethod
    def playing(cls, *names: Output) -> Story:
        """The leading stage plays the first score from beat 0, and its twin follows."""
        story = cls(*names)
        story(play())
        assert story.state.leader
        story((story.state.leader, at("playing", 1)))
        return story


def unpacked(message: ToStage) -> Mapping[str, Any]:
    """Return a message without its envelope."""
    return message["message"] if message["type"] == "page" else message


def in_words(act: Act) -> str:
    match act:
        case Send(to, message, after):
            return f"{to.output}: {unpacked(message)['type']}" + (f" {after} s later" if after else "")
        case SendScore([to], sent, stood=stood) if stood:
            return f"{to.output}: score {sent.generation} stands at beat {stood['beat']:g}"
        case SendScore([to], sent, entry, whole=whole):
            stands = not any(part.scenes for part in sent.score.parts.values())
            how = " stop" if stands else " whole" if whole else ""
            return f"{to.output}: score {sent.generation}{how}" + (f" from beat {entry['beat']:g}" if entry else "")
        case Announce(news, leads):
            said: Any = news
            return str(said.get("message", said["type"])) + ("" if leads else " (the other)")
        case Start(stage):
            return f"start {stage.output}"
        case HearClock(clock):
            return f"listen to {clock.follow}" if clock else "listen to no clock"
    raise AssertionError(f"a score goes to several stages: {act}")


def tell(story: Story, events: Sequence[tuple[Event, list[str]]]) -> None:
    """Check the acts that follow from each event."""
    for event, follows in events:
        assert story(event) == follows
