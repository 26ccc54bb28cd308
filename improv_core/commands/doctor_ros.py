"""Checks of `improv doctor` for ROS 2: the Python that runs it, the machines it reaches, and the listeners."""

from __future__ import annotations

import json
import os
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path

from improv_core.commands.doctor_controllers import JointedRobot, joints
from improv_core.commands.finding import BROKEN, Finding, absent, broken, good
from improv_core.ipc.child import output
from improv_core.outputs.ros.discovery import RANGE, REACH, SERVER, advice, described, limited, reached, server
from improv_core.outputs.ros.graph import UNNAMED, VELOCITIES, Endpoint, Graph
from improv_core.outputs.ros.nodes import STANDBY
from improv_core.outputs.ros.setup.environment import AGAIN, DOWNLOAD, unsuited
from improv_core.outputs.ros.setup.interpreter import (
    SETUP,
    Interpreter,
    InterpreterError,
    find_ros_python,
    private_environment,
)
from improv_core.protocol.limits import FOLDER
from improv_core.robots.config import FILE_NAME, Robot
from improv_core.safety.preflight import Standing, misplaced
from improv_core.safety.preflight import advice as advice_to_move
from improv_core.score.motion import Pose
from improv_core.score.score import Safety

LOOK_LIMIT = 30.0
"""Seconds that reading ROS 2's graph may take on a busy machine."""

AHEAD, BEHIND = 0.02, 0.5
"""Seconds by which the stamps of poses may be ahead of our clock, and the greatest age of a pose by its stamp."""


AFTER_MOVING = "geometry_msgs/msg/PoseWithCovarianceStamped"
"""The type of poses from localization, such as AMCL: it sends one only after a robot has moved."""
CHECK_POSES = "check its network and the node that publishes them"


def examine_ros(
    robots: Mapping[str, Robot], safety: Safety, bodies: Sequence[JointedRobot], places: Mapping[str, Pose]
) -> Iterator[Finding]:
    """Check ROS 2, the listeners of these robots, their bodies, the nodes that can stop them, and their state.

    `places` are the poses at which they begin.
    """
    found: Interpreter | InterpreterError | None
    try:
        found = find_ros_python(None)
    except InterpreterError as error:
        found = error
    yield ros(found, private_environment(), os.environ)
    if isinstance(found, Interpreter):
        yield (reaching := reach(found.env))
        if reaching.mark != BROKEN:
            measured = [topic for robot in robots.values() for topic in (robot.odom, robot.battery) if topic]
            watched = [*(topic for topic, *_ in _guards(safety)), *measured]
            watched += [topic for robot in bodies for topic in robot.topics]
            seen = _look(found, limited(found.env), [*watched, *(robot.topic for robot in robots.values())])
            if isinstance(seen, Finding):
                yield seen
            else:
                yield standby(found)
                yield from guards(safety, seen)
                yield from listeners(robots, {topic: ends for topic, ends in seen.items() if topic not in watched})
                yield from joints(bodies, seen)
                yield from clocks(robots, seen)
                yield from poses(robots, safety, places, seen)
                yield from batteries(robots, seen)
                yield from stops(robots)


def ros(found: Interpreter | InterpreterError | None, private: Path, env: Mapping[str, str]) -> Finding:
    """Report the Python that runs ROS 2, if any can; `private` is the environment that `improv ros setup` makes."""
    if isinstance(found, Interpreter):
        release = f" {found.env['ROS_DISTRO']}" if found.env.get("ROS_DISTRO") else ""
        return good(f"ROS 2{release} from {found.origin}: {found.python}")
    if found:
        return broken(str(found))
    if private.exists():
        return broken(f"the ROS 2 in {private} does not work", AGAIN)
    if "AMENT_PREFIX_PATH" in env:
        what = "ROS 2 is sourced, but no Python can import rclpy"
        return broken(what, "run `sudo apt install ros-$ROS_DISTRO-rclpy`")
    install = unsuited() or f"{SETUP} installs it ({DOWNLOAD} MB to download)"
    return absent("no ROS 2, so only the simulator can play", install)


def reach(env: Mapping[str, str]) -> Finding:
    """Report which robots a stage started in this environment reaches, and how to change that."""
    stage, domain = limited(env), env.get("ROS_DOMAIN_ID") or "0"
    if not domain.isdecimal() or int(domain) > MAX_DOMAIN:
        return broken(f"ROS_DOMAIN_ID is {domain}", "set it to a number from 0 to 101")
    if stage[RANGE] not in REACH:
        return broken(f"{RANGE} is {stage[RANGE]}", f"set it to {', '.join(REACH)}, or unset it")
    what, reaches = described(stage), reached(stage)
    if server(stage):
        return good(what, f"unset {SERVER} to find robots without it")
    if reaches == "LOCALHOST":
        return good(what, f"set {advice(env, 'SUBNET')} to reach robots on the network")
    if reaches == "OFF":
        return absent(what, f"unset {RANGE} to find robots on this machine")
    return good(what, f"set {advice(env, 'LOCALHOST')} after sourcing ROS to stay on this machine")


