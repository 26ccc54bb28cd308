"""Checks the types of JSON values. Standard library only."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache, partial
from types import UnionType
from typing import TYPE_CHECKING, Annotated, Any, Literal, TypeVar, Union, get_args, get_origin, get_type_hints

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


T = TypeVar("T")

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


def checked(kind: Callable[..., T], values: Any) -> T:
    """Return a dataclass or named tuple of numbers and words. Raises ValueError if a value does not fit, TypeError if
    one is missing or unknown."""
    hints = hints_of(kind)
    if wrong := [name for name, value in values.items() if name in hints and not fits(value, hints[name])]:
        raise ValueError(f"`{wrong[0]}` has a wrong value")
    return kind(**values)


def _all_fit(values: Any, hint: Any) -> bool:
    if hint is int:  # there may be thousands
        return {int}.issuperset(map(type, values))
    return hint is Any or all(fits(each, hint) for each in values)
