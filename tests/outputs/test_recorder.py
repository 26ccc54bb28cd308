"""Recordings: exact to the nanosecond, readable by other tools, and never half a file under the final name."""

from __future__ import annotations

import io
import json
import math
from contextlib import nullcontext
from dataclasses import asdict, replace
from fractions import Fraction
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from mcap.reader import make_reader
from rosbags.highlevel import AnyReader
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

from improv_core.commands.exit_codes import CommandError
from improv_core.commands.record import compute, note, recording
from improv_core.outputs.cdr import POSE_TEXTS, SECOND, pose_in
from improv_core.outputs.recording.recorder import SCHEMAS, Recorder, sensed_in
from improv_core.outputs.simulator.simulator import Simulator
from improv_core.program.analysis import Analysis, analyze
from improv_core.program.compiler import compiled, score_of
from improv_core.protocol.messages import Sent
from improv_core.robots.config import read_robots
from improv_core.score.motion import Pose
from improv_core.score.world import World
from improv_core.stage.dry_run import perform
from improv_core.stage.process import report_sent
from tests.recordings import ROS, changes, read, read_joints, topics

START = 1_700_000_000_123_456_789
STILL = (0.0, 0.0, 0.0, 0.0)
QUARTER = math.pi / 2

ROBOTS = """
[robots.burger]
profile = "turtlebot3_burger"
topic = "/cmd_vel"
message = "TwistStamped"
[robots.drone]
profile = "quadrotor"
"""


def analyzed(program: str, robots: str = "") -> Analysis:
    analysis = analyze(program, read_robots(robots, Path("improv.toml"))) if robots else analyze(program)
    assert analysis.ok, analysis.diagnostics
    return analysis


def record(folder: Path, analysis: Analysis, seconds: float | None = None) -> Path:
    path = folder / "dance.mcap"
    with path.open("wb") as file:
        recorder = Recorder(file, START)
        compute(recorder, score_of(analysis), seconds)
        recorder.finish()
    return path


def test_every_compiled_segment_is_reported_when_it_begins(tmp_path: Path) -> None:
    program = (
        "beat 92.5\nsquare = repeat 4 (forward [left right left])\na $ square || slow 7/2 left\nb $ backward square"
    )
    analysis = analyzed(program)
    messages = read(record(tmp_path, analysis))
    for robot, told in compiled(analysis)["robots"].items():
        expected = [(START + round(at * SECOND), tuple(velocity)) for at, _, *velocity in told["segments"]]
        end = START + round(told["seconds"] * SECOND)
        assert changes(messages, f"/{robot}/cmd_vel") == [*expected, (end, STILL)]


