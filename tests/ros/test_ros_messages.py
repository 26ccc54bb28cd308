"""What is sent to whom: the types that listeners want, the limits of robots, and others who send there."""

from __future__ import annotations

import json

from tests.ros.conftest import Listen, Sink

TOPIC = "/turtle1/cmd_vel"
TURTLE = {"turtle1": TOPIC}
TWIST, STAMPED = "geometry_msgs/msg/Twist", "geometry_msgs/msg/TwistStamped"


def test_listeners_of_both_types_are_both_served(sink: Sink, listen: Listen) -> None:
    plain, stamped = listen(TOPIC), listen(TOPIC, "--stamped")
    sink("prepare", TURTLE)
    sink("until_offered", TOPIC, TWIST, STAMPED)
    assert sink("warnings") == {}, "its second node is no other"
    sink("send", "turtle1", 1, 0, 0, 0.5)
    for listener in (plain, stamped):
        message = listener.wait(lambda message: bool(message["x"]))
        assert (message["x"], message["yaw"]) == (1, 0.5)


def test_who_comes_late_is_served_while_robots_move(sink: Sink, listen: Listen) -> None:
    """One listener plays on while one of the other type comes; test_ros_faults.py has them the other way round."""
    early = listen(TOPIC, "--stamped")
    sink("prepare", TURTLE)
    sink("wait")
    late = listen(TOPIC)
    sink("until_missing")  # the look that finds it
    sink("wait")
    sink("send", "turtle1", 1, 0, 0, 0)
    assert early.wait(lambda message: True)["x"] == 1
    assert late.wait(lambda message: True)["x"] == 1


def test_a_type_that_nobody_wants_is_no_longer_offered(sink: Sink, listen: Listen) -> None:
    """Else `ros2 topic echo` would refuse the topic, as one of two types."""
    early, _ = listen(TOPIC), listen(TOPIC, "--stamped")
    sink("prepare", TURTLE)
    sink("until_offered", TOPIC, TWIST, STAMPED)
    early.close()
    sink("until_offered", TOPIC, STAMPED)


def test_a_fixed_type_is_obeyed(sink: Sink, listen: Listen) -> None:
    plain, stamped = listen(TOPIC), listen(TOPIC, "--stamped")
    sink("prepare", TURTLE, profile={"message": "TwistStamped"})
    sink("wait")
    sink("send", "turtle1", 1, 0, 0, 0)
    assert stamped.wait(lambda message: True)["x"] == 1
    sink("prepare", TURTLE, profile={"message": "Twist"})
    sink("wait")
    sink("send", "turtle1", 2, 0, 0, 0)
    assert plain.wait(lambda message: True)["x"] == 2, "the first it hears"
    sink("prepare", TURTLE)
    sink("until_offered", TOPIC, TWIST, STAMPED)
    sink("send", "turtle1", 3, 0, 0, 0)
    assert plain.wait(lambda message: True)["x"] == 3
    assert stamped.wait(lambda message: True)["x"] == 3, "it has not heard 2"


def test_a_publisher_stays_until_its_last_zero_has_arrived(sink: Sink, listen: Listen) -> None:
    plain = listen(TOPIC)
    sink("prepare", TURTLE, profile={"message": "Twist"})
    sink("wait")
    sink("send", "turtle1", 1, 0, 0, 0)
    sink("send", "turtle1", 0, 0, 0, 0)
    sink("prepare", TURTLE, profile={"message": "TwistStamped"})
    assert TWIST in sink("offered", TOPIC)
    assert plain.wait(lambda message: not message["x"])
    listen(TOPIC, "--stamped")
    sink("until_offered", TOPIC, STAMPED)


def test_a_fixed_type_that_nobody_wants_is_said(sink: Sink, listen: Listen) -> None:
    listen(TOPIC)
    sink("prepare", TURTLE, profile={"message": "TwistStamped"})
    line = sink("find", "missing", "turtle1", "expects")
    assert line.startswith(
        f"the listener on {TOPIC} expects {TWIST}, but `message` in improv.toml is TwistStamped: change it (ROS 2,"
    )


def test_a_type_that_nobody_can_send_is_said(sink: Sink, listen: Listen) -> None:
    listen(TOPIC, "--string")
    sink("prepare", TURTLE)
    line = sink("find", "missing", "turtle1", "expects")
    assert line.startswith(
        f"the listener on {TOPIC} expects std_msgs/msg/String, but Improv can only send {TWIST} or {STAMPED} ("
    )


def test_a_quality_of_service_that_we_lack_is_said(sink: Sink, listen: Listen) -> None:
    listen(TOPIC, "--transient")
    sink("prepare", TURTLE)
    line = sink("find", "missing", "turtle1", "transient")
    assert line.startswith(
        f"the listener on {TOPIC} requires transient local, which Improv can't offer: make it volatile (ROS 2,"
    )


def test_a_best_effort_listener_is_served_without_a_word(sink: Sink, listen: Listen) -> None:
    listener = listen(TOPIC, "--best-effort")
    sink("prepare", TURTLE)
    sink("wait")
    sink("send", "turtle1", 1, 0, 0, 0)
    listener.wait(lambda message: message["x"] == 1)
    assert (sink("missing"), sink("warnings")) == ({}, {})


def test_limits_scale_all_of_a_twist(sink: Sink, listen: Listen) -> None:
    listener = listen(TOPIC)
    sink("prepare", TURTLE, profile={"max_linear": 0.2, "max_angular": 1.0})
    sink("wait")
    for twist in [(0.2, 0, 0, 1.0), (0.4, 0, 0, 1.0), (0.1, 0, 0, 4.0)]:
        sink("send", "turtle1", *twist)
    sink("send", "turtle1", 0, 0, 0, 0)
    listener.wait(lambda message: not any((message["x"], message["yaw"])))
    told = [(message["x"], message["yaw"]) for message in listener.heard]
    assert told == [(0.2, 1.0), (0.2, 0.5), (0.025, 1.0), (0, 0)]


def test_what_is_no_number_is_never_sent(sink: Sink, listen: Listen) -> None:
    listener = listen(TOPIC)
    sink("prepare", TURTLE, profile={"max_linear": 0.2})
    sink("wait")
    for speed in ("NaN", "Infinity", "-Infinity"):
        assert sink("refuse", "turtle1", json.loads(speed)) == "turtle1 was given a speed that is not a finite number"
    sink("send", "turtle1", 0.1, 0, 0, 0)
    assert listener.wait(lambda message: True)["x"] == 0.1


def test_others_who_send_to_a_robot_are_named(sink: Sink, listen: Listen) -> None:
    listen(TOPIC)
    sink("prepare", TURTLE)
    sink("wait")
    assert sink("warnings") == {}
    teleop = listen("--publish", TOPIC, "--name", "teleop")
    assert sink("find", "warnings", "turtle1", "teleop") == (
        f"other nodes also publish to {TOPIC}: /teleop; robots obey all of them: stop the others or use twist_mux"
    )
    teleop.close()
    sink("until_no_warnings")
