"""The settings in section `improv`: typed, and tolerant of anything a client sends."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Any, Literal

from improv_core.score.transport import BEATS_PER_BAR, Switch


@dataclass(frozen=True, slots=True)
class Settings:
    """All settings; docs/settings.md explains each."""

    backend: str = "auto"
    on_save: Literal["restart", "continue", "off"] | None = None
    """None means `restart`, and that the person may not know of `continue`."""
    switch_at: Switch = "beat"
    beats_per_bar: int = BEATS_PER_BAR
    page_open: bool = True
    page_port: int = 0
    ros_python: str | None = None
    ros_discovery: str | None = None
    ros_standby: bool = True
    osc_network: bool = False
    code_lens: bool = True
    inlay_hints_beats: bool = False
    inlay_hints_playing: bool | None = None
    """None means: in editors that nothing else tells which words play."""
    hover_pictures: bool = False


def read_settings(given: Any, current: Settings) -> tuple[Settings, list[str]]:
    """Update the settings with a client's values. Return them, and one line for each wrong value, which changes
    nothing.

    Takes the whole section or its contents, nested or with dotted names.
    """
    section = given.get("improv", given) if isinstance(given, Mapping) else {}
    values = dict(_flat(section)) if isinstance(section, Mapping) else {}
    problems = []
    for name, (field, wanted, fits) in _SETTINGS.items():
        value = values.get(name, _ABSENT)
        if value is _ABSENT:
            continue
        if value is None or value == "":
            current = replace(current, **{field: getattr(Settings(), field)})
        elif fits(value):
            current = replace(current, **{field: value})
        else:
            problems.append(f"improv.{name}: expected {wanted}, got {value!r}; keeping the current value")
    return current, problems


_ABSENT = object()


def _flat(section: Mapping[str, Any], prefix: str = "") -> list[tuple[str, Any]]:
    found = []
    for name, value in section.items():
        if isinstance(value, Mapping):
            found += _flat(value, f"{prefix}{name}.")
        else:
            found.append((f"{prefix}{name}", value))
    return found


def _one_of(*words: str) -> tuple[str, Callable[[Any], bool]]:
    return f"{', '.join(words[:-1])} or {words[-1]}", lambda value: value in words


_YES_NO = ("true or false", lambda value: isinstance(value, bool))
_TEXT = ("a string", lambda value: isinstance(value, str))
_PORT = ("a port number from 0 to 65535", lambda value: type(value) is int and 0 <= value <= 65535)
_BEATS = ("a whole number from 1 to 1000", lambda value: type(value) is int and 1 <= value <= 1000)

_SETTINGS: Mapping[str, tuple[str, str, Callable[[Any], bool]]] = {
    "backend": ("backend", *_one_of("auto", "sim", "ros", "both")),
    "onSave": ("on_save", *_one_of("restart", "continue", "off")),
    "switchAt": ("switch_at", *_one_of("now", "beat", "bar", "end")),
    "beatsPerBar": ("beats_per_bar", *_BEATS),
    "page.open": ("page_open", *_YES_NO),
    "page.port": ("page_port", *_PORT),
    "ros.python": ("ros_python", *_TEXT),
    "ros.discovery": ("ros_discovery", *_one_of("LOCALHOST", "SUBNET", "OFF", "SYSTEM_DEFAULT")),
    "ros.standby": ("ros_standby", *_YES_NO),
    "osc.network": ("osc_network", *_YES_NO),
    "codeLens": ("code_lens", *_YES_NO),
    "inlayHints.beats": ("inlay_hints_beats", *_YES_NO),
    "inlayHints.playing": ("inlay_hints_playing", *_YES_NO),
    "hover.pictures": ("hover_pictures", *_YES_NO),
}