def test_two_minutes_at_20_hz_are_exact_to_the_nanosecond(tmp_path: Path) -> None:
    messages = read(record(tmp_path, analyzed("r $ repeat forward"), seconds=120))
    assert [message.time - START for message in messages] == [count * SECOND // 20 for count in range(120 * 20 + 3)]
    assert [message.velocity for message in messages[-4:]] == [(2.0, 0.0, 0.0, 0.0), *[STILL] * 3]


@pytest.mark.slow("records many performances")
@settings(max_examples=20)
@given(
    tempo=st.decimals(20, 400, places=3).map(Fraction),
    fast=st.fractions(Fraction(1, 2), 7, max_denominator=9),
    words=st.lists(st.sampled_from(["forward left", "right backward", "left forward"]), min_size=1, max_size=4),
)
def test_changes_are_at_the_nearest_nanosecond(
    tmp_path_factory: pytest.TempPathFactory, tempo: Fraction, fast: Fraction, words: list[str]
) -> None:
    program = f"beat {float(tempo)}\nr $ fast {fast} repeat 5 ({' '.join(words)})"
    messages = read(record(tmp_path_factory.mktemp("hypothesis"), analyzed(program)))
    items = " ".join(words * 5).split()
    beginnings = [place for place, item in enumerate(items) if not place or item != items[place - 1]]
    exact = [place / fast * 60 / tempo * SECOND for place in [*beginnings, len(items)]]
    found = [time - START for time, _ in changes(messages, "/r/cmd_vel")]
    assert len(found) == len(exact)
    assert all(abs(time - right) <= Fraction(501, 1000) for time, right in zip(found, exact, strict=True))


def test_profiles_set_type_topic_and_limits(tmp_path: Path) -> None:
    path = record(tmp_path, analyzed("burger $ [forward forward] || [left left]\ndrone $ up", ROBOTS))
    assert {topic: found.msgtype for topic, found in topics(path).items()} == {
        "/cmd_vel": "geometry_msgs/msg/TwistStamped",
        "/drone/cmd_vel": "geometry_msgs/msg/Twist",
    }
    messages = read(path)
    burger = [message for message in messages if message.topic == "/cmd_vel"]
    assert all(message.stamp == message.time for message in burger)
    # 0.4 m/s is over its 0.22 m/s and π rad/s over its 2.84: the curve keeps its shape.
    assert burger[0].velocity == pytest.approx((0.22, 0, 0, 2 * QUARTER * 0.22 / 0.4))
    assert changes(messages, "/drone/cmd_vel") == [(START, (0, 0, 0.5, 0)), (START + SECOND, STILL)]
    assert all(message.stamp is None for message in messages if message.topic == "/drone/cmd_vel")


def test_ros2_bag_and_foxglove_find_what_they_need(tmp_path: Path) -> None:
    path = record(tmp_path, analyzed("burger $ forward\ndrone $ up", ROBOTS))
    with path.open("rb") as file:
        reader = make_reader(file)
        summary = reader.get_summary()
        assert reader.get_header().profile == "ros2"
        assert summary is not None
        assert {schema.encoding for schema in summary.schemas.values()} == {"ros2msg"}
        assert {channel.message_encoding for channel in summary.channels.values()} == {"cdr"}
        assert summary.statistics is not None
        assert summary.statistics.message_count == 47  # the drone is repeated in the second slot, which is due at once
        # Humble's rosbag2 understands numbers only; a rosbag2 metadata record would promise words.
        offered = {channel.metadata["offered_qos_profiles"] for channel in summary.channels.values()}
        assert all(text.startswith("- history: 1\n  depth: 10\n") for text in offered)
        assert not list(reader.iter_metadata())
    for topic in topics(path).values():
        (qos,) = topic.ext.offered_qos_profiles  # type: ignore[union-attr]
        names = qos.history.name, qos.depth, qos.reliability.name, qos.durability.name, qos.liveliness.name
        assert names == ("KEEP_LAST", 10, "RELIABLE", "VOLATILE", "AUTOMATIC")


@pytest.mark.parametrize("name", SCHEMAS)
def test_the_schemas_are_those_of_ros(name: str) -> None:
    own = get_typestore(Stores.EMPTY)
    own.register(get_types_from_msg(SCHEMAS[name], name))
    assert own.hash_rihs01(name) == ROS.hash_rihs01(name)


def test_numbers_that_are_not_finite_are_not_recorded() -> None:
    recorder = Recorder(io.BytesIO(), START)
    recorder.prepare(score_of(analyzed("r is puppet\nr $ head left")))
    with pytest.raises(ValueError, match="r was given a speed that is not a finite number"):
        recorder.take({"type": "sent", "robot": "r", "twist": [math.inf, 0, 0, 0], "wall": START})
    with pytest.raises(ValueError, match="a joint of r was given a position or a speed that is not a finite number"):
        recorder.take({"type": "sent", "robot": "r", "joints": {"head_yaw": [math.nan, 0.0]}, "wall": START})
    assert recorder.setpoints == 0


def record_forward(path: Path, problem: BaseException | None = None) -> None:
    with recording(path) as to:
        compute(to, score_of(analyzed("r $ forward")), None)
        if problem:
            raise problem


def test_a_complete_recording_takes_its_name(tmp_path: Path) -> None:
    path, link = tmp_path / "dance.mcap", tmp_path / "link.mcap"
    path.write_bytes(b"old")
    link.symlink_to(path)
    record_forward(link)
    assert link.is_symlink()
    assert len(read(path)) == 23
    assert {each.name for each in tmp_path.iterdir()} == {"dance.mcap", "link.mcap"}


NO_SPACE = OSError(28, "No space left on device")


@pytest.mark.parametrize(
    ("name", "problem", "line"),
    [
        ("dance.mcap", KeyboardInterrupt(), ""),
        ("dance.mcap", NO_SPACE, "dance.mcap was not written: no space left on device"),
        ("dance.mcap", ValueError("why"), "dance.mcap was not written: why"),
        ("dance.mcap", None, ""),  # nothing was recorded
        ("dance.improv", None, "dance.improv: the recording's name must end in .mcap"),
        ("folder.mcap", None, "folder.mcap was not written: a folder or another special file has that name"),
        ("none/dance.mcap", None, "none/dance.mcap was not written: no such file or directory"),
        ("kept.mcap", None, "kept.mcap was not written: permission denied"),
    ],
)
def test_what_is_no_whole_recording_replaces_nothing(
    name: str, problem: BaseException | None, line: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    kept = tmp_path / "dance.mcap"
    kept.write_bytes(b"old")
    (tmp_path / "folder.mcap").mkdir()
    (tmp_path / "kept.mcap").touch()
    monkeypatch.setattr("os.access", lambda path, mode: Path(path).name != "kept.mcap")
    before = sorted(tmp_path.iterdir())
    with pytest.raises((KeyboardInterrupt, CommandError)) if problem or line else nullcontext() as raised:
        if problem:
            record_forward(tmp_path / name, problem)
        else:
            with recording(tmp_path / name):
                assert not line, "it plays"
    assert (str(raised.value) if raised else "") == (f"{tmp_path}/{line}" if line else "")
    assert (sorted(tmp_path.iterdir()), kept.read_bytes()) == (before, b"old")


REACTING = """beat 97
anna $ repeat (until near (repeat forward) [left left])
bert $ repeat (pause near (repeat 3 forward) if near (right right) else left)
"""


@pytest.mark.slow("records many performances")
def test_replaying_sensed_changes_repeats_the_performance(tmp_path: Path) -> None:
    first, again = tmp_path / "first.mcap", tmp_path / "again.mcap"
    score = replace(score_of(analyzed(REACTING)), world=World((9, 7)))
    with recording(first) as recorder:
        compute(recorder, score, 20.0)
    with first.open("rb") as file:
        sensed = sensed_in(file)
    assert len(sensed) > 15
    with recording(again) as recorder:  # robots here sense only the changes in the recording
        recorder.prepare(score)
        simulator = Simulator()
        report_sent(simulator, recorder.take, recorder.time)
        perform(score, simulator, 20.0, lambda told: note(recorder, told), sensed)
    for topic in ("/anna/cmd_vel", "/bert/cmd_vel"):
        before, after = (changes(read(path), topic) for path in (first, again))
        starts = [min(message.time for message in read(path)) for path in (first, again)]
        assert [velocity for _, velocity in after] == [velocity for _, velocity in before]
        assert [time - starts[1] for time, _ in after] == pytest.approx(
            [time - starts[0] for time, _ in before], abs=SECOND / 1000
        )
    assert told_in(again, "sensed") == told_in(first, "sensed")
    assert told_in(again, "decided") == told_in(first, "decided")


def told_in(path: Path, kind: str) -> list[tuple[object, ...]]:
    with AnyReader([path], default_typestore=ROS) as reader:
        connections = [each for each in reader.connections if each.topic == f"/improv/{kind}"]
        assert [each.msgtype for each in connections] == ["std_msgs/msg/String"]
        messages: list[Any] = [reader.deserialize(raw, each.msgtype) for each, _, raw in reader.messages(connections)]
    lines = [json.loads(message.data) for message in messages]
    told = [
        (round(line["beat"], 5), line["robot"], line.get("sense"), line.get("value", line.get("held")))
        for line in lines
    ]
    return sorted(told, key=str)


def test_a_file_that_is_not_a_recording_is_refused_in_one_line(tmp_path: Path) -> None:
    path = tmp_path / "dance.mcap"
    path.write_bytes(b"nothing")
    with path.open("rb") as file, pytest.raises(ValueError, match="it is not a recording"):
        sensed_in(file)


def test_joints_are_recorded_whenever_they_move_differently(tmp_path: Path) -> None:
    program = "beat 60\nada is puppet\nada $ head (left left left left)\n"
    path = record(tmp_path, analyzed(program))
    assert topics(path)["/improv/ada/joint_states"].msgtype == "sensor_msgs/msg/JointState"
    yaw = [(each.time - START, *each.joints["head_yaw"]) for each in read_joints(path)]
    changed = [each for each, before in zip(yaw, [(0, 0.0, 0.0), *yaw], strict=False) if each[2] != before[2]]
    assert [time for time, *_ in changed] == [0, 3 * SECOND]  # there it reaches its limit
    assert [round(math.degrees(each)) for _, *motion in [*changed, yaw[-1]] for each in motion] == [0, 30, 90, 0, 90, 0]
    assert {name for each in read_joints(path) for name in each.joints} == {"head_yaw", "head_pitch"}


@pytest.mark.parametrize(
    ("sent_as", "kind"),
    [
        ([False, False], "Twist"),
        ([None, True], "TwistStamped"),  # a robot that was found late
        ([False, None, True], "Twist"),
        ([None], "Twist"),
    ],
)
def test_a_topic_has_the_first_type_that_was_heard(sent_as: list[bool | None], kind: str, tmp_path: Path) -> None:
    path = tmp_path / "dance.mcap"
    with path.open("wb") as file:
        recorder = Recorder(file, START)
        recorder.prepare(score_of(analyzed("r $ forward")))
        for number, stamped in enumerate(sent_as):
            sent: Sent = {"type": "sent", "robot": "r", "twist": [0.1, 0, 0, 0], "wall": START + number}
            sent["topic"] = "/base/cmd_vel"
            if stamped is not None:
                sent["stamped"] = stamped
            recorder.take(sent)
        recorder.finish()
    with AnyReader([path], default_typestore=ROS) as reader:
        found = [(connection.topic, connection.msgtype) for connection in reader.connections]
    assert found == [("/base/cmd_vel", f"geometry_msgs/msg/{kind}")]
    stamps = [START + number if kind == "TwistStamped" else None for number in range(len(sent_as))]
    assert [(message.velocity, message.stamp) for message in read(path)] == [((0.1, 0, 0, 0), at) for at in stamps]


def test_measured_poses_have_a_topic_of_their_own_and_the_frame_in_which_they_came(tmp_path: Path) -> None:
    path = tmp_path / "dance.mcap"
    origin, pose = Pose(1.0, 2.0, 0.0, math.radians(90)), Pose(1.5, -2.0, 0.25, math.radians(60))
    measured: Any = {"pose": asdict(pose), "origin": asdict(origin), "frame": "odom", "wall": START, "source": "any"}
    with path.open("wb") as file:
        recorder = Recorder(file, START)
        recorder.prepare(score_of(analyzed("r $ forward", "[robots.r]\nodom = 'odom'\n")))
        recorder.take({"type": "measured", "generation": 1, "robots": {"r": measured, "left": measured}})
        recorder.finish()
    with AnyReader([path], default_typestore=ROS) as reader:
        ((connection, time, raw),) = reader.messages()
        found: Any = reader.deserialize(raw, connection.msgtype)
    assert (connection.topic, connection.msgtype, time) == ("/improv/r/pose", "geometry_msgs/msg/PoseStamped", START)
    assert found.header.frame_id == "odom"
    assert found.header.stamp.sec * SECOND + found.header.stamp.nanosec == START
    recorded = pose_in(raw, POSE_TEXTS["geometry_msgs/PoseStamped"])
    assert recorded
    assert recorded.apart(Pose(3.0, 3.5, 0.25, math.radians(150))) == pytest.approx((0, 0), abs=1e-9)
