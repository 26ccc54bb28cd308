"""Loads the types of lsprotocol, each of which attrs completes when it is first used.

An editor uses some sixty of the 554 classes. To complete all of them takes longer than everything else until
`initialize` is answered.
"""

from __future__ import annotations

import sys
from threading import RLock
from typing import Any

import attrs

_define, _lock = attrs.define, RLock()


def load() -> None:
    """Load lsprotocol.types, unless they have been loaded."""
    if "lsprotocol.types" in sys.modules:
        return
    attrs.define = _later  # type: ignore[assignment]
    try:
        import lsprotocol.types
    finally:
        attrs.define = _define
    import lsprotocol._hooks

    lsprotocol._hooks._resolved_forward_references = True  # `_complete` resolves those of each class


class _Fields:
    """Completes a class when somebody looks at its fields, as attrs and cattrs do."""

    def __get__(self, _: object, owner: type[Any]) -> Any:
        _complete(owner)
        return owner.__attrs_attrs__


_fields = _Fields()


def _begin(self: Any, *arguments: Any, **named: Any) -> None:
    """Complete the class of this instance, its first, and initialize it."""
    _complete(type(self))
    self.__init__(*arguments, **named)


def _later(cls: type[Any]) -> type[Any]:
    """Complete a class when it is first instantiated, or when somebody looks at its fields."""
    cls.__attrs_attrs__, cls.__init__ = _fields, _begin
    return cls


def _complete(cls: type[Any]) -> None:
    """Complete a class in place, without parts that nothing here needs: slots, and a `repr`."""
    from lsprotocol.types import ALL_TYPES_MAP

    with _lock:
        if cls.__init__ is _begin:
            # attrs copies all globals of a class's module for its methods. Those of lsprotocol.types take 70 kB each
            # time, and nothing needs them.
            module, cls.__module__ = cls.__module__, ""
            _define(cls, slots=False, repr=False, init=True)
            cls.__module__ = module
            attrs.resolve_types(cls, ALL_TYPES_MAP, {})
