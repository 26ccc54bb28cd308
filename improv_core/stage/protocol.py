"""How a stage and its parent talk (docs/protocol.md)."""

from __future__ import annotations

from pathlib import Path

FOLDER = Path(__file__).resolve().parent
"""What Python is started with to run a stage."""
