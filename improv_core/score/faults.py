"""The faults of real robots that are reported to people, and the response to each. Standard library only."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Literal

Fault = Literal["off_path", "silent", "jumped", "stuck", "joints", "gone", "late"]
"""A robot is off its path, its poses have stopped or jumped, it or its joints don't move though they should, nothing
listens for it, or its commands leave late."""
Response = Literal["tell", "stand", "stop"]
"""The response to a fault besides its report: nothing, that robot stands still, or all robots are stopped."""


@dataclass(frozen=True, slots=True)
class FaultRules:
    """Responses to faults, if not only `tell`, and the largest error of a path that is no fault: meters and radians."""

    responses: Mapping[Fault, Response] = field(default_factory=dict)
    distance: float = 0.25
    angle: float = math.radians(15)

    def response(self, fault: Fault) -> Response:
        return self.responses.get(fault, "tell")
