"""The reason why nothing is heard of a real robot's senses or of its position (the node is passed in)."""

from __future__ import annotations

from typing import Any

from improv_core.outputs.ros.nodes import is_published
from improv_core.outputs.ros.sensors.client import RosReader
from improv_core.score.score import Part
from improv_core.score.senses import CUE, BuiltIn, RobotSense, Topic


def silence(part: Part, moves_since: float | None, reader: RosReader, node: Any) -> str | None:
    """Return one line about a sense of a robot that is silent, or about the unknown position of one that has moved
    since a time; None if everything arrives."""
    robot = part.robot
    for sense, source in part.senses.items():
        if isinstance(source, BuiltIn) and sense != CUE:
            return f"no topic provides `{sense}` for real robots: add [senses.{sense}] to improv.toml"
        if isinstance(source, Topic) and reader.is_silent(RobotSense(robot, sense)):
            problem = reader.unread.get(source.topic) or _unheard(source, node)
            return f"{problem}, so {robot} stands still where it reads `{sense}`"
    topic = part.odom
    if not topic or moves_since is None or not reader.lacks_poses(robot, moves_since):
        return None
    silent = "no poses arrive" if is_published(node, topic) else "nobody publishes"
    return f"{reader.unread.get(topic) or f'{silent} on {topic}'}: {robot}'s real position is unknown"


def _unheard(source: Topic, node: Any) -> str:
    kinds = {info.topic_type for info in node.get_publishers_info_by_topic(source.topic)}
    if not kinds:
        return f"nobody publishes on {source.topic}"
    if source.message.replace("/", "/msg/") not in kinds:
        return f"{source.topic} carries {', '.join(sorted(kinds))}, not {source.message}"
    return f"nothing usable comes on {source.topic}"
