"""Output of every benchmark: the machine, rows of a Markdown table, and the figures in them."""

from __future__ import annotations

import os
from collections.abc import Sequence
from statistics import quantiles


def machine() -> str:
    """Describe the number of processors, and their load."""
    return f"{len(os.sched_getaffinity(0))} cores, load average {os.getloadavg()[0]:.2f}"


def print_head(*columns: str) -> None:
    """Print the head of a table: figures, which stand in all columns but the first, end at the right."""
    print_row(*columns)
    print_row("---", *["---:"] * (len(columns) - 1))


def print_row(*cells: str) -> None:
    print("|", " | ".join(cells), "|", flush=True)


def p99(values: Sequence[float]) -> float:
    return quantiles(values, n=100, method="inclusive")[-1] if len(values) > 1 else values[0]
