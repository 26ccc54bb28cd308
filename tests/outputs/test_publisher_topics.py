"""Topics and diagnostics of a dance, before rclpy sends them."""

from __future__ import annotations

import json
import re
import socket
from pathlib import Path
from typing import Any

import pytest

from improv_core.outputs.ros.publisher.topics import diagnose, path_topics
from improv_core.preview.forecast import Forecast
from improv_core.protocol.helper_messages import Health
from tests.player.test_player import Stage, score


@pytest.mark.parametrize(
    ("robots", "names"),
    [
        (["anna", "r2_d2", "_x"], ["anna", "r2_d2", "_x"]),
        (["rené"], ["ren_"]),
        (["é", "è", "ö"], ["_", "__2", "__3"]),
        (["é", "_"], ["__2", "_"]),
        (["機", "_", "__2"], ["__3", "_", "__2"]),
        (["a" * 300, "a" * 301], ["a" * 200, "a" * 200 + "_2"]),
    ],
)
def test_all_kinds_of_names_become_valid_topics(robots: list[str], names: list[str]) -> None:
    topics = path_topics(robots)
    assert list(topics) == robots
    assert list(topics.values()) == [f"/improv/{name}/path" for name in names]
    assert all(re.fullmatch("(/[A-Za-z_][A-Za-z0-9_]*)+", topic) and len(topic) <= 247 for topic in topics.values())


def test_the_layout_for_foxglove_shows_existing_topics() -> None:
    text = (Path(__file__).parents[2] / "examples" / "ros" / "foxglove.json").read_text(encoding="utf-8")
    layout = json.loads(text)
    topics = {"/improv/markers", "/improv/transport", "/diagnostics", "/rosout"}
    topics |= set(path_topics(["anna", "bert", "turtle1"]).values())
    assert set(re.findall(r'"(/[a-z0-9/]+)"', text)) == topics
    panels = json.dumps(layout["layout"])
    assert all(f'"{panel}"' in panels for panel in layout["configById"])


def test_diagnostics_report_lateness_reach_and_limits() -> None:
    stage, forecast = Stage(), Forecast()
    health: Health = {"type": "health", "late": 0.0, "missing": {}, "clipped": []}
    assert list(diagnose(forecast, health, stage.now)) == []
    made = score("a $ forward\nb $ forward\n")
    forecast.add_score(made, 1)
    stage.perform(made)
    stage.ask("silence", muted=["b"], soloed=[])
    forecast.take(stage.transports[-1])
    levels = [(each.name, each.level, each.message) for each in diagnose(forecast, health, stage.now)]
    assert levels == [("improv", 0, "playing"), ("improv: a", 0, "OK"), ("improv: b", 0, "OK")]
    health = {"type": "health", "late": 0.07, "missing": {"a": "gone"}, "clipped": ["a", "b"]}
    whole, one, two = diagnose(forecast, health, stage.now + 0.5)
    assert (whole.level, whole.message) == (1, "playing, 70 ms late")
    assert whole.values == {"beat": "0.50", "tempo": "60", "late (ms)": "70.0", "waits for": ""}
    assert (one.level, one.message) == (2, "gone; its commands exceeded its limits and were scaled down")
    assert one.values == {"listens": "no", "within its limits": "no", "muted": "no", "faults": ""}
    assert (two.level, two.values["muted"]) == (1, "yes")


def test_diagnostics_report_the_faults_of_each_robot_until_they_are_over_or_all_restarts() -> None:
    stage, forecast, made = Stage(), Forecast(), score("a $ forward\nb $ forward\n")
    health: Health = {"type": "health", "late": 0.0, "missing": {}, "clipped": []}

    def check(level: int, message: str, faults: str = "") -> None:
        whole, one, other = diagnose(forecast, health, stage.now)
        assert (one.level, one.message, one.values["faults"]) == (level, message, faults)
        assert (one.hardware, other.message) == ("/a", "OK")
        assert whole.hardware == socket.gethostname()

    def fault(kind: str, over: bool = False) -> None:
        told: Any = {"type": "fault", "robot": "a", "fault": kind, "over": over, "message": f"a: {kind}"}
        forecast.note_fault(told)

    def restart(generation: int) -> None:
        forecast.add_score(made, generation)
        stage.perform(made, generation)
        forecast.take(stage.transports[-1])

    restart(1)
    fault("off_path")
    check(1, "a: off_path", "off_path")
    fault("gone")
    check(2, "a: off_path; a: gone", "gone, off_path")
    fault("gone", over=True)
    check(1, "a: off_path", "off_path")
    restart(2)
    check(0, "OK")
