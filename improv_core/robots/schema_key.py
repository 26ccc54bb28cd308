"""Description of one key of an `improv.toml`."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field


@dataclass(frozen=True, slots=True)
class Key:
    """One key: what it sets, and what its value may be."""

    about: str
    """The thing that it sets, as Markdown."""
    type: str = "string"
    """The type of its value in JSON schema."""
    default: str = ""
    """The value without the key, for people."""
    unit: str = ""
    """The unit of a number."""
    least: float = 0
    """The least number, or the fewest `items`."""
    most: float = 0
    """The greatest number."""
    choices: Sequence[str] = ()
    """The texts that it may be."""
    profile: bool = False
    """True if the text is the name of a profile."""
    keys: Mapping[str, Key] = field(default_factory=dict)
    """The keys of a table."""
    required: Sequence[str] = ()
    """The keys that a table must have."""
    named: Key | None = None
    """The values that a table has under names that people choose."""
    items: Key | None = None
    """The items of a list."""
    count: int = 0
    """The number of items, if it is fixed."""
    example: str = ""
    """A value to start from."""
    form: tuple[Callable[[str], object], str] | None = None
    """A function that is true for the texts that fit, and advice for people about others."""

    @property
    def range(self) -> str:
        """Range as text: `0.001, 100`; empty if there is none."""
        return f"{self.least:g}, {self.most:g}" if self.least < self.most else ""


def number(about: str, unit: str, least: float, most: float, default: str = "") -> Key:
    return Key(about, "number", default, unit, least, most)


def flag(about: str, default: bool = False) -> Key:
    words = ("false", "true")
    return Key(about, "boolean", default=words[default], example=words[not default])


def table(about: str, keys: Mapping[str, Key], example: str = "", required: Sequence[str] = ()) -> Key:
    return Key(about, "object", keys=keys, required=required, example=example)
