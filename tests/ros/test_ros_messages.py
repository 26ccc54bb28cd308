"""Messages to robots: the types that listeners want, the limits of robots, and other nodes that send there."""

from __future__ import annotations

import json
from typing import Any

import pytest

from tests.ros.conftest import STAMPED, Listen, Publish, Sink
from tests.ros.dance import moving

pytestmark = pytest.mark.slow("processes of ROS find each other")

TOPIC = "/turtle1/cmd_vel"
TURTLE = {"turtle1": TOPIC}
PLAIN, TIMED = "geometry_msgs/msg/Twist", "geometry_msgs/msg/TwistStamped"


def test_listeners_of_both_types_are_both_served(sink: Sink, listen: Listen) -> None:
    plain, stamped = listen(TOPIC), listen(TOPIC, type=STAMPED)
    sink("prepare", TURTLE)
    sink("until_offered", TOPIC, PLAIN, TIMED)
    assert sink("warnings") == {}, "its second node is no other"
    sink("send", "turtle1", 1, 0, 0, 0.5)
    for listener in (plain, stamped):
        message = listener.wait(lambda message: bool(message["x"]))
        assert (message["x"], message["yaw"]) == (1, 0.5)


def test_a_late_listener_is_served_while_robots_move(sink: Sink, listen: Listen) -> None:
    """A listener misses no message while one of the other type comes."""
    early = listen(TOPIC, type=STAMPED)
    sink("prepare", TURTLE)
    sink("wait")
    late = listen(TOPIC)
    sink("until_missing")  # the look that finds it
    sink("wait")
    sink("send", "turtle1", 1, 0, 0, 0)
    assert early.wait(moving)["x"] == 1
    assert late.wait(moving)["x"] == 1


def test_an_unwanted_type_is_no_longer_offered(sink: Sink, listen: Listen) -> None:
    """Otherwise `ros2 topic echo` would refuse the topic, because it would have two types."""
    early, _ = listen(TOPIC), listen(TOPIC, type=STAMPED)
    sink("prepare", TURTLE)
    sink("until_offered", TOPIC, PLAIN, TIMED)
    early.close()
    sink("until_offered", TOPIC, TIMED)


def test_a_fixed_type_is_obeyed(sink: Sink, listen: Listen) -> None:
    plain, stamped = listen(TOPIC), listen(TOPIC, type=STAMPED)
    sink("prepare", TURTLE, profile={"message": "TwistStamped"})
    sink("wait")
    sink("send", "turtle1", 1, 0, 0, 0)
    assert stamped.wait(moving)["x"] == 1
    sink("prepare", TURTLE, profile={"message": "Twist"})
    sink("wait")
    sink("send", "turtle1", 2, 0, 0, 0)
    assert plain.wait(moving)["x"] == 2, "the first it hears"
    sink("prepare", TURTLE)
    sink("until_offered", TOPIC, PLAIN, TIMED)
    sink("send", "turtle1", 3, 0, 0, 0)
    assert plain.wait(moving)["x"] == 3
    assert stamped.wait(moving)["x"] == 3, "it has not heard 2"


def test_a_publisher_stays_until_its_last_zero_has_arrived(sink: Sink, listen: Listen) -> None:
    plain = listen(TOPIC)
    sink("prepare", TURTLE, profile={"message": "Twist"})
    sink("wait")
    sink("send", "turtle1", 1, 0, 0, 0)
    sink("send", "turtle1", 0, 0, 0, 0)
    sink("prepare", TURTLE, profile={"message": "TwistStamped"})
    assert PLAIN in sink("offered", TOPIC)
    assert plain.wait(lambda message: not message["x"])
    listen(TOPIC, type=STAMPED)
    sink("until_offered", TOPIC, TIMED)


@pytest.mark.parametrize(
    ("listener", "profile", "line"),
    [
        ({}, {"message": "TwistStamped"}, f"expects {PLAIN}, but `message` in improv.toml is TwistStamped: change it"),
        ({"type": "std_msgs/String"}, {}, f"expects std_msgs/msg/String, but Improv can only send {PLAIN} or {TIMED}"),
        ({"latched": True}, {}, "requires transient local, which Improv can't offer: make it volatile"),
    ],
)
def test_a_listener_that_can_not_be_served_is_reported(
    listener: dict[str, Any], profile: dict[str, str], line: str, sink: Sink, listen: Listen
) -> None:
    listen(TOPIC, **listener)
    sink("prepare", TURTLE, profile=profile)
    found = sink("find", "missing", "turtle1", f"the listener on {TOPIC}")
    assert found.startswith(f"the listener on {TOPIC} {line} (ROS 2,")


def test_a_value_that_is_not_a_number_is_never_sent(sink: Sink, listen: Listen) -> None:
    listener = listen(TOPIC)
    sink("prepare", TURTLE, profile={"max_linear": 0.2})
    sink("wait")
    for speed in ("NaN", "Infinity", "-Infinity"):
        assert sink("refuse", "turtle1", json.loads(speed)) == "turtle1 was given a speed that is not a finite number"
    sink("send", "turtle1", 0.1, 0, 0, 0)
    assert listener.wait(moving)["x"] == 0.1


def test_other_nodes_that_send_to_a_robot_are_named(sink: Sink, listen: Listen, publish: Publish) -> None:
    listen(TOPIC)
    sink("prepare", TURTLE)
    sink("wait")
    assert sink("warnings") == {}
    teleop = publish(TOPIC, "geometry_msgs/Twist", name="teleop")
    assert sink("find", "warnings", "turtle1", "teleop") == (
        f"other nodes also publish to {TOPIC}: /teleop; robots obey all of them: stop the others or use twist_mux"
    )
    assert sink("other_publishers") == {"turtle1": ["/teleop"]}
    teleop.close()
    sink("until_no_warnings")
    assert sink("other_publishers") == {}
