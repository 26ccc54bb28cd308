"""`improv doctor`: each of its checks, and the whole command without ROS 2."""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from pathlib import Path

import pytest

from improv_core.commands import doctor, doctor_controllers, doctor_editors, doctor_ros
from improv_core.commands.finding import Finding
from improv_core.outputs.ros.graph import UNNAMED, Endpoint, Endpoints
from improv_core.outputs.ros.setup import environment
from improv_core.outputs.ros.setup.interpreter import Interpreter, InterpreterError
from improv_core.protocol.fields import to_pose_json
from improv_core.robots.config import Robot, read_robots
from improv_core.safety.allowed import approve
from improv_core.score.motion import Pose
from improv_core.score.score import Deadman, Safety
from tests.commands.command_line import Ended, program, run

TWIST, STAMPED, POSE = (f"geometry_msgs/msg/{name}" for name in ("Twist", "TwistStamped", "Pose"))
HEARS = "✓ r: /sim listens for Twist on /r/cmd_vel"
CAST = read_robots('[robots.r]\nprofile = "turtlesim"\n[robots.s]\nmessage = "Twist"\n').robots


def told(*findings: Finding) -> list[str]:
    return [str(finding) for finding in findings]


def end(node: str, kind: str, quality: str = "reliable") -> Endpoint:
    return {"node": node, "type": kind, "reliable": quality != "best effort", "latched": quality == "latched"}


def ends(
    listeners: Sequence[tuple[str, ...]],
    *publishers: tuple[str, ...],
    age: float | None = None,
    gap: float = 0.0,
    pose: Pose | None = None,
    battery: float | None = None,
) -> Endpoints:
    return {
        "listeners": [end(*each) for each in listeners],
        "publishers": [end(*each) for each in publishers],
        "age": age,
        "gap": gap,
        "pose": to_pose_json(pose) if pose else None,
        "battery": battery,
    }


def test_listeners_to_a_robots_topic_are_reported() -> None:
    def check(robot: str, seen: Endpoints, *expected: str) -> None:
        topic = CAST[robot].topic
        assert told(*doctor_ros.listeners({robot: CAST[robot]}, {topic: seen})) == [*expected]

    check("r", ends([("/sim", TWIST)]), HEARS)
    check("r", ends([("/base", STAMPED)]), "✓ r: /base listens for TwistStamped on /r/cmd_vel")
    check("r", ends([]), "– r: nothing is listening on /r/cmd_vel: start the robot")
    unnamed = "– r: an unnamed node listens for Twist on /r/cmd_vel: look again, and if it stays unnamed, restart it, "
    check("r", ends([(UNNAMED, TWIST)]), f"{unnamed}because it started before its network was up and hears nothing")
    odd = "✗ r: /odd listens for Pose on /r/cmd_vel, which is neither Twist nor TwistStamped: "
    check("r", ends([("/odd", POSE)]), f"{odd}set another `topic` for it in improv.toml")
    other = "✗ s: /base listens for TwistStamped on /s/cmd_vel, not Twist: "
    check("s", ends([("/base", STAMPED)]), f'{other}set `message = "auto"` for it in improv.toml')
    silent = "– r: /sim is best effort on /r/cmd_vel, so it can't confirm that it hears: "
    check(
        "r",
        ends([("/sim", TWIST, "best effort")]),
        HEARS,
        f"{silent}make it reliable, or its first movement may be cut short",
    )
    latched = "✗ r: /sim requires transient local on /r/cmd_vel, which Improv can't offer: make it volatile"
    check("r", ends([("/sim", TWIST, "latched")]), HEARS, latched)


def test_other_publishers_on_a_robots_topic_are_reported() -> None:
    def check(*publishers: str, expected: Sequence[str] = ()) -> None:
        seen = {CAST["r"].topic: ends([("/sim", TWIST)], *((name, TWIST) for name in publishers))}
        assert told(*doctor_ros.listeners({"r": CAST["r"]}, seen)) == [HEARS, *expected]

    check("/improv_desk_17", "/improv_desk_17_standby")
    two = "– r: 2 Improv processes publish on /r/cmd_vel: /improv_desk_17, /improv_lap_9: "
    check("/improv_desk_17", "/improv_lap_9", expected=[f"{two}let only one of them play, or the robot obeys all"])
    also = "– r: /teleop also publishes on /r/cmd_vel: stop it while Improv plays, or the robot obeys both and stutters"
    check("/teleop", "/improv_desk_17", expected=[also])


