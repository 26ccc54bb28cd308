"""Goals of a trajectory controller's action: how they are sent, canceled, and reported. The test provides the server,
and the types, which only ROS has."""

from __future__ import annotations

import sys
from dataclasses import dataclass, field
from types import SimpleNamespace
from typing import Any
from unittest.mock import Mock

import pytest

from improv_core.outputs.ros.joints import controllers as ros_controllers
from improv_core.outputs.ros.joints.controller import RosController
from improv_core.outputs.ros.joints.goals import ABORTED, MAX_GOALS, OVERDUE, QUIET, Goals
from tests.outputs import test_ros_controllers as topics
from tests.outputs.test_ros_controllers import HEAD, TOPIC, Robot, part

courses = topics.courses
SUCCEEDED = 4


@dataclass
class Response:
    """A response that comes when the test gives it."""

    callbacks: list[Any] = field(default_factory=list)
    value: Any = None
    gone: bool = False

    def add_done_callback(self, callback: Any) -> None:
        self.callbacks.append(callback)

    def cancel(self) -> None:
        self.gone = True
        self.give(None)

    def cancelled(self) -> bool:
        return self.gone

    def exception(self) -> None:
        """Every request is answered."""

    def result(self) -> Any:
        return self.value

    def give(self, value: Any) -> None:
        self.value = value
        for callback in self.callbacks:
            callback(self)


class Server:
    """A node whose clients note their requests; and a clock."""

    def __init__(self) -> None:
        self.now, self.requests = 10.0, dict[str, list[Response]]()
        self.timers: list[Any] = []
        self.destroy_timer = Mock()

    def create_client(self, kind: object, name: str) -> Any:
        asked = self.requests.setdefault(name.rpartition("/")[2], [])

        def call(request: object) -> Response:
            asked.append(Response())
            return asked[-1]

        return SimpleNamespace(service_is_ready=lambda: True, srv_type=Mock(), call_async=call)

    def create_timer(self, seconds: float, act: Any, clock: object) -> Any:
        self.timers.append(act)
        return Mock()


@pytest.fixture
def server(monkeypatch: pytest.MonkeyPatch) -> Server:
    for module in ("control_msgs", "control_msgs.action", "rclpy", "rclpy.clock", "rclpy.serialization"):
        monkeypatch.setitem(sys.modules, module, Mock())
    monkeypatch.setitem(sys.modules, "trajectory_msgs", Mock())
    monkeypatch.setitem(sys.modules, "trajectory_msgs.msg", Mock())
    return Server()


def sent(server: Server, count: int = 1, accepted: bool = True) -> Goals:
    goals = Goals(server, "/ada/head_controller/joint_trajectory", lambda: server.now)
    for _ in range(count):
        goals.send(b"")
        server.requests["send_goal"][-1].give(SimpleNamespace(accepted=accepted))
    return goals


def end(server: Server, goal: int, status: int, why: str = "", code: int = -4) -> None:
    result = SimpleNamespace(error_string=why, error_code=code)
    server.requests["get_result"][goal].give(SimpleNamespace(status=status, result=result))


def test_a_refused_trajectory_is_a_problem_for_a_while(server: Server) -> None:
    goals = sent(server, accepted=False)
    assert goals.problem == "refuses what it gets: its log says why"
    server.now += QUIET
    assert goals.problem == ""


@pytest.mark.parametrize(
    ("goal", "status", "why", "told"),
    [
        (1, ABORTED, "yaw violated\nits tolerance", r"has aborted what it got: yaw violated\nits tolerance"),
        (1, ABORTED, "", "has aborted what it got: its code is -4"),
        (1, SUCCEEDED, "", ""),
        (0, ABORTED, "a new goal replaces it", ""),
        (1, ABORTED, "a new goal replaces it", ""),
        (0, ABORTED, "yaw is too far away", "has aborted what it got: yaw is too far away"),
    ],
)
def test_the_latest_goal_says_why_it_was_aborted(server: Server, goal: int, status: int, why: str, told: str) -> None:
    """A controller that replaces a goal may abort it, and that may be heard before its answer about the other one."""
    goals = sent(server, count=2)
    goals.send(b"")
    end(server, goal, status, why, code=-1 if "replaces" in why else -4)
    assert goals.problem == told


def test_a_stop_cancels_goals_that_have_not_ended_at_once_or_once_joints_have_braked(server: Server) -> None:
    goals = sent(server, count=3)
    end(server, 0, ABORTED)
    goals.stop(0.1)
    assert not server.requests["cancel_goal"]
    server.timers[0]()
    assert len(server.requests["cancel_goal"]) == 2
    sent(server).stop(0.0)
    assert len(server.requests["cancel_goal"]) == 3


def test_a_goal_that_is_accepted_after_a_stop_is_canceled(server: Server) -> None:
    goals = sent(server)
    goals.send(b"")
    goals.stop(0.0)
    assert len(server.requests["cancel_goal"]) == 2
    server.requests["send_goal"][-1].give(SimpleNamespace(accepted=True))
    assert len(server.requests["cancel_goal"]) == 3
    end(server, -1, ABORTED, "it was stopped")
    assert goals.problem == ""


def test_a_trajectory_waits_until_the_controller_has_answered_the_one_before(server: Server) -> None:
    """Otherwise, they would pile up at a slow controller, and a stop would come behind them."""
    goals = sent(server)
    for _ in range(3):
        goals.send(b"")
    assert len(server.requests["send_goal"]) == 2
    server.now += OVERDUE
    assert not goals.serves, "it may hang"
    server.requests["send_goal"][-1].give(SimpleNamespace(accepted=True))
    assert len(server.requests["send_goal"]) == 3
    assert goals.serves
    goals.send(b"")
    goals.stop(0.0)
    server.requests["send_goal"][-1].give(SimpleNamespace(accepted=True))
    assert len(server.requests["send_goal"]) == 3


def test_goals_without_results_are_forgotten(server: Server) -> None:
    goals = sent(server, count=MAX_GOALS + 5)
    goals.stop(0.0)
    assert len(server.requests["cancel_goal"]) == MAX_GOALS


@pytest.mark.parametrize(("listeners", "canceled"), [(1, 0.1), (0, 0.0)])
def test_joints_get_goals_and_a_stop_by_their_topic(
    monkeypatch: pytest.MonkeyPatch, listeners: int, canceled: float
) -> None:
    """A stop waits for no action: no server answers here."""
    goals = Mock(serves=True, problem="")
    monkeypatch.setattr(ros_controllers.RosControllers, "_goals_of", lambda self, channel: goals)
    monkeypatch.setattr(topics.Topic, "count_listeners", lambda self: listeners, raising=False)
    robot = Robot(part(HEAD), pitch=0.0, yaw=0.0)
    robot.send(0.0, yaw=1.0, until=0.5)
    assert len(goals.send.mock_calls) == 1
    assert robot.sent == []
    robot.send(0.1, yaw=0.0, until=0.1)
    assert robot.sent == [(TOPIC, [(0, 0), (0.1, 0)])]
    goals.stop.assert_called_once_with(pytest.approx(canceled))
    assert len(goals.send.mock_calls) == 1


def test_a_controller_that_aborts_is_a_fault_that_names_it() -> None:
    controller = Mock(spec=RosController, channel=Mock(joints=(), topic=TOPIC))
    controller._goals = Mock(problem="refuses what it gets: its log says why")
    found = RosController.unfollowed.fget(controller)  # type: ignore[attr-defined]
    assert found.why == "/ada/head_controller refuses what it gets: its log says why"
