"""Values that are read from JSON have the types of the fields that they fill; anything else is refused."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Annotated, Any, Literal, NamedTuple

import pytest

from improv_core.score.json_types import Between, as_json, read


class Point(NamedTuple):
    x: float
    y: float


@dataclass(frozen=True)
class Path:
    points: Sequence[Point]
    kind: Literal["line", "arc"] = "line"
    names: Mapping[str, int] | None = None
    ends: tuple[int, str] = (0, "")
    share: Annotated[float, Between(0, 1)] = 0.5


PATH = Path((Point(1.0, 2.0), Point(0.5, 0.0)), "arc", {"a": 1}, (3, "b"), 1.0)
WRONG: Mapping[str, Sequence[Any]] = {
    "points": (None, 1, "", {}, [[1]], [[1, 2, 3]], [{"x": 1}], [["a", 2]], [[True, 0]], [[1e400, 0]], [[None, 0]]),
    "kind": ("x", 1),
    "names": ([], {"a": 1.0}, {"a": None}),
    "ends": ([3], [3, 4]),
    "share": (2, float("nan")),
    "more": (1,),
}
WRITTEN = json.loads(json.dumps(as_json(PATH)))


def test_what_was_written_is_read() -> None:
    assert read(WRITTEN, Path) == PATH
    assert read([{"x": 1, "y": 2}, [3, 4]], tuple[Point, ...]) == ((1, 2), (3, 4))


@pytest.mark.parametrize(
    "wrong",
    [
        *({name: each for name, each in WRITTEN.items() if name != lacking} for lacking in WRITTEN),
        *({**WRITTEN, name: value} for name, values in WRONG.items() for value in values),
        *(None, [], 1, "line"),
    ],
    ids=repr,
)
def test_anything_else_is_refused(wrong: Any) -> None:
    with pytest.raises(ValueError, match=r"wrong type|zip"):
        read(wrong, Path)