def test_a_topic_that_nobody_asked_for_is_offered() -> None:
    seen = {"/cmd_vel": ends([("/base", TWIST)]), "/r/cmd_vel": ends([])}
    assert told(*doctor_ros.listeners({"r": CAST["r"]}, seen)) == [
        '– r: nothing is listening on /r/cmd_vel: set `topic = "/cmd_vel"` for it in improv.toml, where a robot listens'
    ]


def test_without_robots_all_listeners_are_reported() -> None:
    none: Mapping[str, Robot] = {}
    seen = {"/cmd_vel": ends([("/base", TWIST)]), "/quiet": ends([])}
    assert told(*doctor_ros.listeners(none, seen)) == ["✓ /base listens for Twist on /cmd_vel"]
    assert told(*doctor_ros.listeners(none, {})) == ["– no robot listens: start one in this domain"]


@pytest.mark.parametrize(
    ("age", "expected"),
    [
        (None, "– r: no poses on /r/odom: start the node that publishes them"),
        (0.08, "✓ r: poses on /r/odom, 0.08 s old by their stamps"),
        (-0.01, "✓ r: poses on /r/odom, 0.00 s old by their stamps"),
        (
            -2.0,
            "✗ r: the clock that stamps /r/odom is at least 2.00 s ahead of this machine's: "
            "synchronize both, such as with chrony",
        ),
        (
            3.0,
            "✗ r: poses on /r/odom are 3.00 s old by their stamps: "
            "synchronize the clocks, such as with chrony, or find what delays them",
        ),
    ],
)
def test_clocks_that_stamp_poses_are_compared_with_ours(age: float | None, expected: str) -> None:
    measured = read_robots('[robots.r]\nodom = "/r/odom"\n').robots
    assert told(*doctor_ros.clocks(measured, {"/r/odom": ends([], age=age)})) == [expected]
    assert told(*doctor_ros.clocks(CAST, {})) == []


@pytest.mark.parametrize(
    ("kind", "age", "expected"),
    [
        (
            doctor_ros.AFTER_MOVING,
            None,
            "– r: /node publishes PoseWithCovarianceStamped on /r/odom, but no pose came: "
            "give the robot its first pose, such as with 2D Pose Estimate in rviz",
        ),
        (
            doctor_ros.AFTER_MOVING,
            90.2,
            "✓ r: the latest pose on /r/odom is 90 s old; the next one follows a movement",
        ),
        (
            "nav_msgs/msg/Odometry",
            None,
            "– r: /node publishes Odometry on /r/odom, but no pose came: "
            "check its network and the node that publishes them",
        ),
    ],
)
def test_nodes_without_recent_poses_are_named(kind: str, age: float | None, expected: str) -> None:
    measured = read_robots('[robots.r]\nodom = "/r/odom"\n').robots
    assert told(*doctor_ros.clocks(measured, {"/r/odom": ends([], ("/node", kind), age=age)})) == [expected]


def test_what_bases_do_by_themselves_is_reported() -> None:
    toml = "".join(f'[robots.{name}]\nprofile = "{name}"\n' for name in ("turtlebot3_burger", "create3"))
    assert told(*doctor_ros.stops(read_robots(f"{toml}[robots.ada]\n").robots)) == [
        "– turtlebot3_burger: never stops by itself, so it keeps moving if this whole machine or its network fails: "
        "stay where you can switch it off",
        "✓ create3: stops by itself 0.5 s after its last command",
        "– create3: stops by itself once it has driven 0.15 m backward: "
        "turn it around, or lift that limit and set `backward_limit` of its profile",
    ]


NAO = """
[profiles.nao]
step = 1
{states}
[profiles.nao.body.head]
left = {{ joint = "yaw", degrees = 30 }}
up = {{ joint = "pitch", degrees = 30 }}
[profiles.nao.controllers.head]
joints = ["yaw", "pitch"]
interface = "{interface}"
[robots.ada]
profile = "nao"
[robots.doll]
profile = "puppet"
"""
TRAJECTORY, HEAD = "trajectory_msgs/msg/JointTrajectory", "/ada/head_controller"


