"""What a stage on another machine says about its link to the parent. Standard library only."""

from __future__ import annotations

from typing import Literal, TypedDict


class Deserted(TypedDict):
    """The stage of a host has stopped its robots, since it has heard nothing from its parent for this long."""

    type: Literal["deserted"]
    seconds: float