def standby(found: Interpreter) -> Finding:
    """Report whether a standby process can start: its input is empty, so it ends as soon as it could watch a stage."""
    command = [found.python, str(FOLDER), "outputs.ros.standby.process", f"{OURS.lstrip('/')}_doctor{STANDBY}"]
    what = "the standby, which stops robots if the process that moves them dies"
    try:
        output(command, LOOK_LIMIT, limited(found.env))
    except OSError as error:
        return broken(f"{what}, does not start ({error})", _repair(found))
    return good(what)


def _guards(safety: Safety) -> Iterator[tuple[str, str, str, str]]:
    """Yield the topic of each node that can stop robots, its name, its type, and what follows without it."""
    if safety.stop:
        yield safety.stop, "emergency stop", "std_msgs/msg/Bool", "until then it stops nothing"
    if deadman := safety.deadman:
        yield deadman.topic, f"deadman {deadman}", "sensor_msgs/msg/Joy", "until then no robot moves"


def guards(safety: Safety, seen: Graph) -> Iterator[Finding]:
    """Report the publishers of the emergency stop and the deadman button, if `improv.toml` names them."""
    for topic, name, kind, so in _guards(safety):
        publishers = sorted({end["node"] for end in seen[topic]["publishers"] if end["type"] == kind})
        if publishers:
            yield good(f"{name}: {' and '.join(publishers)} on {topic}")
        else:
            yield absent(f"{name}: nobody publishes {kind} on {topic}", f"start its node; {so}")


MAX_DOMAIN = 232
"""The last domain of Fast DDS and Cyclone DDS: beyond it, they run out of ports."""


def listeners(robots: Mapping[str, Robot], seen: Graph) -> Iterator[Finding]:
    """Report, for each robot, the listeners to its velocities and other publishers there; without robots, all
    listeners."""
    hearing = {topic: ends["listeners"] for topic, ends in seen.items() if ends["listeners"]}
    spare = sorted(hearing.keys() - {robot.topic for robot in robots.values()})
    for name, robot in robots.items():
        yield _listener(name, robot, hearing.get(robot.topic, ()), spare)
        yield from _quality(name, robot, hearing.get(robot.topic, ()))
        publishers = {end["node"] for end in seen[robot.topic]["publishers"]}
        if len(own := {node for node in publishers if node.startswith(OURS) and not node.endswith(STANDBY)}) > 1:
            what = f"{name}: {len(own)} Improv processes publish on {robot.topic}: {', '.join(sorted(own))}"
            yield absent(what, "let only one of them play, or the robot obeys all")
        others = {node for node in publishers if not node.startswith(OURS)}
        for node in sorted(others):
            what = f"{name}: {node} also publishes on {robot.topic}"
            yield absent(what, "stop it while Improv plays, or the robot obeys both and stutters")
    if not robots:
        for topic, ends in hearing.items():
            yield good(f"{_nodes(ends)} on {topic}")
        if not hearing:
            yield absent("no robot listens", "start one in this domain")


def clocks(robots: Mapping[str, Robot], seen: Graph) -> Iterator[Finding]:
    """Compare the clocks that stamp robots' poses with ours."""
    for name, robot in robots.items():
        if not robot.odom:
            continue
        age, publishers = seen[robot.odom]["age"], seen[robot.odom]["publishers"]
        localized = any(end["type"] == AFTER_MOVING for end in publishers)
        if age is None and publishers:
            nodes = " and ".join(f"{end['node']} publishes {end['type'].rpartition('/')[2]}" for end in publishers)
            first = "give the robot its first pose, such as with 2D Pose Estimate in rviz" if localized else CHECK_POSES
            yield absent(f"{name}: {nodes} on {robot.odom}, but no pose came", first)
        elif age is None:
            yield absent(f"{name}: no poses on {robot.odom}", "start the node that publishes them")
        elif age > BEHIND and localized:
            yield good(f"{name}: the latest pose on {robot.odom} is {age:.0f} s old; the next one follows a movement")
        elif age < -AHEAD:
            what = f"{name}: the clock that stamps {robot.odom} is at least {-age:.2f} s ahead of this machine's"
            yield broken(what, "synchronize both, such as with chrony")
        elif age > BEHIND:
            what = f"{name}: poses on {robot.odom} are {age:.2f} s old by their stamps"
            yield broken(what, "synchronize the clocks, such as with chrony, or find what delays them")
        else:
            yield good(f"{name}: poses on {robot.odom}, {max(age, 0.0):.2f} s old by their stamps")