@pytest.mark.parametrize(
    ("interface", "listeners", "expected"),
    [
        ("trajectory", [("/nao", TRAJECTORY)], [f"✓ ada: /nao listens for JointTrajectory on {HEAD}/joint_trajectory"]),
        ("position", [], [f"– ada: nothing is listening on {HEAD}/commands: start its controller"]),
        (
            "velocity",
            [("/nao", TRAJECTORY)],
            [
                f"✗ ada: /nao listens for JointTrajectory on {HEAD}/commands, not Float64MultiArray: "
                "set another `interface` or `topic` of the controller in improv.toml",
                "– ada: if this whole machine fails, nothing stops the joints of `head`: "
                "let a trajectory controller move them, which comes to rest by itself; see docs/ros.md",
            ],
        ),
    ],
)
def test_nodes_that_move_joints_are_reported(
    interface: str, listeners: list[tuple[str, str]], expected: list[str]
) -> None:
    """The puppet is for the simulator."""
    robots = read_robots(NAO.format(interface=interface, states='joint_states = "joint_states"'))
    (ada,) = doctor_controllers.jointed(["ada", "doll"], robots)
    commands, states = ada.topics
    for publisher, known in (
        (("/broadcaster", doctor_controllers.STATES), f"✓ ada: /broadcaster says on {states} where its joints are"),
        (
            ("/odd", POSE),
            f"– ada: nobody publishes sensor_msgs/msg/JointState on {states}: "
            "start its joint_state_broadcaster; until then no joint moves",
        ),
    ):
        seen = {commands: ends(listeners), states: ends([], publisher)}
        assert told(*doctor_controllers.joints([ada], seen)) == [known, *expected]


def test_a_missing_joint_state_topic_is_reported() -> None:
    robots = read_robots(NAO.format(interface="trajectory", states=""))
    (ada,) = doctor_controllers.jointed(["ada"], robots)
    (topic,) = ada.topics
    assert told(*doctor_controllers.joints([ada], {topic: ends([("/nao", TRAJECTORY)])})) == [
        "✗ ada: it isn't known where its joints are, so trajectories and positions move none: "
        "set `joint_states` of its profile in improv.toml",
        f"✓ ada: /nao listens for JointTrajectory on {topic}",
    ]


SEEN = read_robots('[robots.r]\nodom = "odom"\nodom_frame = "world"\n[robots.s]\nodom = "odom"\n').robots
THERE = ends([], pose=Pose(1.0))


@pytest.mark.parametrize(
    ("r", "s", "expected"),
    [
        (THERE, THERE, []),
        (ends([], pose=Pose(1.05, heading=0.1)), THERE, []),
        (ends([], pose=Pose(1.36)), ends([], pose=Pose(1.36)), ["– r is not in its place: move r 0.36 m toward 180°"]),
        (ends([]), THERE, []),
        (THERE, ends([], gap=0.4), []),
        (
            THERE,
            ends([], gap=1.24),
            ["✗ s: for 1.2 s, no pose came on /s/odom: check its network and the node that publishes them"],
        ),
    ],
)
def test_misplaced_robots_and_lost_poses_are_reported(r: Endpoints, s: Endpoints, expected: list[str]) -> None:
    """Poses that count from the place where a robot was switched on don't show its place in the world."""
    places = {"r": Pose(1.0), "s": Pose(1.0)}
    assert told(*doctor_ros.poses(SEEN, Safety(), places, {"/r/odom": r, "/s/odom": s})) == expected
    if not expected or expected[0].startswith("–"):
        assert told(*doctor_ros.poses(SEEN, Safety(), {}, {"/r/odom": r, "/s/odom": s})) == []


def test_nearly_empty_batteries_are_reported() -> None:
    seen = {"/r/battery_state": ends([], battery=0.12), "/s/battery_state": ends([], battery=0.5)}
    assert told(*doctor_ros.batteries(SEEN, seen)) == ["– r: its battery is at 12%: charge it"]
    assert told(*doctor_ros.batteries(CAST, {})) == []


def test_publishers_of_stops_are_reported() -> None:
    safety = Safety("/e_stop", Deadman("/joy", 4))
    seen = {"/e_stop": ends([], ("/button", "std_msgs/msg/Bool")), "/joy": ends([], ("/x", TWIST))}
    assert told(*doctor_ros.guards(safety, seen)) == [
        "✓ emergency stop: /button on /e_stop",
        "– deadman button 4 on /joy: nobody publishes sensor_msgs/msg/Joy on /joy: "
        "start its node; until then no robot moves",
    ]
    assert told(*doctor_ros.guards(Safety(), seen)) == []


