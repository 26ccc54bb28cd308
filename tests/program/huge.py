"""Short programs of huge movements."""

from __future__ import annotations

from collections.abc import Mapping

CHAINS: Mapping[str, str] = {
    "a phrase around itself thirty times": "a (m) = m m\nr $ " + "a " * 30 + "forward\n",
    "thirty phrases around one another": "a (m) = m m\nb0 (m) = a m\n"
    + "".join(f"b{number} (m) = a (b{number - 1} m)\n" for number in range(1, 31))
    + "r $ b30 forward\n",
    "thirty numbers, each used twice": "p0 n = repeat n left\n"
    + "".join(f"p{number} n = p{number - 1} n*2 p{number - 1} n*3\n" for number in range(1, 31))
    + "r $ p30 1\n",
}
"""Written out, they would have more than a billion words."""
LONG: Mapping[str, str] = {
    "accumulate of a thousand items": "r $ accumulate (" + "forward left " * 500 + ")\n",
    "a billion choices": "r $ repeat 1000000000 choose (forward left)\n",
    "a billion times a billion shuffles": "r $ repeat 1000000000 repeat 1000000000 shuffle (forward left right)\n",
    "the end of a billion throws first": "r $ retrograde repeat 1000000000 chance 1/3 (forward left)\n",
    "a ramp over a million beats": "r $ ramp 1 2 repeat 1000000 forward\n",
    "an ease over a million beats": "r $ ease repeat 500000 (forward left)\n",
}
