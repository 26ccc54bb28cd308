"""Description of one key of an `improv.toml`."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field


@dataclass(frozen=True, slots=True)
class Key:
    """One key: what it sets, as Markdown, and what its value may be.

    `type` is that of JSON schema. A number is in `unit`, from `least` to `most`. A text with `choices` is one of them;
    with `profile`, one of the profiles; with a `form`, one for which that function is true, or else people get its
    advice. `keys` are those of a table, `required` those it must have, `named` what a table has under names that people
    choose, and `items` what a list has: `count` of them, or at least `least`. People see the `default`; `example` is a
    value to start from.
    """

    about: str
    type: str = "string"
    default: str = ""
    unit: str = ""
    least: float = 0
    most: float = 0
    choices: Sequence[str] = ()
    profile: bool = False
    keys: Mapping[str, Key] = field(default_factory=dict)
    required: Sequence[str] = ()
    named: Key | None = None
    items: Key | None = None
    count: int = 0
    example: str = ""
    form: tuple[Callable[[str], object], str] | None = None

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