RANGE = "ROS_AUTOMATIC_DISCOVERY_RANGE"


@pytest.mark.parametrize(
    ("env", "expected"),
    [
        ({}, f"✓ domain 0, this machine only: set {RANGE}=SUBNET to reach robots on the network"),
        (
            {"ROS_DOMAIN_ID": "7", RANGE: "SUBNET"},
            f"✓ domain 7, the whole subnet: set {RANGE}=LOCALHOST after sourcing ROS to stay on this machine",
        ),
        (
            {"ROS_DISCOVERY_SERVER": "10.0.0.1:11811"},
            "✓ domain 0, all robots listed by the discovery server 10.0.0.1:11811: "
            "unset ROS_DISCOVERY_SERVER to find robots without it",
        ),
        ({RANGE: "OFF"}, f"– domain 0, no discovery: unset {RANGE} to find robots on this machine"),
        ({RANGE: "here"}, f"✗ {RANGE} is here: set it to LOCALHOST, SUBNET, OFF, SYSTEM_DEFAULT, or unset it"),
        ({"ROS_DOMAIN_ID": "233"}, "✗ ROS_DOMAIN_ID is 233: set it to a number from 0 to 101"),
        (
            {"ROS_LOCALHOST_ONLY": "1", RANGE: "SUBNET"},
            "✓ domain 0, this machine only: "
            f"set {RANGE}=SUBNET and ROS_LOCALHOST_ONLY=0 to reach robots on the network",
        ),
    ],
)
def test_the_reach_of_ros_is_reported(env: dict[str, str], expected: str) -> None:
    assert str(doctor_ros.reach(env)) == expected


