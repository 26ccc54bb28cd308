"""The faults of real robots that people are told of, and what each of them does. Standard library only."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Literal

Fault = Literal["off_path", "silent", "jumped", "stuck", "gone", "late"]
"""A robot is off its path, its poses have stopped or jumped, it doesn't move though it should, nothing listens for it,
or its commands leave late."""
Response = Literal["tell", "stand", "stop"]
"""What a fault does besides that people are told: nothing, that robot stands still, or all robots are stopped."""


@dataclass(frozen=True, slots=True)
class FaultRules:
    """What faults do, if it isn't only `tell`, and how far off its path a robot may be: meters and radians."""

    responses: Mapping[Fault, Response] = field(default_factory=dict)
    distance: float = 0.25
    angle: float = math.radians(15)

    def response(self, fault: Fault) -> Response:
        """What a fault does."""
        return self.responses.get(fault, "tell")