def poses(robots: Mapping[str, Robot], safety: Safety, places: Mapping[str, Pose], seen: Graph) -> Iterator[Finding]:
    """Report robots whose poses are lost for a while, and those that stand away from their start poses."""
    for name, robot in robots.items():
        if not robot.odom:
            continue
        found = seen[robot.odom]
        if found["gap"] > LONGEST_GAP:
            what = f"{name}: for {found['gap']:.1f} s, no pose came on {robot.odom}"
            yield broken(what, CHECK_POSES)
        if robot.odom_frame != "world" or name not in places or not found["pose"]:
            continue
        standing = Standing(places[name], Pose(**found["pose"]))
        if misplaced({name: standing}, safety.preflight):
            yield absent(f"{name} is not in its place", advice_to_move(name, standing))


def batteries(robots: Mapping[str, Robot], seen: Graph) -> Iterator[Finding]:
    """Report robots whose batteries are nearly empty."""
    for name, robot in robots.items():
        share = seen[robot.battery]["battery"] if robot.battery else None
        if share is not None and share < LOW:
            yield absent(f"{name}: its battery is at {share:.0%}", "charge it")


def stops(robots: Mapping[str, Robot]) -> Iterator[Finding]:
    """Report when bases stop by themselves, as far as their profiles say."""
    for name, robot in robots.items():
        after, backward = robot.profile.stops_after, robot.profile.backward_limit
        if after == 0:
            what = f"{name}: never stops by itself, so it keeps moving if this whole machine or its network fails"
            yield absent(what, "stay where you can switch it off")
        elif after:
            yield good(f"{name}: stops by itself {after:g} s after its last command")
        if backward is not None:
            what = f"{name}: stops by itself once it has driven {backward:g} m backward"
            yield absent(what, "turn it around, or lift that limit and set `backward_limit` of its profile")


LONGEST_GAP = 0.5
"""Seconds without a pose that need no report."""
LOW = 0.2
"""Share of a battery below which it needs a charge, as on the page."""
OURS = "/improv"
"""Beginning of the names of our stages' nodes."""


def _look(found: Interpreter, env: Mapping[str, str], topics: Sequence[str]) -> Graph | Finding:
    command = [found.python, str(FOLDER), "outputs.ros.graph", "look", *topics]
    try:
        graph: Graph = json.loads(output(command, LOOK_LIMIT, env))
    except OSError as error:
        return broken(f"ROS 2 does not start ({error})", _repair(found))
    return graph


def _repair(found: Interpreter) -> str:
    return AGAIN if found.origin == SETUP else f"make sure `{found.python} -c 'import rclpy; rclpy.init()'` works"


# A discovery server shows that it listens. It can't be asked for its name: it announced 127.0.0.1, since Fast DDS looks
# for addresses once (Fast-DDS#664). In 12 runs, 7 unnamed listeners heard nothing, and 5 with names heard us.
_STARTED_EARLY = (
    "look again, and if it stays unnamed, restart it, because it started before its network was up and hears nothing"
)


def _listener(name: str, robot: Robot, ends: Sequence[Endpoint], spare: Sequence[str]) -> Finding:
    if not ends:
        advice = (
            f'set `topic = "{spare[0]}"` for it in {FILE_NAME}, where a robot listens' if spare else "start the robot"
        )
        return absent(f"{name}: nothing is listening on {robot.topic}", advice)
    types = {end["type"] for end in ends}
    if not types & set(VELOCITIES):
        what = f"{name}: {_nodes(ends)} on {robot.topic}, which is neither Twist nor TwistStamped"
        return broken(what, f"set another `topic` for it in {FILE_NAME}")
    if robot.message != "auto" and f"geometry_msgs/msg/{robot.message}" not in types:
        advice = f'set `message = "auto"` for it in {FILE_NAME}'
        return broken(f"{name}: {_nodes(ends)} on {robot.topic}, not {robot.message}", advice)
    if any(end["node"] == UNNAMED for end in ends):
        return absent(f"{name}: {_nodes(ends)} on {robot.topic}", _STARTED_EARLY)
    return good(f"{name}: {_nodes(ends)} on {robot.topic}")


def _quality(name: str, robot: Robot, ends: Sequence[Endpoint]) -> Iterator[Finding]:
    """Report listeners whose quality of service keeps them from getting messages, or from confirming them."""
    for end in ends:
        if end["type"] not in VELOCITIES:
            continue
        if end["latched"]:
            what = f"{name}: {end['node']} requires transient local on {robot.topic}, which Improv can't offer"
            yield broken(what, "make it volatile")
        elif not end["reliable"]:
            what = f"{name}: {end['node']} is best effort on {robot.topic}, so it can't confirm that it hears"
            yield absent(what, "make it reliable, or its first movement may be cut short")


def _nodes(ends: Sequence[Endpoint]) -> str:
    return " and ".join(f"{end['node']} listens for {end['type'].rpartition('/')[2]}" for end in ends)
