"""What every benchmark prints: rows of a Markdown table, and the figures in them."""

from __future__ import annotations

from collections.abc import Sequence
from statistics import quantiles


def print_row(*cells: str) -> None:
    print("|", " | ".join(cells), "|", flush=True)


def p99(values: Sequence[float]) -> float:
    return quantiles(values, n=100, method="inclusive")[-1] if len(values) > 1 else values[0]
