"""The robots' colors on the page: thirty robots can be told apart, and each is clear on the ground, in both themes."""

from __future__ import annotations

import itertools
import math
import re
from pathlib import Path

import pytest

SHEET = (Path(__file__).parents[2] / "improv_core" / "page" / "static" / "page.css").read_text("utf-8")
GROUNDS = re.findall(r"--ground: (#\w+)", SHEET)
PALETTES = [re.findall(r"#\w+", each) for each in re.findall(r"--robots:([^;]+);", SHEET)]
THEMES = list(zip(GROUNDS, PALETTES, strict=True))


@pytest.mark.parametrize(("ground", "colors"), THEMES)
def test_robots_have_colors_that_stay_apart(ground: str, colors: list[str]) -> None:
    assert len(colors) == 32
    assert _nearest(colors[:8]) > 0.1
    assert _nearest(colors) > 0.07  # about three steps that people can just see


@pytest.mark.parametrize(("ground", "colors"), THEMES)
def test_each_color_is_clear_on_the_ground(ground: str, colors: list[str]) -> None:
    assert min(_contrast(ground, color) for color in colors) >= 4.5  # WCAG 2.2, 1.4.3


def _nearest(colors: list[str]) -> float:
    return min(math.dist(_oklab(one), _oklab(other)) for one, other in itertools.combinations(colors, 2))


def _oklab(color: str) -> tuple[float, float, float]:
    """Lightness and two axes of hue; distances are alike wherever people see them alike (Ottosson 2020)."""
    red, green, blue = _linear(color)
    long = (0.4122214708 * red + 0.5363325363 * green + 0.0514459929 * blue) ** (1 / 3)
    middle = (0.2119034982 * red + 0.6806995451 * green + 0.1073969566 * blue) ** (1 / 3)
    short = (0.0883024619 * red + 0.2817188376 * green + 0.6299787005 * blue) ** (1 / 3)
    return (
        0.2104542553 * long + 0.7936177850 * middle - 0.0040720468 * short,
        1.9779984951 * long - 2.4285922050 * middle + 0.4505937099 * short,
        0.0259040371 * long + 0.7827717662 * middle - 0.8086757660 * short,
    )


def _contrast(one: str, other: str) -> float:
    dark, bright = sorted(
        0.2126 * red + 0.7152 * green + 0.0722 * blue for red, green, blue in map(_linear, (one, other))
    )
    return (bright + 0.05) / (dark + 0.05)


def _linear(color: str) -> tuple[float, float, float]:
    red, green, blue = (int(color[at : at + 2], 16) / 255 for at in (1, 3, 5))
    return _decoded(red), _decoded(green), _decoded(blue)


def _decoded(value: float) -> float:
    return value / 12.92 if value <= 0.04045 else ((value + 0.055) / 1.055) ** 2.4
