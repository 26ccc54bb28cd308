"""Faults of robots in physics, and the reports of a camera above them."""

from __future__ import annotations

import math

import pytest

from tests.ros.physics.camera import Camera, Pose
from tests.ros.physics.faults import Fault, parsed

POSES = {"ada": (0.0, 0.0, 0.0), "bert": (1.0, 0.0, 0.0)}


@pytest.mark.parametrize(
    ("text", "fault"),
    [
        ("swap:ada,bert@3-6", Fault("swap", ("ada", "bert"), 0.0, 3.0, 6.0)),
        ("jump:ada=1@2", Fault("jump", ("ada",), 1.0, 2.0, math.inf)),
        ("lost:bert", Fault("lost", ("bert",), 1.0, 0.0, math.inf)),
        ("lost:bert=0.2@1-2", Fault("lost", ("bert",), 0.2, 1.0, 2.0)),
    ],
)
def test_a_fault_is_one_word(text: str, fault: Fault) -> None:
    assert parsed(text, list(POSES)) == fault


@pytest.mark.parametrize("text", ["", "lift", "lift:carl", "swap:ada", "fly:ada", "lift:ada@x"])
def test_invalid_faults_are_refused(text: str) -> None:
    with pytest.raises(ValueError):  # noqa: PT011, as float says it, too
        parsed(text, list(POSES))


@pytest.mark.parametrize(
    ("fault", "ada"),
    [
        ("lift:ada", (0.0, 0.0, 0.0)),
        ("swap:ada,bert", (1.0, 0.0, 0.0)),
        ("jump:ada=1", (0.0, 1.0, 0.0)),
        ("lost:ada", None),
        ("late:ada=0.1", None),
    ],
)
def test_a_camera_reports_a_robot_once_its_latency_is_over(fault: str, ada: Pose | None) -> None:
    camera = Camera(latency=0.08, loss=0.0, seed=1)
    camera.look(POSES, [parsed(fault, list(POSES))], 10.0)
    assert list(camera.say(10.079)) == []
    said = {robot: (pose, at) for robot, pose, at in camera.say(10.08)}
    assert said.get("ada") == (None if ada is None else (ada, 10.0))
    assert list(camera.say(10.08)) == [], "each is said once"
