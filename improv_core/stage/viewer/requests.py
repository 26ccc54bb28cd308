"""What a page may ask for. Every value is checked, and whatever does not fit is dropped."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping
from typing import cast, get_args

from improv_core.stage.protocol import FASTEST, LAST_BEAT, LONGEST_TEXT, SLOWEST, Facing, Shape
from improv_core.stage.viewer.messages import FromPage

MOST_NAMES, LONGEST_NAME = 1000, 100

Check = Callable[[object], bool]


def read(text: str) -> FromPage | None:
    """The request in a message, with the values that belong to it and no others, or None."""
    try:
        message = json.loads(text)
    except (ValueError, RecursionError):
        return None
    kind = message.get("type") if isinstance(message, dict) else None
    if not isinstance(kind, str) or kind not in REQUESTS or not _fits(message, REQUESTS[kind]):
        return None
    return cast(FromPage, {"type": kind, **{name: message[name] for name in REQUESTS[kind]}})


def _fits(message: Mapping[str, object], checks: Mapping[str, Check]) -> bool:
    return all(name in message and check(message[name]) for name, check in checks.items())


def _between(least: float, most: float) -> Check:
    """A number within limits; NaN, infinity and booleans are not."""
    return lambda value: isinstance(value, (int, float)) and not isinstance(value, bool) and least <= value <= most


def _one_of(choices: object) -> Check:
    return lambda value: value in get_args(choices)


def _is_name(value: object) -> bool:
    return isinstance(value, str) and 0 < len(value) <= LONGEST_NAME


def _is_truth(value: object) -> bool:
    return isinstance(value, bool)


def _is_count(value: object) -> bool:
    return type(value) is int and 0 <= value <= LAST_BEAT


def _is_text(value: object) -> bool:
    """A text that can be saved: without halves of characters."""
    if not isinstance(value, str) or len(value) > LONGEST_TEXT:
        return False
    try:
        value.encode()
    except UnicodeEncodeError:
        return False
    return True


def _are_names(value: object) -> bool:
    return isinstance(value, list) and len(value) <= MOST_NAMES and all(map(_is_name, value))


_START_POSE: Mapping[str, Check] = {
    "x": _between(-1000, 1000),
    "y": _between(-1000, 1000),
    "heading": _between(-360, 360),
}
"""Meters and degrees, within the limits of improv.toml."""


def _are_start_poses(value: object) -> bool:
    """Whether this maps robot names to start poses, without extra keys."""
    return (
        isinstance(value, dict)
        and _are_names([*value])
        and all(
            isinstance(pose, dict) and pose.keys() == _START_POSE.keys() and _fits(pose, _START_POSE)
            for pose in value.values()
        )
    )


REQUESTS: Mapping[str, Mapping[str, Check]] = {
    "hush": {},
    "pause": {},
    "resume": {},
    "restart": {},
    "held": {},
    "released": {},
    "cue": {},
    "key": {"key": _is_name, "held": _is_truth},
    "force": {"robot": _is_name, "sense": _is_name, "value": lambda value: value is None or _is_truth(value)},
    "seek": {"beat": _between(0, LAST_BEAT)},
    "speed": {"factor": _between(SLOWEST, FASTEST)},
    "silence": {"muted": _are_names, "soloed": _are_names},
    "place": {"start_poses": _are_start_poses},
    "form": {"shape": _one_of(Shape), "distance": _between(0.001, 1000), "facing": _one_of(Facing)},
    "window": {"generation": _between(0, LAST_BEAT), "from": _between(0, LAST_BEAT), "to": _between(0, LAST_BEAT)},
    "analyze": {"number": _is_count, "text": _is_text},
    "complete": {"number": _is_count, "offset": _is_count},
    "explain": {"number": _is_count, "offset": _is_count},
    "write": {"number": _is_count, "text": _is_text, "revision": _is_text},
}
"""Each request and the values it needs. The viewer answers `window` itself; the others go to the parent."""
