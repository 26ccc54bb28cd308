"""Programs that take seconds to analyze. Functions make them; most have a few kilobytes."""

from __future__ import annotations

from collections.abc import Mapping

_ROBOTS = range(1, 9)


def _expanding(levels: int) -> str:
    """Phrases within phrases: each level uses the one before with four other numbers."""
    levels_written = "".join("a n=a n*2 a n*3 a n*5 a n*7\n" for _ in range(levels))
    return "a n=scale n left\n" + levels_written + "".join(f"r{robot}$a 1{robot}\n" for robot in _ROBOTS)


def _easing() -> str:
    """Ramps that `beat` has to check again, all of them too fast for `LIMITED` robots."""
    lines = "".join(f"r{place}$ramp 1/2 {place + 2} ease(repeat 200(forward left))\n" for place in range(300))
    return f"beat 60\n{lines}"


def _parameters() -> str:
    """A phrase with thousands of parameters."""
    heads, used = " ".join(f"p{number}" for number in range(3_000)), " ".join("1" for _ in range(3_000))
    return f"a {heads} = scale p0 left\nr $ a {used}\n"


HEAVY: Mapping[str, str] = {
    "phrases in phrases": _expanding(17),
    "phrases that are too large": _expanding(22),
    "ramps and a tempo": _easing(),
    "3,000 parameters": _parameters(),
    "50,000 wrong lines": "beat 60\nx y z $ (\n" + "x y z $ (\n" * 50_000,
    "one line of 60,000 words": f"beat 60\nr $ {'up ' * 60_000}\n",
    "20,000 scenes": "beat 60\n" + "".join(f"r{scene % 7} $ up left\n---\n" for scene in range(20_000)),
    "5,000 names in names": "beat 60\na0 = up\n"
    + "".join(f"a{level + 1} = (a{level} up)\n" for level in range(5_000))
    + "r $ a5000\n",
}
"""The programs, by the reason why they are heavy."""
LIMITED = "".join(f'[robots.r{place}]\nprofile = "turtlebot4"\n' for place in range(300))
"""The text of an `improv.toml` with robots whose limits fast movements exceed."""