def test_the_python_for_ros_is_reported(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    found = Interpreter("/usr/bin/python3", {"ROS_DISTRO": "jazzy"}, "/opt/ros/jazzy")
    assert str(doctor_ros.ros(found, tmp_path, {})) == "✓ ROS 2 jazzy from /opt/ros/jazzy: /usr/bin/python3"
    asked = InterpreterError("/x cannot import rclpy (it fails): correct IMPROV_ROS_PYTHON or clear it")
    assert str(doctor_ros.ros(asked, tmp_path, {})) == f"✗ {asked}"
    broken = f"✗ the ROS 2 in {tmp_path} does not work: run `improv ros setup` again"
    assert str(doctor_ros.ros(None, tmp_path, {})) == broken
    none = tmp_path / "none"
    assert str(doctor_ros.ros(None, none, {"AMENT_PREFIX_PATH": "/opt/ros/jazzy"})) == (
        "✗ ROS 2 is sourced, but no Python can import rclpy: run `sudo apt install ros-$ROS_DISTRO-rclpy`"
    )
    monkeypatch.setattr(doctor_ros, "unsuited", lambda: None)
    assert str(doctor_ros.ros(None, none, {})) == (
        "– no ROS 2, so only the simulator can play: `improv ros setup` installs it (75 MB to download)"
    )
    monkeypatch.setattr(doctor_ros, "unsuited", lambda: "not here: source a ROS 2")
    assert str(doctor_ros.ros(None, none, {})) == "– no ROS 2, so only the simulator can play: not here: source a ROS 2"


def test_editors_and_how_old_they_are(tmp_path: Path) -> None:
    program(tmp_path / "codium", "echo 1.95.3; echo 1a2b3c; echo x64")
    program(tmp_path / "nvim", "echo NVIM v0.9.5; echo Build type: Release")
    program(tmp_path / "hx", "exit 1")
    assert told(*doctor_editors.editors(str(tmp_path))) == [
        "✓ VS Code 1.95.3",
        "– Neovim 0.9.5: Improv needs 0.10 or newer",
        f"– Helix does not report its version: make sure `{tmp_path}/hx --version` works",
        "– no Emacs, no Vim: any editor works with `improv watch FILE`",
    ]


def test_doctor_names_the_server_that_editors_find(tmp_path: Path) -> None:
    own = program(tmp_path / "own" / "improv-ls", "").parent
    other = program(tmp_path / "other" / "improv-ls", "").parent
    (tmp_path / "links").mkdir()
    (tmp_path / "links" / "improv-ls").symlink_to(own / "improv-ls")
    assert str(doctor_editors.server("", own)) == f"– improv-ls is not on the PATH: add {own} to it, for editors"
    assert (
        str(doctor_editors.server(f"{tmp_path}/links", own)) == f"✓ improv-ls for editors: {tmp_path}/links/improv-ls"
    )
    assert str(doctor_editors.server(f"{other}:{own}", own)) == (
        f"– {other}/improv-ls is another Improv's: put {own} before it on the PATH"
    )


def test_broken_parts_are_reported() -> None:
    def missing() -> None:
        raise ImportError("No module named 'pymunk'")

    def closed() -> None:
        raise PermissionError(13, "Permission denied")

    assert told(doctor.works("the simulator", missing), doctor.works("the page", closed), doctor.browser(False)) == [
        "✗ the simulator does not work (No module named 'pymunk'): reinstall improv-ls",
        "✗ the page cannot be served ([Errno 13] Permission denied): allow Improv to open a port on 127.0.0.1",
        "– no browser to show the page: open the address that Improv prints in a browser or your editor",
    ]


@pytest.fixture
def without_ros(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Callable[..., Ended]:
    """Return a function that runs `improv doctor` in an empty environment, without ROS 2 whatever this machine has."""
    for name in os.environ:
        monkeypatch.delenv(name)
    monkeypatch.setenv("HOME", str(tmp_path / "home"))
    monkeypatch.setenv("PATH", str(tmp_path / "bin"))
    monkeypatch.setattr("improv_core.outputs.ros.setup.interpreter._INSTALLED", "/nowhere")
    return partial(run, "doctor", folder=tmp_path)


def test_addresses_of_robots_are_reported(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("XDG_CONFIG_HOME", str(tmp_path))
    approve("tcp:10.0.0.5:4000")
    about = '[robots.{}]\noutput = "thymio"\naddress = "{}"\nnode = {}\n'
    places = [("ada", "tcp:10.0.0.5:4000", 1), ("bob", "tcp:10.0.0.5:4000", 2), ("carla", "serial:/dev/ttyACM0", 1)]
    robots = read_robots("".join(about.format(*place) for place in places)).robots
    assert [str(finding) for finding in doctor.addresses(robots)] == [
        "✓ ada, bob at tcp:10.0.0.5:4000, which Improv may use",
        "– carla at serial:/dev/ttyACM0: nobody has allowed Improv to use it: if you trust it, "
        "run `improv hosts allow serial:/dev/ttyACM0`",
    ]


def test_doctor_works_without_ros(without_ros: Callable[..., Ended]) -> None:
    done = without_ros()
    assert (done.returncode, done.stderr) == (0, "")
    lines = done.stdout.splitlines()
    assert lines[0].startswith("✓ Improv ")
    assert "✓ the simulator" in lines
    assert "✓ the simulator's page" in lines
    advice = environment.unsuited() or "`improv ros setup` installs it (75 MB to download)"
    assert f"– no ROS 2, so only the simulator can play: {advice}" in lines
    assert lines[-1] == "– no VS Code, no Neovim, no Helix, no Emacs, no Vim: any editor works with `improv watch FILE`"


def test_errors_are_reported_and_counted(tmp_path: Path, without_ros: Callable[..., Ended]) -> None:
    toml, dance = tmp_path / "improv.toml", tmp_path / "dance.improv"
    toml.write_text("[robots.r]\nprofile = 'turtlesim'\n")
    dance.write_text("r $ left\n")
    done = without_ros("dance.improv")
    assert done.returncode == 0
    assert done.stdout.splitlines()[1:3] == ["✓ no errors in dance.improv", f"✓ {toml}: r (turtlesim)"]

    toml.write_text("[robots.r]\nprofile = 'turtlesym'\n")
    dance.write_text("r $ lft\n")
    done = without_ros("dance.improv")
    assert done.returncode == 1
    checked, robots = done.stdout.splitlines()[1:3]
    assert checked == "✗ dance.improv has errors: run `improv check dance.improv` to see them"
    assert robots.startswith(f"✗ {toml}:2:11: error[robots] `turtlesym` is not valid here")

    done = without_ros("none.improv")
    assert done.returncode == 1
    assert "✗ none.improv: no such file or directory" in done.stdout
