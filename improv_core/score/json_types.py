"""Checks the types of JSON values, and makes dataclasses of them. Standard library only."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import asdict, dataclass, is_dataclass
from functools import cache, lru_cache, partial
from types import UnionType
from typing import TYPE_CHECKING, Annotated, Any, Literal, NoReturn, Union, get_args, get_origin, get_type_hints

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
    return _check(hint)(value)


def as_json(value: Any) -> Any:
    """Return the JSON value of a dataclass, of a mapping of them, or of anything that JSON has as it is."""
    if isinstance(value, Mapping):
        return {name: as_json(each) for name, each in value.items()}
    return asdict(value) if is_dataclass(value) and not isinstance(value, type) else value


def read(value: Any, hint: Any) -> Any:
    """Return the value of a type that `as_json` wrote. Besides the types of `fits`, it may be a tuple, a dataclass with
    exactly these fields, or a named tuple. Raises ValueError on anything else."""
    return _reader(hint)(value)


@cache
def _check(hint: Any) -> Callable[[Any], bool]:
    """Return what `fits` does for a type: to look into a type takes several times as long as to check a value."""
    origin, arguments = get_origin(hint), get_args(hint)
    if hint is Any:
        return lambda value: True
    if origin is Annotated:
        inner, limits = _check(arguments[0]), [limit.holds for limit in arguments[1:]]
        return lambda value: inner(value) and all(holds(value) for holds in limits)
    if hint is float:
        return lambda value: type(value) in (int, float) and -LARGEST_FLOAT <= value <= LARGEST_FLOAT
    if hint is int:
        return lambda value: type(value) is int
    if origin is Literal:
        return lambda value: isinstance(value, str) and value in arguments
    if origin in (UnionType, Union):
        checks = [*map(_check, arguments)]
        return lambda value: any(check(value) for check in checks)
    if origin is None and hasattr(hint, "__required_keys__"):
        required, fields = required_of(hint), {name: _check(each) for name, each in hints_of(hint).items()}
        return lambda value: (
            isinstance(value, dict)
            and required <= value.keys()
            and all(check(value[name]) for name, check in fields.items() if name in value)
        )
    if origin is not None and issubclass(origin, Mapping):
        keys = _check_all(Any if arguments[0] is str else arguments[0])  # JSON has no other keys
        values = _check_all(arguments[1])
        return lambda value: isinstance(value, dict) and keys(value) and values(value.values())
    if origin is not None and issubclass(origin, Sequence):
        items = _check_all(arguments[0])
        return lambda value: isinstance(value, list) and items(value)
    return lambda value: isinstance(value, hint)


def _check_all(hint: Any) -> Callable[[Any], bool]:
    if hint is int:  # there may be thousands
        return lambda values: {int}.issuperset(map(type, values))
    check = _check(hint)
    return lambda values: hint is Any or all(map(check, values))


@cache
def _reader(hint: Any) -> Callable[[Any], Any]:
    """Return what `read` does for a type."""
    origin, arguments = get_origin(hint), get_args(hint)
    types = () if origin is Literal else arguments[:1] if origin is Annotated else arguments
    own = [_reader(each) for each in types if each is not ...]

    def limited(value: Any) -> Any:
        made = own[0](value)
        return made if all(limit.holds(made) for limit in arguments[1:]) else _refuse(value)

    def first(value: Any) -> Any:
        if value is None and type(None) in arguments:
            return None
        for each in own:
            with suppress(ValueError):
                return each(value)
        return _refuse(value)

    def mapping(value: Any) -> Any:
        keys, values = own
        return {keys(key): values(each) for key, each in value.items()} if isinstance(value, dict) else _refuse(value)

    def several(value: Any) -> Any:  # of one type, or of one for each item
        if not isinstance(value, (list, tuple)):
            _refuse(value)
        if origin is tuple and arguments[-1] is not ...:
            return tuple([each(item) for each, item in zip(own, value, strict=True)])
        return tuple(map(own[0], value))

    if origin is Annotated:
        return limited
    if origin in (UnionType, Union):
        return first
    if isinstance(origin, type) and issubclass(origin, (Mapping, Sequence)):
        return mapping if issubclass(origin, Mapping) else several
    return _fields_reader(hint) if is_dataclass(hint) or hasattr(hint, "_fields") else _simple_reader(_check(hint))


def _simple_reader(check: Callable[[Any], bool]) -> Callable[[Any], Any]:
    return lambda value: value if check(value) else _refuse(value)


def _fields_reader(kind: Any) -> Callable[[Any], Any]:
    readers = {name: _reader(each) for name, each in hints_of(kind).items()}

    def made(value: Any) -> Any:
        fields = dict(zip(readers, value, strict=True)) if isinstance(value, list) else value
        if isinstance(fields, dict) and fields.keys() == readers.keys():
            return kind(**{name: readers[name](each) for name, each in fields.items()})
        return value if type(value) is kind else _refuse(value)

    return made


def _refuse(value: object) -> NoReturn:
    raise ValueError(f"{value!r:.100} has a wrong type")
