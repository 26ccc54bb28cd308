"""Checks the types of JSON values, and makes dataclasses of them. Standard library only."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import asdict, dataclass, is_dataclass
from functools import lru_cache, partial
from types import UnionType
from typing import TYPE_CHECKING, Annotated, Any, Literal, Union, get_args, get_origin, get_type_hints

if TYPE_CHECKING:
    from typing import NotRequired as NotRequired
else:

    class NotRequired:
        """Marks a field of a TypedDict that may be missing, also in Python 3.10."""

        def __class_getitem__(cls, hint: Any) -> Any:
            return Annotated[hint, cls]

        @staticmethod
        def holds(value: object) -> bool:
            return True


LARGEST_FLOAT = 1e300
"""Larger numbers are refused."""

hints_of: Callable[[Any], dict[str, Any]] = lru_cache(partial(get_type_hints, include_extras=True))


@lru_cache
def required_of(kind: Any) -> frozenset[str]:
    """Return the keys that a TypedDict must have."""
    hints = hints_of(kind)
    return frozenset(name for name in kind.__required_keys__ if NotRequired not in get_args(hints[name]))


@dataclass(frozen=True, slots=True)
class Between:
    """The limit of a number: `Annotated[float, Between(0, 1)]`."""

    least: float
    most: float

    def holds(self, value: Any) -> bool:
        return bool(self.least <= value <= self.most)


@dataclass(frozen=True, slots=True)
class Long:
    """The limit of the length of a text, a list, or a mapping: `Annotated[str, Long(1, 100)]`."""

    least: int
    most: int

    def holds(self, value: Any) -> bool:
        return self.least <= len(value) <= self.most


Clock = Literal["monotonic", "unix", "unix_nanoseconds", "asleep"]


@dataclass(frozen=True, slots=True)
class TimeOn:
    """Marks a time with the clock that shows it, so another machine can translate it."""

    clock: Clock

    def holds(self, value: object) -> bool:
        """Return True: any number may be a time."""
        return True


Monotonic = Annotated[float, TimeOn("monotonic")]
"""Seconds."""
UnixTime = Annotated[float, TimeOn("unix")]
"""Seconds."""
UnixNanoseconds = Annotated[int, TimeOn("unix_nanoseconds")]
Asleep = Annotated[float, TimeOn("asleep")]
"""The seconds that a machine has slept."""


def fits(value: object, hint: Any) -> bool:
    """Return whether a JSON value is of a type: Any, a simple type, a Literal, a union, a TypedDict, a Mapping, or a
    Sequence; or `Annotated` with limits such as `Between`, each of which has a method `holds`.

    NaN and infinity are not numbers, and True is not 1. Unknown keys of a TypedDict are ignored.
    """
    origin, arguments = get_origin(hint), get_args(hint)
    if hint is Any:
        return True
    if origin is Annotated:
        return fits(value, arguments[0]) and all(limit.holds(value) for limit in arguments[1:])
    if hint is float:
        return type(value) in (int, float) and -LARGEST_FLOAT <= value <= LARGEST_FLOAT  # type: ignore[operator]
    if hint is int:
        return type(value) is int
    if origin is Literal:
        return isinstance(value, str) and value in arguments
    if origin in (UnionType, Union):
        return any(fits(value, each) for each in arguments)
    if origin is None and hasattr(hint, "__required_keys__"):
        return (
            isinstance(value, dict)
            and required_of(hint) <= value.keys()
            and all(fits(value[name], inner) for name, inner in hints_of(hint).items() if name in value)
        )
    if origin is not None and issubclass(origin, Mapping):
        return (
            isinstance(value, dict)
            and (arguments[0] is str or _all_fit(value, arguments[0]))  # JSON has no other keys
            and _all_fit(value.values(), arguments[1])
        )
    if origin is not None and issubclass(origin, Sequence):
        return isinstance(value, list) and _all_fit(value, arguments[0])
    return isinstance(value, hint)


def as_json(value: Any) -> Any:
    """Return the JSON value of a dataclass, of a mapping of them, or of anything that JSON has as it is."""
    if isinstance(value, Mapping):
        return {name: as_json(each) for name, each in value.items()}
    return asdict(value) if is_dataclass(value) and not isinstance(value, type) else value


def read(value: Any, hint: Any) -> Any:
    """Return the value of a type that `as_json` wrote. Besides the types of `fits`, it may be a tuple, a dataclass with
    exactly these fields, or a named tuple. Raises ValueError on anything else."""
    if type(value) is hint and hint is not float:  # most values; a number may be too large
        return value
    origin, arguments = get_origin(hint), get_args(hint)
    if origin is Annotated:
        made = read(value, arguments[0])
        if all(limit.holds(made) for limit in arguments[1:]):
            return made
    elif origin in (UnionType, Union):
        for each in arguments:
            with suppress(ValueError):
                return read(value, each)
    elif isinstance(origin, type) and issubclass(origin, Mapping):
        if isinstance(value, dict):
            return {read(key, arguments[0]): read(each, arguments[1]) for key, each in value.items()}
    elif isinstance(origin, type) and issubclass(origin, Sequence):  # of one type, or of one for each item
        if isinstance(value, (list, tuple)):
            inner = arguments if origin is tuple and arguments[-1] is not ... else arguments[:1] * len(value)
            return tuple([read(each, own) for each, own in zip(value, inner, strict=True)])
    elif is_dataclass(hint) or hasattr(hint, "_fields"):
        hints = hints_of(hint)
        fields = dict(zip(hints, value, strict=True)) if isinstance(value, list) else value
        if isinstance(fields, dict) and fields.keys() == hints.keys():
            return hint(**{name: read(each, hints[name]) for name, each in fields.items()})
    elif fits(value, hint):
        return value
    raise ValueError(f"{value!r:.100} has a wrong type")


def _all_fit(values: Any, hint: Any) -> bool:
    if hint is int:  # there may be thousands
        return {int}.issuperset(map(type, values))
    return hint is Any or all(fits(each, hint) for each in values)
