"""Message types between stages, their session, and pages."""

from __future__ import annotations

from collections.abc import Iterator

from improv_core.protocol.decoding import by_type
from improv_core.protocol.messages import FromStage, ToStage
from improv_core.protocol.page_messages import FromPage, ToPage

UNIONS = {"to a stage": ToStage, "from a stage": FromStage, "to pages": ToPage, "from pages": FromPage}


def table() -> Iterator[str]:
    """Yield one row for each direction, then the number of types, and of rows: a type that is sent in two directions is
    one type and two rows."""
    types = {direction: set(by_type(union)) for direction, union in UNIONS.items()}
    for direction, names in types.items():
        yield f"{len(names):4}  {direction}"
    yield f"{len(set().union(*types.values())):4}  types in all"
    yield f"{sum(map(len, types.values())):4}  rows in all"
