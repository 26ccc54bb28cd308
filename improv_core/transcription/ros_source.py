"""Reads recordings of ROS 2: poses and velocities of robots in .mcap (mcap, imported lazily) and .db3 files."""

from __future__ import annotations

import itertools
import sqlite3
import struct
from collections.abc import Iterator, Mapping, Sequence
from contextlib import closing
from pathlib import Path

from improv_core.outputs.cdr import POSE_TEXTS, pose_in, transforms_in, twist_in
from improv_core.score.motion import Pose, Twist
from improv_core.transcription.sources import Recording, SourceError, robot_name
from improv_core.transcription.track import TimedPlace

Message = tuple[str, str, int, bytes]
"""A topic, its type such as `nav_msgs/Odometry`, the time in nanoseconds, and the data."""
_TWISTS = ("geometry_msgs/Twist", "geometry_msgs/TwistStamped")
_TF = "tf2_msgs/TFMessage"
_BASES = ("base_link", "base_footprint")
"""The last part of the names of robots' own frames in tf."""
_STILL = 0.02
"""Meters and radians: at the ends of a recording, poses that are nearer to each other are waiting."""
_TYPES = "Odometry, PoseStamped, PoseWithCovarianceStamped, TFMessage, or Twist"
_ENDINGS = ("odom", "pose", "amcl_pose", "cmd_vel", "improv", "odometry", "filtered", "ground_truth")


def read_recording(path: Path) -> Recording:
    """Read the robots of a recording, each from the best of its topics. Raises SourceError.

    Poses count before velocities, which are added up. Waiting at the beginning and the end is left out.
    """
    read = _mcap if path.suffix == ".mcap" else _db3
    tracks: dict[tuple[int, str], list[tuple[int, Pose]]] = {}  # by kind and topic or frame
    twists: dict[str, list[tuple[int, Twist]]] = {}
    for topic, kind, time, data in read(path):
        if kind in POSE_TEXTS:
            if pose := pose_in(data, POSE_TEXTS[kind]):
                tracks.setdefault((0, topic), []).append((time, pose))
        elif kind == _TF:
            for each in transforms_in(data):
                if each.child.rpartition("/")[2] in _BASES:
                    tracks.setdefault((1, each.child), []).append((time, each.pose))
        elif kind in _TWISTS and (twist := twist_in(data, kind == _TWISTS[1])):
            twists.setdefault(topic, []).append((time, twist))
    for topic, found in twists.items():
        tracks[2, topic] = list(_driven(found))
    best: dict[str, tuple[int, str, list[tuple[int, Pose]]]] = {}
    for (rank, topic), poses in sorted(tracks.items()):
        robot = _robot(topic, path.stem)
        if len(poses) > 1 and robot not in best:
            best[robot] = rank, topic, poses
    if not best:
        raise SourceError(f"{path}: it has no {_TYPES}")
    begin = min(poses[0][0] for _, _, poses in best.values())
    guesses = [f"{robot} is read from {topic}" for robot, (_, topic, _) in best.items()]
    return Recording(_trimmed({robot: _places(poses, begin) for robot, (_, _, poses) in best.items()}), guesses)


def _robot(topic: str, file: str) -> str:
    """Return the robot that a topic or frame is of: `tb1` for `/tb1/odom`."""
    parts = [part for part in topic.replace("/improv/", "/").strip("/").split("/") if part not in _ENDINGS]
    first = parts[0] if parts else file
    return robot_name("robot" if first in (*_BASES, "tf") else first)


def _places(poses: Sequence[tuple[int, Pose]], begin: int) -> list[TimedPlace]:
    found: list[TimedPlace] = []
    for time, pose in poses:
        seconds = (time - begin) / 1e9
        if not found or seconds > found[-1].time:
            found.append(TimedPlace(seconds, pose.x, pose.y, pose.z, pose.heading))
    return found


def _trimmed(places: Mapping[str, list[TimedPlace]]) -> dict[str, Sequence[TimedPlace]]:
    """Leave out the waiting that is common to all robots, at both ends."""

    def moves(one: TimedPlace, other: TimedPlace) -> bool:
        far = max(abs(one.x - other.x), abs(one.y - other.y), abs(one.z - other.z))
        return max(far, abs((one.heading or 0.0) - (other.heading or 0.0))) > _STILL

    def first(all_of: Sequence[TimedPlace]) -> float:
        return next(
            (before.time for before, here in itertools.pairwise(all_of) if moves(all_of[0], here)),
            all_of[-1].time,
        )

    begin = min(first(each) for each in places.values())
    end = max(first(each[::-1]) for each in places.values())
    if end <= begin:
        return dict(places)
    kept = {
        robot: [p._replace(time=p.time - begin) for p in each if begin <= p.time <= end]
        for robot, each in places.items()
    }
    return {robot: each for robot, each in kept.items() if len(each) > 1}


def _driven(twists: Sequence[tuple[int, Twist]]) -> Iterator[tuple[int, Pose]]:
    """Yield the poses of a robot that holds each velocity until the next one."""
    pose = Pose()
    yield twists[0][0], pose
    for (time, twist), (after, _) in itertools.pairwise(twists):
        pose = pose.after(twist, (after - time) / 1e9)
        yield after, pose


def _mcap(path: Path) -> Iterator[Message]:
    from mcap.exceptions import McapError
    from mcap.reader import make_reader

    try:
        with path.open("rb") as file:
            for schema, channel, message in make_reader(file).iter_messages():
                if schema:
                    yield channel.topic, schema.name.replace("/msg/", "/"), message.log_time, message.data
    except (McapError, struct.error, EOFError) as error:
        raise SourceError(f"{path}: it is no MCAP recording: {error}") from None


def _db3(path: Path) -> Iterator[Message]:
    rows = (
        "SELECT topics.name, replace(topics.type, '/msg/', '/'), messages.timestamp, messages.data"
        " FROM messages JOIN topics ON topics.id = messages.topic_id"
        " WHERE typeof(messages.data) = 'blob' AND typeof(messages.timestamp) = 'integer' ORDER BY messages.timestamp"
    )
    try:
        with closing(sqlite3.connect(f"{path.absolute().as_uri()}?mode=ro", uri=True)) as base:
            yield from base.execute(rows)
    except sqlite3.Error as error:
        raise SourceError(f"{path}: it is no recording of rosbag2: {error}") from None
