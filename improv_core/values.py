"""A decorator for immutable values that are made thousands of times at one key. Standard library only."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

__all__ = ["value"]

if TYPE_CHECKING:
    from dataclasses import dataclass as value
else:
    import dataclasses

    def value(*, frozen: bool, slots: bool, eq: bool = True) -> Any:
        """Make a dataclass of a class, whose values only mypy keeps from being changed.

        When Python itself keeps fields from being set, making a value takes four times as long: a fifth of the time
        that an edit of a name with many users needs.
        """
        return dataclasses.dataclass(slots=slots, eq=eq, unsafe_hash=eq)
