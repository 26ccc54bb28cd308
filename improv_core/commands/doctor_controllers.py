"""Checks of `improv doctor` for the joints of real robots: the listeners to their commands, and the nodes that can stop
them."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

from improv_core.commands.finding import Finding, absent, broken, good
from improv_core.outputs.ros.graph import Graph
from improv_core.outputs.ros.joints.channels import MESSAGES, controllers_of, topic_of
from improv_core.outputs.ros.topic import TYPES
from improv_core.robots.config import FILE_NAME, Robots
from improv_core.score.body import Body
from improv_core.score.score import in_namespace

STATES = "sensor_msgs/msg/JointState"


@dataclass(frozen=True, slots=True)
class JointedRobot:
    """A robot with a body, and the namespace of its topics."""

    name: str
    body: Body
    namespace: str

    @property
    def states(self) -> str | None:
        """The topic with the positions of its joints."""
        return in_namespace(self.body.joint_states, self.namespace) if self.body.joint_states else None

    @property
    def topics(self) -> list[str]:
        """All topics about its joints."""
        told = [topic_of(each, self.namespace) for each in controllers_of(self.body)]
        return [*told, *([self.states] if self.states else [])]


def jointed(names: Sequence[str], robots: Robots) -> list[JointedRobot]:
    """Return the robots whose joints move in ROS 2. A body without any ROS 2 names is for the simulator."""
    bodies = {name: robots.profile_of(name).body for name in names}
    return [
        JointedRobot(name, body, robots.namespace_of(name))
        for name, body in bodies.items()
        if body and (body.joint_states or body.controllers)
    ]


def joints(robots: Sequence[JointedRobot], seen: Graph) -> Iterator[Finding]:
    """Report, for each robot, the nodes that publish the positions of its joints and those that move them."""
    for robot in robots:
        yield _states(robot, seen)
        for each in controllers_of(robot.body):
            topic, kind = topic_of(each, robot.namespace), MESSAGES[each.interface]
            yield _listener(robot.name, topic, kind, {end["node"]: end["type"] for end in seen[topic]["listeners"]})
            if each.interface == "velocity":
                what = f"{robot.name}: if this whole machine fails, nothing stops the joints of `{each.name}`"
                advice = "let a trajectory controller move them, which comes to rest by itself; see docs/ros.md"
                yield absent(what, advice)


def _states(robot: JointedRobot, seen: Graph) -> Finding:
    if not robot.states:
        what = f"{robot.name}: it isn't known where its joints are, so trajectories and positions move none"
        return broken(what, f"set `joint_states` of its profile in {FILE_NAME}")
    nodes = sorted({end["node"] for end in seen[robot.states]["publishers"] if end["type"] == STATES})
    if nodes:
        return good(f"{robot.name}: {' and '.join(nodes)} says on {robot.states} where its joints are")
    what = f"{robot.name}: nobody publishes {STATES} on {robot.states}"
    return absent(what, "start its joint_state_broadcaster; until then no joint moves")


def _listener(robot: str, topic: str, kind: str, nodes: Mapping[str, str]) -> Finding:
    if not nodes:
        return absent(f"{robot}: nothing is listening on {topic}", "start its controller")
    named = " and ".join(f"{node} listens for {found.rpartition('/')[2]}" for node, found in nodes.items())
    if TYPES[kind] in nodes.values():
        return good(f"{robot}: {named} on {topic}")
    advice = f"set another `interface` or `topic` of the controller in {FILE_NAME}"
    return broken(f"{robot}: {named} on {topic}, not {kind}", advice)
